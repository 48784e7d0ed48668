#include "data_sets.h"
#include "fit/problem/internal_problem.h"

static double between(uint64_t *state, double lo, double hi)
{
    return lo + (hi - lo) * fit_uniform(state);
}

static double log_between(uint64_t *state, double lo, double hi)
{
    return lo * pow(hi / lo, fit_uniform(state));
}

static size_t one_of(uint64_t *state, size_t n)
{
    return (size_t)(fit_random(state) % n);
}

static int chance(uint64_t *state, double p)
{
    return fit_uniform(state) < p;
}

/* ---- models ---------------------------------------------------------------------------------- */

/* What data are drawn from: a fixed list, so that a masking more does not change them. */
static const char *const maskings[] = {"smith-masking-only",
                                       "smith-separable",
                                       "smith-height-correlated",
                                       "smith-direction-correlated",
                                       "smith-height-direction-correlated",
                                       "v-cavity",
                                       "kelemen",
                                       "hammon",
                                       "schlick-smith",
                                       "none"};

/* A masking that goes with the distribution, and is not for the furnace test alone. */
static const char *draw_masking(uint64_t *state, const char *ndf)
{
    ff_model m;
    char text[FF_MODEL_NAME];
    for (;;) {
        const char *name = maskings[one_of(state, sizeof maskings / sizeof *maskings)];
        const ff_term *masking = ff_term_at(FF_MASKING, (size_t)ff_term_find(FF_MASKING, name));
        snprintf(text, sizeof text, "%s/%s", ndf, masking->name);
        if (!(masking->claims & FF_FURNACE_ONLY) && !ff_model_parse(text, &m, NULL)) return masking->name;
    }
}

/* Schlick's term for most, the others for the rest; none (F = 1) for a few. */
static const char *draw_fresnel(uint64_t *state)
{
    static const char *const others[] = {"schlick-f82", "dielectric", "conductor", "sgd", "none"};
    return chance(state, 0.75) ? "schlick" : others[one_of(state, sizeof others / sizeof *others)];
}

static void draw_one_lobe(uint64_t *state, size_t i, char *out)
{
    const char *ndf = ff_term_at(FF_NDF, i % ff_term_count(FF_NDF))->name;
    const char *masking = draw_masking(state, ndf), *fresnel = draw_fresnel(state);
    snprintf(out, FF_MODEL_NAME, "%s/%s/%s%s", ndf, masking, fresnel, chance(state, 0.6) ? "+lambert" : "");
}

/* Two thirds of one kind or of the usual two, a third of any two; one in four shares its Fresnel term. */
static void draw_two_lobes(uint64_t *state, size_t i, char *out)
{
    static const char *const usual[][2] = {{"ggx", "ggx"},       {"beckmann", "ggx"}, {"beckmann", "beckmann"},
                                           {"ggx", "student-t"}, {"phong", "phong"},  {"vmf", "ggx"}};
    const char *const *pair = usual[i % (sizeof usual / sizeof *usual)], *any[2];
    for (int k = 0; k < 2; k++) any[k] = ff_term_at(FF_NDF, one_of(state, ff_term_count(FF_NDF)))->name;
    if (chance(state, 1.0 / 3)) pair = any;
    const char *masking[2];
    for (int k = 0; k < 2; k++) masking[k] = chance(state, 0.5) ? "smith-height-correlated" : draw_masking(state, pair[k]);
    ff_model m; /* some distributions have no Lambda */
    for (int k = 0; k < 2; k++) {
        char text[FF_MODEL_NAME];
        snprintf(text, sizeof text, "%s/%s", pair[k], masking[k]);
        if (ff_model_parse(text, &m, NULL)) masking[k] = draw_masking(state, pair[k]);
    }
    snprintf(out, FF_MODEL_NAME, "%s/%s/schlick+%s/%s/%s%s", pair[0], masking[0], pair[1], masking[1],
             chance(state, 0.25) ? "shared" : "schlick", chance(state, 0.6) ? "+lambert" : "");
}

/* ---- parameters ------------------------------------------------------------------------------ */

/* The width parameter of a distribution that looks like a roughness alpha. */
static double width_like(const char *name, const char *ndf, double alpha)
{
    if (strcmp(name, "n") == 0) return 2 / (alpha * alpha) - 2;
    if (strcmp(name, "kappa") == 0) return 2 / (alpha * alpha);
    if (strcmp(name, "B") == 0) return 1 / (alpha * alpha);
    if (strcmp(ndf, "sgd") == 0) return alpha * alpha;
    return alpha;
}

/* Shape parameters beyond the width. */
static double draw_own(uint64_t *state, const ff_param *p, const char *ndf)
{
    if (strcmp(p->name, "gamma") == 0)
        return strcmp(ndf, "gtr") == 0 ? log_between(state, 0.6, 8) : 1 + log_between(state, 0.6, 30);
    if (strcmp(p->name, "p") == 0) return between(state, 0, 3);
    if (strcmp(p->name, "C") == 0) return log_between(state, 0.3, 4);
    return p->init;
}

