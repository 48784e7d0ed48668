/* The samples of a table that a page has: some spread evenly over all, and those of a few incidences in their plane. */
#include "internal_html.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Values, samples times channels, of either of both parts; samples at most, and at least. */
enum { VALUES = 30000, MOST = 3000, LEAST_OF_SLICE = 24, MOST_OF_SLICE = 120 };

static int is_prime(size_t n)
{
    for (size_t k = 2; k * k <= n; k++)
        if (n % k == 0) return 0;
    return n > 1;
}

/* The step shares no factor with the sizes of grids unless they are as large. */
static size_t step_for(size_t n, size_t wanted)
{
    size_t step = (n + wanted - 1) / wanted;
    if (step <= 1) return 1;
    while (!is_prime(step)) step++;
    return step;
}

/* ---- which ----------------------------------------------------------------------------------- */

static size_t add_slice(const ff_planes *planes, size_t group, size_t most, ff_html_samples *v)
{
    const size_t first = planes->first[group], count = planes->first[group + 1] - first, step = (count + most - 1) / most;
    ff_html_slice *slice = &v->slice[v->n_slices++];
    *slice = (ff_html_slice){ff_planes_theta(planes, group), planes->sample[first].phi_i, v->n, 0};
    for (size_t i = 0; i < count; i += step) v->index[v->n++] = planes->sample[first + i].index;
    slice->n = v->n - slice->first;
    return slice->n;
}

/* Tables without a sample near a plane of incidence have no slices. */
static ff_status choose(const ff_html_subject *s, ff_html_samples *v)
{
    const ff_table *t = s->r->table;
    size_t group[FF_PLOT_LIST], each = VALUES / FF_HTML_SLICES / s->n_channels, wanted = VALUES / s->n_channels;
    ff_planes planes = {.n_samples = 0};
    each = each < LEAST_OF_SLICE ? LEAST_OF_SLICE : each > MOST_OF_SLICE ? MOST_OF_SLICE : each;
    wanted = wanted < MOST ? wanted : MOST;
    v->step = step_for(t->n, wanted);
    v->n_even = (t->n + v->step - 1) / v->step;
    v->index = calloc(v->n_even + FF_HTML_SLICES * each, sizeof *v->index);
    if (!v->index) return FF_ERR_MEMORY;
    for (size_t i = 0; i < v->n_even; i++) v->index[v->n++] = (uint32_t)(i * v->step);
    const ff_status status = ff_planes_find(t, &planes, NULL);
    if (status) return status == FF_ERR_DATA ? FF_OK : status;
    const ff_plot_choice any = {.n_incidence = 0};
    const size_t n = ff_planes_choose(&planes, &any, FF_HTML_SLICES, group);
    for (size_t k = 0; k < n; k++) add_slice(&planes, group[k], each, v);
    v->width = planes.width;
    ff_planes_free(&planes);
    return FF_OK;
}

/* ---- what is known of them ------------------------------------------------------------------- */

static ff_status look_at_directions(const ff_html_subject *s, ff_html_samples *v)
{
    const double least = cos(s->r->options->max_theta) - 1e-9;
    v->w = malloc(6 * v->n * sizeof *v->w);
    v->why = malloc(v->n);
    if (!v->w || !v->why) return FF_ERR_MEMORY;
    for (size_t i = 0; i < v->n; i++) {
        double *const own[6] = {v->w + i,           v->w + v->n + i, v->w + 2 * v->n + i, v->w + 3 * v->n + i, v->w + 4 * v->n + i,
                                v->w + 5 * v->n + i};
        ff_table_directions(s->r->table, v->index[i], 1, own);
        v->why[i] = (unsigned char)(!s->r->table->valid[v->index[i]]                     ? FF_WHY_INVALID
                                    : !(*own[2] > FF_COS_MIN) || !(*own[5] > FF_COS_MIN) ? FF_WHY_HORIZON
                                    : *own[2] < least || *own[5] < least                 ? FF_WHY_GRAZING
                                                                                         : FF_WHY_OTHER);
    }
    return FF_OK;
}

/* What multiplies the residual of sample `at` of p in channel c. */
static double weight_of(const struct ff_problem *p, size_t c, size_t at)
{
    const size_t block = at / FF_BLOCK, lane = at % FF_BLOCK;
    const double w = ff_problem_plane(p, block, p->weight + p->weight_stride * (int)c)[lane];
    return p->factor ? w * (double)p->factor[c * p->n_blocks * FF_BLOCK + at] : w;
}

/* chain: samples of the page that stand for one of the table, by way of `next`; 0 = none, else the number + 1. */
static void take_weights(const ff_html_subject *s, size_t problem, const uint32_t *chain, const uint32_t *next, ff_html_samples *v)
{
    const struct ff_problem *p = s->r->problem[problem];
    for (size_t at = 0; at < p->n; at++)
        for (uint32_t i = chain[p->index[at]]; i; i = next[i - 1]) {
            v->why[i - 1] = FF_WHY_USED;
            for (size_t k = 0; k < s->n_channels; k++)
                if (s->channel[k].problem == problem) v->weight[k * v->n + i - 1] = weight_of(p, s->channel[k].c, at);
        }
}

static ff_status look_at_weights(const ff_html_subject *s, ff_html_samples *v)
{
    uint32_t *chain = calloc(s->r->table->n, sizeof *chain), *next = calloc(v->n, sizeof *next);
    v->weight = calloc(v->n * s->n_channels, sizeof *v->weight);
    const ff_status status = chain && next && v->weight ? FF_OK : FF_ERR_MEMORY;
    for (size_t i = 0; i < v->n && !status; i++) {
        next[i] = chain[v->index[i]];
        chain[v->index[i]] = (uint32_t)i + 1;
    }
    for (size_t p = 0; p < s->r->n_problems && !status; p++) take_weights(s, p, chain, next, v);
    free(chain);
    free(next);
    return status;
}

