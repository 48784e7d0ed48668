/* The angles of a file to be written: parts of a text, or what the data have. */
#include "internal_scatter_plan.h"
#include "base/internal_input.h"
#include "base/internal_number.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double degree = 3.14159265358979323846 / 180;
static const char *const axis_name[FF_SCATTER_AXES] = {"rotation", "incidence", "azimuth", "radial"};
enum { MOST_ANGLES = 4096 };

ff_status ff_scatter_plan_add(ff_values *v, double angle, ff_error *err)
{
    if (v->n == v->capacity) {
        double *larger = realloc(v->value, (2 * v->capacity + 16) * sizeof *larger);
        if (!larger) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for the angles of a grid");
        v->value = larger;
        v->capacity = 2 * v->capacity + 16;
    }
    v->value[v->n++] = angle;
    return FF_OK;
}

ff_status ff_scatter_plan_copy(ff_values *v, size_t n, const double *node, double factor, ff_error *err)
{
    ff_status status = FF_OK;
    for (size_t i = 0; i < n && status == FF_OK; i++) status = ff_scatter_plan_add(v, factor * node[i], err);
    return status;
}

ff_status ff_scatter_plan_steps(ff_values *v, double from, double to, double step, ff_error *err)
{
    ff_status status = FF_OK;
    for (int k = 0; from + k * step <= to + 1e-9 && status == FF_OK; k++) status = ff_scatter_plan_add(v, from + k * step, err);
    return status;
}

/* "rotation, incidence and radial", of the axes that there are. */
static void list_axes(unsigned axes, char out[64])
{
    int left = 0;
    for (int k = 0; k < FF_SCATTER_AXES; k++) left += (axes >> k & 1) != 0;
    out[0] = '\0';
    for (int k = 0; k < FF_SCATTER_AXES; k++) {
        if (!(axes >> k & 1)) continue;
        strcat(out, axis_name[k]);
        strcat(out, --left > 1 ? ", " : left ? " and " : "");
    }
}

static ff_status bad_grid(const char *part, unsigned axes, ff_error *err)
{
    char found[FF_QUOTE], names[64];
    list_axes(axes, names);
    return ff_error_set(err, FF_ERR_SYNTAX, NULL, 0, -1,
                        "grid: found %s, expected parts like azimuth:10 (a step in degrees) or radial:0/2/5/10 (ascending angles), "
                        "of %s, separated by commas",
                        ff_quote(part, strcspn(part, ","), found), names);
}

static ff_status out_of_grid(int k, double v, double least, double most, ff_error *err)
{
    return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "grid: found %s %g, expected ascending degrees from %g to %g", axis_name[k],
                        v, least, most);
}

/* The numbers of one part, up to ',' or the end; *p moves there. */
static ff_status parse_angles(const ff_scatter_limits *limits, ff_values *v, int k, const char *part, const char **at,
                              ff_error *err)
{
    const double most = limits->most[k];
    for (;;) {
        double angle;
        const char *end = ff_number_read(*at, &angle);
        if (!end || (*end != '/' && *end != ',' && *end != '\0')) return bad_grid(part, limits->axes, err);
        const int is_step = v->n == 0 && *end != '/';
        if (is_step && !(angle >= 0.01 && angle <= 360)) return out_of_grid(k, angle, 0.01, 360, err);
        if (is_step) {
            *at = end;
            return ff_scatter_plan_steps(v, 0, limits->end[k], angle, err);
        }
        if (!(angle >= 0 && angle <= most) || (v->n && angle <= v->value[v->n - 1]) || v->n == MOST_ANGLES)
            return out_of_grid(k, angle, 0, most, err);
        const ff_status status = ff_scatter_plan_add(v, angle, err);
        *at = *end == '/' ? end + 1 : end;
        if (status != FF_OK || *end != '/') return status;
    }
}

