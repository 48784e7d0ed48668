/* Tables on other directions. */
#include "resample_struct.h"
#include "ff_interpolate.h"
#include "internal_node_means.h"
#include "internal_reflectance.h"
#include "models/model_struct.h"
#include "base/internal_options.h"
#include "base/internal_order.h"
#include "base/internal_pool.h"
#include "data_formats/table/internal_table.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { BLOCK = 512 };

void ff_resample_options_init_size(ff_resample_options *o, size_t size)
{
    const ff_resample_options defaults = {.threads = 0};
    ff_options_init(o, size, &defaults, sizeof defaults);
}

/* ---- copies ---------------------------------------------------------------------------------- */

static int copy_plane(double **to, const double *from, size_t n)
{
    if (!from) return 1;
    if (!*to) *to = malloc(n * sizeof **to);
    if (*to) memcpy(*to, from, n * sizeof **to);
    return *to != NULL;
}

ff_status ff_table_copy_into(const ff_table *t, ff_table *out, ff_error *err)
{
    ff_table c;
    ff_status status = ff_table_init(t->n, t->n_channels, t->grid, t->sigma != NULL, t->weight != NULL, &c, err);
    if (status != FF_OK) return status;
    int copied = copy_plane(&c.value, t->value, t->n * t->n_channels) && copy_plane(&c.sigma, t->sigma, t->n * t->n_channels) &&
                 copy_plane(&c.weight, t->weight, t->n);
    for (int k = 0; k < 4; k++)
        copied = copied && copy_plane(&c.angle[k], t->angle[k], t->n) && copy_plane(&c.axes.node[k], t->axes.node[k], t->axes.n[k]);
    if (!copied) {
        ff_table_clear(&c);
        return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for a copy of %zu samples", t->n);
    }
    memcpy(c.valid, t->valid, t->n);
    memcpy(c.channels, t->channels, t->n_channels * sizeof *t->channels);
    c.axes.kind = t->axes.kind;
    memcpy(c.axes.n, t->axes.n, sizeof c.axes.n);
    c.radians_per_unit = t->radians_per_unit;
    c.isotropic = t->isotropic;
    c.quantity = t->quantity;
    c.n_invalid = t->n_invalid;
    c.n_negative = t->n_negative;
    memcpy(c.format, t->format, sizeof c.format);
    memcpy(c.note, t->note, sizeof c.note);
    memcpy(c.note_hint, t->note_hint, sizeof c.note_hint);
    if (t->cells) c.cells = t->cells->share(t->cells);
    if (t->kept && t->kept_share) {
        c.kept = t->kept_share(t->kept);
        c.kept_free = t->kept_free;
        c.kept_incidence = t->kept_incidence;
        c.kept_around = t->kept_around;
        c.kept_share = t->kept_share;
        if (!c.kept) {
            ff_table_clear(&c);
            return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for a copy of %zu samples", t->n);
        }
    }
    *out = c;
    return FF_OK;
}

/* ---- the same directions? -------------------------------------------------------------------- */

/* 1 when both tables have the same pairs of directions in the same order, to rounding. */
static int same_directions(const ff_table *a, const ff_table *b)
{
    enum { FEW = 128 };
    double x[6][FEW], y[6][FEW];
    double *const px[6] = {x[0], x[1], x[2], x[3], x[4], x[5]}, *const py[6] = {y[0], y[1], y[2], y[3], y[4], y[5]};
    if (a->n != b->n) return 0;
    if (a->grid && a->grid == b->grid) return 1;
    for (size_t first = 0; first < a->n; first += FEW) {
        const size_t n = a->n - first < FEW ? a->n - first : FEW;
        ff_table_directions(a, first, n, px);
        ff_table_directions(b, first, n, py);
        for (int k = 0; k < 6; k++)
            for (size_t i = 0; i < n; i++)
                if (!(fabs(x[k][i] - y[k][i]) < 1e-12)) return 0;
    }
    return 1;
}

/* ---- what the format cannot hold ------------------------------------------------------------- */

static size_t count_invalid(const ff_table *t)
{
    size_t n = 0;
    for (size_t i = 0; i < t->n; i++) n += t->valid[i] == 0;
    return n;
}

static void raise_negative(ff_table *t, ff_resample_report *r)
{
    for (size_t c = 0; c < t->n_channels; c++)
        for (size_t i = 0; i < t->n; i++) {
            double *v = &t->value[c * t->n + i];
            if (!t->valid[i] || *v >= 0) continue;
            *v = 0;
            r->raised++;
        }
    if (r->raised) ff_table_note(t, "%zu negative values became 0: the format holds none", r->raised);
}

