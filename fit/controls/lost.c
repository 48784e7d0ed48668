/* What is lost when a material of a renderer takes the place of a model, part by part: each part is exchanged in the model by
 * itself, with its parameters as they are or, of a Fresnel term, with the same reflectance at normal incidence. */
#include "internal_refit.h"
#include "models/internal_model.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { PART = 48 };

/* A model in words. */
typedef struct parts {
    char ndf[PART], masking[PART], fresnel[PART], bases[2 * PART];
} parts;

static void bases_of(const ff_model *m, char *out, size_t size)
{
    out[0] = '\0';
    for (uint32_t b = 0; b < m->n_bases; b++) {
        const size_t used = strlen(out);
        snprintf(out + used, size - used, "+%s", ff_diffuse_at(m->base[b].diffuse)->term.name);
    }
}

static parts parts_of(const ff_model *m)
{
    parts p = {"", "", "", ""};
    if (m->n_lobes) {
        snprintf(p.ndf, PART, "%s", ff_ndf_at(m->lobe[0].ndf)->term.name);
        snprintf(p.masking, PART, "%s", ff_masking_at(m->lobe[0].masking)->term.name);
        snprintf(p.fresnel, PART, "%s", ff_fresnel_at(m->lobe[0].fresnel)->term.name);
    }
    bases_of(m, p.bases, sizeof p.bases);
    return p;
}

/* A surface of its own. */
typedef struct owned {
    ff_model model;
    double shape[FF_MAX_SHAPE];
    double *channel;
} owned;

/* F of the first lobe of s at a cosine, in channel c. */
static double fresnel_of(const ff_surface *s, size_t c, double cosine)
{
    const ff_lobe *lobe = &s->model->lobe[0];
    const ff_geometry g = {.plane = {[FF_G_C] = &cosine}};
    double f;
    ff_fresnel_at(lobe->fresnel)->eval(s->channel + c * s->model->n_channel + lobe->channel0, &g, 1, &f, NULL);
    return f;
}

/* alpha of the lobes of s by name: its own, or the geometric mean of the axes of its ellipse. */
static double alpha_of(const ff_surface *s)
{
    const ff_param_ref one = ff_model_param_find(s->model, "alpha"), x = ff_model_param_find(s->model, "alpha_x");
    if (one.kind == FF_PARAM_SHAPE) return s->shape[one.index];
    if (x.kind != FF_PARAM_SHAPE) return NAN;
    const double *p = s->shape + x.index;
    return sqrt(p[0] * p[1] * sqrt(fmax((1 - p[2]) * (1 + p[2]), 0)));
}

static double inside(const ff_model_param *p, double x)
{
    return fmin(fmax(x, p->info->lo), p->info->hi);
}

/* Parameters of the same name, and the roughness whatever its name is. */
static void copy_shape(const ff_surface *s, owned *to)
{
    for (uint32_t k = 0; k < to->model.n_shape; k++) {
        const char *name = to->model.shape[k].name;
        const ff_param_ref from = ff_model_param_find(s->model, name);
        const int rough = !strcmp(name, "alpha") || !strcmp(name, "alpha_x") || !strcmp(name, "alpha_y");
        if (from.kind == FF_PARAM_SHAPE)
            to->shape[k] = inside(&to->model.shape[k], s->shape[from.index]);
        else if (rough && !isnan(alpha_of(s)))
            to->shape[k] = inside(&to->model.shape[k], alpha_of(s));
    }
}

/* The first lobe's Fresnel parameters, of another term. */
static void copy_fresnel(const ff_surface *s, size_t c, owned *to)
{
    const ff_lobe *lobe = &to->model.lobe[0];
    const ff_fresnel *term = ff_fresnel_at(lobe->fresnel);
    double *p = to->channel + c * to->model.n_channel + lobe->channel0;
    const double f0 = fresnel_of(s, c, 1);
    if (term->like_schlick) term->like_schlick(f0, p);
    for (uint32_t k = 0; k < term->term.n_params && !term->like_schlick; k++) {
        const char *name = term->term.params[k].name;
        if (!strcmp(name, "f0")) p[k] = fmin(f0, term->term.params[k].hi);
        if (!strcmp(name, "f82")) p[k] = fmin(fresnel_of(s, c, 1.0 / 7), 1);
    }
    if (term->term.n_params == 0) p[0] *= f0; /* the scale stands for what is not there */
}

static void copy_channels(const ff_surface *s, int other_fresnel, owned *to)
{
    for (size_t c = 0; c < s->n_channels; c++) {
        for (uint32_t k = 0; k < to->model.n_channel; k++) {
            const ff_model_param *p = &to->model.channel[k];
            const ff_param_ref from = ff_model_param_find(s->model, p->name);
            if (from.kind == FF_PARAM_CHANNEL)
                to->channel[c * to->model.n_channel + k] = inside(p, s->channel[c * s->model->n_channel + from.index]);
        }
        if (other_fresnel) copy_fresnel(s, c, to);
    }
}

/* s with other parts; 0 where these do not go together, or without memory. */
static int exchanged(const ff_surface *s, const parts *p, int other_fresnel, owned *out)
{
    char expression[FF_MODEL_NAME];
    snprintf(expression, sizeof expression, "%s/%s/%s%s", p->ndf, p->masking, p->fresnel, p->bases);
    out->channel = NULL;
    if (ff_model_parse(expression, &out->model, NULL)) return 0;
    out->channel = malloc((s->n_channels * out->model.n_channel + 1) * sizeof *out->channel);
    if (!out->channel) return 0;
    ff_model_defaults(&out->model, s->n_channels, out->shape, out->channel);
    copy_shape(s, out);
    copy_channels(s, other_fresnel, out);
    return 1;
}

