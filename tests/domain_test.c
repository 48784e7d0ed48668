/* Every model over its closed box and all of the sphere: finite everywhere, nothing below the horizon, blocks of any size, and the
 * claims of the registry: reciprocity, isotropy, passivity. */
#include "model_samples.h"
#include "ff_albedo.h"

/* ---- finite on closed boxes ------------------------------------------------------------------ */

/* All pairs of directions from the normal to the last cosine above the horizon: wi = wo, opposite azimuths, both grazing. */
static void hard_pairs(model_pairs *w)
{
    const double thetas[] = {0, 1e-9, 40 * FIT_DEGREE, 89.99 * FIT_DEGREE, acos(1e-6), acos(2e-8)},
                 phis[] = {0, 33 * FIT_DEGREE, MODEL_PI};
    enum { THETAS = sizeof thetas / sizeof *thetas, PHIS = sizeof phis / sizeof *phis };
    double d[THETAS * PHIS][3];
    w->n = 0;
    for (int i = 0; i < THETAS * PHIS; i++) model_direction(thetas[i / PHIS], phis[i % PHIS], d[i]);
    for (int i = 0; i < THETAS * PHIS; i++)
        for (int o = 0; o < THETAS * PHIS; o++)
            if (i < PHIS || i >= 2 * PHIS || o >= PHIS) model_pairs_add(w, d[i], d[o]);
}

enum { CORNERS = 4, CHANNELS = 2 };

/* The values of a parameter whose combinations are tried: its bounds, its initial value, and ten times the lower bound of a scale.
 */
static size_t corners(const ff_param *p, double *out)
{
    size_t n = 0;
    out[n++] = p->lo;
    out[n++] = p->hi;
    if (p->init > p->lo && p->init < p->hi && !(p->flags & FF_PARAM_LOG)) out[n++] = p->init;
    if ((p->flags & FF_PARAM_LOG) && p->lo > 0) out[n++] = fmin(10 * p->lo, p->hi);
    return n;
}

/* A Fresnel term that is fitted to data may be anything. */
static int may_be_negative(const ff_model *m)
{
    return m->n_lobes && !(ff_term_at(FF_FRESNEL, (size_t)m->lobe[0].fresnel)->claims & FF_PASSIVE);
}

static void check_finite(const fit_surface *s, const model_pairs *w, const char *label)
{
    static double f[CHANNELS * MODEL_PAIRS], alone[CHANNELS * MODEL_PAIRS],
        df[CHANNELS * (FF_MAX_SHAPE + FF_MAX_CHANNEL_PARAMS) * MODEL_PAIRS];
    const ff_dirs dirs = model_dirs(w);
    const size_t n = w->n, n_params = s->model.n_shape + s->model.n_channel, planes = CHANNELS * n_params;
    for (size_t i = 0; i < CHANNELS * n; i++) f[i] = NAN;
    for (size_t i = 0; i < planes * n; i++) df[i] = NAN;
    FF_CHECK(ff_model_eval(&s->model, FF_ISA_BEST, CHANNELS, s->shape, s->channel, &dirs, n, f, df, n) == FF_OK, "%s", label);
    FF_CHECK(ff_model_eval(&s->model, FF_ISA_BEST, CHANNELS, s->shape, s->channel, &dirs, n, alone, NULL, n) == FF_OK, "%s", label);
    FF_CHECK(memcmp(f, alone, CHANNELS * n * sizeof *f) == 0, "%s: f has other bits without derivatives", label);
    size_t bad_f = CHANNELS * n, bad_df = planes * n;
    for (size_t i = CHANNELS * n; i-- > 0;)
        if (!(isfinite(f[i]) && (f[i] >= 0 || may_be_negative(&s->model)))) bad_f = i;
    for (size_t i = planes * n; i-- > 0;)
        if (!isfinite(df[i])) bad_df = i;
    if (bad_f < CHANNELS * n || bad_df < planes * n) {
        const size_t i = (bad_f < CHANNELS * n ? bad_f : bad_df) % n, k = bad_df < planes * n ? bad_df / n % n_params : 0;
        char values[512] = "";
        for (uint32_t q = 0; q < s->model.n_shape; q++)
            snprintf(values + strlen(values), sizeof values - strlen(values), " %g", s->shape[q]);
        FF_CHECK(0, "%s at%s: wi %g %g %g, wo %g %g %g: f %g, d/d%u %g", label, values, w->w[0][i], w->w[1][i], w->w[2][i],
                 w->w[3][i], w->w[4][i], w->w[5][i], f[bad_f < CHANNELS * n ? bad_f : 0], (unsigned)k,
                 bad_df < planes * n ? df[bad_df] : 0);
    }
}

