/* JSON as a tree. Texts are decoded where they stand, since none grows by that. */
#include "internal_input.h"
#include "internal_json.h"
#include "internal_number.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { NONE = 0, PIECE = 1 << 16 };

struct ff_json_node {
    ff_json_kind kind;
    uint32_t count, first, next; /* numbers of nodes; NONE: there is none, for the root is nobody's child */
    const ff_json_tree *tree;
    const char *name;
    union {
        const char *text;
        double number;
    } is; /* as the kind has it */
};

struct ff_json_tree {
    char *text;
    ff_json_node *node;
    uint32_t n, room;
};

typedef struct reader {
    ff_json_tree *tree;
    char *at, *end;
    const char *path;
    int depth;
    long line;
    ff_error *err;
} reader;

/* ---- errors ---------------------------------------------------------------------------------- */

static ff_status wrong(const reader *r, const char *what)
{
    char quoted[FF_QUOTE];
    const size_t left = (size_t)(r->end - r->at), n = left < 24 ? left : 24;
    return ff_error_set(r->err, FF_ERR_FORMAT, r->path, r->line, -1, "no JSON: expected %s, found %s", what,
                        left ? ff_quote(r->at, n, quoted) : "the end");
}

/* ---- text ------------------------------------------------------------------------------------ */

static void skip_blanks(reader *r)
{
    while (r->at < r->end && (*r->at == ' ' || *r->at == '\t' || *r->at == '\n' || *r->at == '\r'))
        r->line += *r->at++ == '\n'; /* a text has none */
}

/* Length of the UTF-8 sequence at c, 0 when it is none: no overlong form, no surrogate, nothing beyond U+10FFFF. */
static size_t sequence(const unsigned char *c, size_t left)
{
    static const struct {
        unsigned char lo, hi, second_lo, second_hi;
        size_t n;
    } rows[] = {{0x01, 0x7f, 0, 0, 1},       {0xc2, 0xdf, 0x80, 0xbf, 2}, {0xe0, 0xe0, 0xa0, 0xbf, 3},
                {0xe1, 0xec, 0x80, 0xbf, 3}, {0xed, 0xed, 0x80, 0x9f, 3}, {0xee, 0xef, 0x80, 0xbf, 3},
                {0xf0, 0xf0, 0x90, 0xbf, 4}, {0xf1, 0xf3, 0x80, 0xbf, 4}, {0xf4, 0xf4, 0x80, 0x8f, 4}};
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        if (c[0] < rows[k].lo || c[0] > rows[k].hi) continue;
        if (rows[k].n > left) return 0;
        if (rows[k].n > 1 && (c[1] < rows[k].second_lo || c[1] > rows[k].second_hi)) return 0;
        for (size_t i = 2; i < rows[k].n; i++)
            if ((c[i] & 0xc0) != 0x80) return 0;
        return rows[k].n;
    }
    return 0;
}

static char *put_code(char *to, uint32_t code)
{
    if (code < 0x80) {
        *to++ = (char)code;
    } else if (code < 0x800) {
        *to++ = (char)(0xc0 | code >> 6);
        *to++ = (char)(0x80 | (code & 0x3f));
    } else if (code < 0x10000) {
        *to++ = (char)(0xe0 | code >> 12);
        *to++ = (char)(0x80 | (code >> 6 & 0x3f));
        *to++ = (char)(0x80 | (code & 0x3f));
    } else {
        *to++ = (char)(0xf0 | code >> 18);
        *to++ = (char)(0x80 | (code >> 12 & 0x3f));
        *to++ = (char)(0x80 | (code >> 6 & 0x3f));
        *to++ = (char)(0x80 | (code & 0x3f));
    }
    return to;
}

/* Four hexadecimal digits at c, of `left` bytes; -1: they are none. */
static long hexadecimal(const char *c, size_t left)
{
    long value = 0;
    for (int k = 0; k < 4; k++) {
        const char digit = (size_t)k < left ? c[k] : 0;
        const int v = digit >= '0' && digit <= '9'   ? digit - '0'
                      : digit >= 'a' && digit <= 'f' ? digit - 'a' + 10
                      : digit >= 'A' && digit <= 'F' ? digit - 'A' + 10
                                                     : -1;
        if (v < 0) return -1;
        value = value * 16 + v;
    }
    return value;
}

