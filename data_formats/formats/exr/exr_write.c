/* A table as an OpenEXR image, without compression; docs/exr.md. Numbers in 1/sr. */
#include "internal_exr.h"
#include "base/internal_bytes.h"
#include "base/internal_input.h"
#include "base/internal_number.h"
#include "data_formats/table/internal_table.h"
#include <float.h>
#include <math.h>
#include <stdlib.h>

enum { WIDTH = 16384, WIDTH_LEAST = 64, NAME = FF_CHANNEL_NAME + 16 };

/* Where the numbers of a plane come from. */
typedef struct source {
    char name[NAME];
    ff_exr_role role;
    size_t channel; /* of the table */
    int doubles;
} source;

/* A channel of the image: a plane, or the upper or lower halves of its doubles. */
typedef struct part {
    size_t source;
    int shift; /* -1: floats; 32, 0: halves of doubles */
} part;

typedef struct writer {
    const char *path;
    ff_error *err;
    const ff_table *t;
    exr_context_t context; /* of the output */
    size_t width, height;
    source *sources;
    size_t n_sources;
    part *parts; /* in the order of the file */
    size_t n_parts;
    double *numbers;     /* [n_sources][width]: one line */
    unsigned char *line; /* as it goes into the file     */
} writer;

/* ---- names ----------------------------------------------------------------------------------- */

static int ends_with(const char *text, const char *end)
{
    const size_t n = strlen(text), m = strlen(end);
    return n >= m && strcmp(text + n - m, end) == 0;
}

/* 1 when a channel's own name can be that of its plane: printable, and no name of another kind of plane. */
static int is_plain(const char *name)
{
    static const char *const other[] = {"sigma.", "direction.", "channel.", "weight"};
    for (const char *p = name; *p; p++)
        if (*p <= ' ' || *p >= 0x7F) return 0;
    for (size_t k = 0; k < sizeof other / sizeof other[0]; k++)
        if (strncmp(name, other[k], strlen(other[k])) == 0) return 0;
    return *name && !ends_with(name, FF_EXR_HIGH) && !ends_with(name, FF_EXR_LOW);
}

/* r, g, b become R, G, B, which every viewer shows. */
static void name_plane(const ff_table *t, size_t c, char out[FF_CHANNEL_NAME])
{
    static const char *const small[3] = {"r", "g", "b"}, *const large[3] = {"R", "G", "B"};
    const char *name = t->channels[c].name;
    if (!is_plain(name) || ff_table_channel_find(t, name) != (int)c) {
        snprintf(out, FF_CHANNEL_NAME, "channel.%zu", c);
        return;
    }
    snprintf(out, FF_CHANNEL_NAME, "%s", name);
    for (int k = 0; k < 3; k++)
        if (strcmp(name, small[k]) == 0 && ff_table_channel_find(t, large[k]) < 0) strcpy(out, large[k]);
}

static void add_source(writer *w, ff_exr_role role, size_t channel, int doubles, const char *prefix, const char *name)
{
    source *s = &w->sources[w->n_sources++];
    *s = (source){.role = role, .channel = channel, .doubles = doubles};
    snprintf(s->name, sizeof s->name, "%s%s", prefix, name);
}

/* Angles of a list lose nothing: floats where these are exact. */
static int angles_are_floats(const ff_table *t)
{
    for (int k = 0; k < 4; k++)
        for (size_t i = 0; i < t->n; i++)
            if ((double)(float)t->angle[k][i] != t->angle[k][i]) return 0;
    return 1;
}

static ff_status no_memory(const writer *w)
{
    return ff_error_set(w->err, FF_ERR_MEMORY, w->path, 0, -1, "no memory for an image of %zu x %zu pixels", w->width, w->height);
}

static ff_status make_sources(writer *w)
{
    const ff_table *t = w->t;
    const ff_exr_kept *kept = ff_exr_kept_of(t);
    const int doubles = kept && kept->doubles;
    w->sources = calloc(2 * t->n_channels + 5, sizeof *w->sources);
    w->parts = calloc(2 * (2 * t->n_channels + 5), sizeof *w->parts);
    if (!w->sources || !w->parts) return no_memory(w);
    for (size_t c = 0; c < t->n_channels; c++) {
        char name[FF_CHANNEL_NAME];
        name_plane(t, c, name);
        add_source(w, FF_EXR_VALUE, c, doubles, "", name);
    }
    for (size_t c = 0; c < t->n_channels && t->sigma; c++) {
        char name[FF_CHANNEL_NAME];
        name_plane(t, c, name);
        add_source(w, FF_EXR_SIGMA, c, doubles, "sigma.", name);
    }
    if (t->weight) add_source(w, FF_EXR_WEIGHT, 0, doubles, "", "weight");
    if (t->grid || t->axes.kind) return FF_OK;
    const int exact = angles_are_floats(t);
    for (size_t k = 0; k < 4; k++) add_source(w, FF_EXR_ANGLE, k, !exact, "", ff_exr_direction[k]);
    return FF_OK;
}

