/* The formats: list, detection by content, reading and writing by name. */
#define _GNU_SOURCE
#include "base/internal_name.h"
#include "base/internal_input.h"
#include "base/internal_options.h"
#include "data_formats/table/internal_table.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

enum { HEAD_BYTES = 1 << 14 };

#define FF_FORMAT(name) extern const ff_format ff_format_##name;
#include "data_formats/formats.def"
#undef FF_FORMAT

#define FF_FORMAT(name) &ff_format_##name,
static const ff_format *const formats[] = {
#include "data_formats/formats.def"
};
#undef FF_FORMAT

size_t ff_format_count(void)
{
    return sizeof formats / sizeof formats[0];
}

const ff_format *ff_format_at(size_t i)
{
    return i < ff_format_count() ? formats[i] : NULL;
}

const ff_format *ff_format_find(const char *name)
{
    for (size_t i = 0; i < ff_format_count(); i++)
        if (ff_name_is(formats[i]->name, name, strlen(name))) return formats[i];
    return NULL;
}

enum { LIST = 256 };
/* "merl, astm, csv", all or those that can be written. */
static const char *list_names(int writable, char out[LIST])
{
    size_t used = 0;
    out[0] = '\0';
    for (size_t i = 0; i < ff_format_count() && used < LIST; i++)
        if (!writable || formats[i]->write)
            used += (size_t)snprintf(out + used, LIST - used, "%s%s", used ? ", " : "", formats[i]->name);
    return out;
}

/* *best stays NULL where none recognises it. */
static ff_status most_confident(const unsigned char *head, size_t n, int64_t size, const ff_format **best)
{
    *best = NULL;
    int confidence = 0;
    for (size_t i = 0; i < ff_format_count(); i++) {
        int p = formats[i]->probe(head, n, size);
        if (p < 0) return FF_ERR_MEMORY;
        if (p > confidence) {
            confidence = p;
            *best = formats[i];
        }
    }
    return FF_OK;
}

/* The schema of one of our own results, "facetfit.fit/2", at the beginning of its JSON; 0: it is none. */
static int is_result(const unsigned char *head, size_t n, char out[64])
{
    static const char key[] = "\"schema\": \"";
    const char *at = memmem(head, n < 256 ? n : 256, key, sizeof key - 1);
    if (!at || *head != '{') return 0;
    at += sizeof key - 1;
    const char *end = memchr(at, '"', (size_t)((const char *)head + n - at));
    if (!end || (size_t)(end - at) >= 64 || strncmp(at, "facetfit.", 9) != 0) return 0;
    memcpy(out, at, (size_t)(end - at));
    out[end - at] = '\0';
    return 1;
}

static ff_status not_recognised(const char *path, const unsigned char *head, size_t n, ff_error *err)
{
    char names[LIST], text[FF_QUOTE], hex[3 * 8 + 1] = "";
    char schema[64];
    size_t shown = n < 24 ? n : 24;
    if (is_result(head, n, schema))
        return ff_error_hint(
            err, ff_error_set(err, FF_ERR_FORMAT, path, 0, -1, "found a result as JSON (%s), expected measured data", schema),
            FF_HINT_RESULT);
    for (size_t i = 0; i < n && i < 8; i++) snprintf(hex + 3 * i, 4, "%02x ", head[i]);
    return ff_error_set(err, FF_ERR_FORMAT, path, 0, 0, "no format recognises it: found bytes %s(%s), expected one of %s", hex,
                        ff_quote((const char *)head, shown, text), list_names(0, names));
}

static ff_status detect_in(int fd, const char *path, int64_t size, size_t *looked_at, const ff_format **out, ff_error *err)
{
    unsigned char head[HEAD_BYTES];
    size_t n = 0;
    ff_status status = ff_input_read(fd, path, 0, head, sizeof head, &n, err);
    *looked_at = n;
    if (status != FF_OK) return status;
    if (n == 0) return ff_error_set(err, FF_ERR_READ, path, 0, 0, "found an empty file, expected a measurement");
    const size_t mark = ff_byte_order_mark(head, n);
    const ff_format *best;
    if (most_confident(head + mark, n - mark, size, &best))
        return ff_error_set(err, FF_ERR_MEMORY, path, 0, -1, "no memory to look at it");
    if (!best) return not_recognised(path, head, n, err);
    *out = best;
    return FF_OK;
}

