/* Pages of Markdown that the program writes: their prose in lines of a readable width. */
#include "ff_report.h"
#include "internal_text.h"
#include <stdlib.h>
#include <string.h>

enum { PAGE_WIDTH = 100 };

/* Length of the next piece that stays together: a word, with the whole of a code span that begins in it. */
static size_t piece(const char *text, const char *end)
{
    const char *p = text;
    int code = 0;
    for (; p < end && (code || *p != ' '); p++)
        if (*p == '`') code = !code;
    if (p == end && code) /* a backquote that nothing closes */
        for (p = text; p < end && *p != ' ';) p++;
    return (size_t)(p - text);
}

static size_t columns(const char *text, size_t n)
{
    size_t count = 0;
    for (size_t i = 0; i < n; i++) count += ((unsigned char)text[i] & 0xc0) != 0x80;
    return count;
}

/* Tables, headings and code are taken as they are; two blanks at the end of a line are a line break. */
static void put_line(const char *line, const char *end, FILE *out)
{
    const size_t length = (size_t)(end - line);
    if (line == end || *line == '|' || *line == '#' || strncmp(line, "    ", 4) == 0) {
        fwrite(line, 1, length, out);
        return;
    }
    const int forced = length >= 2 && end[-1] == ' ' && end[-2] == ' ';
    const size_t width = forced ? PAGE_WIDTH - 2 : PAGE_WIDTH;
    const int indent = line[0] == '-' && line[1] == ' ' ? 2 : 0;
    while (end > line && end[-1] == ' ') end--;
    for (size_t column = 0; line < end;) {
        const size_t n = piece(line, end), wide = columns(line, n);
        if (column && column + 1 + wide > width) {
            fprintf(out, "\n%*s", indent, "");
            column = (size_t)indent;
        } else if (column) {
            fputc(' ', out);
            column++;
        }
        fwrite(line, 1, n, out);
        column += wide;
        line += n;
        while (line < end && *line == ' ') line++;
    }
    if (forced) fputs("  ", out);
}

ff_status ff_report_page(ff_status (*write)(const void *context, FILE *out), const void *context, FILE *out)
{
    char *text = NULL;
    const ff_status status = ff_text_capture(write, context, &text);
    for (const char *line = text; status == FF_OK && *line;) {
        const char *end = line + strcspn(line, "\n");
        put_line(line, end, out);
        if (*end) fputc('\n', out);
        line = end + (*end != '\0');
    }
    free(text);
    return status;
}
