/* The grid of a Zemax file to be written: what the person asks for, else what the data have. */
#include "internal_zemax.h"
#include "base/internal_input.h"
#include "base/internal_number.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double degree = 3.14159265358979323846 / 180;
const double ff_zemax_axis_most[FF_ZEMAX_AXES] = {360, 90, 360, 180};
const char *const ff_zemax_xyz[3] = {"X", "Y", "Z"};

int ff_zemax_symmetry_of(const ff_table *t)
{
    const double *azimuth = t->axes.node[FF_ZEMAX_AZIMUTH], half = 180 * degree / t->radians_per_unit;
    if (t->axes.n[FF_ZEMAX_ROTATION] > 1) return FF_ZEMAX_ASYMMETRICAL_4D;
    return azimuth[0] >= 0 && azimuth[t->axes.n[FF_ZEMAX_AZIMUTH] - 1] <= half ? FF_ZEMAX_PLANE_SYMMETRICAL : FF_ZEMAX_ASYMMETRICAL;
}

ff_status ff_zemax_check_channels(const ff_table *t, const char *path, ff_error *err)
{
    int same = t->n_channels == 3;
    for (size_t c = 0; c < 3 && same; c++) same = strcmp(t->channels[c].name, ff_zemax_xyz[c]) == 0;
    if (t->n_channels == 1 || same) return FF_OK;
    return ff_error_set(err, FF_ERR_UNSUPPORTED, path, 0, -1,
                        "found %zu channels ('%s' first), but a file of this format has one, or the tristimulus values X, Y and Z; "
                        "write one file per channel, or csv",
                        t->n_channels, t->channels[0].name);
}

/* The grid of a file to be written: "rotation:0/90,incidence:20,azimuth:10,radial:0/2/5/10". A single number is a step. */
typedef struct plan {
    ff_values axis[FF_ZEMAX_AXES];
    int half; /* isotropic data, one rotation: azimuths 0 to 180 */
} plan;

static const char *const plan_name[FF_ZEMAX_AXES] = {"rotation", "incidence", "azimuth", "radial"};
enum { PLAN_ANGLES = 4096, MOST_SAMPLES = 200000000 };
static const char plan_syntax[] = "parts like azimuth:10 (a step in degrees) or radial:0/2/5/10 (ascending angles), of rotation, "
                                  "incidence, azimuth and radial, separated by commas";

static ff_status add_angle(ff_values *v, double angle, ff_error *err)
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

static ff_status add_steps(ff_values *v, double from, double to, double step, ff_error *err)
{
    ff_status status = FF_OK;
    for (int k = 0; from + k * step <= to + 1e-9 && status == FF_OK; k++) status = add_angle(v, from + k * step, err);
    return status;
}

static double axis_end(const plan *p, int k)
{
    static const double end[FF_ZEMAX_AXES] = {360, 85, 360, 175};
    return k == FF_ZEMAX_AZIMUTH && p->half ? 180 : end[k];
}

static ff_status bad_grid(const char *part, ff_error *err)
{
    char found[FF_QUOTE];
    return ff_error_set(err, FF_ERR_SYNTAX, NULL, 0, -1, "grid: found %s, expected %s", ff_quote(part, strcspn(part, ","), found),
                        plan_syntax);
}

static ff_status out_of_grid(int k, double v, double least, double most, ff_error *err)
{
    return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "grid: found %s %g, expected ascending degrees from %g to %g", plan_name[k],
                        v, least, most);
}

/* The numbers of one part, up to ',' or the end; *p moves there. */
static ff_status parse_angles(plan *p, int k, const char *part, const char **at, ff_error *err)
{
    ff_values *v = &p->axis[k];
    const double most = k == FF_ZEMAX_INCIDENCE ? 89.9 : k == FF_ZEMAX_AZIMUTH && p->half ? 180 : ff_zemax_axis_most[k];
    for (;;) {
        double angle;
        const char *end = ff_number_read(*at, &angle);
        if (!end || (*end != '/' && *end != ',' && *end != '\0')) return bad_grid(part, err);
        const int is_step = v->n == 0 && *end != '/';
        if (is_step && !(angle >= 0.01 && angle <= 360)) return out_of_grid(k, angle, 0.01, 360, err);
        if (is_step) {
            *at = end;
            return add_steps(v, 0, axis_end(p, k), angle, err);
        }
        if (!(angle >= 0 && angle <= most) || (v->n && angle <= v->value[v->n - 1]) || v->n == PLAN_ANGLES)
            return out_of_grid(k, angle, 0, most, err);
        const ff_status status = add_angle(v, angle, err);
        *at = *end == '/' ? end + 1 : end;
        if (status != FF_OK || *end != '/') return status;
    }
}