/* All corners of the box of a model; stretch = 0: the lobe's first five parameters stay where they begin. The two channels have the
 * lower and the upper bounds of its linear parameters. */
static long all_corners(const ff_model *m, int stretch, const model_pairs *w, const char *label)
{
    fit_surface s = {.model = *m, .n_channels = CHANNELS};
    double value[FF_MAX_SHAPE][CORNERS];
    size_t n[FF_MAX_SHAPE], total = 1;
    for (uint32_t k = 0; k < m->n_shape; k++) {
        n[k] = corners(m->shape[k].info, value[k]);
        if (model_is_slope(m->shape[k].info) && model_needs_centred(m)) value[k][0] = 0, n[k] = 1;
        if (!stretch && m->shape[k].lobe < m->n_lobes && k < 5) value[k][0] = m->shape[k].info->init, n[k] = 1;
        total *= n[k];
    }
    for (uint32_t k = 0; k < m->n_channel; k++) {
        s.channel[k] = m->channel[k].info->lo;
        s.channel[m->n_channel + k] = m->channel[k].info->hi;
    }
    for (size_t code = 0; code < total; code++) {
        size_t rest = code;
        for (uint32_t k = 0; k < m->n_shape; k++) {
            s.shape[k] = value[k][rest % n[k]];
            rest /= n[k];
        }
        check_finite(&s, w, label);
    }
    return (long)total;
}

static void finite_on_closed_boxes(void)
{
    static model_pairs w;
    long total = 0;
    hard_pairs(&w);
    for (size_t k = 0; k < model_combination_count(); k++) {
        char label[MODEL_LABEL];
        const ff_model m = model_combination(k, label);
        total += all_corners(&m, m.lobe[0].fresnel == 0 && m.n_bases == 0, &w, label);
    }
    printf("  %ld corners, %zu pairs of directions\n", total, w.n);
}

/* Random points of the whole box too, with random and hard directions. */
static void finite_inside(void)
{
    static model_pairs w;
    for (size_t k = 0; k < model_combination_count(); k++) {
        char label[MODEL_LABEL];
        const ff_model m = model_combination(k, label);
        uint64_t state = ff_test_stream("finite inside %s", label);
        for (int i = 0; i < 6; i++) {
            fit_surface s = {.model = m, .n_channels = CHANNELS};
            model_random_parameters(&m, CHANNELS, (model_freedom)(i % 3), 1, &state, s.shape, s.channel);
            hard_pairs(&w);
            model_pairs_random(&m, s.shape, &state, 200, &w);
            check_finite(&s, &w, label);
        }
    }
}

/* ---- the horizon ----------------------------------------------------------------------------- */