/* After "\u": one code, or two halves of one. */
static ff_status read_unicode(reader *r, char **to)
{
    long code = hexadecimal(r->at, (size_t)(r->end - r->at));
    if (code > 0 && code >= 0xd800 && code < 0xdc00 && r->end - r->at >= 10 && r->at[4] == '\\' && r->at[5] == 'u') {
        const long low = hexadecimal(r->at + 6, (size_t)(r->end - r->at - 6));
        if (low < 0xdc00 || low > 0xdfff) return wrong(r, "the second half of a surrogate pair");
        code = 0x10000 + ((code - 0xd800) << 10) + (low - 0xdc00);
        r->at += 6;
    }
    if (code <= 0 || (code >= 0xd800 && code < 0xe000)) return wrong(r, "the code of a character");
    r->at += 4;
    *to = put_code(*to, (uint32_t)code);
    return FF_OK;
}

static ff_status read_escape(reader *r, char **to)
{
    static const char escapes[] = "\"\\/bfnrt", meaning[] = "\"\\/\b\f\n\r\t";
    const char *found = r->at < r->end && *r->at ? strchr(escapes, *r->at) : NULL;
    if (found) {
        *(*to)++ = meaning[found - escapes];
        r->at++;
        return FF_OK;
    }
    if (r->at == r->end || *r->at != 'u') return wrong(r, "an escape of JSON");
    r->at++;
    return read_unicode(r, to);
}

/* At the opening quote. The text is moved to its front and ended where its closing quote stood, or before. */
static ff_status read_text(reader *r, const char **out)
{
    if (r->at == r->end || *r->at != '"') return wrong(r, "a text in quotes");
    char *to = ++r->at;
    *out = to;
    while (r->at < r->end && *r->at != '"') {
        if (*r->at == '\\') {
            r->at++;
            const ff_status status = read_escape(r, &to);
            if (status) return status;
            continue;
        }
        const size_t n = (unsigned char)*r->at < 0x20 ? 0 : sequence((const unsigned char *)r->at, (size_t)(r->end - r->at));
        if (n == 0) return wrong(r, "a character of UTF-8");
        memmove(to, r->at, n);
        to += n;
        r->at += n;
    }
    if (r->at == r->end) return wrong(r, "the closing quote");
    r->at++;
    *to = '\0';
    return FF_OK;
}

/* ---- values ---------------------------------------------------------------------------------- */

/* [-] digits without a leading 0 [. digits] [e [sign] digits], as JSON wants it; where it ends, NULL when it is none. */
static const char *number_end(const char *c)
{
    c += *c == '-';
    const size_t whole = strspn(c, "0123456789");
    if (whole == 0 || (*c == '0' && whole > 1)) return NULL;
    c += whole;
    if (*c == '.') {
        const size_t n = strspn(c + 1, "0123456789");
        if (n == 0) return NULL;
        c += 1 + n;
    }
    if (*c == 'e' || *c == 'E') {
        c++;
        c += *c == '+' || *c == '-';
        const size_t n = strspn(c, "0123456789");
        if (n == 0) return NULL;
        c += n;
    }
    return c;
}

static ff_status read_number(reader *r, double *out)
{
    const char *end = number_end(r->at);
    if (!end || ff_number_read(r->at, out) != end) return wrong(r, "a value");
    r->at += end - r->at;
    return isfinite(*out) ? FF_OK
                          : ff_error_set(r->err, FF_ERR_FORMAT, r->path, r->line, -1, "a number that is too large for a double");
}

static ff_status new_node(reader *r, uint32_t *out)
{
    ff_json_tree *t = r->tree;
    if (t->n == t->room) {
        const uint32_t room = t->room ? 2 * t->room : 256;
        ff_json_node *longer = realloc(t->node, room * sizeof *longer);
        if (!longer) return ff_error_set(r->err, FF_ERR_MEMORY, r->path, 0, -1, "out of memory");
        t->node = longer;
        t->room = room;
    }
    t->node[t->n] = (ff_json_node){.tree = t};
    *out = t->n++;
    return FF_OK;
}