/* ---- attributes ------------------------------------------------------------------------------ */

static exr_result_t set_numbers(const writer *w, const char *name, const double *v, size_t n)
{
    char *text = malloc(n * (FF_NUMBER_TEXT + 1) + 1), *p = text;
    if (!text) return EXR_ERR_OUT_OF_MEMORY;
    for (size_t i = 0; i < n; i++) {
        if (i) *p++ = ' ';
        if (isnan(v[i]))
            *p++ = '-';
        else
            p += ff_number_write(v[i], p);
    }
    *p = '\0';
    const exr_result_t r = exr_attr_set_string(w->context, 0, name, text);
    free(text);
    return r;
}

static exr_result_t set_channels(const writer *w)
{
    const ff_table *t = w->t;
    const char **names = malloc(t->n_channels * sizeof *names);
    double *nm = malloc(t->n_channels * sizeof *nm);
    exr_result_t r = names && nm ? EXR_ERR_SUCCESS : EXR_ERR_OUT_OF_MEMORY;
    for (size_t c = 0; c < t->n_channels && r == EXR_ERR_SUCCESS; c++) {
        names[c] = t->channels[c].name;
        nm[c] = t->channels[c].wavelength_nm;
    }
    if (r == EXR_ERR_SUCCESS) r = exr_attr_set_string_vector(w->context, 0, FF_EXR_A("channels"), (int32_t)t->n_channels, names);
    for (size_t c = 0; c < t->n_channels && r == EXR_ERR_SUCCESS; c++) names[c] = w->sources[c].name;
    if (r == EXR_ERR_SUCCESS) r = exr_attr_set_string_vector(w->context, 0, FF_EXR_A("planes"), (int32_t)t->n_channels, names);
    if (r == EXR_ERR_SUCCESS) r = set_numbers(w, FF_EXR_A("wavelengths"), nm, t->n_channels);
    free(names);
    free(nm);
    return r;
}

static exr_result_t set_attributes(const writer *w)
{
    const ff_table *t = w->t;
    const ff_exr_kept *kept = ff_exr_kept_of(t);
    const char *from = kept ? kept->source : t->format;
    const struct {
        const char *name, *value;
    } words[] = {{FF_EXR_A("parametrisation"), t->grid ? "merl" : ff_exr_parametrisation[t->axes.kind]},
                 {FF_EXR_A("quantity"), "brdf"},
                 {FF_EXR_A("angle_unit"), t->radians_per_unit == 1 && !t->grid ? "radian" : "degree"},
                 {FF_EXR_A("value_unit"), "1/sr"},
                 {FF_EXR_A("source"), *from ? from : "facetfit"}};
    exr_result_t r = exr_attr_set_int(w->context, 0, FF_EXR_A("version"), FF_EXR_VERSION);
    for (size_t k = 0; k < sizeof words / sizeof words[0] && r == EXR_ERR_SUCCESS; k++)
        r = exr_attr_set_string(w->context, 0, words[k].name, words[k].value);
    if (r == EXR_ERR_SUCCESS) r = exr_attr_set_int(w->context, 0, FF_EXR_A("samples"), (int32_t)t->n);
    if (r == EXR_ERR_SUCCESS) r = exr_attr_set_int(w->context, 0, FF_EXR_A("isotropic"), t->isotropic != 0);
    for (int k = 0; k < 4 && t->axes.kind && r == EXR_ERR_SUCCESS; k++)
        r = set_numbers(w, ff_exr_axis_name[t->axes.kind][k], t->axes.node[k], t->axes.n[k]);
    return r == EXR_ERR_SUCCESS ? set_channels(w) : r;
}

/* ---- header ---------------------------------------------------------------------------------- */