static void nothing_below_the_horizon(void)
{
    static model_pairs w;
    static double f[MODEL_PAIRS], df[(FF_MAX_SHAPE + FF_MAX_CHANNEL_PARAMS) * MODEL_PAIRS], terms[5][MODEL_PAIRS];
    const double zs[] = {FF_COS_MIN, nextafter(FF_COS_MIN, 0), 1e-300, 0, -0.0, -1e-9, -0.5, -1}, up[3] = {0.6, 0, 0.8};
    w.n = 0;
    for (size_t i = 0; i < sizeof zs / sizeof *zs; i++) {
        const double s = sqrt(1 - zs[i] * zs[i]), down[3] = {s * 0.6, -s * 0.8, zs[i]}, mirrored[3] = {-down[0], -down[1], zs[i]};
        model_pairs_add(&w, down, up);
        model_pairs_add(&w, up, down);
        model_pairs_add(&w, down, down);
        model_pairs_add(&w, down, mirrored);
    }
    const size_t below = w.n;
    const double last[3] = {sqrt(1 - 4e-16), 0, 2 * FF_COS_MIN};
    model_pairs_add(&w, last, up); /* just above */
    const ff_dirs dirs = model_dirs(&w);
    for (size_t code = 0; code < 2 * model_combination_count(); code++) { /* as they begin, and tilted */
        char label[MODEL_LABEL];
        fit_surface s = {.n_channels = 1};
        const int tilted = code >= model_combination_count();
        s.model = model_combination(code % model_combination_count(), label);
        uint64_t state = ff_test_stream("horizon %s", label);
        if (tilted)
            model_random_parameters(&s.model, 1, MODEL_TILTED, 0.5, &state, s.shape, s.channel);
        else
            ff_model_defaults(&s.model, 1, s.shape, s.channel);
        const size_t n_params = s.model.n_shape + s.model.n_channel, n = w.n;
        FF_CHECK(ff_model_eval(&s.model, FF_ISA_BEST, 1, s.shape, s.channel, &dirs, n, f, df, n) == FF_OK, "%s", label);
        const ff_terms out = {terms[0], terms[1], terms[2], terms[3], terms[4]};
        FF_CHECK(ff_model_terms(&s.model, FF_ISA_BEST, 1, s.shape, s.channel, 0, 0, &dirs, n, &out) == FF_OK, "%s", label);
        for (size_t i = 0; i < below; i++) {
            FF_CHECK(f[i] == 0, "%s: f is %g below the horizon, pair %zu", label, f[i], i);
            for (size_t p = 0; p < n_params; p++)
                FF_CHECK(df[p * n + i] == 0, "%s: df is %g below the horizon, pair %zu", label, df[p * n + i], i);
            for (int t = 0; t < 5; t++)
                FF_CHECK(terms[t][i] == 0, "%s: factor %d is %g below the horizon, pair %zu", label, t, terms[t][i], i);
        }
        FF_CHECK(tilted || f[below] > 0, "%s: f is %g just above the horizon", label, f[below]);
    }
}

/* ---- blocks of any size ---------------------------------------------------------------------- */