static ff_status read_value(reader *r, uint32_t *out);

/* A member's name and colon. */
static ff_status read_name(reader *r, const char **out)
{
    ff_status status = read_text(r, out);
    if (status) return status;
    skip_blanks(r);
    if (r->at == r->end || *r->at != ':') return wrong(r, "':' after the name of a member");
    r->at++;
    return FF_OK;
}

/* After the bracket. */
static ff_status read_members(reader *r, uint32_t self, int object)
{
    const char close = object ? '}' : ']';
    uint32_t last = NONE;
    skip_blanks(r);
    if (r->at < r->end && *r->at == close) {
        r->at++;
        return FF_OK;
    }
    for (;;) {
        const char *name = NULL;
        uint32_t child;
        skip_blanks(r);
        ff_status status = object ? read_name(r, &name) : FF_OK;
        if (!status) status = read_value(r, &child);
        if (status) return status;
        r->tree->node[child].name = name;
        *(last == NONE ? &r->tree->node[self].first : &r->tree->node[last].next) = child;
        last = child;
        r->tree->node[self].count++;
        skip_blanks(r);
        if (r->at == r->end || (*r->at != ',' && *r->at != close)) return wrong(r, object ? "',' or '}'" : "',' or ']'");
        if (*r->at++ == close) return FF_OK;
    }
}

static int is_word(const reader *r, const char *word)
{
    const size_t n = strlen(word);
    return (size_t)(r->end - r->at) >= n && !memcmp(r->at, word, n);
}

static ff_status read_value(reader *r, uint32_t *out)
{
    static const char *const words[] = {"null", "false", "true"};
    ff_status status = new_node(r, out);
    if (status) return status;
    skip_blanks(r);
    const uint32_t self = *out;
    for (int k = 0; k < 3; k++) {
        if (!is_word(r, words[k])) continue;
        r->tree->node[self].kind = (ff_json_kind)(FF_JSON_NULL + k);
        r->at += strlen(words[k]);
        return FF_OK;
    }
    const char c = r->at < r->end ? *r->at : '\0';
    if (c == '"') {
        r->tree->node[self].kind = FF_JSON_TEXT;
        return read_text(r, &r->tree->node[self].is.text);
    }
    if (c == '{' || c == '[') {
        if (r->depth == FF_JSON_NESTING)
            return ff_error_set(r->err, FF_ERR_FORMAT, r->path, r->line, -1, "nested more than %d deep", (int)FF_JSON_NESTING);
        r->tree->node[self].kind = c == '{' ? FF_JSON_OBJECT : FF_JSON_ARRAY;
        r->at++;
        r->depth++;
        status = read_members(r, self, c == '{');
        r->depth--;
        return status;
    }
    r->tree->node[self].kind = FF_JSON_NUMBER;
    return read_number(r, &r->tree->node[self].is.number);
}

/* ---- documents ------------------------------------------------------------------------------- */

/* text [n + 1], malloc'ed, belongs to the tree from here on. */
static ff_status parse(char *text, size_t n, const char *path, ff_json_tree **out, ff_error *err)
{
    ff_json_tree *tree = calloc(1, sizeof *tree);
    if (!tree) {
        free(text);
        return ff_error_set(err, FF_ERR_MEMORY, path, 0, -1, "out of memory");
    }
    tree->text = text;
    text[n] = '\0';
    reader r = {tree, text + ff_byte_order_mark(text, n), text + n, path, 0, 1, err};
    uint32_t root;
    ff_status status = read_value(&r, &root);
    skip_blanks(&r);
    if (!status && r.at < r.end) status = wrong(&r, "nothing behind the value");
    if (status) {
        ff_json_free(tree);
        return status;
    }
    *out = tree;
    return FF_OK;
}