static exr_result_t add_channels(const writer *w)
{
    exr_result_t r = EXR_ERR_SUCCESS;
    for (size_t k = 0; k < w->n_sources && r == EXR_ERR_SUCCESS; k++) {
        const source *s = &w->sources[k];
        char name[NAME + 8];
        for (int half = 0; half < 1 + s->doubles && r == EXR_ERR_SUCCESS; half++) {
            snprintf(name, sizeof name, "%s%s", s->name, !s->doubles ? "" : half ? FF_EXR_LOW : FF_EXR_HIGH);
            r = exr_add_channel(w->context, 0, name, s->doubles ? EXR_PIXEL_UINT : EXR_PIXEL_FLOAT, EXR_PERCEPTUALLY_LOGARITHMIC, 1,
                                1);
        }
    }
    return r;
}

/* The library keeps the channels in the order of the file. */
static exr_result_t order_parts(writer *w)
{
    const exr_attr_chlist_t *list;
    const exr_result_t r = exr_get_channels(w->context, 0, &list);
    if (r != EXR_ERR_SUCCESS) return r;
    for (int c = 0; c < list->num_channels; c++) {
        const char *name = list->entries[c].name.str;
        for (size_t k = 0; k < w->n_sources; k++) {
            const source *s = &w->sources[k];
            const size_t n = strlen(s->name);
            if (strncmp(name, s->name, n) != 0) continue;
            if (!s->doubles && !name[n]) w->parts[w->n_parts++] = (part){k, -1};
            if (s->doubles && strcmp(name + n, FF_EXR_HIGH) == 0) w->parts[w->n_parts++] = (part){k, 32};
            if (s->doubles && strcmp(name + n, FF_EXR_LOW) == 0) w->parts[w->n_parts++] = (part){k, 0};
        }
    }
    return w->n_parts != (size_t)list->num_channels ? EXR_ERR_INVALID_ATTR : EXR_ERR_SUCCESS;
}

static exr_result_t write_header(writer *w)
{
    int index;
    exr_result_t r = exr_set_longname_support(w->context, 1);
    if (r == EXR_ERR_SUCCESS) r = exr_add_part(w->context, "brdf", EXR_STORAGE_SCANLINE, &index);
    if (r == EXR_ERR_SUCCESS)
        r = exr_initialize_required_attr_simple(w->context, 0, (int32_t)w->width, (int32_t)w->height, EXR_COMPRESSION_NONE);
    if (r == EXR_ERR_SUCCESS) r = add_channels(w);
    if (r == EXR_ERR_SUCCESS) r = set_attributes(w);
    if (r == EXR_ERR_SUCCESS) r = order_parts(w);
    return r == EXR_ERR_SUCCESS ? exr_write_header(w->context) : r;
}

/* ---- pixels ---------------------------------------------------------------------------------- */

/* The numbers of n samples from `first` on, in 1/sr; what was not measured and what is no sample is NaN. */
static void take_numbers(const writer *w, const source *s, size_t first, size_t n, double *out)
{
    const ff_table *t = w->t;
    if (s->role == FF_EXR_VALUE) ff_table_values(t, s->channel, first, n, out);
    if (s->role == FF_EXR_SIGMA) ff_table_sigmas(t, s->channel, first, n, out);
    if (s->role == FF_EXR_WEIGHT) memcpy(out, t->weight + first, n * sizeof *out);
    if (s->role == FF_EXR_ANGLE) memcpy(out, t->angle[s->channel] + first, n * sizeof *out);
    for (size_t i = 0; i < n && s->role <= FF_EXR_SIGMA; i++)
        if (!t->valid[first + i]) out[i] = NAN;
    for (size_t i = n; i < w->width; i++) out[i] = s->role <= FF_EXR_SIGMA ? NAN : 0;
}

static unsigned char *put_part(const part *p, const double *v, size_t n, unsigned char *to)
{
    for (size_t i = 0; i < n; i++, to += 4) {
        if (p->shift < 0) {
            ff_bytes_of_float((float)v[i], to);
            continue;
        }
        uint64_t u;
        memcpy(&u, v + i, sizeof u);
        ff_bytes_of_uint((u >> p->shift) & UINT32_MAX, 4, to);
    }
    return to;
}

static exr_result_t write_line(writer *w, size_t y)
{
    const size_t first = y * w->width, left = w->t->n - first, n = left < w->width ? left : w->width;
    for (size_t k = 0; k < w->n_sources; k++) take_numbers(w, &w->sources[k], first, n, w->numbers + k * w->width);
    unsigned char *to = w->line;
    for (size_t k = 0; k < w->n_parts; k++) to = put_part(&w->parts[k], w->numbers + w->parts[k].source * w->width, w->width, to);
    return exr_write_scanline_chunk(w->context, 0, (int)y, w->line, (uint64_t)(to - w->line));
}

