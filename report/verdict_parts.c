/* What the sentences of a verdict ask of a fit, whichever file they are in. */
#define _GNU_SOURCE
#include "internal_verdict.h"
#include <math.h>
#include <stdarg.h>
#include <string.h>

void ff_verdict_put(ff_verdict *v, const char *format, ...)
{
    const size_t used = strlen(v->text);
    va_list args;
    va_start(args, format);
    vsnprintf(v->text + used, sizeof v->text - used, format, args);
    va_end(args);
}

size_t ff_verdict_models(const ff_report_fits *r)
{
    return r->n_fits / r->n_problems;
}

const ff_explained *ff_verdict_explained(const ff_report_fits *r, const ff_fit_result *f)
{
    const ff_fit_trust *t = r->trust ? &r->trust[f - r->fit] : NULL;
    return t && t->has_explained ? &t->explained : NULL;
}

static int is_within(const ff_explained *e, double share, double deviation)
{
    return e->share >= share && !(e->bright_error > deviation) && !(fabs(e->worst_mean) > deviation);
}

ff_quality ff_quality_of(const ff_explained *e)
{
    if (!e || isnan(e->share)) return FF_QUALITY_UNKNOWN;
    return is_within(e, 0.98, 0.1) ? FF_QUALITY_GOOD : is_within(e, 0.9, 0.3) ? FF_QUALITY_FAIR : FF_QUALITY_POOR;
}

/* Is there a parameter whose lobe or base came out as nothing? */
int ff_verdict_is_of_nothing(const ff_fit_result *f)
{
    for (uint32_t k = 0; k < f->model.n_shape; k++)
        if (f->shape_value[k].weightless) return 1;
    return 0;
}

int ff_verdict_has_warning(const ff_fit_result *f, ff_warning_code code)
{
    for (size_t i = 0; i < f->warnings.n; i++)
        if (f->warnings.item[i].code == code) return 1;
    return 0;
}
