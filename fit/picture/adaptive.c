/* The loss of a fit by the pictures that the fits make. */
#include "picture_struct.h"
#include "fit/losses/internal_loss.h"
#include "fit/warning/internal_warning.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Parameters of a result as the model takes them: shape [FF_MAX_SHAPE], channel [n_channels][n_channel]. */
static void parameters_of(const ff_fit_result *r, double *shape, double *channel)
{
    for (size_t k = 0; k < r->model.n_shape; k++) shape[k] = r->shape_value[k].value;
    for (size_t k = 0; k < r->n_channels * r->model.n_channel; k++) channel[k] = r->channel_value[k].value;
}

static ff_status compare(const ff_picture *p, ff_adaptive_candidate *c, ff_error *err)
{
    double shape[FF_MAX_SHAPE], *channel = malloc((c->fit.n_channels * c->fit.model.n_channel + 1) * sizeof *channel);
    if (!channel) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    parameters_of(&c->fit, shape, channel);
    const ff_status status = ff_picture_difference(p, &c->fit.model, shape, channel, &c->difference, err);
    free(channel);
    return status;
}

/* A picture this near to a black one, in parts of that one's difference, shows nothing of the data. */
#define AS_BLACK 0.9

/* May the fit be chosen? It has converged, unless none has, and its picture is not as good as black. */
static int may_be_chosen(const ff_adaptive *a, size_t k, int any, double black)
{
    const ff_adaptive_candidate *c = &a->candidate[k];
    return (!any || c->fit.outcome == FF_CONVERGED) && c->difference < AS_BLACK * black;
}

/* The first of those that differ least; a->n where there is none. black: what a black picture differs by. */
static size_t choose(const ff_adaptive *a, double black)
{
    double least = INFINITY;
    size_t chosen = a->n;
    int any = 0;
    for (size_t k = 0; k < a->n; k++) any |= a->candidate[k].fit.outcome == FF_CONVERGED;
    for (size_t k = a->n; k-- > 0;)
        if (may_be_chosen(a, k, any, black)) least = fmin(least, a->candidate[k].difference);
    for (size_t k = a->n; k-- > 0;)
        if (may_be_chosen(a, k, any, black) && a->candidate[k].difference <= least + FF_PICTURE_SAME) chosen = k;
    return chosen;
}

static ff_status nothing_chosen(ff_error *err)
{
    return ff_error_set(err, FF_ERR_DATA, NULL, 0, -1,
                        "under every loss the picture of the model is as far from the data's as a black one: this model does not "
                        "hold these data, or they span too many decades for pictures; name a loss instead of auto, e.g. ln");
}

/* One more candidate; *weighting: what the weighting of its samples is. */
static ff_status add(ff_adaptive *a, const ff_table *t, const ff_model *m, const ff_picture *p, const ff_fit_options *o,
                     ff_weighting *weighting, ff_error *err)
{
    ff_adaptive_candidate *c = &a->candidate[a->n];
    ff_problem *problem = NULL;
    ff_selection selection;
    ff_status status = ff_problem_make(t, m, 1, o, &problem, err);
    if (status == FF_ERR_DATA && a->n > 0) return FF_OK; /* a loss that no sample has a value under says nothing */
    if (status) return status;
    ff_problem_selection(problem, &selection);
    *weighting = selection.weighting;
    status = ff_problem_fit_into(problem, m, o, &c->fit, err);
    ff_problem_free(problem);
    if (status) return status;
    a->n++;
    c->loss = o->loss;
    if (c->fit.outcome == FF_CANCELLED) return ff_error_set(err, FF_ERR_CANCELLED, NULL, 0, -1, "cancelled");
    return compare(p, c, err);
}

/* Losses that say nothing new under these weights: with sigma weights every linear one after the first. */
static int stands_for_another(ff_loss loss, ff_weighting weighting)
{
    if (weighting != FF_WEIGHT_SIGMA || ff_loss_is_curved(loss)) return 0;
    for (int k = 0; k < (int)loss; k++)
        if (!ff_loss_is_curved((ff_loss)k)) return 1;
    return 0;
}

static ff_status warn_of_coverage(ff_adaptive *a)
{
    ff_fit_result *r = &a->candidate[a->chosen].fit;
    const ff_picture_coverage c = a->coverage;
    const double value[] = {(double)c.measured, (double)c.pixels};
    if (value[0] >= FF_PICTURE_COVERED * value[1]) return FF_OK;
    return ff_warnings_say(&r->warnings, FF_WARNING_FEW_PIXELS, value);
}

ff_status ff_fit_adaptive_into(const ff_table *t, const ff_model *m, const ff_fit_options *o, ff_adaptive *out, ff_error *err)
{
    ff_picture *picture = NULL;
    ff_fit_options one = *o;
    ff_weighting weighting = FF_WEIGHT_AUTO;
    if (o->robust != FF_ROBUST_NONE)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1,
                            "the scale of a robust loss is in units of the residual, which are each loss's own: name a loss "
                            "instead of auto");
    one.loss = FF_LOSS_COSINE;
    ff_adaptive *a = calloc(1, sizeof *a);
    if (!a) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    ff_status status = ff_picture_new(t, &one, &picture, err);
    for (int loss = 0; loss < FF_LOSS_COUNT && !status; loss++) {
        one.loss = (ff_loss)loss;
        if (!stands_for_another(one.loss, weighting)) status = add(a, t, m, picture, &one, &weighting, err);
    }
    if (!status) {
        a->chosen = choose(a, ff_picture_black(picture));
        a->coverage = ff_picture_covered(picture);
        status = a->chosen < a->n ? FF_OK : nothing_chosen(err);
    }
    if (!status) {
        status = warn_of_coverage(a);
        if (status) ff_error_set(err, status, NULL, 0, -1, "out of memory");
        /* The samples once more rather than those of every loss all along: there may be millions. */
        one.loss = a->candidate[a->chosen].loss;
        if (!status) status = ff_problem_make(t, m, 1, &one, &a->problem, err);
    }
    ff_picture_free(picture);
    if (status)
        ff_adaptive_clear(a);
    else
        *out = *a;
    free(a);
    return status;
}

void ff_adaptive_clear(ff_adaptive *a)
{
    for (size_t k = 0; k < a->n; k++) ff_fit_result_clear(&a->candidate[k].fit);
    ff_problem_free(a->problem);
    memset(a, 0, sizeof *a);
}