ff_status ff_format_detect(const char *path, const ff_format **out, ff_error *err)
{
    int fd;
    int64_t size;
    size_t looked_at = 0;
    ff_status status = ff_input_look(path, &fd, &size, err);
    if (status != FF_OK) return status;
    if (size < 0) /* looking at the content of a pipe would use it up */
        status =
            ff_error_hint(err,
                          ff_error_set(err, FF_ERR_FORMAT, path, 0, -1,
                                       "found a pipe or device, whose format cannot be found by looking at it, expected a file "
                                       "or the name of its format: where it is a table, say format csv"),
                          FF_HINT_SAY);
    else
        status = detect_in(fd, path, size, &looked_at, out, err);
    ff_input_unlook(path, fd, looked_at);
    return status;
}

static int has_extension(const char *path, const char *extension, size_t length)
{
    size_t n = strlen(path);
    return n > length && strncasecmp(path + n - length, extension, length) == 0;
}

/* The longest extension decides: "x.zemax.bsdf" is not what "x.bsdf" is. */
const ff_format *ff_format_for_writing(const char *path)
{
    const ff_format *best = NULL;
    size_t longest = 0;
    for (size_t i = 0; i < ff_format_count(); i++) {
        const char *e = formats[i]->extensions;
        while (formats[i]->write && *e) {
            size_t length = strcspn(e, " ");
            if (length > longest && has_extension(path, e, length)) {
                best = formats[i];
                longest = length;
            }
            e += length;
            e += strspn(e, " ");
        }
    }
    return best;
}

static ff_status find_named(const char *path, const char *name, const ff_format **out, ff_error *err)
{
    char names[LIST];
    const ff_format *f = ff_format_find(name);
    if (!f)
        return ff_error_set(err, FF_ERR_UNKNOWN, path, 0, -1, "found format '%s', expected one of %s", name, list_names(0, names));
    *out = f;
    return FF_OK;
}

void ff_read_options_init_size(ff_read_options *o, size_t size)
{
    const ff_read_options defaults = {.quantity = -1, .scale = NAN};
    ff_options_init(o, size, &defaults, sizeof defaults);
}

static ff_status check_options(const char *path, const ff_format *f, const ff_read_options *o, ff_error *err)
{
    const struct {
        const char *name;
        int given;
        unsigned bit;
    } all[] = {{"columns", o->columns != NULL, FF_READS_COLUMNS},
               {"grid", o->grid != NULL, FF_READS_GRID},
               {"part", o->part != NULL, FF_READS_PART},
               {"dialect", o->dialect != NULL, FF_READS_DIALECT}};
    for (size_t k = 0; k < sizeof all / sizeof all[0]; k++)
        // NOLINTNEXTLINE(clang-analyzer-core.NullDereference): as below
        if (all[k].given && !(f->reads & all[k].bit))
            return ff_error_set(err, FF_ERR_UNSUPPORTED, path, 0, -1, "the format '%s' takes no option '%s'", f->name, all[k].name);
    if (o->quantity != -1 && !ff_quantity_name(o->quantity))
        return ff_error_set(err, FF_ERR_RANGE, path, 0, -1, "found a quantity of number %d, expected -1 to %d", o->quantity,
                            (int)FF_REFLECTANCE_FACTOR);
    if (!ff_azimuth_name(o->azimuth) || !ff_phi_sense_name(o->phi) || !ff_angles_name(o->angles))
        return ff_error_set(err, FF_ERR_RANGE, path, 0, -1,
                            "found the options azimuth %d, phi %d and angles %d, expected 0 to %d, %d and %d", o->azimuth, o->phi,
                            o->angles, (int)FF_AZIMUTH_LIGHT, (int)FF_PHI_CLOCKWISE_OUT, (int)FF_ANGLES_ELEVATION_OUT);
    if (!isnan(o->scale) && !(o->scale > 0 && isfinite(o->scale)))
        return ff_error_set(err, FF_ERR_RANGE, path, 0, -1, "found a scale of %g, expected a finite number > 0", o->scale);
    return FF_OK;
}

