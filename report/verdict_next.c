/* The commands at the end of a verdict: what to try next, and the figure that shows where a fit is off. */
#define _GNU_SOURCE
#include "internal_verdict.h"
#include "internal_fits_text.h"
#include "models/tools/internal_aperture.h"
#include <math.h>
#include <string.h>

#define USUAL_MAX_THETA 80.0 /* degrees: that of ff_fit_options_init */

/* A file name as a shell takes it. */
static void put_path(ff_verdict *v, const char *path)
{
    static const char plain[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_./-+=,:@%";
    if (*path && *path != '-' && strspn(path, plain) == strlen(path)) {
        ff_verdict_put(v, "%s", path);
        return;
    }
    ff_verdict_put(v, "'");
    for (; *path; path++) ff_verdict_put(v, *path == '\'' ? "'\\''" : "%c", *path);
    ff_verdict_put(v, "'");
}

static void put_command(ff_verdict *v, const char *command, const char *path, const char *flags)
{
    ff_verdict_put(v, "facetfit %s ", command);
    put_path(v, path);
    ff_verdict_put(v, "%s", flags);
}

/* Does a parameter rest on fewer than three values? */
static int is_carried_by_few(const ff_fit_result *f)
{
    return ff_verdict_has_warning(f, FF_WARNING_FEW_CARRIERS);
}

int ff_verdict_next_of_fit(const ff_report_fits *r, const ff_fit_result *f, ff_verdict *v)
{
    const ff_quality quality = ff_quality_of(ff_verdict_explained(r, f));
    v->code = FF_VERDICT_NEXT;
    ff_verdict_put(v, "Next: ");
    if (ff_verdict_has_warning(f, FF_WARNING_BRIGHTEST_ELSEWHERE))
        ff_verdict_put(v, "look at the angles of the file, which the warning below is about");
    else if (f->outcome != FF_CONVERGED || ff_verdict_is_of_nothing(f) || quality == FF_QUALITY_POOR)
        put_command(v, "compare", r->path, "   # does another model do better?");
    else if (is_carried_by_few(f) && r->options->weighting != FF_WEIGHT_NOISE)
        put_command(v, "fit", r->path, " --weight noise   # smaller errors where few values carry a parameter");
    else if (quality == FF_QUALITY_FAIR)
        put_command(v, "compare", r->path, "   # does another model do better?");
    else
        return 0;
    return 1;
}

int ff_verdict_next_of_comparison(const ff_report_fits *r, const ff_fit_result *f, ff_verdict *v)
{
    const ff_quality quality = ff_quality_of(ff_verdict_explained(r, f));
    char expression[FF_MODEL_NAME], flags[FF_MODEL_NAME + 192];
    v->code = FF_VERDICT_NEXT;
    ff_model_expression(&f->model, expression, sizeof expression);
    ff_verdict_put(v, "Next: ");
    if (ff_verdict_has_warning(f, FF_WARNING_BRIGHTEST_ELSEWHERE)) {
        ff_verdict_put(v, "look at the angles of the file, which the warning below is about");
        return 1;
    }
    if (quality == FF_QUALITY_POOR && f->model.n_lobes == 1)
        snprintf(flags, sizeof flags, " --model %s/%s+%s   # do two lobes do better?", ff_report_ndf_name(f),
                 ff_report_masking_name(f), expression);
    else
        snprintf(flags, sizeof flags, " --model %s   # its errors and warnings", expression);
    put_command(v, "fit", r->path, flags);
    return 1;
}

/* What makes the fit that the figure draws the one of the report. */
static void put_flags(const ff_report_fits *r, const ff_fit_result *f, ff_verdict *v)
{
    const ff_fit_options *o = r->options;
    char expression[FF_MODEL_NAME], number[FF_TEXT_NUMBER], text[FF_APERTURE_TEXT];
    ff_model_expression(&f->model, expression, sizeof expression);
    ff_verdict_put(v, " --model %s", expression);
    if (o->weighting == FF_WEIGHT_NOISE)
        ff_verdict_put(v, " --weight noise");
    else if (o->loss != FF_LOSS_COSINE)
        ff_verdict_put(v, " --loss %s", ff_loss_name((int)o->loss));
    if (fabs(ff_report_degrees(o->max_theta) - USUAL_MAX_THETA) > 1e-6)
        ff_verdict_put(v, " --max-theta %s", ff_text_number(ff_report_degrees(o->max_theta), 6, number));
    if (o->aperture && ff_aperture_extended(o->aperture)) ff_verdict_put(v, " --aperture %s", ff_aperture_text(o->aperture, text));
    if (o->aperture && o->aperture->source > 0)
        ff_verdict_put(v, " --source %s", ff_text_number(ff_report_degrees(o->aperture->source), 6, number));
}

int ff_verdict_look(const ff_report_fits *r, const ff_fit_result *f, ff_verdict *v)
{
    const ff_explained *e = ff_verdict_explained(r, f);
    const ff_quality quality = ff_quality_of(e);
    v->code = FF_VERDICT_LOOK;
    if (f->outcome != FF_CONVERGED || ff_verdict_is_of_nothing(f) || (quality != FF_QUALITY_POOR && quality != FF_QUALITY_FAIR))
        return 0;
    if (!strcmp(r->path, "-") || r->n_problems > 1) return 0; /* read once, and fitted apart: no one command draws it */
    const int by_half_angle = f->model.n_lobes > 0 && !isnan(e->worst_mean) && e->worst_place == FF_PLACE_THETA_H;
    const char *kind = by_half_angle ? "profile" : "residuals";
    ff_verdict_put(v, "Look: ");
    put_command(v, by_half_angle ? "plot profile" : "plot residuals", r->path, "");
    put_flags(r, f, v);
    ff_verdict_put(v, " -o %s.svg   # where it is off", kind);
    return 1;
}