static void blocks_of_any_size(void)
{
    enum { LD = MODEL_PAIRS + 3, PARAMS = FF_MAX_SHAPE + FF_MAX_CHANNEL_PARAMS };
    static const size_t sizes[] = {0, 1, 127, 128, 129, 255, 257, 1000};
    static model_pairs w;
    static double f[CHANNELS * LD], df[CHANNELS * PARAMS * LD], terms[5][LD], one_f[CHANNELS], one_df[CHANNELS * PARAMS],
        one_term[5];
    const double sentinel = -4711.5;
    for (size_t ndf = 0; ndf < ff_term_count(FF_NDF); ndf++) {
        char label[FF_MODEL_NAME];
        snprintf(label, sizeof label, "%s/%s+%s/v-cavity+lambert", ff_term_at(FF_NDF, ndf)->name,
                 ff_ndf_at((int)ndf)->lambda ? "smith-direction-correlated" : "none", ff_term_at(FF_NDF, 0)->name);
        fit_surface s = fit_surface_make(label, CHANNELS, "");
        uint64_t state = ff_test_stream("blocks %s", label);
        const size_t n_params = s.model.n_shape + s.model.n_channel;
        w.n = 0;
        model_pairs_random(&s.model, s.shape, &state, 1000, &w);
        for (size_t k = 0; k < sizeof sizes / sizeof *sizes; k++) {
            const size_t n = sizes[k];
            const ff_dirs dirs = model_dirs(&w);
            for (size_t i = 0; i < CHANNELS * LD; i++) f[i] = sentinel;
            for (size_t i = 0; i < CHANNELS * PARAMS * LD; i++) df[i] = sentinel;
            for (size_t i = 0; i < LD; i++) terms[2][i] = sentinel;
            const ff_terms some = {.lambda_o = terms[2]};
            FF_CHECK(ff_model_eval(&s.model, FF_ISA_BEST, CHANNELS, s.shape, s.channel, &dirs, n, f, df, LD) == FF_OK,
                     "%s, %zu pairs", label, n);
            FF_CHECK(ff_model_terms(&s.model, FF_ISA_BEST, CHANNELS, s.shape, s.channel, 0, 1, &dirs, n, &some) == FF_OK,
                     "%s, %zu pairs", label, n);
            for (size_t i = 0; i < CHANNELS * n_params * LD; i++)
                FF_CHECK((df[i] == sentinel) == (i % LD >= n), "%s, %zu pairs: df[%zu] of plane %zu is %g", label, n, i % LD,
                         i / LD, df[i]);
            for (size_t i = CHANNELS * n_params * LD; i < CHANNELS * PARAMS * LD; i++)
                FF_CHECK(df[i] == sentinel, "%s: a plane too many", label);
            for (size_t i = 0; i < CHANNELS * LD; i++)
                FF_CHECK((f[i] == sentinel) == (i % LD >= n), "%s, %zu pairs: f[%zu] is %g", label, n, i % LD, f[i]);
            for (size_t i = 0; i < LD; i++)
                FF_CHECK((terms[2][i] == sentinel) == (i >= n), "%s, %zu pairs: lambda[%zu] is %g", label, n, i, terms[2][i]);
        }
        for (size_t i = 0; i < w.n; i += 37) { /* a pair by itself gives what it gives among others */
            const ff_dirs dirs = {w.w[0] + i, w.w[1] + i, w.w[2] + i, w.w[3] + i, w.w[4] + i, w.w[5] + i};
            const ff_terms all = {one_term, one_term + 1, one_term + 2, one_term + 3, one_term + 4};
            FF_CHECK(ff_model_eval(&s.model, FF_ISA_BEST, CHANNELS, s.shape, s.channel, &dirs, 1, one_f, one_df, 1) == FF_OK, "%s",
                     label);
            FF_CHECK(ff_model_terms(&s.model, FF_ISA_BEST, CHANNELS, s.shape, s.channel, 0, 1, &dirs, 1, &all) == FF_OK, "%s",
                     label);
            for (size_t c = 0; c < CHANNELS; c++) FF_CHECK_CLOSE(one_f[c], f[c * LD + i], 1e-14, 0);
            for (size_t p = 0; p < CHANNELS * n_params; p++)
                FF_CHECK_CLOSE(one_df[p], df[p * LD + i], 1e-13, 1e-13 * one_f[p / n_params]);
            FF_CHECK_CLOSE(one_term[2], terms[2][i], 1e-14, 0);
        }
    }
}

