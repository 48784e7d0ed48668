/* Comment lines of a CSV: "# quantity: brdf", "# angles: degrees", "# isotropic: yes", "# facetfit-csv: 1". */
#define _GNU_SOURCE
#include "internal_csv.h"
#include "base/internal_input.h"
#include <string.h>
#include <strings.h>

static const double degree = 3.14159265358979323846 / 180;

typedef struct comment {
    ff_csv_head *head;
    const char *key, *value, *path;
    long line;
    ff_error *err;
} comment;

static ff_status unexpected(const comment *c, const char *expected)
{
    char quoted[FF_QUOTE];
    return ff_error_set(c->err, FF_ERR_FORMAT, c->path, c->line, -1, "'# %s:': found %s, expected %s", c->key,
                        ff_quote(c->value, strlen(c->value), quoted), expected);
}

static ff_status set_quantity(const comment *c)
{
    static const char *const name[3] = {"brdf", "brdf-cos", "reflectance-factor"};
    for (int q = 0; q < 3; q++)
        if (strcasecmp(c->value, name[q]) == 0) {
            c->head->quantity = (ff_quantity)q;
            c->head->quantity_is_said = 1;
            return FF_OK;
        }
    return unexpected(c, "brdf, brdf-cos or reflectance-factor");
}

static ff_status set_angles(const comment *c)
{
    if (strcasecmp(c->value, "degrees") != 0 && strcasecmp(c->value, "radians") != 0) return unexpected(c, "degrees or radians");
    c->head->angles_are_said = 1;
    c->head->radians_per_unit = strcasecmp(c->value, "radians") == 0 ? 1 : degree;
    return FF_OK;
}

static ff_status set_isotropic(const comment *c)
{
    if (strcasecmp(c->value, "yes") != 0 && strcasecmp(c->value, "no") != 0) return unexpected(c, "yes or no");
    c->head->isotropic = strcasecmp(c->value, "yes") == 0;
    return FF_OK;
}

static ff_status set_version(const comment *c)
{
    c->head->is_ours = 1;
    return strcmp(c->value, "1") == 0 ? FF_OK : unexpected(c, "version 1");
}

/* Commas at the end are what a spreadsheet adds. */
ff_status ff_csv_comment(ff_csv_head *h, char *text, int after_header, const char *path, long line, ff_error *err)
{
    static const struct {
        const char *key;
        ff_status (*set)(const comment *);
    } known[] = {{"quantity", set_quantity}, {"angles", set_angles}, {"isotropic", set_isotropic}, {"facetfit-csv", set_version}};
    char *key = text + strspn(text, "# \t"), *colon = strchr(key, ':');
    if (!colon) return FF_OK;
    char *value = colon + 1 + strspn(colon + 1, " \t"), *end = value + strlen(value);
    while (end > value && strchr(", \t\"", end[-1])) end--;
    *end = '\0';
    for (*colon-- = '\0'; colon >= key && (*colon == ' ' || *colon == '\t'); colon--) *colon = '\0';
    for (size_t k = 0; k < sizeof known / sizeof known[0]; k++) {
        if (strcasecmp(key, known[k].key) != 0) continue;
        if (after_header)
            return ff_error_set(err, FF_ERR_FORMAT, path, line, -1, "found '# %s:' after the header line, expected it before", key);
        return known[k].set(&(const comment){h, known[k].key, value, path, line, err});
    }
    return FF_OK;
}
