/* Means over the aperture for passes: at levels that are held, or that a block chooses for itself. */
#include "internal_evaluate.h"
#include <stdlib.h>

static ff_dirs directions(const struct ff_problem *p, size_t block)
{
    const double *w[6];
    for (int d = 0; d < 6; d++) w[d] = ff_problem_plane(p, block, p->direction + d);
    return (ff_dirs){w[0], w[1], w[2], w[3], w[4], w[5]};
}

static size_t samples(const struct ff_problem *p, size_t block)
{
    const size_t left = p->n - block * FF_BLOCK;
    return left < FF_BLOCK ? left : FF_BLOCK;
}

static int all_centres(const unsigned char *level, size_t n)
{
    for (size_t i = 0; i < n; i++)
        if (level[i] != FF_LEVEL_CENTRE) return 0;
    return 1;
}

int ff_evaluate_means(const ff_pass *pass, size_t block, ff_average_work *work)
{
    const struct ff_problem *p = pass->p;
    const ff_dirs w = directions(p, block);
    const size_t n = samples(p, block);
    unsigned char level[FF_BLOCK];
    if (pass->levels)
        memcpy(level, pass->levels->level + block * FF_BLOCK, n);
    else {
        if (ff_average_centres_do(pass->averaging, &w, n, work)) return 1;
        ff_average_choose(pass->averaging, &w, n, work);
        memcpy(level, work->level, n);
    }
    if (all_centres(level, n)) return 1;
    ff_average_at(pass->averaging, &w, n, level, work);
    return 0;
}

ff_status ff_evaluate_works(const ff_pass *pass, size_t threads, ff_average_work ***out)
{
    const ff_wanted *w = &pass->prepared.wanted;
    *out = NULL;
    if (!pass->averaging) return FF_OK;
    *out = ff_average_works_new(threads, pass->p->n_channels, w->n_shape + w->n_channel);
    return *out ? FF_OK : FF_ERR_MEMORY;
}

typedef struct choice {
    const ff_pass *pass;
    ff_average_work **works;
    ff_levels *levels;
} choice;

static void choose_block(void *context, size_t block, int worker)
{
    const choice *c = context;
    const struct ff_problem *p = c->pass->p;
    const ff_dirs w = directions(p, block);
    const size_t n = samples(p, block);
    if (ff_average_centres_do(c->pass->averaging, &w, n, c->works[worker])) return;
    ff_average_choose(c->pass->averaging, &w, n, c->works[worker]);
    memcpy(c->levels->level + block * FF_BLOCK, c->works[worker]->level, n);
}

ff_levels *ff_levels_new(const ff_pass *pass, int parallel)
{
    const struct ff_problem *p = pass->p;
    choice c = {pass, ff_average_works_new(parallel ? (size_t)ff_pool_threads(p->pool) : 1, p->n_channels, 0),
                calloc(1, sizeof *c.levels + p->n_blocks * FF_BLOCK)};
    if (c.works && c.levels) {
        c.levels->needles = pass->averaging->needles;
        if (parallel)
            ff_pool_run(p->pool, p->n_blocks, choose_block, &c);
        else
            for (size_t block = 0; block < p->n_blocks; block++) choose_block(&c, block, 0);
    } else {
        free(c.levels);
        c.levels = NULL;
    }
    ff_average_works_free(c.works);
    return c.levels;
}