/* Refusals leave the outputs alone. */
static void refusals_write_nothing(void)
{
    const fit_surface s = fit_surface_make("ggx", 1, "");
    const double up = 1, zero = 0;
    const ff_dirs w = {&zero, &zero, &up, &zero, &zero, &up};
    double bad[FF_MAX_SHAPE], f = 4711, df[16] = {4711}, d = 4711;
    const ff_terms terms = {.d = &d};
    memcpy(bad, s.shape, sizeof bad);
    bad[0] = 0;
    FF_CHECK(ff_model_eval(&s.model, FF_ISA_BEST, 1, bad, s.channel, &w, 1, &f, df, 1) == FF_ERR_RANGE, "alpha 0");
    FF_CHECK(ff_model_terms(&s.model, FF_ISA_BEST, 1, bad, s.channel, 0, 0, &w, 1, &terms) == FF_ERR_RANGE, "alpha 0");
    FF_CHECK(ff_model_terms(&s.model, FF_ISA_BEST, 1, s.shape, s.channel, 1, 0, &w, 1, &terms) == FF_ERR_RANGE, "lobe 2 of one");
    FF_CHECK(ff_model_terms(&s.model, FF_ISA_BEST, 1, s.shape, s.channel, 0, 1, &w, 1, &terms) == FF_ERR_RANGE, "channel 2 of one");
    FF_CHECK(f == 4711 && df[0] == 4711 && d == 4711, "a refusal wrote its output");
}

/* ---- claims ---------------------------------------------------------------------------------- */

static double worst_of(const double *a, const double *b, size_t n)
{
    double worst = 0;
    for (size_t i = 0; i < n; i++) {
        const double deviation = fabs(a[i] - b[i]) / fmax(fabs(b[i]), 1e-290);
        if (isnan(deviation)) return HUGE_VAL;
        worst = fmax(worst, deviation);
    }
    return worst;
}

static void values(const fit_surface *s, const model_pairs *w, int swapped, double *f)
{
    const ff_dirs d = model_dirs(w), turned = {d.wox, d.woy, d.woz, d.wix, d.wiy, d.wiz};
    FF_CHECK(ff_model_eval(&s->model, FF_ISA_BEST, s->n_channels, s->shape, s->channel, swapped ? &turned : &d, w->n, f, NULL,
                           w->n) == FF_OK,
             "eval");
}

/* Largest relative difference of f with the directions exchanged, where a random surface of the model is; its claim in *claims. */
static double not_reciprocal(fit_surface *s, model_freedom freedom, uint64_t *state, int *claims)
{
    static model_pairs w;
    static double f[CHANNELS * MODEL_PAIRS], back[CHANNELS * MODEL_PAIRS];
    model_random_parameters(&s->model, CHANNELS, freedom, 0.7, state, s->shape, s->channel);
    w.n = 0;
    model_pairs_random(&s->model, s->shape, state, 1000, &w);
    values(s, &w, 0, f);
    values(s, &w, 1, back);
    *claims = (ff_model_claims(&s->model, s->shape) & FF_RECIPROCAL) != 0;
    return worst_of(back, f, CHANNELS * w.n);
}

/* Masking of one direction alone is 1 where the surface is smooth, and f is reciprocal there by chance: a model that claims nothing
 * has a surface among its next few that is not. */
static void reciprocity(void)
{
    enum { SURFACES = 20 };
    long claimed = 0, not_claimed = 0;
    for (size_t k = 0; k < model_combination_count(); k++)
        for (int freedom = MODEL_ROUND; freedom <= MODEL_TILTED; freedom++) {
            char label[MODEL_LABEL];
            fit_surface s = {.n_channels = CHANNELS};
            s.model = model_combination(k, label);
            uint64_t state = ff_test_stream("reciprocity %s %d", label, freedom);
            int claims;
            double worst = not_reciprocal(&s, (model_freedom)freedom, &state, &claims);
            if (claims) FF_CHECK(worst <= 1e-12, "%s claims reciprocity; deviation %.3g", label, worst);
            for (int i = 1; i < SURFACES && !claims && worst <= 1e-6; i++)
                worst = not_reciprocal(&s, (model_freedom)freedom, &state, &claims);
            if (!claims) FF_CHECK(worst > 1e-6, "%s does not claim reciprocity and %d surfaces are reciprocal", label, SURFACES);
            claimed += claims, not_claimed += !claims;
        }
    FF_CHECK(claimed > 100, "only %ld settings claim reciprocity", claimed);
    FF_CHECK(not_claimed > 100, "only %ld settings do not claim reciprocity", not_claimed);
}