static double draw_channel(uint64_t *state, const ff_model_param *p, const char *fresnel, double shade)
{
    const char *name = p->info->name;
    if (strcmp(name, "f0") == 0 && strcmp(fresnel, "sgd") == 0) return between(state, 0.1, 1.2) * shade;
    if (strcmp(name, "f0") == 0) return (chance(state, 0.5) ? log_between(state, 0.02, 1) : between(state, 0.02, 1)) * shade;
    if (strcmp(name, "f1") == 0) return between(state, -0.05, 0.05);
    if (strcmp(name, "f82") == 0) return between(state, 0.5, 1);
    if (strcmp(name, "eta") == 0)
        return strcmp(fresnel, "dielectric") == 0 ? log_between(state, 1.2, 3) : log_between(state, 0.2, 3);
    if (strcmp(name, "k") == 0) return log_between(state, 1, 8);
    if (strcmp(name, "kd") == 0) return chance(state, 0.15) ? 0 : between(state, 0, 0.8);
    return p->init;
}

/* Turns a circle of roughness alpha into an ellipse. */
static void draw_ellipse(uint64_t *state, int correlated, double alpha, double *shape)
{
    const double aspect = log_between(state, 1, 8),
                 phi = correlated ? between(state, 0, 180) * FIT_DEGREE : 90 * FIT_DEGREE * (double)one_of(state, 2);
    const double c = cos(phi), s = sin(phi), major2 = alpha * alpha * aspect, minor2 = alpha * alpha / aspect,
                 xx = major2 * c * c + minor2 * s * s, yy = major2 * s * s + minor2 * c * c;
    shape[0] = sqrt(xx);
    shape[1] = sqrt(yy);
    shape[2] = correlated ? (major2 - minor2) * c * s / sqrt(xx * yy) : 0;
}

static void draw_lobe(uint64_t *state, fit_surface *s, uint32_t k, double alpha, int isotropic)
{
    const ff_model *m = &s->model;
    const ff_lobe *lobe = &m->lobe[k];
    const char *ndf = ff_term_at(FF_NDF, (size_t)lobe->ndf)->name;
    double *shape = s->shape + lobe->shape0;
    for (uint32_t i = 0; i < lobe->n_shape; i++) {
        const ff_param *p = m->shape[lobe->shape0 + i].info;
        shape[i] = i == 0 ? width_like(p->name, ndf, alpha) : draw_own(state, p, ndf);
        if (strcmp(p->name, "alpha_y") == 0) shape[i] = shape[0];
        if (strcmp(p->name, "weight") == 0) shape[i] = between(state, 0.1, 0.9);
    }
    if (!isotropic && !lobe->isotropic) draw_ellipse(state, chance(state, 0.6), alpha, shape);
}

static void into_box(fit_surface *s)
{
    for (uint32_t k = 0; k < s->model.n_shape; k++)
        s->shape[k] = fmin(fmax(s->shape[k], s->model.shape[k].info->lo), s->model.shape[k].info->hi);
    for (size_t i = 0; i < s->n_channels * s->model.n_channel; i++) {
        const ff_param *p = s->model.channel[i % s->model.n_channel].info;
        s->channel[i] = fmin(fmax(s->channel[i], p->lo), p->hi);
    }
}

/* Roughness: what occurs, and one in eight from the whole range that is resolved. */
static void draw_surface(uint64_t *state, fit_surface *s, int isotropic)
{
    const ff_model *m = &s->model;
    double alpha = chance(state, 1.0 / 8) ? log_between(state, 0.002, 4) : log_between(state, 0.02, 1);
    for (uint32_t k = 0; k < m->n_lobes; k++) {
        draw_lobe(state, s, k, alpha, isotropic || chance(state, 0.3));
        alpha *= log_between(state, 1.5, 12); /* of a second lobe */
    }
    for (size_t c = 0; c < s->n_channels; c++) {
        const double shade = between(state, 0.6, 1);
        for (uint32_t k = 0; k < m->n_channel; k++) {
            const uint32_t lobe = m->channel[k].lobe;
            const char *fresnel =
                lobe < m->n_lobes && m->lobe[lobe].fresnel >= 0 ? ff_term_at(FF_FRESNEL, (size_t)m->lobe[lobe].fresnel)->name : "";
            s->channel[c * m->n_channel + k] = draw_channel(state, &m->channel[k], fresnel, shade);
        }
    }
    into_box(s);
}

/* ---- data sets ------------------------------------------------------------------------------- */

static data_set draw(family f, uint64_t *state, size_t i)
{
    data_set d;
    memset(&d, 0, sizeof d);
    if (f == ONE_LOBE)
        draw_one_lobe(state, i, d.model);
    else
        draw_two_lobes(state, i, d.model);
    const int isotropic = chance(state, 1.0 / 3); /* of the surface; half of these are measured as such */
    d.isotropic = isotropic && chance(state, 0.5);
    d.truth = fit_surface_make(d.model, chance(state, 0.6) ? 1 : 3, "");
    draw_surface(state, &d.truth, isotropic);
    d.coverage = chance(state, 0.6) ? SCATTERED : FEW_INCIDENCES;
    d.incidences = 1 + (int)one_of(state, 6);
    d.how.n = (size_t)log_between(state, 300, 2000);
    d.how.max_theta = chance(state, 0.5) ? 80 : between(state, 30, 80);
    d.how.glossy = 0.3 * (double)one_of(state, 3);
    d.how.noise = chance(state, 0.2) ? 0 : between(state, 0.001, 0.1);
    d.how.sigma = d.how.noise > 0 && chance(state, 0.2);
    d.how.seed = fit_random(state);
    return d;
}

