/* What a word is that may name measured data, a result or a model. */
#include "internal_rendering.h"
#include <string.h>
#include <sys/stat.h>

static int looks_like_path(const char *word)
{
    return strchr(word, '/') || strchr(word, '.');
}

/* A folder is none. */
static int is_file(const char *word)
{
    struct stat st;
    return !strcmp(word, "-") || (stat(word, &st) == 0 && !S_ISDIR(st.st_mode));
}

int cli_source_of(const char *word, cli_source *out)
{
    ff_model m;
    ff_error err = {0};
    *out = CLI_SOURCE_MODEL;
    if (!is_file(word)) {
        const ff_status status = ff_model_parse(word, &m, &err);
        if (status == FF_OK) return EXIT_DONE;
        if (!looks_like_path(word)) {
            cli_message("'%s' is neither a file nor a model: %s", word, err.message);
            return status == FF_ERR_MEMORY ? cli_exit_status(status) : EXIT_INPUT;
        }
    }
    *out = ff_fit_document_probe(word) ? CLI_SOURCE_DOCUMENT : CLI_SOURCE_TABLE;
    return EXIT_DONE;
}
