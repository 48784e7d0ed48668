/* The same directions with values drawn anew about a fit: what would be measured if the fit were the surface. */
#include "fit/losses/internal_loss.h"
#include "fit/noise/internal_noise.h"
#include "internal_trust.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_DRAWS = 8 };
#define COPIES_BYTES 268435456.0 /* of all copies together, where that is more than one */

static const double two_pi = 6.28318530717958647692;

static ff_status copy_problem(const struct ff_problem *p, struct ff_problem *out)
{
    const size_t bytes = ff_problem_doubles(p) * sizeof *p->data;
    *out = *p;
    out->data = ff_block_memory(bytes);
    if (!out->data) return FF_ERR_MEMORY;
    memcpy(out->data, p->data, bytes);
    return FF_OK;
}

ff_status ff_redrawn_new(const ff_finished *f, ff_redrawn *out)
{
    const struct ff_problem *p = f->plan.p;
    const double bytes = (double)(ff_problem_doubles(p) * sizeof *p->data), room = COPIES_BYTES / bytes,
                 threads = (double)ff_pool_threads(p->pool);
    ff_redrawn r = {.copies = (size_t)fmax(fmin(threads, room), 1)};
    ff_point where = {.channel = f->at.noise->channel};
    memcpy(where.shape, f->at.noise->shape, sizeof where.shape);
    r.problem = calloc(r.copies, sizeof *r.problem);
    r.model = malloc(p->n_channels * p->n * sizeof *r.model);
    r.deviation = malloc(p->n_channels * p->n_blocks * FF_BLOCK * sizeof *r.deviation);
    ff_status status = r.problem && r.model && r.deviation ? FF_OK : FF_ERR_MEMORY;
    for (size_t k = 0; k < r.copies && !status; k++) status = copy_problem(p, &r.problem[k]);
    if (!status) status = ff_point_evaluate(&f->plan, &f->at, 1, r.model, NULL, NULL);
    if (!status) status = ff_noise_deviations(&f->plan, p, &where, f->at.noise->noise, r.deviation);
    if (status) {
        ff_redrawn_free(&r);
        return status;
    }
    *out = r;
    return FF_OK;
}

void ff_redrawn_free(ff_redrawn *r)
{
    for (size_t k = 0; k < r->copies && r->problem; k++) free(r->problem[k].data);
    free(r->problem);
    free(r->model);
    free(r->deviation);
}

/* Box and Muller (1958). */
static double normal_at(uint64_t seed, uint64_t repeat, uint64_t draw)
{
    return sqrt(-2 * log(ff_trust_uniform(seed, repeat, 2 * draw))) * cos(two_pi * ff_trust_uniform(seed, repeat, 2 * draw + 1));
}

void ff_redrawn_draw(const ff_redrawn *r, size_t copy, uint64_t seed, uint64_t repeat)
{
    const struct ff_problem *p = &r->problem[copy];
    const size_t stride = p->n_blocks * FF_BLOCK;
    for (size_t i = 0; i < p->n; i += FF_BLOCK) {
        const size_t block = i / FF_BLOCK, n = p->n - i < FF_BLOCK ? p->n - i : FF_BLOCK;
        double x[FF_BLOCK];
        ff_geometry g;
        for (int k = 0; k < FF_G_COUNT; k++) g.plane[k] = p->geometry[k] < 0 ? NULL : ff_problem_plane(p, block, p->geometry[k]);
        ff_problem_cosines(&g, x);
        for (size_t c = 0; c < p->n_channels; c++) {
            double *value = ff_problem_plane(p, block, p->value + (int)c);
            for (size_t k = 0; k < n; k++) {
                const double f = r->model[c * p->n + i + k], sd = (double)r->deviation[c * stride + i + k];
                const uint64_t first = (c * p->n + i + k) * MOST_DRAWS;
                value[k] = f;
                for (uint64_t draw = 0; draw < MOST_DRAWS; draw++) {
                    const double y = f + sd * normal_at(seed, repeat, first + draw);
                    if (!ff_loss_has_value(p->loss, y, x[k])) continue;
                    value[k] = y;
                    break;
                }
            }
            ff_problem_aim(p, block, c, x);
        }
    }
}