/* Turns the surface by phi: covariance and mean slope of every lobe. 0 when a lobe has no direction to turn. */
static int turn_surface(fit_surface *s, double phi)
{
    int turned = 0;
    const double c = cos(phi), d = sin(phi);
    for (uint32_t l = 0; l < s->model.n_lobes; l++) {
        const ff_lobe *lobe = &s->model.lobe[l];
        double *p = s->shape + lobe->shape0;
        if (lobe->n_shape < 5 || strcmp(s->model.shape[lobe->shape0 + 2].info->name, "r_xy") != 0) continue;
        const double xx = p[0] * p[0], yy = p[1] * p[1], xy = p[2] * p[0] * p[1], x = p[3], y = p[4];
        p[0] = sqrt(c * c * xx - 2 * c * d * xy + d * d * yy);
        p[1] = sqrt(d * d * xx + 2 * c * d * xy + c * c * yy);
        p[2] = (c * d * (xx - yy) + (c * c - d * d) * xy) / (p[0] * p[1]);
        p[3] = c * x - d * y;
        p[4] = d * x + c * y;
        turned = 1;
    }
    return turned;
}

static void turn_pairs(const model_pairs *w, double phi, model_pairs *out)
{
    const double c = cos(phi), d = sin(phi);
    out->n = w->n;
    for (size_t i = 0; i < w->n; i++)
        for (int side = 0; side < 6; side += 3) {
            out->w[side][i] = c * w->w[side][i] - d * w->w[side + 1][i];
            out->w[side + 1][i] = d * w->w[side][i] + c * w->w[side + 1][i];
            out->w[side + 2][i] = w->w[side + 2][i];
        }
}

/* A surface and the directions turned together reflect as before; an isotropic one also when the directions alone are turned. */
static void rotations(void)
{
    static model_pairs w, turned;
    static double f[CHANNELS * MODEL_PAIRS], g[CHANNELS * MODEL_PAIRS];
    long isotropic = 0, with_surface = 0, seen = 0, anisotropic = 0;
    for (size_t k = 0; k < model_combination_count(); k++)
        for (int freedom = MODEL_ROUND; freedom <= MODEL_TILTED; freedom++) {
            char label[MODEL_LABEL];
            fit_surface s = {.n_channels = CHANNELS};
            s.model = model_combination(k, label);
            uint64_t state = ff_test_stream("rotation %s %d", label, freedom);
            const double phi = 2 * MODEL_PI * fit_uniform(&state);
            model_random_parameters(&s.model, CHANNELS, (model_freedom)freedom, 0.4, &state, s.shape, s.channel);
            w.n = 0;
            model_pairs_random(&s.model, s.shape, &state, 300, &w);
            turn_pairs(&w, phi, &turned);
            values(&s, &w, 0, f);
            values(&s, &turned, 0, g);
            const double alone = worst_of(g, f, CHANNELS * w.n);
            if (ff_model_claims(&s.model, s.shape) & FF_ISOTROPIC) {
                FF_CHECK(alone <= 1e-10, "%s claims to be isotropic; deviation %.3g", label, alone);
                isotropic++;
            } else {
                anisotropic++;
                seen += alone > 1e-3;
            }
            if (!turn_surface(&s, phi) || ff_model_check(&s.model, CHANNELS, s.shape, s.channel, NULL)) continue;
            values(&s, &turned, 0, g);
            const double together = worst_of(g, f, CHANNELS * w.n);
            FF_CHECK(together <= 1e-9, "%s: turned with its directions by %.3g it deviates by %.3g", label, phi, together);
            with_surface++;
        }
    FF_CHECK(isotropic > 50 && with_surface > 50, "%ld isotropic settings, %ld turned", isotropic, with_surface);
    FF_CHECK(seen == anisotropic && seen > 0, "of %ld anisotropic settings the test would have caught %ld", anisotropic, seen);
}

