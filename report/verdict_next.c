/* The commands at the end of a verdict: what to try next, and the figure that shows where a fit is off. */
#define _GNU_SOURCE
#include "internal_verdict.h"
#include "internal_fits_text.h"
#include <math.h>
#include <string.h>

enum { CHANGES = 4 };

/* What a command line that is suggested has in place of what the person gave. */
typedef struct changes {
    ff_report_change at[CHANGES];
    size_t n;
} changes;

static void change(changes *c, const char *flag, const char *value)
{
    if (c->n < CHANGES) c->at[c->n++] = (ff_report_change){flag, value};
}

/* "Next: facetfit fit paint.csv --model ggx   # remark". 0: there is no such command line. */
static int put_command(const ff_report_fits *r, const char *begin, const char *command, const changes *c, const char *end,
                       ff_verdict *v)
{
    const size_t used = strlen(v->text);
    ff_verdict_put(v, "%s", begin);
    const size_t at = strlen(v->text), room = sizeof v->text - at;
    if (r->again && room > strlen(end) && r->again(r->again_context, command, c->at, c->n, v->text + at, room - strlen(end))) {
        ff_verdict_put(v, "%s", end);
        return 1;
    }
    v->text[used] = '\0';
    return 0;
}

/* The loss that was chosen is named where the command might choose another, or knows no such choice. */
static void change_loss(const ff_report_fits *r, changes *c)
{
    if (r->adaptive) change(c, "loss", ff_loss_name((int)r->options->loss));
}

/* What a comparison tries if it is not told otherwise. */
static const char *const tried[] = {"schlick", "lambert"};

/* The same Fresnel and diffuse term under other distributions and maskings; of a renderer, its other materials. */
static int compare_next(const ff_report_fits *r, const ff_fit_result *f, ff_verdict *v)
{
    changes c = {.n = 0};
    if (r->target) {
        change(&c, "for", r->target[f - r->fit].target->name);
    } else if (f->model.n_lobes) {
        const char *fresnel = ff_term_at(FF_FRESNEL, (size_t)f->model.lobe[0].fresnel)->name;
        const char *diffuse = f->model.n_bases ? ff_term_at(FF_DIFFUSE, (size_t)f->model.base[0].diffuse)->name : "none";
        if (strcmp(fresnel, tried[0]) != 0) change(&c, "fresnel", fresnel);
        if (strcmp(diffuse, tried[1]) != 0) change(&c, "diffuse", diffuse);
    }
    change_loss(r, &c);
    return put_command(r, "Next: ", "compare", &c, "   # does another model do better?", v);
}

/* Does a parameter rest on fewer than three values? */
static int is_carried_by_few(const ff_fit_result *f)
{
    return ff_verdict_has_warning(f, FF_WARNING_FEW_CARRIERS);
}

/* Can the fit be weighed by the noise? Not where errors or a loss that the person asked for rest on something else. */
static int may_weigh_by_noise(const ff_fit_options *o)
{
    return o->weighting != FF_WEIGHT_NOISE && o->robust == FF_ROBUST_NONE && o->errors != FF_ERRORS_RESIDUALS;
}

static int weigh_next(const ff_report_fits *r, ff_verdict *v)
{
    changes c = {.n = 0};
    change_loss(r, &c);
    change(&c, "weight", "noise");
    return put_command(r, "Next: ", "fit", &c, "   # smaller errors where few values carry a parameter", v);
}

static int look_at_angles(ff_verdict *v)
{
    ff_verdict_put(v, "Next: look at the angles of the file, which the warning below is about");
    return 1;
}

int ff_verdict_next_of_fit(const ff_report_fits *r, const ff_fit_result *f, ff_verdict *v)
{
    const ff_quality quality = ff_quality_of(ff_verdict_explained(r, f));
    v->code = FF_VERDICT_NEXT;
    if (ff_verdict_has_warning(f, FF_WARNING_BRIGHTEST_ELSEWHERE)) return look_at_angles(v);
    if (f->outcome != FF_CONVERGED || ff_verdict_is_of_nothing(f) || quality == FF_QUALITY_POOR) return compare_next(r, f, v);
    if (is_carried_by_few(f) && may_weigh_by_noise(r->options)) return weigh_next(r, v);
    return quality == FF_QUALITY_FAIR && compare_next(r, f, v);
}

/* What fits best, alone: its errors and warnings. */
static int fit_next(const ff_report_fits *r, const ff_fit_result *f, ff_verdict *v)
{
    const int two = !r->target && ff_quality_of(ff_verdict_explained(r, f)) == FF_QUALITY_POOR && f->model.n_lobes == 1;
    char expression[FF_MODEL_NAME], model[FF_MODEL_NAME + 128];
    changes c = {.n = 0};
    if (r->target) {
        const ff_report_target *t = &r->target[f - r->fit];
        snprintf(model, sizeof model, "%s:%s", t->target->name, t->material->name);
        change(&c, "for", model);
    } else {
        ff_model_expression(&f->model, expression, sizeof expression);
        if (two)
            snprintf(model, sizeof model, "%s/%s+%s", ff_report_ndf_name(f), ff_report_masking_name(f), expression);
        else
            snprintf(model, sizeof model, "%s", expression);
        change(&c, "model", model);
    }
    return put_command(r, "Next: ", "fit", &c, two ? "   # do two lobes do better?" : "   # its errors and warnings", v);
}

int ff_verdict_next_of_comparison(const ff_report_fits *r, const ff_fit_result *f, ff_verdict *v)
{
    v->code = FF_VERDICT_NEXT;
    return ff_verdict_has_warning(f, FF_WARNING_BRIGHTEST_ELSEWHERE) ? look_at_angles(v) : fit_next(r, f, v);
}

int ff_verdict_look(const ff_report_fits *r, const ff_fit_result *f, ff_verdict *v)
{
    const ff_explained *e = ff_verdict_explained(r, f);
    const ff_quality quality = ff_quality_of(e);
    char expression[FF_MODEL_NAME], end[96];
    v->code = FF_VERDICT_LOOK;
    if (f->outcome != FF_CONVERGED || ff_verdict_is_of_nothing(f) || (quality != FF_QUALITY_POOR && quality != FF_QUALITY_FAIR))
        return 0;
    /* standard input is read once, channels are fitted apart, and what a renderer holds and shares no model says: no one command
     * draws it */
    if (!strcmp(r->path, "-") || r->n_problems > 1 || r->target) return 0;
    const int by_half_angle = f->model.n_lobes > 0 && !isnan(e->worst_mean) && e->worst_place == FF_PLACE_THETA_H;
    const char *kind = by_half_angle ? "profile" : "residuals";
    changes c = {.n = 0};
    ff_model_expression(&f->model, expression, sizeof expression);
    change(&c, "model", expression);
    change_loss(r, &c);
    if (r->options->channels == FF_CHANNELS_EACH) change(&c, "channels", NULL); /* there is but one */
    snprintf(end, sizeof end, " -o %s.svg   # where it is off", kind);
    return put_command(r, "Look: ", by_half_angle ? "plot profile" : "plot residuals", &c, end, v);
}
