/* The list of conversions, one of them applied, and ways from a convention to another along several. */
#include "base/internal_name.h"
#include "internal_conversions.h"
#include <string.h>

#define ALIAS(word, name)
#define GROUP(name) extern const ff_conversion_group ff_conversions_##name;
#include "conversions.def"
#undef GROUP

static const ff_conversion_group *const groups[] = {
#define GROUP(name) &ff_conversions_##name,
#include "conversions.def"
#undef GROUP
#undef ALIAS
};
enum { GROUPS = sizeof groups / sizeof groups[0] };

static const struct {
    const char *word, *name;
} aliases[] = {
#define GROUP(name)
#define ALIAS(word, name) {word, name},
#include "conversions.def"
#undef GROUP
#undef ALIAS
};

const char *ff_conversion_name(const char *word)
{
    const ff_conversion *c;
    const size_t n = strlen(word);
    for (size_t i = 0; (c = ff_conversion_at(i)); i++)
        for (int k = 0; k < 2; k++)
            if (ff_name_is(k ? c->to : c->from, word, n)) return k ? c->to : c->from;
    for (size_t i = 0; i < sizeof aliases / sizeof *aliases; i++)
        if (ff_name_is(aliases[i].word, word, n)) return aliases[i].name;
    return NULL;
}

/* ---- one ------------------------------------------------------------------------------------- */

size_t ff_conversion_count(void)
{
    size_t n = 0;
    for (size_t g = 0; g < GROUPS; g++) n += groups[g]->n;
    return n;
}

const ff_conversion *ff_conversion_at(size_t i)
{
    for (size_t g = 0; g < GROUPS; g++) {
        if (i < groups[g]->n) return &groups[g]->at[i];
        i -= groups[g]->n;
    }
    return NULL;
}

int ff_conversion_find(const char *from, const char *to, const char *by, size_t start)
{
    const ff_conversion *c;
    for (size_t i = start; (c = ff_conversion_at(i)); i++)
        if (!strcmp(c->from, from) && !strcmp(c->to, to) && (!by || !strcmp(c->by, by))) return (int)i;
    return -1;
}

static int inside(const ff_conversion_value *v, double x)
{
    return isfinite(x) && x < v->hi && (x > v->lo || (v->lo_included && x >= v->lo));
}

static ff_status run(const ff_conversion *c, const double *in, double theta_i, double *out, ff_error *err)
{
    if (c->apply_at) return c->apply_at(in, theta_i, out, err);
    const char *reason = c->apply(in, out);
    return reason ? ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "%s", reason) : FF_OK;
}

/* Says what the formula would give for an argument that it can be computed for, since that is the reason of the refusal. */
static ff_status refuse(const ff_conversion *c, const ff_conversion_value *v, const double *in, double x, ff_error *err)
{
    double would[FF_CONVERSION_VALUES] = {0};
    const char open = v->lo_included ? '[' : '(';
    if (c->n_in == 1 && isfinite(x) && x >= v->hi && c->apply && !c->apply(in, would))
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "%s = %g: %s would give %s = %g; %s must lie in %c%g, %g)", v->name, x,
                            c->formula, c->out[0].name, would[0], v->name, open, v->lo, v->hi);
    return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "%s = %g: must be a number in %c%g, %g) for %s", v->name, x, open, v->lo,
                        v->hi, c->formula);
}

ff_status ff_conversion_apply(const ff_conversion *c, const double *in, double theta_i, double *out, ff_error *err)
{
    double result[FF_CONVERSION_VALUES] = {0};
    for (uint32_t k = 0; k < c->n_in; k++)
        if (!inside(&c->in[k], in[k])) return refuse(c, &c->in[k], in, in[k], err);
    if (c->apply_at && !(theta_i >= 0 && theta_i < FF_CONVERSION_PI / 2))
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "angle of incidence %g: must lie in [0, pi/2)", theta_i);
    const ff_status status = run(c, in, theta_i, result, err);
    if (status) return status;
    for (uint32_t k = 0; k < c->n_out; k++)
        if (!inside(&c->out[k], result[k]))
            return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "%s = %g is outside %c%g, %g): %s has no usable answer here",
                                c->out[k].name, result[k], c->out[k].lo_included ? '[' : '(', c->out[k].lo, c->out[k].hi,
                                c->formula);
    memcpy(out, result, c->n_out * sizeof *out);
    return FF_OK;
}

const char *ff_conversion_doubt(const ff_conversion *c, const double *in, const double *out)
{
    return c->doubt ? c->doubt(in, out) : NULL;
}