/* Does any light arrive? A narrow lobe may lie between all samples, with nothing under it. */
static int is_lit(const data_set *d)
{
    double sum = 0;
    ff_table t = data_set_measure(d);
    for (size_t k = 0; k < t.n * t.n_channels; k++) sum += t.valid[k % t.n] ? t.value[k] : 0;
    sum /= (double)(t.n * t.n_channels);
    ff_table_clear(&t);
    return sum > 1e-6;
}

data_set data_set_make(family f, uint64_t seed, size_t i)
{
    uint64_t state = (seed * FAMILIES + (uint64_t)f) * UINT64_C(0xd1342543de82ef95) + (uint64_t)i * UINT64_C(0x2545f4914f6cdd1d);
    data_set d = draw(f, &state, i);
    while (!is_lit(&d)) d = draw(f, &state, i);
    return d;
}

/* Directions of light from a short list, in one azimuth or in several. */
static void few_incidences(const data_set *d, ff_table *t, uint64_t *state)
{
    const double cos_max = cos(d->how.max_theta * FIT_DEGREE);
    const int azimuths = d->isotropic ? 1 : 1 + (int)one_of(state, 4);
    for (size_t i = 0; i < t->n; i++) {
        double a[4];
        const int k = (int)one_of(state, (size_t)d->incidences);
        a[0] = d->how.max_theta * FIT_DEGREE * (k + 0.5) / d->incidences;
        a[1] = 180 * FIT_DEGREE * (double)one_of(state, (size_t)azimuths) / azimuths;
        a[2] = fit_theta(state, cos_max);
        a[3] = 360 * FIT_DEGREE * fit_uniform(state);
        if (fit_uniform(state) < d->how.glossy) fit_mirror(state, cos_max, a);
        for (int j = 0; j < 4; j++) t->angle[j][i] = a[j];
    }
}

ff_table data_set_measure(const data_set *d)
{
    ff_table t;
    uint64_t state = d->how.seed;
    if (ff_table_init(d->how.n, d->truth.n_channels, NULL, d->how.sigma, 0, &t, NULL)) {
        printf("out of memory for the test's samples\n");
        exit(1);
    }
    fit_directions(&d->how, &t, &state);
    if (d->coverage == FEW_INCIDENCES) few_incidences(d, &t, &state);
    t.isotropic = d->isotropic;
    fit_evaluate(&d->truth, &t);
    /* a detector that states its error has some where there is no light */
    double floor = 0;
    for (size_t k = 0; d->how.sigma && k < t.n * t.n_channels; k++) floor += 1e-3 * t.value[k] / (double)(t.n * t.n_channels);
    for (size_t k = 0; k < t.n * t.n_channels; k++) {
        const double deviation = hypot(d->how.noise * t.value[k], floor);
        if (d->how.sigma) t.sigma[k] = deviation;
        if (d->how.noise > 0) t.value[k] += deviation * fit_normal(&state);
    }
    return t;
}

void data_set_describe(const data_set *d, char *out, size_t size)
{
    char where[48] = "";
    if (d->coverage == FEW_INCIDENCES)
        snprintf(where, sizeof where, " of %d incidence%s", d->incidences, d->incidences > 1 ? "s" : "");
    snprintf(out, size, "%s, %zu samples%s to %.0f degrees, %.0f %% near the mirror, %zu channel%s, noise %.1f %%%s%s", d->model,
             d->how.n, where, d->how.max_theta, 100 * d->how.glossy, d->truth.n_channels, d->truth.n_channels > 1 ? "s" : "",
             100 * d->how.noise, d->how.sigma ? " with sigma" : "", d->isotropic ? ", isotropic" : "");
}

void data_set_parameters(const ff_layout *l, const double *shape, const double *channel, char *out, size_t size)
{
    const ff_model *m = l->m;
    size_t used = 0;
    out[0] = 0;
    for (uint32_t k = 0; k < l->free.n_shape && used < size; k++) {
        const uint32_t i = l->free.shape[k];
        used += (size_t)snprintf(out + used, size - used, "%s%s %.4g", used ? ", " : "", m->shape[i].name, shape[i]);
    }
    for (uint32_t k = 0; k < l->free.n_channel && used < size; k++)
        for (size_t c = 0; c < l->n_channels && used < size; c++) {
            const double v = channel[c * m->n_channel + l->free.channel[k]];
            if (c == 0)
                used += (size_t)snprintf(out + used, size - used, "%s%s %.4g", used ? ", " : "",
                                         m->channel[l->free.channel[k]].name, v);
            else
                used += (size_t)snprintf(out + used, size - used, ":%.4g", v);
        }
}
