/* Model expressions: is one right, and which name was meant in one that is not. */
#include "internal_flags.h"
#include "models/model_struct.h"
#include <string.h>

static cli_words *const words_of_part[3] = {cli_words_model, cli_words_masking_one, cli_words_fresnel};

/* The name that is nearest to the first one that no registry has, NULL when none is near. */
static const char *meant(const char *text)
{
    int part = 0;
    for (;;) {
        text += strspn(text, " \t");
        const size_t all = strcspn(text, "/+");
        size_t n = all;
        while (n && (text[n - 1] == ' ' || text[n - 1] == '\t')) n--;
        const int shared = part == 2 && n == 6 && !strncmp(text, "shared", n);
        if (part < 3 && !shared && cli_words_find(words_of_part[part], text, n) < 0)
            return cli_words_nearest(words_of_part[part], text, n);
        text += all;
        if (!*text) return NULL;
        part = *text++ == '/' ? part + 1 : 0;
    }
}

int cli_expression_check(const char *flag, const char *text)
{
    ff_model m;
    ff_error err = {0};
    const ff_status status = ff_model_parse(text, &m, &err);
    if (status == FF_OK) return EXIT_DONE;
    const char *nearest = status == FF_ERR_UNKNOWN ? meant(text) : NULL;
    cli_error("%s%s%s%s%s%s%s", flag ? "--" : "", flag ? flag : "", flag ? ": " : "", err.message,
              nearest ? "; did you mean '" : "", nearest ? nearest : "", nearest ? "'?" : "");
    return cli_exit_status(status);
}