static void drop(ff_table *t, const ff_format *to, ff_resample_report *r)
{
    const unsigned holds = to->holds;
    if (t->sigma && !(holds & FF_HOLDS_SIGMA)) {
        free(t->sigma);
        t->sigma = NULL;
        ff_table_note(t, "standard deviations are dropped: the format '%s' has none", to->name);
    }
    if (t->weight && !to->layout && !(holds & FF_HOLDS_WEIGHTS)) /* with a layout they follow from the directions */
        ff_table_note(t, "weights of the samples are dropped: the format '%s' has none", to->name);
    if (!(holds & FF_HOLDS_NEGATIVE)) raise_negative(t, r);
    if (r->as_it_is && !(holds & FF_HOLDS_INVALID) && count_invalid(t))
        ff_table_note(t, "%zu samples that were not measured are left out", count_invalid(t));
    if (t->cells && r->as_it_is)
        ff_table_note(
            t,
            "values are means over cells of directions, whose extent the format '%s' does not hold: read again they stand "
            "at the centres, and the reflectance between them is guessed",
            to->name);
    int named = 0;
    for (size_t c = 0; c < t->n_channels; c++) named |= isfinite(t->channels[c].wavelength_nm);
    if (named && !(holds & (FF_HOLDS_NAMES | FF_HOLDS_NM)))
        ff_table_note(t, "names and wavelengths of the channels are dropped: the format '%s' has none", to->name);
    if (!(holds & FF_HOLDS_DOUBLE) && to->precision) ff_table_note(t, "values are rounded: %s", to->precision);
}

/* ---- interpolation --------------------------------------------------------------------------- */

/* What the threads share, and what each has of its own. */
typedef struct filling {
    const ff_table *t;
    const ff_interpolant *p;
    ff_table *out;
    const ff_node_means *means; /* NULL: values are those of p */
    int keep_beyond;
    const volatile int *cancel;
    double *value;                       /* [threads][n_channels][BLOCK] */
    size_t (*found)[FF_FOUND_BELOW + 1]; /* [threads] counts            */
} filling;

/* Values of cells: a peak's cell holds its mean, which a point beside the border would miss. */
static void average(const filling *f, size_t first, const double *const planes[6], size_t n, double *value, unsigned char *found)
{
    for (size_t i = 0; i < n; i++) {
        const double wi[3] = {planes[0][i], planes[1][i], planes[2][i]}, wo[3] = {planes[3][i], planes[4][i], planes[5][i]};
        const int above = wi[2] > FF_COS_MIN && wo[2] > FF_COS_MIN;
        for (size_t c = 0; c < f->t->n_channels; c++) value[c * n + i] = 0;
        found[i] = !above                                                        ? FF_FOUND_BELOW
                   : ff_node_means_at(f->means, first + i, wi, wo, value + i, n) ? FF_FOUND_BETWEEN
                                                                                 : FF_FOUND_BEYOND;
    }
}

static void fill_block(void *context, size_t block, int worker)
{
    const filling *f = context;
    const size_t channels = f->t->n_channels, first = block * BLOCK, n = f->out->n - first < BLOCK ? f->out->n - first : BLOCK;
    double plane[6][BLOCK], *const planes[6] = {plane[0], plane[1], plane[2], plane[3], plane[4], plane[5]};
    double *value = f->value + (size_t)worker * channels * BLOCK;
    unsigned char found[BLOCK];
    ff_table *out = f->out;
    if (f->cancel && *f->cancel) return;
    ff_table_directions(out, first, n, planes);
    if (f->means)
        average(f, first, (const double *const *)planes, n, value, found);
    else
        ff_interpolant_eval_reciprocal(f->p, (const double *const *)planes, n, value, found);
    for (size_t i = 0; i < n; i++) {
        f->found[worker][found[i]]++;
        if (found[i] == FF_FOUND_BELOW || (found[i] == FF_FOUND_BEYOND && !f->keep_beyond)) out->valid[first + i] = 0;
        for (size_t c = 0; c < out->n_channels && out->valid[first + i]; c++)
            out->value[c * out->n + first + i] = value[(channels == 1 ? 0 : c) * n + i] / out->channels[c].scale;
    }
}

