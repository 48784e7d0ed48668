/* The parameters of a model by their names: where they start, are held and bounded; values from text and their boxes. */
#include "internal_model.h"
#include "base/internal_number.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

void ff_model_defaults(const ff_model *m, size_t n_channels, double *shape, double *channel)
{
    if (shape)
        for (uint32_t k = 0; k < m->n_shape; k++) shape[k] = m->shape[k].init;
    if (channel)
        for (size_t c = 0; c < n_channels; c++)
            for (uint32_t k = 0; k < m->n_channel; k++) channel[c * m->n_channel + k] = m->channel[k].init;
}

uint32_t ff_model_set_table(ff_model *m, const struct ff_profile_table *table)
{
    uint32_t count = 0;
    for (uint32_t l = 0; l < m->n_lobes; l++)
        if (ff_ndf_at(m->lobe[l].ndf)->needs_values) {
            m->lobe[l].table = table;
            count++;
        }
    return count;
}

ff_param_ref ff_model_param_find(const ff_model *m, const char *name)
{
    for (uint32_t k = 0; k < m->n_shape; k++)
        if (strcmp(m->shape[k].name, name) == 0) return (ff_param_ref){FF_PARAM_SHAPE, k};
    for (uint32_t k = 0; k < m->n_channel; k++)
        if (strcmp(m->channel[k].name, name) == 0) return (ff_param_ref){FF_PARAM_CHANNEL, k};
    return (ff_param_ref){FF_PARAM_NONE, 0};
}

const ff_model_param *ff_model_param_at(const ff_model *m, ff_param_ref ref)
{
    if (ref.kind == FF_PARAM_SHAPE && ref.index < m->n_shape) return &m->shape[ref.index];
    if (ref.kind == FF_PARAM_CHANNEL && ref.index < m->n_channel) return &m->channel[ref.index];
    return NULL;
}

static int has(const ff_model *m, const char *name)
{
    return ff_model_param_find(m, name).kind != FF_PARAM_NONE;
}

static ff_status out_of_box(const ff_model *m, const ff_model_param *p, double value, ff_error *err)
{
    const ff_param *domain = ff_model_param_domain(m, p);
    return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "%s = %g lies outside [%g, %g]", p->name, value, domain->lo, domain->hi);
}

static int inside(const ff_model *m, const ff_model_param *p, double v)
{
    const ff_param *domain = ff_model_param_domain(m, p);
    return v >= domain->lo && v <= domain->hi; /* false for NaN */
}

ff_status ff_model_unknown_param(const ff_model *m, const char *name, ff_error *err)
{
    char known[500] = "";
    for (uint32_t k = 0; k < m->n_shape + m->n_channel; k++) {
        const size_t used = strlen(known);
        snprintf(known + used, sizeof known - used, "%s%s", used ? ", " : "",
                 k < m->n_shape ? m->shape[k].name : m->channel[k - m->n_shape].name);
    }
    return ff_error_set(err, FF_ERR_UNKNOWN, NULL, 0, -1, "the model has no parameter '%s'; it has %s", name,
                        known[0] ? known : "none");
}

/* "alpha" or "lobe2.alpha" stands for alpha_x and alpha_y: writes the name of that axis. 0 when name is not such a word. */
static int alpha_axis(const char *name, char axis, char *out, size_t size)
{
    const size_t length = strlen(name);
    if (length < 5 || strcmp(name + length - 5, "alpha") != 0 || (length > 5 && name[length - 6] != '.')) return 0;
    snprintf(out, size, "%s_%c", name, axis);
    return 1;
}

int ff_model_alpha_axes(const ff_model *m, const char *name, char x[FF_PARAM_NAME], char y[FF_PARAM_NAME])
{
    if (strlen(name) >= FF_PARAM_NAME - 2 || has(m, name)) return 0;
    return alpha_axis(name, 'x', x, FF_PARAM_NAME) && alpha_axis(name, 'y', y, FF_PARAM_NAME) && has(m, x);
}