static ff_status parse_grid(const char *grid, plan *p, ff_error *err)
{
    for (const char *at = grid; at;) {
        int k = 0;
        const char *part = at;
        const size_t length = strcspn(at, ":,");
        while (k < FF_ZEMAX_AXES && (strlen(plan_name[k]) != length || strncmp(at, plan_name[k], length) != 0)) k++;
        if (k == FF_ZEMAX_AXES || at[length] != ':' || p->axis[k].n) return bad_grid(part, err);
        at += length + 1;
        const ff_status status = parse_angles(p, k, part, &at, err);
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
static ff_status plan_from_data(const ff_table *t, int k, plan *p, ff_error *err)
{
    static const double step[2] = {10, 5};
    ff_status status = FF_OK;
    double *bin = malloc(BINS * sizeof *bin), last = 0;
    if (!bin) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for the angles of a grid");
    const size_t count = distinct(t, k == FF_ZEMAX_ROTATION, bin);
    for (int b = 0; b < BINS && status == FF_OK; b++) {
        if (bin[b] < 0) continue;
        last = bin[b];
        if (count <= DISTINCT) status = add_angle(&p->axis[k], last, err);
    }
    if (status == FF_OK && count > DISTINCT)
        status = add_steps(&p->axis[k], 0, k == FF_ZEMAX_ROTATION ? 360 : fmin(last, 85), step[k], err);
    if (status == FF_OK && count == 0) status = add_angle(&p->axis[k], 0, err);
    ff_values *v = &p->axis[k];
    if (status == FF_OK && k == FF_ZEMAX_ROTATION && v->n > 1 && v->value[0] == 0 && v->value[v->n - 1] < 360)
        status = add_angle(v, 360, err);
    free(bin);
    return status;
}

static ff_status plan_radial(plan *p, ff_error *err)
{
    static const double from[] = {0, 2, 5, 10, 20, 60}, step[] = {0.5, 1, 2.5, 5, 5, 10}, to[] = {1.5, 4, 7.5, 15, 55, 170};
    ff_status status = FF_OK;
    for (int k = 0; k < 6 && status == FF_OK; k++) status = add_steps(&p->axis[FF_ZEMAX_RADIAL], from[k], to[k], step[k], err);
    return status;
}

/* Data of this layout keep their own angles. */
static ff_status plan_like(const ff_table *t, plan *p, ff_error *err)
{
    ff_status status = FF_OK;
    for (int k = 0; k < FF_ZEMAX_AXES && status == FF_OK; k++) {
        const int given = p->axis[k].n > 0;
        for (size_t i = 0; i < t->axes.n[k] && !given && status == FF_OK; i++)
            status = add_angle(&p->axis[k], t->radians_per_unit / degree * t->axes.node[k][i], err);
    }
    return status;
}

static ff_status fill_plan(const ff_table *t, const char *grid, plan *p, ff_error *err)
{
    ff_status status = grid ? parse_grid(grid, p, err) : FF_OK;
    if (status == FF_OK && t->axes.kind == FF_AXES_SPECULAR) status = plan_like(t, p, err);
    if (status == FF_OK && !p->axis[FF_ZEMAX_ROTATION].n)
        status = t->isotropic ? add_angle(&p->axis[FF_ZEMAX_ROTATION], 0, err) : plan_from_data(t, FF_ZEMAX_ROTATION, p, err);
    if (status == FF_OK && !p->axis[FF_ZEMAX_INCIDENCE].n) status = plan_from_data(t, FF_ZEMAX_INCIDENCE, p, err);
    if (status == FF_OK && !p->axis[FF_ZEMAX_AZIMUTH].n)
        status = add_steps(&p->axis[FF_ZEMAX_AZIMUTH], 0, axis_end(p, FF_ZEMAX_AZIMUTH), 10, err);
    if (status == FF_OK && !p->axis[FF_ZEMAX_RADIAL].n) status = plan_radial(p, err);
    return status;
}

static ff_status make_layout(const ff_table *t, const plan *p, ff_table *out, ff_error *err)
{
    ff_zemax_cells c;
    size_t n[FF_ZEMAX_AXES];
    const double *node[FF_ZEMAX_AXES];
    double samples = (double)t->n_channels;
    for (int k = 0; k < FF_ZEMAX_AXES; k++) n[k] = p->axis[k].n, node[k] = p->axis[k].value, samples *= (double)n[k];
    if (samples > MOST_SAMPLES)
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "grid: found %.0f values, expected at most %d: take larger steps",
                            samples, MOST_SAMPLES);
    ff_status status = ff_zemax_cells_make(n, node, p->half ? FF_ZEMAX_PLANE_SYMMETRICAL : FF_ZEMAX_ASYMMETRICAL, &c, err);
    if (status != FF_OK) return status;
    status = ff_table_init_axes(FF_AXES_SPECULAR, n, node, degree, t->n_channels, ff_zemax_has_cells(n, node), out, err);
    if (status == FF_OK) {
        const double *const of[FF_ZEMAX_AXES] = {c.of[0], c.of[1], c.of[2], c.of[3]};
        if (out->weight) ff_table_product_weights(out, of);
        out->isotropic = n[FF_ZEMAX_ROTATION] == 1;
        ff_table_name_channels_like(out, t);
    }
    free(c.memory);
    return status;
}

static void free_plan(plan *p)
{
    for (int k = 0; k < FF_ZEMAX_AXES; k++) free(p->axis[k].value);
}

/* Several rotations are a file of the full circle, whatever the data: between two of them readers need both sides of the plane. */
static ff_status plan_halves(const ff_table *t, const char *grid, int *half, ff_error *err)
{
    plan p = {.half = 0};
    ff_status status = grid && t->isotropic ? parse_grid(grid, &p, err) : FF_OK;
    *half = t->isotropic && p.axis[FF_ZEMAX_ROTATION].n < 2;
    if (t->axes.kind == FF_AXES_SPECULAR) *half &= ff_zemax_symmetry_of(t) == FF_ZEMAX_PLANE_SYMMETRICAL;
    free_plan(&p);
    return status;
}

ff_status ff_zemax_layout(const ff_table *t, const char *grid, ff_table *out, ff_error *err)
{
    plan p = {.half = 0};
    ff_status status = ff_zemax_check_channels(t, NULL, err);
    if (status == FF_OK) status = plan_halves(t, grid, &p.half, err);
    if (status == FF_OK) status = fill_plan(t, grid, &p, err);
    if (status == FF_OK) status = make_layout(t, &p, out, err);
    free_plan(&p);
    return status;
}