static ff_status fill(const ff_table *t, const ff_interpolant *p, const ff_node_means *means, const ff_format *to,
                      const ff_resample_options *o, ff_table *out, ff_resample_report *r, ff_error *err)
{
    ff_pool *pool = ff_pool_new(o->threads ? o->threads : ff_threads_default());
    filling f = {.t = t,
                 .p = p,
                 .means = means,
                 .out = out,
                 .keep_beyond = o->beyond || !(to->holds & FF_HOLDS_INVALID),
                 .cancel = o->cancel};
    const size_t threads = pool ? (size_t)ff_pool_threads(pool) : 0;
    f.value = malloc((threads + 1) * t->n_channels * BLOCK * sizeof *f.value);
    f.found = calloc(threads + 1, sizeof *f.found);
    ff_status status = FF_OK;
    if (pool && f.value && f.found) {
        ff_pool_run(pool, (out->n + BLOCK - 1) / BLOCK, fill_block, &f);
        size_t *const counter[] = {&r->at_sample, &r->between, &r->reciprocal, &r->beyond, &r->below_horizon};
        for (size_t w = 0; w < threads; w++)
            for (int k = 0; k <= FF_FOUND_BELOW; k++) *counter[k] += f.found[w][k];
        if (o->cancel && *o->cancel) status = ff_error_set(err, FF_ERR_CANCELLED, NULL, 0, -1, "cancelled");
    } else {
        status = ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for %zu channels", t->n_channels);
    }
    ff_pool_free(pool);
    free(f.value);
    free(f.found);
    return status;
}

/* What others say of a sample against what was measured, for samples spread over the table. */
static ff_status predict(const ff_table *t, const ff_interpolant *p, ff_found (*from)(const ff_interpolant *, size_t, double *),
                         ff_prediction *out, ff_error *err)
{
    enum { MOST = 4000 };
    const size_t step = t->n / MOST + 1;
    double *error = malloc(MOST * sizeof *error), *value = malloc(t->n_channels * sizeof *value);
    *out = (ff_prediction){0, NAN, NAN, NAN};
    if (!error || !value) {
        free(error);
        free(value);
        return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for %zu channels", t->n_channels);
    }
    for (size_t i = 0; i < t->n && ff_interpolant_regresses(p); i += step) {
        double predicted = 0, measured = 0;
        if (!ff_table_is_measured(t, i) || from(p, i, value) != FF_FOUND_BETWEEN) continue;
        for (size_t c = 0; c < t->n_channels; c++) {
            predicted += value[c];
            measured += t->channels[c].scale * t->value[c * t->n + i];
        }
        if (predicted > 0 && measured > 0) error[out->n++] = fabs(log(predicted / measured));
    }
    qsort(error, out->n, sizeof *error, ff_ascending);
    if (out->n) *out = (ff_prediction){out->n, error[out->n / 2], error[out->n * 95 / 100], error[out->n - 1]};
    free(error);
    free(value);
    return FF_OK;
}

static ff_status weigh_energy(const ff_table *t, const ff_interpolant *p, const ff_table *out, ff_resample_report *r, ff_error *err)
{
    ff_energy e;
    const ff_status status = ff_energy_compare(t, p, out, &e, err);
    if (status != FF_OK) return status;
    r->incidences = e.incidences;
    r->missed = e.missed;
    r->lost = e.lost;
    r->lost_most = e.most;
    r->lost_at = e.at;
    return FF_OK;
}

/* Cells that are written as the directions of their centres: what a reader interpolates between these. */
static ff_status weigh_centres(const ff_table *t, ff_table *made, ff_resample_report *r, ff_error *err)
{
    ff_interpolant *p;
    ff_status status = ff_interpolant_new(t, 0, &p, err);
    if (status != FF_OK) return status;
    ff_cells *cells = made->cells;
    made->cells = NULL;
    status = weigh_energy(t, p, made, r, err);
    made->cells = cells;
    ff_interpolant_free(p);
    return status;
}

static ff_status interpolate(const ff_table *t, const ff_format *to, const ff_resample_options *o, ff_table *out,
                             ff_resample_report *r, ff_error *err)
{
    ff_interpolant *p;
    ff_status status = ff_interpolant_new(t, 0, &p, err);
    if (status != FF_OK) return status;
    ff_node_means *means = t->cells ? ff_node_means_new(t, out) : NULL;
    const char *of = means && ff_node_means_is_wide(means) ? "; means over what each sample stands for" : "";
    snprintf(r->method, sizeof r->method, "%s%s", ff_interpolant_method(p), of);
    r->in_plane = ff_interpolant_is_in_plane(p);
    if (t->cells && !means) status = ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for the axes of the new directions");
    if (status == FF_OK) status = fill(t, p, means, to, o, out, r, err);
    ff_node_means_free(means);
    if (status == FF_OK) status = weigh_energy(t, p, out, r, err);
    if (status == FF_OK) status = predict(t, p, ff_interpolant_without, &r->near, err);
    if (status == FF_OK) status = predict(t, p, ff_interpolant_without_incidence, &r->across, err);
    ff_interpolant_free(p);
    if (t->sigma) ff_table_note(out, "standard deviations are dropped: interpolated values have none");
    if (t->weight && !out->weight && !out->grid)
        ff_table_note(out, "weights of the samples are dropped: the new directions have none");
    return status;
}