static ff_status hold_one(ff_model *m, const char *name, int held, double value, ff_error *err)
{
    const ff_param_ref at = ff_model_param_find(m, name);
    if (at.kind == FF_PARAM_NONE) return ff_model_unknown_param(m, name, err);
    ff_model_param *p = ff_model_param_of(m, at);
    if (held && !inside(m, p, value)) return out_of_box(m, p, value, err);
    if (held && value > p->info->hi) p->info = ff_model_param_domain(m, p);
    if (held) p->init = value;
    p->flags = held ? p->flags | FF_PARAM_HELD : p->flags & ~(uint32_t)FF_PARAM_HELD;
    return FF_OK;
}

/* A name, or where the model has none of that name "alpha" for the two axes. */
static ff_status hold(ff_model *m, const char *name, int held, double value, ff_error *err)
{
    char x[FF_PARAM_NAME], y[FF_PARAM_NAME];
    if (!ff_model_alpha_axes(m, name, x, y)) return hold_one(m, name, held, value, err);
    const ff_status status = hold_one(m, x, held, value, err);
    return status ? status : hold_one(m, y, held, value, err);
}

ff_status ff_model_hold(ff_model *m, const char *name, double value, ff_error *err)
{
    return hold(m, name, 1, value, err);
}

ff_status ff_model_vary(ff_model *m, const char *name, ff_error *err)
{
    return hold(m, name, 0, 0, err);
}

ff_status ff_model_share(ff_model *m, const char *name, ff_error *err)
{
    const ff_param_ref at = ff_model_param_find(m, name);
    const int axis = at.kind == FF_PARAM_SHAPE && strcmp(m->shape[at.index].info->name, "alpha_y") == 0;
    if (at.kind != FF_PARAM_CHANNEL && !axis) return ff_model_unknown_param(m, name, err);
    ff_model_param_of(m, at)->flags |= FF_PARAM_SHARED;
    return FF_OK;
}

static ff_status bound_one(ff_model *m, const char *name, double lo, double hi, ff_error *err)
{
    const ff_param_ref at = ff_model_param_find(m, name);
    if (at.kind == FF_PARAM_NONE) return ff_model_unknown_param(m, name, err);
    ff_model_param *p = ff_model_param_of(m, at);
    if (!(lo < hi))
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "the bounds of %s must rise, found %g and %g", p->name, lo, hi);
    const ff_param *domain = ff_model_param_domain(m, p);
    if (!inside(m, p, lo) || !inside(m, p, hi))
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "the bounds of %s, %g and %g, must lie inside [%g, %g]", p->name, lo,
                            hi, domain->lo, domain->hi);
    const double start = fmin(fmax(p->init, lo), hi);
    if ((p->flags & FF_PARAM_HELD) && start != p->init)
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "%s is held at %g, outside its bounds [%g, %g]", p->name, p->init, lo,
                            hi);
    if (hi > p->info->hi) p->info = domain;
    p->init = start;
    p->lo = lo;
    p->hi = hi;
    return FF_OK;
}

ff_status ff_model_bound(ff_model *m, const char *name, double lo, double hi, ff_error *err)
{
    char x[FF_PARAM_NAME], y[FF_PARAM_NAME];
    if (!ff_model_alpha_axes(m, name, x, y)) return bound_one(m, name, lo, hi, err);
    ff_model both = *m; /* both axes or, when one is refused, neither */
    ff_status status = bound_one(&both, x, lo, hi, err);
    if (!status) status = bound_one(&both, y, lo, hi, err);
    if (!status) *m = both;
    return status;
}

static ff_status set_one(const ff_model *m, size_t n_channels, const char *name, const double *values, size_t n_values,
                         double *shape, double *channel, ff_error *err)
{
    const ff_param_ref at = ff_model_param_find(m, name);
    const ff_model_param *p = ff_model_param_at(m, at);
    if (!p) return ff_model_unknown_param(m, name, err);
    if (at.kind == FF_PARAM_SHAPE && n_values != 1)
        return ff_error_set(err, FF_ERR_SYNTAX, NULL, 0, -1, "%s takes one value, found %zu", name, n_values);
    if (at.kind == FF_PARAM_CHANNEL && n_values != 1 && n_values != n_channels)
        return ff_error_set(err, FF_ERR_SYNTAX, NULL, 0, -1, "%s takes one value or one per channel (%zu), found %zu", name,
                            n_channels, n_values);
    for (size_t i = 0; i < n_values; i++)
        if (!inside(m, p, values[i])) return out_of_box(m, p, values[i], err);
    if (at.kind == FF_PARAM_SHAPE)
        shape[at.index] = values[0];
    else
        for (size_t c = 0; c < n_channels; c++) channel[c * m->n_channel + at.index] = values[n_values == 1 ? 0 : c];
    return FF_OK;
}