static void add(ff_refit *out, const char *what, const char *from, const char *to, double share)
{
    if (out->n_lost == FF_LOST_MOST) return;
    ff_lost *lost = &out->lost[out->n_lost++];
    snprintf(lost->what, sizeof lost->what, "%s %.60s as %.60s", what, from, to);
    lost->share = share;
}

/* What the exchange of one part changes. */
static void add_exchange(ff_refit *out, const ff_surface *s, const parts *p, int other_fresnel, const char *what, const char *from,
                         const char *to)
{
    owned made;
    double share = NAN;
    if (exchanged(s, p, other_fresnel, &made)) {
        const ff_surface other = {&made.model, s->n_channels, made.shape, made.channel};
        share = ff_surface_difference(s, &other);
    }
    free(made.channel);
    add(out, what, from, to, share);
}

/* ---- directions ------------------------------------------------------------------------------ */

static int is_stretched(const ff_model *m)
{
    return ff_model_param_find(m, "alpha_x").kind == FF_PARAM_SHAPE;
}

/* s with the shape changed by `change`. */
static double share_of_shape(const ff_surface *s, void (*change)(const ff_surface *s, double *x))
{
    double shape[FF_MAX_SHAPE];
    memcpy(shape, s->shape, s->model->n_shape * sizeof *shape);
    change(s, shape + ff_model_param_find(s->model, "alpha_x").index);
    const ff_surface other = {s->model, s->n_channels, shape, s->channel};
    return ff_surface_difference(s, &other);
}

static void round_off(const ff_surface *s, double *x)
{
    x[0] = x[1] = alpha_of(s);
    x[2] = 0;
}

static void level(const ff_surface *s, double *x)
{
    (void)s;
    x[3] = x[4] = 0;
}

static int can_turn(const ff_material *m)
{
    for (size_t k = 0; k < ff_control_count(m); k++)
        if (m->control[k].is_of_axis) return 1;
    return 0;
}

static void look_at_directions(const ff_surface *s, const ff_material *m, ff_refit *out)
{
    if (!is_stretched(s->model)) return;
    const double *x = s->shape + ff_model_param_find(s->model, "alpha_x").index;
    if ((x[0] != x[1] || x[2] != 0) && !can_turn(m))
        add(out, "anisotropy:", "two roughnesses", "their geometric mean", share_of_shape(s, round_off));
    if (x[2] != 0 && can_turn(m))
        add(out, "correlation r_xy:", "a sheared ellipse", "a rotation of its axes", 0); /* the same ellipse */
    if (x[3] != 0 || x[4] != 0) add(out, "mean slope:", "a tilted surface", "none", share_of_shape(s, level));
}

/* ---- the whole ------------------------------------------------------------------------------- */

static void look_at_lobes(const ff_surface *s, const ff_model *to, ff_refit *out)
{
    char from[16], into[16];
    if (s->model->n_lobes == to->n_lobes) return;
    snprintf(from, sizeof from, "%u", s->model->n_lobes);
    snprintf(into, sizeof into, "%u", to->n_lobes);
    const parts own = parts_of(s->model);
    add_exchange(out, s, &own, 0, "lobes:", from, into); /* own has the first lobe alone */
}

/* A parameter of each channel that is one for all there. */
static void look_at_shared(const ff_surface *s, const ff_model *to, ff_refit *out)
{
    for (uint32_t k = 0; k < to->n_channel && s->n_channels > 1; k++) {
        const ff_param_ref from = ff_model_param_find(s->model, to->channel[k].name);
        if (!(to->channel[k].flags & FF_PARAM_SHARED) || from.kind != FF_PARAM_CHANNEL) continue;
        double mean = 0, *channel = malloc(s->n_channels * s->model->n_channel * sizeof *channel);
        if (!channel) return;
        memcpy(channel, s->channel, s->n_channels * s->model->n_channel * sizeof *channel);
        for (size_t c = 0; c < s->n_channels; c++) mean += s->channel[c * s->model->n_channel + from.index] / (double)s->n_channels;
        for (size_t c = 0; c < s->n_channels; c++) channel[c * s->model->n_channel + from.index] = mean;
        const ff_surface other = {s->model, s->n_channels, s->shape, channel};
        const double share = ff_surface_difference(s, &other);
        if (share > 0) add(out, to->channel[k].name, "of each channel", "one number for all", share);
        free(channel);
    }
}

ff_status ff_lost_find(const ff_surface *s, const ff_material *m, const ff_model *to, ff_refit *out)
{
    if (s->model->n_lobes == 0) return FF_OK;
    const parts own = parts_of(s->model), other = parts_of(to);
    parts one = own;
    look_at_lobes(s, to, out);
    look_at_directions(s, m, out);
    if (strcmp(own.ndf, other.ndf)) {
        memcpy(one.ndf, other.ndf, PART);
        add_exchange(out, s, &one, 0, "distribution", own.ndf, other.ndf);
    }
    one = own;
    if (strcmp(own.masking, other.masking)) {
        memcpy(one.masking, other.masking, PART);
        add_exchange(out, s, &one, 0, "masking", own.masking, other.masking);
    }
    one = own;
    if (strcmp(own.fresnel, other.fresnel)) {
        memcpy(one.fresnel, other.fresnel, PART);
        add_exchange(out, s, &one, 1, "Fresnel term", own.fresnel, other.fresnel);
    }
    one = own;
    if (strcmp(own.bases, other.bases)) {
        memcpy(one.bases, other.bases, sizeof one.bases);
        add_exchange(out, s, &one, 0, "under the lobe", own.bases[0] ? own.bases + 1 : "nothing",
                     other.bases[0] ? other.bases + 1 : "nothing");
    }
    look_at_shared(s, to, out);
    return FF_OK;
}