/* Values that are no numbers were not measured. */
static void leave_out_no_numbers(ff_table *t)
{
    for (size_t i = 0; i < t->n; i++) t->valid[i] = (unsigned char)(t->valid[i] && ff_table_is_measured(t, i));
}

/* What t holds, in a layout that has its directions already; where there is no layout, a copy of t. */
static ff_status take_as_it_is(const ff_table *t, ff_table *made, ff_error *err)
{
    if (made->n == 0) {
        const ff_status status = ff_table_copy_into(t, made, err);
        if (status == FF_OK) made->note[0] = '\0';
        return status;
    }
    if (!copy_plane(&made->sigma, t->sigma, t->n * t->n_channels))
        return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for a copy of %zu samples", t->n);
    memcpy(made->value, t->value, t->n * t->n_channels * sizeof *t->value);
    memcpy(made->valid, t->valid, t->n);
    memcpy(made->channels, t->channels, t->n_channels * sizeof *t->channels);
    if (made->weight && t->weight) memcpy(made->weight, t->weight, t->n * sizeof *t->weight);
    made->quantity = t->quantity;
    return FF_OK;
}

ff_status ff_resample_into(const ff_table *t, const ff_format *to, const ff_resample_options *o, ff_table *out,
                           ff_resample_report *report, ff_error *err)
{
    ff_resample_report r = {.size = sizeof r, .as_it_is = 1, .near = {0, NAN, NAN, NAN}, .across = {0, NAN, NAN, NAN}};
    r.lost = r.lost_most = r.lost_at = NAN;
    ff_table made = {0};
    if (!to->write) return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "the format '%s' can only be read", to->name);
    if (!to->layout && o->grid)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1,
                            "the format '%s' takes the directions as they are, found the grid '%s'", to->name, o->grid);
    /* what came from such a file goes back to it as it is */
    const int back = t->kept && t->kept_share && strcmp(t->format, to->name) == 0 && !o->grid;
    ff_status status = to->layout && !back ? to->layout(t, o->grid, &made, err) : FF_OK;
    if (status != FF_OK) return status;
    if (made.n > 0 && !(made.n_channels == t->n_channels && same_directions(t, &made))) {
        r.as_it_is = 0;
        status = interpolate(t, to, o, &made, &r, err);
    } else {
        r.at_sample = t->n;
        status = take_as_it_is(t, &made, err);
        if (status == FF_OK) leave_out_no_numbers(&made);
        if (status == FF_OK && t->cells) status = weigh_centres(t, &made, &r, err);
    }
    if (status == FF_OK) {
        drop(&made, to, &r);
        status = ff_table_count(&made, NULL, err);
        if (status != FF_OK)
            ff_error_set(
                err, status, NULL, 0, -1,
                "none of the %zu samples that the format '%s' needs lies within the data; extrapolated, they would take the "
                "nearest values",
                made.n, to->name);
    }
    if (status != FF_OK) {
        ff_table_clear(&made);
        return status;
    }
    r.n = made.n;
    r.invalid = made.n_invalid;
    *out = made;
    *report = r;
    return FF_OK;
}

/* ---- for programs that do not see inside ----------------------------------------------------- */

ff_status ff_resample(const ff_table *t, const ff_format *to, const ff_resample_options *o, ff_table **out,
                      ff_resample_report *report, ff_error *err)
{
    ff_resample_options own;
    ff_resample_report r;
    ff_table made;
    ff_resample_options_init(&own);
    ff_status status =
        o ? ff_options_take("ff_resample_options", o, FF_END_OF(ff_resample_options, cancel), &own, sizeof own, err) : FF_OK;
    if (!status && report) status = ff_record_check("ff_resample_report", report, FF_END_OF(ff_resample_report, across), err);
    if (!status) status = ff_resample_into(t, to, &own, &made, &r, err);
    if (!status) status = ff_table_move(&made, out, err);
    if (!status && report) ff_options_init(report, report->size, &r, sizeof r);
    return status;
}

ff_status ff_table_copy(const ff_table *t, ff_table **out, ff_error *err)
{
    ff_table made;
    const ff_status status = ff_table_copy_into(t, &made, err);
    return status ? status : ff_table_move(&made, out, err);
}