ff_status ff_html_samples_make(const ff_html_subject *s, ff_html_samples *out, ff_error *err)
{
    *out = (ff_html_samples){.n = 0};
    ff_status status = choose(s, out);
    if (!status) status = look_at_directions(s, out);
    if (!status) status = look_at_weights(s, out);
    if (status) ff_error_set(err, status, NULL, 0, -1, "%s", ff_status_str(status));
    return status;
}

void ff_html_samples_free(ff_html_samples *v)
{
    free(v->index);
    free(v->w);
    free(v->why);
    free(v->weight);
}

/* ---- JSON ------------------------------------------------------------------------------------ */

static double polar(const double *w, size_t n, size_t i)
{
    return atan2(hypot(w[i], w[n + i]), w[2 * n + i]) / FF_DEGREE;
}

static double azimuth(const double *w, size_t n, size_t i)
{
    return hypot(w[i], w[n + i]) > 1e-12 ? atan2(w[n + i], w[i]) / FF_DEGREE : 0;
}

static void put_angles(ff_json *j, const ff_html_samples *v)
{
    static const char *const key[] = {"theta_i", "phi_i", "theta_o", "phi_o"};
    for (int k = 0; k < 4; k++) {
        const double *w = v->w + (k < 2 ? 0 : 3 * v->n);
        ff_json_array(j, key[k], FF_JSON_LINE);
        for (size_t i = 0; i < v->n; i++)
            ff_json_number(j, NULL, ff_page_rounded(k % 2 ? azimuth(w, v->n, i) : polar(w, v->n, i), 6));
        ff_json_close(j);
    }
}

static void put_values(ff_json *j, const ff_html_subject *s, const ff_html_samples *v)
{
    ff_json_array(j, "values", FF_JSON_LINE);
    for (size_t k = 0; k < s->n_channels; k++) {
        ff_json_array(j, NULL, FF_JSON_LINE);
        for (size_t i = 0; i < v->n; i++)
            ff_json_number(j, NULL,
                           v->why[i] == FF_WHY_INVALID
                               ? NAN
                               : ff_page_rounded(ff_plot_value(s->r->table, s->channel[k].of_table, v->index[i]), 6));
        ff_json_close(j);
    }
    ff_json_close(j);
}

static void put_sigmas(ff_json *j, const ff_html_subject *s, const ff_html_samples *v)
{
    if (!s->r->table->sigma) return;
    ff_json_array(j, "sigmas", FF_JSON_LINE);
    for (size_t k = 0; k < s->n_channels; k++) {
        ff_json_array(j, NULL, FF_JSON_LINE);
        for (size_t i = 0; i < v->n; i++)
            ff_json_number(j, NULL, ff_page_rounded(ff_plot_sigma(s->r->table, s->channel[k].of_table, v->index[i]), 4));
        ff_json_close(j);
    }
    ff_json_close(j);
}

/* One list where all channels have the same. */
static void put_weights(ff_json *j, const ff_html_subject *s, const ff_html_samples *v)
{
    int same = 1;
    for (size_t k = 1; k < s->n_channels && same; k++) same = !memcmp(v->weight, v->weight + k * v->n, v->n * sizeof *v->weight);
    ff_json_array(j, "weights", FF_JSON_LINE);
    for (size_t k = 0; k < (same ? 1 : s->n_channels); k++) ff_page_numbers(j, NULL, v->n, v->weight + k * v->n, 1, 6);
    ff_json_close(j);
}

static void put_slices(ff_json *j, const ff_html_samples *v)
{
    ff_json_array(j, "slices", FF_JSON_LINE);
    for (size_t k = 0; k < v->n_slices; k++) {
        ff_json_object(j, NULL, FF_JSON_LINE);
        ff_json_number(j, "theta_i", ff_page_rounded(v->slice[k].theta_i / FF_DEGREE, 6));
        ff_json_number(j, "phi_i", ff_page_rounded(v->slice[k].phi_i / FF_DEGREE, 6));
        ff_json_integer(j, "first", (int64_t)v->slice[k].first);
        ff_json_integer(j, "n", (int64_t)v->slice[k].n);
        ff_json_close(j);
    }
    ff_json_close(j);
    ff_json_number(j, "slice_width", ff_page_rounded(v->width / FF_DEGREE, 6));
}

void ff_html_samples_json(ff_json *j, const ff_html_subject *s, const ff_html_samples *v)
{
    ff_json_array(j, "channels", FF_JSON_LINE);
    for (size_t k = 0; k < s->n_channels; k++) {
        ff_json_object(j, NULL, FF_JSON_LINE);
        ff_json_string(j, "name", s->channel[k].name);
        ff_json_integer(j, "problem", (int64_t)s->channel[k].problem);
        ff_json_integer(j, "c", (int64_t)s->channel[k].c);
        ff_json_close(j);
    }
    ff_json_close(j);
    ff_json_integer(j, "channels_left_out", (int64_t)s->skipped);
    ff_json_object(j, "samples", FF_JSON_LINE);
    ff_json_integer(j, "of", (int64_t)s->r->table->n);
    ff_json_integer(j, "step", (int64_t)v->step);
    ff_json_integer(j, "even", (int64_t)v->n_even);
    put_angles(j, v);
    ff_json_array(j, "why", FF_JSON_LINE);
    for (size_t i = 0; i < v->n; i++) ff_json_integer(j, NULL, v->why[i]);
    ff_json_close(j);
    put_values(j, s, v);
    put_sigmas(j, s, v);
    put_weights(j, s, v);
    ff_json_close(j);
    put_slices(j, v);
}
