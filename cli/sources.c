/* What a word is that may name measured data, a result or a model. */
#include "internal_rendering.h"
#include <string.h>
#include <sys/stat.h>

/* Of "ggx alpha=0.2" only what stands before the values. */
static int looks_like_path(const char *word)
{
    const size_t n = strchr(word, '=') ? strcspn(word, " ") : strlen(word);
    return memchr(word, '/', n) || memchr(word, '.', n);
}

/* A folder is none. */
static int is_file(const char *word)
{
    struct stat st;
    return !strcmp(word, "-") || (stat(word, &st) == 0 && !S_ISDIR(st.st_mode));
}

ff_status cli_model_parse(const char *word, char expression[FF_MODEL_NAME], const char **own, ff_model *out, ff_error *err)
{
    const size_t n = strcspn(word, " ");
    snprintf(expression, FF_MODEL_NAME, "%.*s", (int)(n < FF_MODEL_NAME ? n : FF_MODEL_NAME), word);
    *own = word + n + strspn(word + n, " ");
    return n < FF_MODEL_NAME ? ff_model_parse(expression, out, err) : ff_model_parse(word, out, err);
}

int cli_source_of(const char *word, cli_source *out)
{
    ff_model m;
    ff_error err = {0};
    char expression[FF_MODEL_NAME];
    const char *own;
    *out = CLI_SOURCE_MODEL;
    if (!is_file(word)) {
        const ff_status status = cli_model_parse(word, expression, &own, &m, &err);
        if (status == FF_OK) return EXIT_DONE;
        if (!looks_like_path(word)) {
            cli_error("'%s' is neither a file nor a model: %s", word, err.message);
            return status == FF_ERR_MEMORY ? cli_exit_status(status) : EXIT_INPUT;
        }
    }
    *out = ff_fit_document_probe(word) ? CLI_SOURCE_DOCUMENT : CLI_SOURCE_TABLE;
    return EXIT_DONE;
}
