/* Lines of help: wrapped text and the spelling of a flag. */
#include "internal_flags.h"
#include <string.h>

static void spaces(FILE *out, size_t n)
{
    fprintf(out, "%*s", (int)n, "");
}

void cli_wrap(FILE *out, const char *text, size_t at, size_t indent)
{
    size_t column = at;
    int first = 1;
    while (*text) {
        const size_t n = strcspn(text, " \n");
        if (!first && column + 1 + n > CLI_WIDTH) {
            fputc('\n', out);
            spaces(out, indent);
            column = indent;
            first = 1;
        }
        column += n + !first;
        fprintf(out, "%s%.*s", first ? "" : " ", (int)n, text);
        first = 0;
        text += n + (text[n] != '\0');
    }
    fputc('\n', out);
}

const char *cli_flag_spelling(const cli_flag *f, char *out, size_t size)
{
    char letter[8] = "";
    if (f->letter) snprintf(letter, sizeof letter, "-%c, ", f->letter);
    snprintf(out, size, "%s--%s%s%s%s", letter, f->negatable ? "[no-]" : "", f->name, f->placeholder ? " " : "",
             f->placeholder ? f->placeholder : "");
    return out;
}