static void gamma_is_continuous(void)
{
    static model_pairs w;
    static double f[3][MODEL_PAIRS];
    uint64_t state = ff_test_stream("continuous gamma");
    static const double gammas[] = {1.6, 2, 2.5, 3, 4, 11, 99};
    for (size_t k = 0; k < sizeof gammas / sizeof *gammas; k++) {
        fit_surface s = fit_surface_make("student-t/smith-separable/none", 1, "alpha_x=0.3 alpha_y=0.6 r_xy=0.3");
        const double h = 1e-9 * gammas[k];
        w.n = 0;
        model_pairs_random(&s.model, s.shape, &state, 500, &w);
        for (int i = 0; i < 3; i++) {
            s.shape[5] = fmax(gammas[k] + (i - 1) * h, s.model.shape[5].info->lo);
            values(&s, &w, 0, f[i]);
        }
        for (size_t i = 0; i < w.n; i++) /* d ln f / d gamma is at most about ln(1 + q2 / nu), nu = gamma - 1 */
            FF_CHECK(fabs(f[2][i] - f[1][i]) <= 100 * h * f[1][i] && fabs(f[0][i] - f[1][i]) <= 100 * h * f[1][i],
                     "gamma %g: %.15g %.15g %.15g", gammas[k], f[0][i], f[1][i], f[2][i]);
    }
}

/* Albedo at most 1 with F = 1, a few settings of every distribution with every masking that claims it. */
static void passivity(void)
{
    static const double thetas[] = {0, 50, 80};
    double most = 0;
    long checked = 0;
    for (size_t ndf = 0; ndf < ff_term_count(FF_NDF); ndf++)
        for (size_t masking = 0; masking < ff_term_count(FF_MASKING); masking++)
            for (int freedom = MODEL_ROUND; freedom <= MODEL_CENTRED; freedom++)
                for (size_t t = 0; t < 3; t++) {
                    fit_surface s = {.n_channels = 1};
                    double wo[3];
                    ff_integral albedo = {NAN, NAN};
                    if (!model_lobe(ndf, ff_term_at(FF_MASKING, masking)->name, "schlick", &s.model)) continue;
                    uint64_t state = ff_test_stream("passivity %s/%s %d %zu", ff_term_at(FF_NDF, ndf)->name,
                                                    ff_term_at(FF_MASKING, masking)->name, freedom, t);
                    model_random_parameters(&s.model, 1, (model_freedom)freedom, 0.5, &state, s.shape, s.channel);
                    s.channel[0] = s.channel[1] = 1; /* f0, ks */
                    if (!(ff_model_claims(&s.model, s.shape) & FF_PASSIVE)) continue;
                    model_direction(thetas[t] * FIT_DEGREE, 0.7, wo);
                    FF_CHECK(ff_albedo_directional(&s.model, FF_ISA_BEST, 1, s.shape, s.channel, wo, &albedo, NULL) == FF_OK,
                             "albedo");
                    FF_CHECK(albedo.value > 0 && albedo.value <= 1 + 1e-6, "%s/%s, theta %g: albedo %.9g",
                             ff_term_at(FF_NDF, ndf)->name, ff_term_at(FF_MASKING, masking)->name, thetas[t], albedo.value);
                    most = fmax(most, albedo.value);
                    checked++;
                }
    FF_CHECK(checked > 50, "only %ld settings claim to be passive", checked);
    printf("  %ld albedos, largest %.9f\n", checked, most);
}

FF_TEST_MAIN(FF_TEST(finite_on_closed_boxes), FF_TEST(finite_inside), FF_TEST(nothing_below_the_horizon),
             FF_TEST(blocks_of_any_size), FF_TEST(refusals_write_nothing), FF_TEST(reciprocity), FF_TEST(rotations),
             FF_TEST(gamma_is_continuous), FF_TEST(passivity))
