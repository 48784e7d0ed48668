/* Lines of fields with tabs between. */
#define _GNU_SOURCE /* asprintf */
#include "internal_batch.h"
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static const char escaped[] = "\t\n\r\\", letters[] = "tnr\\";

void batch_field_put(const char *text, FILE *out)
{
    for (; *text; text++) {
        const char *at = strchr(escaped, *text);
        if (at) fputc('\\', out);
        fputc(at ? letters[at - escaped] : *text, out);
    }
}

/* A backslash before something else is one. */
static void unescape(char *text)
{
    char *to = text;
    for (; *text; text++) {
        const char *at = *text == '\\' && text[1] ? strchr(letters, text[1]) : NULL;
        if (at) text++;
        *to++ = at ? escaped[at - letters] : *text;
    }
    *to = '\0';
}

size_t batch_fields(char *line, char **field, size_t most)
{
    size_t n = 0;
    for (char *end; line; line = end) {
        end = strchr(line, '\t');
        if (end) *end++ = '\0';
        unescape(line);
        if (n < most) field[n] = line;
        n++;
    }
    return n;
}

char *batch_path(const char *folder, const char *name)
{
    char *path;
    const size_t n = strlen(folder);
    return asprintf(&path, "%s%s%s", folder, n && folder[n - 1] == '/' ? "" : "/", name) < 0 ? NULL : path;
}

char *batch_page_name(const char *json)
{
    char *name;
    return asprintf(&name, "%.*s.html", (int)(strlen(json) - strlen(".json")), json) < 0 ? NULL : name;
}

char *batch_read_whole(const char *path, size_t *n)
{
    struct stat st;
    FILE *in = fopen(path, "rb");
    char *text = in && fstat(fileno(in), &st) == 0 && S_ISREG(st.st_mode) ? malloc((size_t)st.st_size + 1) : NULL;
    *n = text ? fread(text, 1, (size_t)st.st_size + 1, in) : 0;
    if (in) (void)fclose(in);
    return text;
}