ff_status ff_json_parse(const char *text, size_t n, const char *path, ff_json_tree **out, ff_error *err)
{
    char *copy = n <= FF_JSON_BYTES ? malloc(n + 1) : NULL;
    if (n > FF_JSON_BYTES) return ff_error_set(err, FF_ERR_FORMAT, path, 0, -1, "more than %d bytes of JSON", (int)FF_JSON_BYTES);
    if (!copy) return ff_error_set(err, FF_ERR_MEMORY, path, 0, -1, "out of memory");
    memcpy(copy, text, n);
    return parse(copy, n, path, out, err);
}

/* Whether a long document may begin so: a file of another kind is not read to its end to be refused at its first byte. */
static int may_be_json(const char *text, size_t n)
{
    size_t i = n >= 3 && !memcmp(text, "\xEF\xBB\xBF", 3) ? 3 : 0;
    while (i < n && (text[i] == ' ' || text[i] == '\t' || text[i] == '\r' || text[i] == '\n')) i++;
    return i < n && (text[i] == '{' || text[i] == '[');
}

static ff_status slurp(int fd, const char *path, char **out, size_t *n, ff_error *err)
{
    size_t room = PIECE, got = 0;
    char *text = malloc(room + 1);
    ff_status status = FF_OK;
    *n = 0;
    while (text) {
        status = ff_input_read(fd, path, (int64_t)*n, text + *n, room - *n, &got, err);
        *n += got;
        if (status || *n < room || (room == PIECE && !may_be_json(text, *n))) break;
        if (room >= 2 * (size_t)FF_JSON_BYTES) break;
        room *= 2;
        char *longer = realloc(text, room + 1);
        if (!longer) {
            free(text);
            text = NULL;
        } else {
            text = longer;
        }
    }
    if (!text) return ff_error_set(err, FF_ERR_MEMORY, path, 0, -1, "out of memory");
    if (!status && *n > FF_JSON_BYTES)
        status = ff_error_set(err, FF_ERR_FORMAT, path, 0, -1, "more than %d bytes of JSON", (int)FF_JSON_BYTES);
    if (status)
        free(text);
    else
        *out = text;
    return status;
}

ff_status ff_json_read(const char *path, ff_json_tree **out, ff_error *err)
{
    int fd;
    int64_t size;
    char *text = NULL;
    size_t n = 0;
    ff_status status = ff_input_open(path, &fd, &size, err);
    if (status) return status;
    status = slurp(fd, path, &text, &n, err);
    close(fd);
    return status ? status : parse(text, n, path, out, err);
}

void ff_json_free(ff_json_tree *tree)
{
    if (!tree) return;
    free(tree->text);
    free(tree->node);
    free(tree);
}

/* ---- looking --------------------------------------------------------------------------------- */

const ff_json_node *ff_json_root(const ff_json_tree *tree)
{
    return tree ? &tree->node[0] : NULL;
}

ff_json_kind ff_json_kind_of(const ff_json_node *node)
{
    return node ? node->kind : FF_JSON_NULL;
}

const ff_json_node *ff_json_first(const ff_json_node *node)
{
    return node && node->first != NONE ? &node->tree->node[node->first] : NULL;
}

const ff_json_node *ff_json_next(const ff_json_node *node)
{
    return node && node->next != NONE ? &node->tree->node[node->next] : NULL;
}

const ff_json_node *ff_json_member(const ff_json_node *object, const char *name)
{
    if (ff_json_kind_of(object) != FF_JSON_OBJECT) return NULL;
    for (const ff_json_node *m = ff_json_first(object); m; m = ff_json_next(m))
        if (!strcmp(m->name, name)) return m;
    return NULL;
}

size_t ff_json_count(const ff_json_node *node)
{
    return node ? node->count : 0;
}

const char *ff_json_name(const ff_json_node *node)
{
    return node ? node->name : NULL;
}

const char *ff_json_text(const ff_json_node *node)
{
    return ff_json_kind_of(node) == FF_JSON_TEXT ? node->is.text : NULL;
}

double ff_json_real(const ff_json_node *node)
{
    return ff_json_kind_of(node) == FF_JSON_NUMBER ? node->is.number : NAN;
}

int ff_json_is_true(const ff_json_node *node)
{
    return ff_json_kind_of(node) == FF_JSON_TRUE;
}