ff_status ff_scatter_plan_parse(const char *grid, const ff_scatter_limits *limits, ff_scatter_plan *p, ff_error *err)
{
    for (const char *at = grid; at;) {
        int k = 0;
        const char *part = at;
        const size_t length = strcspn(at, ":,");
        while (k < FF_SCATTER_AXES && (strlen(axis_name[k]) != length || strncmp(at, axis_name[k], length) != 0)) k++;
        if (k == FF_SCATTER_AXES || !(limits->axes >> k & 1) || at[length] != ':' || p->axis[k].n)
            return bad_grid(part, limits->axes, err);
        at += length + 1;
        const ff_status status = parse_angles(limits, &p->axis[k], k, part, &at, err);
        if (status != FF_OK) return status;
        at = *at == ',' ? at + 1 : NULL;
    }
    return FF_OK;
}

enum { BINS = 36000, DISTINCT = 36 };
/* Distinct angles of the data, in degrees within [0, 90) or [0, 360), to a hundredth of a degree; the first met of each stands for
 * it. bin [BINS] ends with -1 in the empty ones. Returns their number. */
static size_t distinct(const ff_table *t, int rotation, double *bin)
{
    enum { BLOCK = 512 };
    double plane[4][BLOCK], *const planes[4] = {plane[0], plane[1], plane[2], plane[3]};
    size_t count = 0;
    for (int b = 0; b < BINS; b++) bin[b] = -1;
    for (size_t first = 0; first < t->n; first += BLOCK) {
        const size_t n = t->n - first < BLOCK ? t->n - first : BLOCK;
        ff_table_angles(t, degree, first, n, planes);
        for (size_t k = 0; k < n; k++) {
            const double turn = plane[0][k] < 0 ? 180 : 0; /* a negative theta is on the other side */
            double v = rotation ? -90 - turn - plane[1][k] : fabs(plane[0][k]);
            if (rotation) v -= 360 * floor(v / 360);
            if (!t->valid[first + k] || !(v >= 0 && v < (rotation ? 360 : 89.995))) continue;
            const long b = lround(v * 100) % BINS;
            if (fabs(v - 0.01 * (double)b) < 1e-9 || (rotation && b == 0)) v = (double)b / 100;
            if (bin[b] < 0) bin[b] = v, count++;
        }
    }
    return count;
}

/* The data's own angles when they are few, else steps over their range. Rotation 0 comes again as 360: a reader that interpolates
 * needs it. */
ff_status ff_scatter_plan_from_data(const ff_table *t, int k, ff_scatter_plan *p, ff_error *err)
{
    static const double step[2] = {10, 5};
    ff_status status = FF_OK;
    double *bin = malloc(BINS * sizeof *bin), last = 0;
    if (!bin) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for the angles of a grid");
    const size_t count = distinct(t, k == FF_SCATTER_ROTATION, bin);
    for (int b = 0; b < BINS && status == FF_OK; b++) {
        if (bin[b] < 0) continue;
        last = bin[b];
        if (count <= DISTINCT) status = ff_scatter_plan_add(&p->axis[k], last, err);
    }
    if (status == FF_OK && count > DISTINCT)
        status = ff_scatter_plan_steps(&p->axis[k], 0, k == FF_SCATTER_ROTATION ? 360 : fmin(last, 85), step[k], err);
    if (status == FF_OK && count == 0) status = ff_scatter_plan_add(&p->axis[k], 0, err);
    ff_values *v = &p->axis[k];
    if (status == FF_OK && k == FF_SCATTER_ROTATION && v->n > 1 && v->value[0] == 0 && v->value[v->n - 1] < 360)
        status = ff_scatter_plan_add(v, 360, err);
    free(bin);
    return status;
}

void ff_scatter_plan_clear(ff_scatter_plan *p)
{
    for (int k = 0; k < FF_SCATTER_AXES; k++) free(p->axis[k].value);
    *p = (ff_scatter_plan){0};
}
