/* Text for people in lines that fit their terminal. */
#include "ff_report.h"
#include "internal_text.h"
#include <stdlib.h>
#include <string.h>

enum { FURTHER = 2 }; /* what a broken line continues with is indented by so much more */

/* Of text [n]; longer than any line: its bytes. */
static size_t columns_of(const char *text, size_t n)
{
    char word[256];
    if (n >= sizeof word) return n;
    memcpy(word, text, n);
    word[n] = '\0';
    return ff_text_width(word);
}

/* Writes text [n] and returns its columns. */
static size_t put(const char *text, size_t n, FILE *out)
{
    fwrite(text, 1, n, out);
    return columns_of(text, n);
}

/* Length of the next word; a per cent sign and the s of seconds stay with their number. */
static size_t word_length(const char *text)
{
    const size_t n = strcspn(text, " \n");
    if (text[n] != ' ') return n;
    const char *unit = text + n + 1;
    const size_t length = strcspn(unit, " \n");
    return *unit == '%' || (length == 1 && *unit == 's') ? n + 1 + length : n;
}

/* A line [n] that is too long: blanks between words stay what they are where the line is not broken. */
static void put_broken(const char *line, size_t n, size_t width, FILE *out)
{
    const size_t indent = strspn(line, " ");
    size_t at = indent, column = put(line, indent, out);
    while (at < n) {
        const size_t word = word_length(line + at), blanks = strspn(line + at + word, " ");
        column += put(line + at, word, out);
        at += word + blanks;
        if (at >= n) break;
        if (column + blanks + columns_of(line + at, word_length(line + at)) > width) {
            fprintf(out, "\n%*s", (int)(indent + FURTHER), "");
            column = indent + FURTHER;
        } else {
            column += put(line + at - blanks, blanks, out);
        }
    }
}

/* ---- commands -------------------------------------------------------------------------------- */

/* A line of a verdict that ends with a command, to be pasted: where that begins; 0: none. */
static size_t command_begins(const char *line)
{
    static const char *const before[] = {"Next: facetfit ", "Look: facetfit "};
    const char *text = *line == '\x1b' ? line + strcspn(line, "m\n") + 1 : line;
    for (size_t k = 0; k < sizeof before / sizeof *before; k++)
        if (!strncmp(text, before[k], strlen(before[k]))) return (size_t)(text - line) + strcspn(text, " ") + 1;
    return 0;
}

/* Length of the next word of a shell, [n] to the end of the line: blanks between quotes are of it, and a comment is one. */
static size_t shell_word(const char *text, size_t n)
{
    size_t k = 0;
    if (*text == '#') return n;
    for (int quoted = 0; k < n && (quoted || text[k] != ' '); k++)
        quoted ^= text[k] == '\'' && (k == 0 || quoted || text[k - 1] != '\\');
    return k;
}

/* A command that is too long, in lines that a shell takes for one. A comment that has no room in a line of its own is left out. */
static void put_command(const char *line, size_t n, size_t begin, size_t width, FILE *out)
{
    size_t at = begin, column = put(line, begin, out) - (*line == '\x1b' ? strcspn(line, "m") + 1 : 0);
    while (at < n) {
        const size_t word = shell_word(line + at, n - at), blanks = strspn(line + at + word, " "), next = at + word + blanks;
        column += put(line + at, word, out);
        const size_t following = next < n ? shell_word(line + next, n - next) : 0, columns = columns_of(line + next, following);
        const int is_last = next + following >= n;
        if (following && line[next] == '#' && FURTHER + columns > width) {
            const char *colours = memchr(line + next, '\x1b', n - next); /* that end with it */
            if (colours) put(colours, n - (size_t)(colours - line), out);
            break;
        }
        if (next < n && column + blanks + columns + (is_last ? 0 : 2) > width) {
            fprintf(out, " \\\n%*s", FURTHER, "");
            column = FURTHER;
        } else {
            column += put(line + at + word, blanks, out);
        }
        at = next;
    }
}

/* ---- lines ----------------------------------------------------------------------------------- */

static int is_too_long(const char *line, size_t n, size_t width)
{
    size_t used = 0;
    for (size_t at = 0; at < n && used <= width;) {
        const size_t blanks = strspn(line + at, " "), word = strcspn(line + at + blanks, " \n");
        used += blanks + columns_of(line + at + blanks, word);
        at += blanks + word;
    }
    return used > width;
}

ff_status ff_report_fold(ff_status (*write)(const void *context, FILE *out), const void *context, const ff_report_style *style,
                         FILE *out)
{
    char *text = NULL;
    if (!style || !style->width) return write(context, out);
    const ff_status status = ff_text_capture(write, context, &text);
    for (const char *line = text; status == FF_OK && *line;) {
        const size_t n = strcspn(line, "\n");
        if (is_too_long(line, n, style->width) && command_begins(line))
            put_command(line, n, command_begins(line), style->width, out);
        else if (is_too_long(line, n, style->width))
            put_broken(line, n, style->width, out);
        else
            fwrite(line, 1, n, out);
        if (line[n]) fputc('\n', out);
        line += n + (line[n] != '\0');
    }
    free(text);
    return status;
}