/* An ff_exr_body of a writer. */
static ff_status write_image(ff_exr_output *out, void *context)
{
    writer *w = context;
    w->context = out->context;
    w->numbers = malloc(w->n_sources * w->width * sizeof *w->numbers);
    w->line = malloc(2 * w->n_sources * w->width * 4);
    if (!w->numbers || !w->line) return no_memory(w);
    exr_result_t r = write_header(w);
    for (size_t y = 0; y < w->height && r == EXR_ERR_SUCCESS && !out->broken; y++) r = write_line(w, y);
    return ff_exr_output_result(out, r, "a table that it can hold");
}

/* ---- what can be written --------------------------------------------------------------------- */

/* A float cannot hold every double: too large ones, and standard deviations that would become 0. */
static ff_status check_floats(const writer *w)
{
    for (size_t k = 0; k < w->n_sources; k++) {
        const source *s = &w->sources[k];
        const char *expected = s->role == FF_EXR_SIGMA ? "1.2e-38 to 3.4e38" : "at most 3.4e38";
        for (size_t i = 0; i < w->t->n && !s->doubles && s->role != FF_EXR_ANGLE; i++) {
            double v = 0;
            if (s->role != FF_EXR_WEIGHT && !w->t->valid[i]) continue;
            if (s->role == FF_EXR_VALUE) ff_table_values(w->t, s->channel, i, 1, &v);
            if (s->role == FF_EXR_SIGMA) ff_table_sigmas(w->t, s->channel, i, 1, &v);
            if (s->role == FF_EXR_WEIGHT) v = w->t->weight[i];
            if (fabs(v) > FLT_MAX || (s->role == FF_EXR_SIGMA && v < FLT_MIN))
                return ff_error_set(
                    w->err, FF_ERR_UNSUPPORTED, w->path, 0, -1,
                    "plane '%s', sample %zu: found %g, expected %s for a 32-bit float; the layout 'double' takes it", s->name, i, v,
                    expected);
        }
    }
    return FF_OK;
}

static ff_status check_writable(const writer *w)
{
    const ff_table *t = w->t;
    if (t->grid && t->grid != &ff_grid_merl)
        return ff_error_set(w->err, FF_ERR_UNSUPPORTED, w->path, 0, -1, "found the grid '%s', expected 'merl', axes or directions",
                            t->grid->name);
    if (t->n > INT32_MAX - WIDTH || t->n_channels > 4096)
        return ff_error_set(w->err, FF_ERR_UNSUPPORTED, w->path, 0, -1,
                            "found %zu samples of %zu channels, expected fewer than 2^31 and at most 4096", t->n, t->n_channels);
    for (size_t c = 0; c < t->n_channels; c++) {
        char found[FF_QUOTE];
        const char *name = t->channels[c].name;
        if (!*name || ff_table_channel_find(t, name) != (int)c)
            return ff_error_set(w->err, FF_ERR_UNSUPPORTED, w->path, 0, -1,
                                "found channel %zu named %s, expected a name of its own", c, ff_quote(name, strlen(name), found));
    }
    return ff_table_check(t, w->path, w->err);
}

/* A line is what the last two axes make, where that is neither too short nor too long to be read at once. */
static void choose_size(writer *w)
{
    const ff_table *t = w->t;
    const size_t inner = t->grid ? 16200 : t->axes.kind ? t->axes.n[2] * t->axes.n[3] : 0;
    w->width = inner >= WIDTH_LEAST && inner <= 4 * WIDTH ? inner : t->n < WIDTH ? t->n : WIDTH;
    w->height = (t->n + w->width - 1) / w->width;
}

ff_status ff_exr_write(const char *path, const ff_table *t, ff_error *err)
{
    writer w = {.path = path, .err = err, .t = t};
    ff_status status = check_writable(&w);
    if (status == FF_OK) {
        choose_size(&w);
        status = make_sources(&w);
    }
    if (status == FF_OK) status = check_floats(&w);
    if (status == FF_OK) status = ff_exr_output_write(path, write_image, &w, err);
    free(w.sources);
    free(w.parts);
    free(w.numbers);
    free(w.line);
    return status;
}