ff_status ff_model_number(const char *text, const char *end, double *out, ff_error *err)
{
    const size_t length = (size_t)(end - text);
    if (ff_number_read(text, out) == end) return FF_OK; /* what is too large is outside every box */
    return ff_error_set(err, FF_ERR_SYNTAX, NULL, 0, -1, "'%.*s' is not a number", (int)(length < 60 ? length : 60), text);
}

ff_status ff_model_set(const ff_model *m, size_t n_channels, const char *assignment, double *shape, double *channel, ff_error *err)
{
    enum { MAX_VALUES = 256 };
    double values[MAX_VALUES];
    size_t n_values = 0;
    char name[FF_PARAM_NAME * 2], axis[FF_PARAM_NAME * 2 + 2];
    const char *equals = strchr(assignment, '=');
    if (!equals || equals == assignment || (size_t)(equals - assignment) >= sizeof name)
        return ff_error_set(err, FF_ERR_SYNTAX, NULL, 0, -1, "expected NAME=VALUE, found '%.80s'", assignment);
    memcpy(name, assignment, (size_t)(equals - assignment));
    name[equals - assignment] = 0;
    for (const char *text = equals + 1; text;) {
        const char *colon = strchr(text, ':'), *end = colon ? colon : text + strlen(text);
        if (n_values == MAX_VALUES)
            return ff_error_set(err, FF_ERR_SYNTAX, NULL, 0, -1, "%s has more than %d values", name, MAX_VALUES);
        const ff_status status = ff_model_number(text, end, &values[n_values++], err);
        if (status) return status;
        text = colon ? colon + 1 : NULL;
    }
    if (has(m, name) || !alpha_axis(name, 'x', axis, sizeof axis))
        return set_one(m, n_channels, name, values, n_values, shape, channel, err);
    /* both axes or, when one is refused, neither: they have the same box and the same number of values */
    ff_status status = set_one(m, n_channels, axis, values, n_values, shape, channel, err);
    if (!status && alpha_axis(name, 'y', axis, sizeof axis))
        status = set_one(m, n_channels, axis, values, n_values, shape, channel, err);
    return status;
}

ff_status ff_model_check_values(const ff_model *m, size_t n_channels, const double *shape, const double *channel, ff_error *err)
{
    if (n_channels == 0) return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "a model of no channels, expected at least one");
    for (uint32_t k = 0; k < m->n_shape; k++)
        if (!inside(m, &m->shape[k], shape[k])) return out_of_box(m, &m->shape[k], shape[k], err);
    for (size_t i = 0; i < n_channels * m->n_channel; i++) {
        const ff_model_param *p = &m->channel[i % m->n_channel];
        if (!inside(m, p, channel[i])) return out_of_box(m, p, channel[i], err);
    }
    for (uint32_t l = 0; l < m->n_lobes; l++) {
        ff_lobe_pass pass;
        ff_model_lobe(m, l, shape, &pass, NULL);
        const ff_term *masking = &ff_masking_at(m->lobe[l].masking)->term;
        if ((masking->claims & FF_NEEDS_CENTRED) && (pass.s.x0 != 0 || pass.s.y0 != 0))
            return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1,
                                "%s is undefined with a mean slope (found %g, %g); use a Smith form or slope_x = slope_y = 0",
                                masking->name, pass.s.x0, pass.s.y0);
    }
    return FF_OK;
}

ff_status ff_model_check(const ff_model *m, size_t n_channels, const double *shape, const double *channel, ff_error *err)
{
    const ff_status status = ff_model_check_values(m, n_channels, shape, channel, err);
    for (uint32_t l = 0; l < m->n_lobes && !status; l++) {
        if (ff_ndf_at(m->lobe[l].ndf)->needs_values && !m->lobe[l].table)
            return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "%s needs the table of its profile",
                                ff_ndf_at(m->lobe[l].ndf)->term.name);
    }
    return status;
}
