/* Models for the script: terms with the names of their parameters, as the formulas of assets/model.js take them. */
#include "internal_html.h"
#include "models/internal_model.h"
#include "models/tools/internal_aperture.h"
#include <stdlib.h>
#include <string.h>

/* Values of models that the script has no formula for, in all: samples times channels times models. */
enum { TABLED = 120000 };

/* The terms that assets/model.js has formulas for; what is not named here, and means over an aperture, are shown by tabled values.
 */
static const char *const known[FF_TERM_KINDS] = {
    [FF_NDF] = " beckmann ggx student-t phong gtr vmf gaussian sgd abc kelemen-ward kelemen-phong beckmann-walter phong-walter ",
    [FF_MASKING] = " smith-masking-only smith-separable smith-height-correlated smith-direction-correlated "
                   "smith-height-direction-correlated v-cavity kelemen hammon schlick-smith "
                   "disney-clearcoat none ",
    [FF_FRESNEL] = " schlick schlick-f82 schlick-karis dielectric conductor cycles sgd none ",
    [FF_DIFFUSE] = " lambert oren-nayar oren-nayar-qualitative eon disney disney-coupled hammon shirley-coupled abg harvey-shack "
                   "k-correlation "};

static int is_known(ff_term_kind kind, const ff_term *term)
{
    char word[64];
    snprintf(word, sizeof word, " %s ", term->name);
    return strstr(known[kind], word) != NULL;
}

/* Does the script evaluate it? */
static int is_live(const ff_model *m)
{
    int live = 1;
    for (uint32_t l = 0; l < m->n_lobes; l++) {
        const ff_lobe *lobe = &m->lobe[l], *first = &m->lobe[ff_model_group(m, l)];
        live &= is_known(FF_NDF, &ff_ndf_at(lobe->ndf)->term) && is_known(FF_MASKING, &ff_masking_at(lobe->masking)->term) &&
                is_known(FF_FRESNEL, &ff_fresnel_at(first->fresnel)->term);
    }
    for (uint32_t b = 0; b < m->n_bases; b++) live &= is_known(FF_DIFFUSE, &ff_diffuse_at(m->base[b].diffuse)->term);
    return live;
}

static void put_names(ff_json *j, const char *key, const ff_model_param *p, uint32_t n)
{
    ff_json_array(j, key, FF_JSON_LINE);
    for (uint32_t k = 0; k < n; k++) ff_json_string(j, NULL, p[k].name);
    ff_json_close(j);
}

static void put_lobe(ff_json *j, const ff_model *m, uint32_t l)
{
    const uint32_t group = ff_model_group(m, l);
    const ff_lobe *lobe = &m->lobe[l], *first = &m->lobe[group];
    const ff_fresnel *fresnel = ff_fresnel_at(first->fresnel);
    const int shares = lobe->fresnel == FF_FRESNEL_SHARED, masked = ff_masking_at(lobe->masking)->term.n_params > 0;
    const ff_model_param *last = &m->shape[lobe->shape0 + lobe->n_shape - 1];
    ff_json_object(j, NULL, FF_JSON_LINE);
    ff_json_string(j, "ndf", ff_ndf_at(lobe->ndf)->term.name);
    ff_json_string(j, "masking", ff_masking_at(lobe->masking)->term.name);
    ff_json_string(j, "fresnel", fresnel->term.name);
    ff_json_bool(j, "isotropic", lobe->isotropic);
    put_names(j, "shape", m->shape + lobe->shape0, lobe->n_shape);
    ff_json_string(j, "masking_parameter", masked ? (shares ? last - 1 : last)->name : NULL);
    ff_json_string(j, "share", shares ? last->name : NULL);
    ff_json_integer(j, "group", group);
    put_names(j, "fresnel_parameters", m->channel + first->channel0, fresnel->term.n_params);
    ff_json_string(j, "ks", m->channel[first->channel0 + fresnel->term.n_params].name);
    ff_json_close(j);
}

/* Parameters in the order of the term, whichever of both lists they are in. */
static void put_base(ff_json *j, const ff_model *m, const ff_base *base)
{
    const ff_term *term = &ff_diffuse_at(base->diffuse)->term;
    uint32_t shape = base->shape0, channel = base->channel0;
    ff_json_object(j, NULL, FF_JSON_LINE);
    ff_json_string(j, "diffuse", term->name);
    ff_json_array(j, "parameters", FF_JSON_LINE);
    for (uint32_t k = 0; k < term->n_params; k++)
        ff_json_string(j, NULL, term->params[k].flags & FF_PARAM_PER_CHANNEL ? m->channel[channel++].name : m->shape[shape++].name);
    ff_json_close(j);
    ff_json_close(j);
}

/* f at the samples: [channels of the page][n]; null for those of other problems. */
static ff_status put_tabled(ff_json *j, const ff_html_subject *s, const ff_html_samples *v, size_t fit)
{
    const ff_plot_model *m = &s->model[fit];
    const size_t n = v->n, problem = fit / s->models;
    const ff_dirs w = {v->w, v->w + n, v->w + 2 * n, v->w + 3 * n, v->w + 4 * n, v->w + 5 * n};
    double *f = malloc((m->n_channels * n + 1) * sizeof *f);
    const ff_status status =
        f ? ff_aperture_eval(&m->aperture, m->model, s->isa, m->n_channels, m->shape, m->channel, &w, n, f, NULL, NULL, n)
          : FF_ERR_MEMORY;
    if (!status) {
        ff_json_array(j, "tabled", FF_JSON_LINE);
        for (size_t k = 0; k < s->n_channels; k++) {
            if (s->channel[k].problem == problem)
                ff_page_numbers(j, NULL, n, f + s->channel[k].c * n, 1, 6);
            else
                ff_json_null(j, NULL);
        }
        ff_json_close(j);
    }
    free(f);
    return status == FF_ERR_MEMORY ? status : FF_OK;
}

static void put_boxes(ff_json *j, const ff_model *m)
{
    ff_json_object(j, "log", FF_JSON_LINE); /* parameters that are a scale */
    for (uint32_t k = 0; k < m->n_shape + m->n_channel; k++) {
        const ff_model_param *p = k < m->n_shape ? &m->shape[k] : &m->channel[k - m->n_shape];
        if (p->flags & FF_PARAM_LOG) ff_json_number(j, p->name, p->info->offset);
    }
    ff_json_close(j);
}

ff_status ff_html_models_json(ff_json *j, const ff_html_subject *s, const ff_html_samples *v)
{
    size_t room = TABLED;
    ff_status status = FF_OK;
    ff_json_array(j, "models", FF_JSON_LINE);
    for (size_t k = 0; k < s->r->n_fits && !status; k++) {
        const ff_model *m = s->model[k].model;
        const size_t size = v->n * s->n_channels;
        const int live = is_live(m) && !ff_aperture_extended(&s->model[k].aperture), tabled = !live && size <= room;
        ff_json_object(j, NULL, FF_JSON_LINE);
        ff_json_bool(j, "live", live);
        put_boxes(j, m);
        ff_json_array(j, "lobes", FF_JSON_LINE);
        for (uint32_t l = 0; l < m->n_lobes; l++) put_lobe(j, m, l);
        ff_json_close(j);
        ff_json_array(j, "bases", FF_JSON_LINE);
        for (uint32_t b = 0; b < m->n_bases; b++) put_base(j, m, &m->base[b]);
        ff_json_close(j);
        if (tabled) status = put_tabled(j, s, v, k);
        if (tabled) room -= size;
        ff_json_close(j);
    }
    ff_json_close(j);
    return status;
}
