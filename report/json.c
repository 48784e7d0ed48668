#include "ff_json.h"
#include "internal_text.h"
#include <math.h>
#include <string.h>

void ff_json_begin(ff_json *j, FILE *file)
{
    memset(j, 0, sizeof *j);
    j->file = file;
}

void ff_json_end(ff_json *j)
{
    fputc('\n', j->file);
}

static void put_string(FILE *f, const char *s)
{
    fputc('"', f);
    while (*s) {
        const unsigned char c = (unsigned char)*s;
        uint32_t code;
        const size_t n = ff_text_sequence(s, &code);
        if (c == '"' || c == '\\') {
            fprintf(f, "\\%c", c);
        } else if (c == '\n') {
            fputs("\\n", f);
        } else if (n == 0) {
            fputs("\xef\xbf\xbd", f);
        } else if (ff_text_is_control(code)) {
            fprintf(f, "\\u%04x", (unsigned)code);
        } else {
            fwrite(s, 1, n, f);
        }
        s += n ? n : 1;
    }
    fputc('"', f);
}

static void put_line_end(ff_json *j)
{
    if (j->line[j->depth]) return;
    fputc('\n', j->file);
    for (int i = 0; i < j->depth; i++) fputs("  ", j->file);
}

/* What stands before a value: the comma of the one before it, the new line, the key. */
static void put_before(ff_json *j, const char *key)
{
    if (j->filled[j->depth]) fputs(j->line[j->depth] ? ", " : ",", j->file);
    if (j->depth > 0) put_line_end(j);
    j->filled[j->depth] = 1;
    if (key) {
        put_string(j->file, key);
        fputs(": ", j->file);
    }
}

static void open_level(ff_json *j, const char *key, ff_json_layout layout, int array)
{
    put_before(j, key);
    fputc(array ? '[' : '{', j->file);
    const unsigned char line = (unsigned char)(layout == FF_JSON_LINE || j->line[j->depth]);
    if (j->depth < FF_JSON_DEPTH) j->depth++;
    j->filled[j->depth] = 0;
    j->line[j->depth] = line;
    j->array[j->depth] = (unsigned char)array;
}

void ff_json_object(ff_json *j, const char *key, ff_json_layout layout)
{
    open_level(j, key, layout, 0);
}

void ff_json_array(ff_json *j, const char *key, ff_json_layout layout)
{
    open_level(j, key, layout, 1);
}

void ff_json_close(ff_json *j)
{
    const int array = j->array[j->depth], filled = j->filled[j->depth], line = j->line[j->depth];
    if (j->depth > 0) j->depth--;
    if (filled && !line) put_line_end(j);
    fputc(array ? ']' : '}', j->file);
}

void ff_json_string(ff_json *j, const char *key, const char *value)
{
    put_before(j, key);
    if (value) {
        put_string(j->file, value);
    } else {
        fputs("null", j->file);
    }
}

void ff_json_number(ff_json *j, const char *key, double value)
{
    char text[FF_TEXT_NUMBER];
    put_before(j, key);
    fputs(isfinite(value) ? ff_text_exact(value, text) : "null", j->file);
}

void ff_json_integer(ff_json *j, const char *key, int64_t value)
{
    put_before(j, key);
    fprintf(j->file, "%lld", (long long)value);
}

void ff_json_bool(ff_json *j, const char *key, int value)
{
    put_before(j, key);
    fputs(value ? "true" : "false", j->file);
}

void ff_json_null(ff_json *j, const char *key)
{
    put_before(j, key);
    fputs("null", j->file);
}
