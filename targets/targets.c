/* The registry of renderers, the models of their materials, and their controls. */
#include "base/internal_name.h"
#include "internal_target.h"
#include "models/internal_model.h"
#include <stdio.h>
#include <string.h>

#define FF_TARGET(id) extern const ff_target ff_target_##id;
#include "targets.def"
#undef FF_TARGET

static const ff_target *const targets[] = {
#define FF_TARGET(id) &ff_target_##id,
#include "targets.def"
#undef FF_TARGET
};

size_t ff_target_count(void)
{
    return sizeof targets / sizeof *targets;
}

const ff_target *ff_target_at(size_t i)
{
    return i < ff_target_count() ? targets[i] : NULL;
}

const ff_target *ff_target_find(const char *name)
{
    const size_t n = strlen(name);
    for (size_t i = 0; i < ff_target_count(); i++) {
        if (ff_name_is(targets[i]->name, name, n)) return targets[i];
        for (size_t k = 0; k < FF_TARGET_ALIASES && targets[i]->alias[k]; k++)
            if (ff_name_is(targets[i]->alias[k], name, n)) return targets[i];
    }
    return NULL;
}

const ff_material *ff_material_find(const ff_target *t, const char *name, size_t n)
{
    for (size_t i = 0; i < t->n_materials; i++)
        if (strlen(t->material[i].name) == n && !strncmp(t->material[i].name, name, n)) return &t->material[i];
    return NULL;
}

size_t ff_control_count(const ff_material *m)
{
    size_t n = 0;
    while (n < FF_TARGET_CONTROLS && m->control[n].made.name) n++;
    return n;
}

/* ---- models ---------------------------------------------------------------------------------- */

/* Cuts "name=..." into name [FF_PARAM_NAME] and what follows. */
static const char *assigned(const char *word, char *name)
{
    const char *equals = strchr(word, '=');
    snprintf(name, FF_PARAM_NAME, "%.*s", (int)(equals - word), word);
    return equals + 1;
}

static ff_status hold(ff_model *m, const char *word, ff_error *err)
{
    char name[FF_PARAM_NAME];
    double value;
    const char *text = assigned(word, name);
    const ff_status status = ff_model_number(text, text + strlen(text), &value, err);
    return status ? status : ff_model_hold(m, name, value, err);
}

static ff_status bound(ff_model *m, const char *word, ff_error *err)
{
    char name[FF_PARAM_NAME];
    double lo, hi;
    const char *text = assigned(word, name), *colon = strchr(text, ':');
    ff_status status = ff_model_number(text, colon, &lo, err);
    if (!status) status = ff_model_number(colon + 1, colon + strlen(colon), &hi, err);
    return status ? status : ff_model_bound(m, name, lo, hi, err);
}

ff_status ff_material_model(const ff_material *m, ff_model *out, ff_error *err)
{
    ff_model model;
    ff_status status = ff_model_parse(m->expression, &model, err);
    for (size_t k = 0; k < FF_TARGET_HOLDS && m->hold[k] && !status; k++) status = hold(&model, m->hold[k], err);
    for (size_t k = 0; k < FF_TARGET_HOLDS && m->vary[k] && !status; k++) status = ff_model_vary(&model, m->vary[k], err);
    for (size_t k = 0; k < FF_TARGET_HOLDS && m->bound[k] && !status; k++) status = bound(&model, m->bound[k], err);
    for (size_t k = 0; k < FF_TARGET_HOLDS && m->shared[k] && !status; k++) status = ff_model_share(&model, m->shared[k], err);
    if (!status) *out = model;
    return status;
}

/* Is a value of m held by the material at another one, or not what all channels or both axes share? */
static int is_other(const ff_model *material, size_t n_channels, const double *shape, const double *channel)
{
    for (uint32_t k = 0; k < material->n_shape; k++) {
        if ((material->shape[k].flags & FF_PARAM_HELD) && shape[k] != material->shape[k].init) return 1;
        if ((material->shape[k].flags & FF_PARAM_SHARED) && shape[k] != shape[k - 1]) return 1;
    }
    for (size_t c = 0; c < n_channels; c++)
        for (uint32_t k = 0; k < material->n_channel; k++) {
            const double x = channel[c * material->n_channel + k];
            if ((material->channel[k].flags & FF_PARAM_HELD) && x != material->channel[k].init) return 1;
            if ((material->channel[k].flags & FF_PARAM_SHARED) && x != channel[k]) return 1;
        }
    return 0;
}

const ff_material *ff_material_of_model(const ff_target *t, const ff_model *m, size_t n_channels, const double *shape,
                                        const double *channel)
{
    char of_m[FF_MODEL_NAME], of_material[FF_MODEL_NAME];
    ff_model_expression(m, of_m, sizeof of_m);
    for (size_t i = 0; i < t->n_materials; i++) {
        ff_model model;
        if (ff_material_model(&t->material[i], &model, NULL)) continue;
        ff_model_expression(&model, of_material, sizeof of_material);
        if (!strcmp(of_m, of_material) && !is_other(&model, n_channels, shape, channel)) return &t->material[i];
    }
    return NULL;
}

/* ---- controls -------------------------------------------------------------------------------- */

static double value_at(const ff_model *m, ff_param_ref ref, const double *shape, const double *channel, size_t c)
{
    return ref.kind == FF_PARAM_SHAPE ? shape[ref.index] : channel[c * m->n_channel + ref.index];
}

double ff_control_value(const ff_control *k, const ff_model *m, const double *shape, const double *channel, size_t c,
                        ff_param_ref *ref, double *d)
{
    double x[FF_FORMULA_INPUTS] = {0};
    for (size_t i = 0; i < FF_FORMULA_INPUTS; i++) {
        ff_param_ref at = {FF_PARAM_NONE, 0};
        if (k->made.of[i]) at = ff_model_param_find(m, k->made.of[i]);
        if (at.kind != FF_PARAM_NONE) x[i] = value_at(m, at, shape, channel, k->is_color ? c : 0);
        if (ref) ref[i] = at;
        if (d) d[i] = 0;
    }
    return k->made.value(x, d);
}

/* Number of the control called `name`. */
static size_t control_called(const ff_material *m, const char *name)
{
    size_t k = 0;
    while (strcmp(m->control[k].made.name, name) != 0) k++;
    return k;
}

void ff_material_parameters(const ff_material *m, const ff_model *model, size_t n_channels, const double *control, double *shape,
                            double *channel)
{
    for (size_t p = 0; p < FF_TARGET_PARAMETERS && m->parameter[p].name; p++) {
        const ff_formula *f = &m->parameter[p];
        const ff_param_ref to = ff_model_param_find(model, f->name);
        for (size_t c = 0; c < (to.kind == FF_PARAM_SHAPE ? 1 : n_channels); c++) {
            double x[FF_FORMULA_INPUTS] = {0};
            for (size_t i = 0; i < FF_FORMULA_INPUTS && f->of[i]; i++) {
                const size_t k = control_called(m, f->of[i]);
                x[i] = control[k * n_channels + (m->control[k].is_color ? c : 0)];
            }
            if (to.kind == FF_PARAM_SHAPE)
                shape[to.index] = f->value(x, NULL);
            else
                channel[c * model->n_channel + to.index] = f->value(x, NULL);
        }
    }
}