/* What the person says of the numbers of a format that leaves that to nobody: instruments write a cosine where it forbids one. What
 * is kept of the file for writing it again, or for what its function integrates to, is then not that of the table. */
static ff_status take_quantity(const char *path, const ff_format *f, ff_quantity asked, ff_table *t, ff_error *err)
{
    if ((f->reads & FF_READS_QUANTITY) || asked == t->quantity) return FF_OK;
    if (t->kept && t->kept_free) t->kept_free(t->kept);
    t->kept = NULL;
    t->kept_free = NULL;
    ff_table_unset_quantity(t);
    ff_table_set_quantity(t, asked);
    return ff_table_count(t, path, err);
}

/* What is asked of a table of any format, when it is read. */
static ff_status take_options(const char *path, const ff_format *f, const ff_read_options *o, ff_table *t, ff_error *err)
{
    ff_status status = ff_table_orient(t, o, err);
    if (status == FF_OK && o->quantity >= 0) status = take_quantity(path, f, (ff_quantity)o->quantity, t, err);
    if (status != FF_OK || isnan(o->scale)) return status;
    for (size_t c = 0; c < t->n_channels; c++) t->channels[c].scale *= o->scale;
    ff_table_note(t, "all values are multiplied by %g, as asked", o->scale);
    return FF_OK;
}

ff_status ff_table_read_with_into(const char *path, const ff_read_options *options, ff_table *out, ff_error *err)
{
    const ff_format *f = NULL;
    ff_read_options o;
    ff_read_options_init(&o);
    if (options) o = *options;
    if ((o.columns || o.dialect) && !o.format) o.format = "csv"; /* whatever it looks like, the person says how to read it */
    ff_status status = o.format ? find_named(path, o.format, &f, err) : ff_format_detect(path, &f, err);
    if (status == FF_OK) status = check_options(path, f, &o, err);
    if (status != FF_OK) return status;
    ff_table t;
    // NOLINTNEXTLINE(clang-analyzer-core.NullDereference): a format was found where the status is FF_OK
    status = f->read(path, &o, &t, err);
    if (status != FF_OK) return status;
    status = take_options(path, f, &o, &t, err);
    if (status == FF_OK)
        *out = t;
    else
        ff_table_clear(&t);
    return status;
}

ff_status ff_table_read_into(const char *path, const char *format, ff_table *out, ff_error *err)
{
    ff_read_options o;
    ff_read_options_init(&o);
    o.format = format;
    return ff_table_read_with_into(path, &o, out, err);
}

ff_status ff_table_write_with(const char *path, const char *format, const ff_table *t, struct ff_outputs *with, ff_error *err)
{
    char names[LIST];
    const ff_format *f = NULL;
    if (format) {
        ff_status status = find_named(path, format, &f, err);
        if (status != FF_OK) return status;
        if (!f->write)
            return ff_error_set(err, FF_ERR_UNSUPPORTED, path, 0, -1, "format '%s' can only be read, expected one of %s", format,
                                list_names(1, names));
    } else if (!(f = ff_format_for_writing(path))) {
        return ff_error_set(err, FF_ERR_UNKNOWN, path, 0, -1,
                            "the name tells no format, expected a usual extension or one of the formats %s", list_names(1, names));
    }
    return f->write(path, t, with, err);
}

ff_status ff_table_write(const char *path, const char *format, const ff_table *t, ff_error *err)
{
    return ff_table_write_with(path, format, t, NULL, err);
}
