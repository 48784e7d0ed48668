/* What tests ask of the warnings of a result: by their codes, never by their words. */
#ifndef FF_TEST_WARNINGS_H
#define FF_TEST_WARNINGS_H
#include "fit/interface/fit_struct.h"
#include <string.h>

static inline size_t count_warnings(const ff_warnings *w, ff_warning_code code)
{
    size_t n = 0;
    for (size_t k = 0; k < w->n; k++) n += w->item[k].code == code;
    return n;
}

static inline int same_parameter(ff_param_ref a, ff_param_ref b)
{
    return a.kind == b.kind && a.index == b.index;
}

static inline int warning_names(const ff_fit_result *r, const ff_warning *w, const char *parameter)
{
    const ff_param_ref at = ff_model_param_find(&r->model, parameter);
    for (size_t k = 0; k < w->n_parameters; k++)
        if (same_parameter(w->parameter[k].parameter, at)) return 1;
    return 0;
}

/* The first of this code that is about this parameter (NULL: about anything); NULL when there is none. */
static inline const ff_warning *find_warning(const ff_fit_result *r, ff_warning_code code, const char *parameter)
{
    for (size_t k = 0; k < r->warnings.n; k++) {
        const ff_warning *w = &r->warnings.item[k];
        if (w->code == code && (!parameter || warning_names(r, w, parameter))) return w;
    }
    return NULL;
}

static inline int has_warning(const ff_fit_result *r, ff_warning_code code, const char *parameter)
{
    return find_warning(r, code, parameter) != NULL;
}

static inline int same_warning(const ff_warning *a, const ff_warning *b)
{
    int same = a->code == b->code && a->severity == b->severity && a->n_parameters == b->n_parameters &&
               a->n_channels == b->n_channels && !memcmp(a->value, b->value, sizeof a->value);
    for (size_t k = 0; same && k < a->n_parameters; k++)
        same &= same_parameter(a->parameter[k].parameter, b->parameter[k].parameter) &&
                a->parameter[k].channel == b->parameter[k].channel;
    for (size_t k = 0; same && k < a->n_channels; k++) same &= a->channel[k] == b->channel[k];
    return same;
}
#endif
