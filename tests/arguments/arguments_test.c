/* Every number that a public function takes, far outside and just outside of what its header allows: NaN, infinities, 0, -1, huge
 * ones and the neighbours of both bounds. A call comes back within its time, with a status that says so and nothing written where
 * the number is not legal, and with what it was asked for where it is. arguments.def has the list.
 *
 * The values of one probe are tried in a process that is split off, which has a processor time for each: what hangs or crashes is
 * one failure, and the rest goes on. */
#include "internal_scene.h"
#include <float.h>
#include <limits.h>
#include <signal.h>
#include <stddef.h>
#include <sys/mman.h>
#include <sys/time.h>
#include <sys/wait.h>

#define HORIZON       1.5707963267948968                                      /* pi/2, and what programs make of 90 degrees */
#define AT_MOST(k, n) ((size_t)(k) > (size_t)(n) ? (size_t)(n) : (size_t)(k)) /* arrays are no longer than n */
enum { SECONDS = 5, MOST_VALUES = 16, TOUCHED = -1 };
enum { LO = 1, HI = 2, NUMBERS = 4, ANY = 8, MAYBE = 16, ONLY_LO = 32, OUTSIDE = 64 };
typedef enum kind { REAL, INT, SIZE } kind;

/* An output that nobody has written to: a pointer, and a number. */
static char nothing[8];
#define NOTHING -7.25e-77

static ff_error err;

/* ---- what the bodies of arguments.def are made of -------------------------------------------- */

/* A call that makes an object: nothing was written where it failed. */
#define NEW(type, release, call)                                                                                                   \
    type *out = (type *)(void *)nothing;                                                                                           \
    const ff_status made = call;                                                                                                   \
    if (made) return out == (type *)(void *)nothing ? made : TOUCHED;                                                              \
    release(out);                                                                                                                  \
    return FF_OK;

static ff_status found(const void *pointer)
{
    return pointer ? FF_OK : FF_ERR_RANGE;
}

static ff_status untouched(ff_status status, double out)
{
    return status && out != NOTHING ? TOUCHED : status;
}

static ff_status formatted(ff_status status)
{
    char out[64];
    ff_error_format(&err, out, sizeof out);
    return status == FF_ERR_READ ? FF_OK : TOUCHED;
}

static ff_status is_inside(double u)
{
    return u > 0 && u < 1 ? FF_OK : TOUCHED;
}

/* A pair of directions whose light leans by x, a unit vector where that is one. */
typedef struct pair {
    double number[6];
    const double *plane[6];
    ff_dirs dirs;
} pair;

static void pair_fill(pair *p, double z)
{
    const double number[6] = {sqrt(fmax(1 - z * z, 0)), 0, z, -0.5, 0, sqrt(0.75)};
    memcpy(p->number, number, sizeof number);
    for (int k = 0; k < 6; k++) p->plane[k] = &p->number[k];
    p->dirs = (ff_dirs){p->plane[0], p->plane[1], p->plane[2], p->plane[3], p->plane[4], p->plane[5]};
}

/* ---- of tables ------------------------------------------------------------------------------- */

static const char *a_file(void)
{
    static const char text[] = "theta_i,phi_i,theta_o,phi_o,f\n30,0,30,180,1\n30,0,20,180,0.5\n";
    const char *path = ff_test_path("read.csv");
    ff_test_write(path, text, sizeof text - 1);
    return path;
}

/* Four numbers may be written, and not one behind them. */
static ff_status directions_of(const scene *s, size_t first, size_t count)
{
    double out[6][5], *planes[6];
    for (int k = 0; k < 6; k++) planes[k] = out[k], out[k][4] = NOTHING;
    ff_table_directions(s->table, first, count, planes);
    for (int k = 0; k < 6; k++)
        if (out[k][4] != NOTHING) return TOUCHED;
    return FF_OK;
}

static ff_status values_of(const scene *s, void (*get)(const ff_table *, size_t, size_t, size_t, double *), size_t c, size_t first,
                           size_t count)
{
    double out[5] = {0, 0, 0, 0, NOTHING};
    get(s->table, c, first, count, out);
    return out[4] == NOTHING ? FF_OK : TOUCHED;
}

static ff_status valid_of(const scene *s, size_t first, size_t count)
{
    unsigned char out[5] = {0, 0, 0, 0, 7};
    ff_table_valid(s->table, first, count, out);
    return out[4] == 7 ? FF_OK : TOUCHED;
}

static ff_status weights_of(size_t first, size_t count)
{
    double out[5] = {0, 0, 0, 0, NOTHING};
    ff_table *t;
    if (ff_table_new(4, 1, 0, 1, &t, &err)) return TOUCHED;
    ff_table_weights(t, first, count, out);
    ff_table_free(t);
    return out[4] == NOTHING ? FF_OK : TOUCHED;
}

/* ---- of models ------------------------------------------------------------------------------- */

static ff_status evaluate(const scene *s, ff_isa isa, const double *shape, const double *channel, double z, size_t ld)
{
    double f[2 * N_CHANNELS];
    pair p;
    pair_fill(&p, z);
    f[0] = NOTHING;
    return untouched(ff_model_eval(s->model, isa, N_CHANNELS, shape, channel, &p.dirs, 1, f, NULL, ld), f[0]);
}

/* The same through a disc of half a degree. */
static ff_status through(const scene *s, ff_isa isa, const double *shape, const double *channel, double z, size_t ld)
{
    const ff_aperture disc = {.outline = FF_APERTURE_DISC, .half = 0.00873};
    double f[2 * N_CHANNELS];
    pair p;
    pair_fill(&p, z);
    f[0] = NOTHING;
    return untouched(ff_aperture_eval(&disc, s->model, isa, N_CHANNELS, shape, channel, &p.dirs, 1, f, NULL, NULL, ld), f[0]);
}

static ff_status terms(const scene *s, ff_isa isa, size_t n_channels, const double *shape, const double *channel, uint32_t lobe,
                       size_t c, double z)
{
    double d = NOTHING;
    pair p;
    pair_fill(&p, z);
    const ff_terms out = {.d = &d};
    return untouched(ff_model_terms(s->model, isa, n_channels, shape, channel, lobe, c, &p.dirs, 1, &out), d);
}

/* A view of cosine z: a unit vector for 0 <= z <= 1. */
static ff_status albedo(const scene *s, ff_isa isa, size_t n_channels, const double *shape, const double *channel, double z)
{
    const double wo[3] = {sqrt(fmax(1 - z * z, 0)), 0, z};
    ff_integral out[N_CHANNELS] = {{NOTHING, 0}};
    return untouched(ff_albedo_directional(s->model, isa, n_channels, shape, channel, wo, out, &err), out[0].value);
}

static ff_status furnace(const scene *s, ff_isa isa, const double *shape, uint32_t lobe, double z)
{
    const double wo[3] = {sqrt(fmax(1 - z * z, 0)), 0, z};
    ff_integral out = {NOTHING, 0};
    return untouched(ff_albedo_weak_furnace(s->model, isa, shape, lobe, wo, &out, &err), out.value);
}

static ff_status sampler(const scene *s, const double *shape, const double *channel)
{
    NEW(ff_sampler, ff_sampler_free, ff_sampler_new(s->model, FF_ISA_BEST, N_CHANNELS, shape, channel, &out, &err))
}

static ff_status simulate(const scene *s, size_t n_channels, const double *shape, const double *channel)
{
    ff_simulate_options o;
    ff_simulate_options_init(&o);
    o.sampling.step_deg = 45;
    NEW(ff_table, ff_table_free, ff_simulate(s->model, n_channels, shape, channel, &o, &out, &err))
}

static ff_status start(const scene *s, const double *shape, const double *channel)
{
    ff_fit_options o = s->options;
    o.start_shape = shape;
    o.start_channel = channel;
    NEW(ff_fit_result, ff_fit_result_free, ff_problem_fit(s->problem, s->model, &o, &out, &err))
}

static ff_status difference(const scene *s, const double *shape, const double *channel)
{
    double out = NOTHING;
    return untouched(ff_picture_difference(s->picture, s->model, shape, channel, &out, &err), out);
}

enum { BALL = 3 }; /* pixels of a side */

enum { SMALLEST = 4 }; /* pixels across that a picture may have, which are tried as well */

/* Three channels of the scene's two, or as many as are asked for of them. */
static ff_status ball(const scene *s, const ff_table *t, const ff_render_options *o, size_t n_channels, const double *shape,
                      const double *channel)
{
    float rgba[4 * SMALLEST * SMALLEST] = {-7};
    double own[3 * N_CHANNEL_MOST];
    ff_render_options small;
    ff_render_options_init(&small);
    small.pixels = BALL;
    small.samples = 2;
    small.threads = 1;
    for (size_t c = 0; c < 3; c++) memcpy(own + c * s->n_channel, channel + (c > 0) * s->n_channel, s->n_channel * sizeof *own);
    const ff_status status = t ? ff_render_table(t, s->model, n_channels, shape, own, o ? o : &small, rgba, NULL, &err)
                               : ff_render_model(s->model, n_channels, shape, own, o ? o : &small, rgba, NULL, &err);
    return status && rgba[0] != -7 ? TOUCHED : status;
}

/* A float that is no nearer to the legal ones than x. */
static float as_float(double x)
{
    if (fabs(x) > (double)FLT_MAX) return (float)copysign(INFINITY, x);
    return x != 0 && (float)x == 0 ? copysignf(FLT_TRUE_MIN, (float)x) : (float)x;
}

static ff_status environment(size_t nx, size_t ny, double red, double turn)
{
    const float rgb[3 * 4] = {as_float(red), 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1};
    NEW(ff_environment, ff_environment_free, ff_environment_new(nx, ny, rgb, turn, &out, &err))
}

static ff_status sky(double elevation, double turbidity, double ground, double turn)
{
    NEW(ff_environment, ff_environment_free, ff_environment_sky(elevation, turbidity, ground, turn, &out, &err))
}

/* A direction, or two numbers to draw one by, of a small environment: what comes of any of them is finite. */
static ff_status in_environment(double x, int draws)
{
    const float rgb[3 * 4] = {1, 2, 3};
    double v[3] = {x, 0.5, 0.5}, w[3], L[3] = {0}, pdf = 0;
    ff_environment *e;
    if (ff_environment_new(2, 2, rgb, 0, &e, &err)) return FF_ERR_INTERNAL;
    if (draws)
        ff_environment_draw(e, 1, v, w, L, &pdf, 1);
    else
        ff_environment_look(e, 1, v, L, &pdf, 1);
    ff_environment_free(e);
    return isfinite(pdf) && isfinite(L[0]) ? FF_OK : TOUCHED;
}

static ff_status exr_layers(size_t n)
{
    const float rgba[4] = {1, 1, 1, 1};
    const ff_render_cell cell = {rgba, NULL, FF_CELL_PICTURE};
    ff_render_sheet one;
    ff_render_layer layer[64];
    char name[64][8];
    ff_render_sheet_init(&one);
    one.pixels = one.n = 1;
    for (size_t k = 0; k < 64; k++) {
        snprintf(name[k], sizeof name[k], "l%zu", k);
        layer[k] = (ff_render_layer){name[k], &cell};
    }
    return ff_render_exr("/dev/null", &one, n, layer, &err);
}

static ff_status walk(const scene *s, size_t n_channels, const double *shape, const double *channel, const ff_walk_options *o)
{
    ff_walk_options own;
    ff_walk_options_init(&own);
    if (o) own = *o;
    if (own.facets == FF_FACETS_MIRROR) own.facets = FF_FACETS_COUPLED; /* the scene has a base */
    NEW(ff_walk, ff_walk_free, ff_walk_new(s->model, n_channels, shape, channel, &own, &out, &err))
}

static ff_status walk_values(const scene *s, double z, uint64_t first, size_t ld)
{
    const double x = sqrt(fmax(1 - z * z, 0)), zero = 0;
    const ff_dirs w = {&x, &zero, &z, &zero, &x, &z};
    double f[N_CHANNELS * 2] = {NOTHING, 0}, error[N_CHANNELS * 2];
    return untouched(ff_walk_values(s->walk, &w, 1, first, f, error, ld, &err), f[0]);
}

static ff_status walk_lobe(const scene *s, double z)
{
    const double wi[3] = {sqrt(fmax(1 - z * z, 0)), 0, z};
    ff_lobe_mean lobe[N_CHANNELS];
    lobe[0].albedo = NOTHING;
    return untouched(ff_walk_lobe(s->walk, wi, lobe, NULL, &err), lobe[0].albedo);
}

enum {
    WITH_CHECK,
    WITH_CLAIMS,
    WITH_EVAL,
    WITH_APERTURE,
    WITH_TERMS,
    WITH_ALBEDO,
    WITH_FURNACE,
    WITH_SAMPLER,
    WITH_SIMULATE,
    WITH_WALK,
    WITH_START,
    WITH_BALL,
    WITH_BALL_OF_TABLE,
    WITH_PICTURE
};

static ff_status with(const scene *s, int what, const double *shape, const double *channel)
{
    switch (what) {
    case WITH_CHECK:
        return ff_model_check(s->model, N_CHANNELS, shape, channel, &err);
    case WITH_CLAIMS:
        (void)ff_model_claims(s->model, shape);
        return FF_OK;
    case WITH_EVAL:
        return evaluate(s, FF_ISA_BEST, shape, channel, 0.5, 1);
    case WITH_APERTURE:
        return through(s, FF_ISA_BEST, shape, channel, 0.5, 1);
    case WITH_TERMS:
        return terms(s, FF_ISA_BEST, N_CHANNELS, shape, channel, 0, 0, 0.5);
    case WITH_ALBEDO:
        return albedo(s, FF_ISA_BEST, N_CHANNELS, shape, channel, 0.5);
    case WITH_FURNACE:
        return furnace(s, FF_ISA_BEST, shape, 0, 0.5);
    case WITH_SAMPLER:
        return sampler(s, shape, channel);
    case WITH_SIMULATE:
        return simulate(s, N_CHANNELS, shape, channel);
    case WITH_WALK:
        return walk(s, N_CHANNELS, shape, channel, NULL);
    case WITH_START:
        return start(s, shape, channel);
    case WITH_BALL:
        return ball(s, NULL, NULL, 3, shape, channel);
    case WITH_BALL_OF_TABLE:
        return ball(s, s->grey, NULL, 3, shape, channel);
    default:
        return difference(s, shape, channel);
    }
}

/* x as each of the shape parameters: refused outside of the parameter's box. */
static ff_status with_shape(const scene *s, double x, int what)
{
    for (uint32_t k = 0; k < s->n_shape; k++) {
        const ff_model_param *p = ff_model_param_at(s->model, (ff_param_ref){FF_PARAM_SHAPE, k});
        double shape[N_SHAPE_MOST];
        memcpy(shape, s->shape, sizeof shape);
        shape[k] = x;
        const ff_status status = with(s, what, shape, s->channel);
        const int legal = x >= p->info->lo && x <= p->info->hi;
        if (status < 0 || status >= FF_ERR_INTERNAL) return status;
        if (what != WITH_CLAIMS && !legal && !status) return TOUCHED;
    }
    return FF_OK;
}

/* x as the reflectance F0 of the second channel. */
static ff_status with_channel(const scene *s, double x, int what)
{
    double channel[N_CHANNELS * N_CHANNEL_MOST];
    memcpy(channel, s->channel, sizeof channel);
    channel[s->n_channel + ff_model_param_find(s->model, "f0").index] = x;
    return with(s, what, s->shape, channel);
}

/* x as each argument of each conversion: refused outside of the argument's interval. */
static ff_status convert_all(double x)
{
    for (size_t i = 0; i < ff_conversion_count(); i++) {
        const ff_conversion *c = ff_conversion_at(i);
        for (uint32_t k = 0; k < c->n_in; k++) {
            double in[FF_CONVERSION_VALUES] = {0.5, 0.5, 0.5}, out[FF_CONVERSION_VALUES] = {NOTHING, 0, 0};
            const ff_conversion_value *v = &c->in[k];
            in[k] = x;
            const ff_status status = ff_conversion_apply(c, in, 0.5, out, &err);
            if (status < 0 || status >= FF_ERR_INTERNAL || untouched(status, out[0]) < 0) return TOUCHED;
            if (!(x < v->hi && (x > v->lo || (x == v->lo && v->lo_included))) && !status) return TOUCHED;
            for (uint32_t j = 0; j < c->n_out && !status; j++)
                if (!isfinite(out[j])) return TOUCHED;
        }
    }
    return FF_OK;
}

static ff_status doubt_all(double x, double y)
{
    const double in[FF_CONVERSION_VALUES] = {x, x, x}, out[FF_CONVERSION_VALUES] = {y, y, y};
    for (size_t i = 0; i < ff_conversion_count(); i++) (void)ff_conversion_doubt(ff_conversion_at(i), in, out);
    return FF_OK;
}

static ff_status profile(size_t n, ff_profile_kind kind, double second, double value)
{
    const double x[FF_PROFILE_POINTS_MIN] = {0.1, second, 0.5, 0.9}, y[FF_PROFILE_POINTS_MIN] = {1, value, 0.3, 0.01};
    NEW(ff_profile_table, ff_profile_free, ff_profile_new(kind, n, x, y, &out, NULL, &err))
}

static ff_status write_profile(ff_profile_kind kind, double x, double y)
{
    const char *path = ff_test_path("profile.csv");
    remove(path);
    const ff_status status = ff_profile_write(path, kind, 1, &x, &y, NULL, &err);
    return status && access(path, F_OK) == 0 ? TOUCHED : status;
}

static ff_status noise(ff_noise_level level, size_t n, double cos_i, double cos_o)
{
    NEW(ff_noise, ff_noise_free, ff_noise_new(&level, n, cos_i, cos_o, &out, &err))
}

static ff_status draw(const scene *s, double z, double u, double roulette, size_t ld)
{
    const double wo[3] = {sqrt(fmax(1 - z * z, 0)), 0, z}, uniform[3] = {u, u, u};
    double wi[3], pdf = NOTHING, f[N_CHANNELS], weight[N_CHANNELS];
    ff_sampler_sample(s->sampler, 1, wo, uniform, &roulette, wi, &pdf, f, weight, ld);
    return pdf < 0 ? TOUCHED : FF_OK;
}

static ff_status density(const scene *s, double zo, double zi)
{
    const double wo[3] = {sqrt(fmax(1 - zo * zo, 0)), 0, zo}, wi[3] = {0, sqrt(fmax(1 - zi * zi, 0)), zi};
    double pdf = NOTHING;
    ff_sampler_pdf(s->sampler, 1, wo, wi, &pdf, 1);
    return pdf < 0 ? TOUCHED : FF_OK;
}

/* ---- of fits --------------------------------------------------------------------------------- */

static ff_status constrained(const scene *s, ff_bound bound, ff_prior prior, double held)
{
    const double value[N_CHANNELS] = {held, held};
    const ff_fixed fixed = {"kd", N_CHANNELS, value, NULL};
    const ff_constraints c = {.n_bounds = 1, .n_priors = 1, .n_fixed = 1, .bound = &bound, .prior = &prior, .fixed = &fixed};
    return ff_constraints_check(&c, s->model, &err);
}

static ff_status correlation(const scene *s, int a, uint32_t ia, size_t ca, int b, uint32_t ib, size_t cb)
{
    const double r =
        ff_fit_result_correlation(s->fit[0], (ff_param_ref){(ff_param_kind)a, ia}, ca, (ff_param_ref){(ff_param_kind)b, ib}, cb);
    return isnan(r) ? FF_ERR_RANGE : fabs(r) <= 1 + 1e-12 ? FF_OK : TOUCHED;
}

static ff_status bootstrap(const scene *s, const ff_fit_options *o, size_t repeats)
{
    ff_bootstrap out = {.size = sizeof out, .n_groups = 77};
    const ff_status status = ff_trust_bootstrap(s->problem, s->places, o, repeats, 1, s->fit[0], &out, &err);
    return status && out.n_groups != 77 ? TOUCHED : status;
}

static ff_status compare(const scene *s, const ff_fit_options *o, size_t winner, size_t folds)
{
    ff_versus out[2] = {{.objective = NOTHING}};
    const ff_status status =
        ff_trust_compare(s->problem, s->places, o, (const ff_fit_result *const *)s->fit, 2, winner, folds, out, &err);
    return untouched(status, out[0].objective);
}

static void init_fit(const scene *s, void *o)
{
    memcpy(o, &s->options, sizeof s->options);
}

static void init_ndf(const scene *s, void *o)
{
    memcpy(o, &s->ndf_options, sizeof s->ndf_options);
}

static void init_walk(const scene *s, void *o)
{
    (void)s;
    ff_walk_options_init(o);
}

static void init_simulate(const scene *s, void *o)
{
    (void)s;
    ff_simulate_options_init(o);
    ((ff_simulate_options *)o)->sampling.step_deg = 45;
    ((ff_simulate_options *)o)->sampling.n = 50;
}

static void init_resample(const scene *s, void *o)
{
    (void)s;
    ff_resample_options_init(o);
}

/* The number of the last name of a list. */
static double last_of(const char *(*name)(size_t i))
{
    size_t n = 0;
    while (name(n)) n++;
    return (double)n - 1;
}

/* What a call writes of text: nothing where it failed. */
static ff_content kept;

static ff_status content_of(ff_status status)
{
    const int touched = status && kept.text;
    ff_content_clear(&kept);
    return touched ? TOUCHED : status;
}

/* Refits and folds are as many as there is time for. */
static ff_status study_with(const scene *s, ff_study_options *o)
{
    o->bootstrap = AT_MOST(o->bootstrap, 20);
    NEW(ff_study, ff_study_free, ff_study_new(s->table, (const ff_model *[]){s->model}, 1, &s->options, o, &out, &err))
}

/* Of a study, of a table, of a model. */
static ff_status drawn(const scene *s, const char *kind, ff_plot_options *o)
{
    static const double thirty[32] = {30};
    const ff_plotted one = {"a", s->model, N_CHANNELS, s->shape, s->channel};
    o->incidence = thirty;
    if (!strcmp(kind, "residuals")) return content_of(ff_study_plot(s->study, kind, o, &kept, &err));
    if (!strcmp(kind, "coverage")) return content_of(ff_table_plot(s->table, kind, o, &kept, &err));
    return content_of(ff_models_plot(&one, 1, kind, o, &kept, &err));
}

static void init_study(const scene *s, void *o)
{
    (void)s;
    ff_study_options_init(o);
}

static void init_plot(const scene *s, void *o)
{
    (void)s;
    ff_plot_options_init(o);
}

static void init_render(const scene *s, void *o)
{
    (void)s;
    ff_render_options_init(o);
    ((ff_render_options *)o)->pixels = BALL;
    ((ff_render_options *)o)->threads = 1;
}

static void init_read(const scene *s, void *o)
{
    (void)s;
    ff_read_options_init(o);
}

static void init_budget(const scene *s, void *o)
{
    (void)s;
    ff_budget_options_init(o);
}
#define INIT_ff_fit_options      init_fit
#define INIT_ff_ndf_options      init_ndf
#define INIT_ff_simulate_options init_simulate
#define INIT_ff_walk_options     init_walk
#define INIT_ff_resample_options init_resample
#define INIT_ff_render_options   init_render
#define INIT_ff_study_options    init_study
#define INIT_ff_plot_options     init_plot
#define INIT_ff_read_options     init_read
#define INIT_ff_budget_options   init_budget

/* ---- the list -------------------------------------------------------------------------------- */

#define JOIN3(a, b, c)     a##b##c
#define CALL(prefix, line) JOIN3(prefix, _, line)

/* One value, as the kind says, that is put somewhere. */
typedef struct value {
    double x;
    long long k;
} value;

typedef struct limits {
    double lo, hi;
} limits;

/* A probe as a function of the value: what arguments.def says of it. */
typedef struct probe {
    const char *function, *argument;
    kind kind;
    int flags;
    limits (*limits)(const scene *s);
    ff_status (*call)(scene *s, value v, const struct probe *p);
    /* of options: the member that is set, and the defaults of the caller's struct */
    size_t offset, size;
    ff_status (*with_options)(scene *s, void *o);
    void (*init)(const scene *s, void *o);
    /* of tables: the plane that is written to */
    int plane;
    ff_status (*with_table)(scene *s, ff_table *t);
} probe;

#define PROBE(function, argument, kind, lo, hi, flags, ...)                                                                        \
    static limits CALL(limits, __LINE__)(const scene *s)                                                                           \
    {                                                                                                                              \
        (void)s;                                                                                                                   \
        return (limits){lo, hi};                                                                                                   \
    }                                                                                                                              \
    static ff_status CALL(call, __LINE__)(scene * s, value v, const probe *own)                                                    \
    {                                                                                                                              \
        const double x = v.x;                                                                                                      \
        const long long k = v.k;                                                                                                   \
        (void)s;                                                                                                                   \
        (void)x;                                                                                                                   \
        (void)k;                                                                                                                   \
        (void)own;                                                                                                                 \
        __VA_ARGS__                                                                                                                \
    }
#define OPTIONS(function, type, flags, ...)                                                                                        \
    static ff_status JOIN3(with_, function, _of_##type)(scene * s, void *options)                                                  \
    {                                                                                                                              \
        type *o = options;                                                                                                         \
        (void)s;                                                                                                                   \
        __VA_ARGS__                                                                                                                \
    }
#define MEMBER(type, member, kind, lo, hi, flags)                                                                                  \
    static limits CALL(limits, __LINE__)(const scene *s)                                                                           \
    {                                                                                                                              \
        (void)s;                                                                                                                   \
        return (limits){lo, hi};                                                                                                   \
    }
#define TABLE(function, ...)                                                                                                       \
    static ff_status JOIN3(with_, function, _table)(scene * s, ff_table * t)                                                       \
    {                                                                                                                              \
        (void)s;                                                                                                                   \
        __VA_ARGS__                                                                                                                \
    }
#include "arguments.def"

/* Sets the member of the caller's options and calls. */
static ff_status call_with_options(scene *s, value v, const probe *p)
{
    _Alignas(max_align_t) unsigned char o[512];
    const int number = (int)v.k;
    p->init(s, o);
    memcpy(o + p->offset, p->kind == REAL ? (void *)&v.x : p->kind == INT ? (const void *)&number : (void *)&v.k, p->size);
    return p->with_options(s, o);
}

enum { PLANE_VALUE = 4, PLANE_SIGMA = 5, PLANE_WEIGHT = 6, PLANES = 7 };
static const char *const plane_name[PLANES] = {"t theta_i", "t phi_i", "t theta_o", "t phi_o", "t value", "t sigma", "t weight"};

/* A small table with all planes, one of whose samples in a dozen has the number. */
static ff_status call_with_table(scene *s, value v, const probe *p)
{
    enum { STEPS = 6, EVERY = 12 };
    ff_table *t;
    if (ff_table_new((size_t)STEPS * STEPS * STEPS, 1, 1, 1, &t, &err)) return FF_ERR_INTERNAL;
    double *plane[PLANES];
    for (int k = 0; k < 4; k++) plane[k] = ff_table_angle_plane(t, k);
    plane[PLANE_VALUE] = ff_table_value_plane(t, 0);
    plane[PLANE_SIGMA] = ff_table_sigma_plane(t, 0);
    plane[PLANE_WEIGHT] = ff_table_weight_plane(t);
    ff_table_set_angle_unit(t, FF_DEGREES);
    for (size_t i = 0; i < ff_table_samples(t); i++) {
        const double theta_i = 12 * (double)(i / STEPS / STEPS), theta_o = 13 * (double)(i / STEPS % STEPS);
        const double phi = 36 * (double)(i % STEPS);
        plane[0][i] = theta_i;
        plane[2][i] = theta_o;
        plane[3][i] = phi;
        plane[PLANE_VALUE][i] = 0.1 + exp(-0.003 * pow(theta_i - theta_o, 2) - 0.001 * pow(phi - 180, 2));
        plane[PLANE_SIGMA][i] = 0.01;
        plane[PLANE_WEIGHT][i] = 1;
        if (i % EVERY == 2) plane[p->plane][i] = v.x;
    }
    const ff_status status = p->with_table(s, t);
    ff_table_free(t);
    return status;
}

static limits no_limits(const scene *s)
{
    (void)s;
    return (limits){0, 0};
}

static const probe probes[] = {
#define PROBE(function, argument, kind, lo, hi, flags, ...)                                                                        \
    {#function, #argument, kind, flags, CALL(limits, __LINE__), CALL(call, __LINE__), 0, 0, NULL, NULL, 0, NULL},
#include "arguments.def"
};

/* Functions by their options, and members; every pair of one type is a probe. */
static const struct {
    const char *function, *type;
    int flags;
    ff_status (*call)(scene *s, void *o);
    void (*init)(const scene *s, void *o);
} options[] = {
#define OPTIONS(function, type, flags, ...) {#function, #type, flags, JOIN3(with_, function, _of_##type), INIT_##type},
#include "arguments.def"
};

static const struct {
    const char *type, *name;
    kind kind;
    int flags;
    limits (*limits)(const scene *s);
    size_t offset, size;
} members[] = {
#define MEMBER(type, member, kind, lo, hi, flags)                                                                                  \
    {#type, #member, kind, flags, CALL(limits, __LINE__), offsetof(type, member), sizeof(((type *)0)->member)},
#include "arguments.def"
};

static const struct {
    const char *function;
    ff_status (*call)(scene *s, ff_table *t);
} tables[] = {
#define TABLE(function, ...) {#function, JOIN3(with_, function, _table)},
#include "arguments.def"
};

/* ---- values ---------------------------------------------------------------------------------- */

static int is_legal(const probe *p, limits l, value v)
{
    const double x = p->kind == REAL ? v.x : p->kind == SIZE ? (double)(unsigned long long)v.k : (double)v.k;
    if (isnan(x)) return (p->flags & NUMBERS) != 0;
    if (p->flags & ONLY_LO) return x >= l.lo;
    return (p->flags & LO ? x > l.lo : x >= l.lo) && (p->flags & HI ? x < l.hi : x <= l.hi);
}

static int is_among(value v, const value *all, size_t n)
{
    for (size_t i = 0; i < n; i++)
        if (memcmp(&v, &all[i], sizeof v) == 0) return 1;
    return 0;
}

/* A whole number beside x, which may be more than any of them. */
static long long whole_near(double x, int by)
{
    return (long long)fmin(fmax(x, -0x1p62), 0x1p62) + by;
}

static size_t values_of_kind(const probe *p, limits l, value out[MOST_VALUES])
{
    const double real[] = {NAN,
                           INFINITY,
                           -INFINITY,
                           0,
                           -1,
                           1,
                           1e300,
                           -1e300,
                           5e-324,
                           l.lo,
                           l.hi,
                           nextafter(l.lo, -INFINITY),
                           nextafter(l.hi, INFINITY)};
    const long long whole[] = {0,
                               1,
                               -1,
                               INT_MIN,
                               INT_MAX,
                               whole_near(l.lo, 0),
                               whole_near(l.hi, 0),
                               whole_near(l.lo, -1),
                               whole_near(fmin(l.hi, INT_MAX - 1), 1)};
    const long long size[] = {
        0, 1, -1, LLONG_MAX, 1LL << 40, whole_near(l.lo, 0), whole_near(l.hi, 0), whole_near(l.lo, -1), whole_near(l.hi, 1)};
    const size_t n = p->kind == REAL ? sizeof real / sizeof *real : sizeof whole / sizeof *whole;
    size_t used = 0;
    for (size_t i = 0; i < n; i++) {
        const value v = p->kind == REAL ? (value){real[i], 0} : (value){0, p->kind == INT ? whole[i] : size[i]};
        if (((p->flags & OUTSIDE) && is_legal(p, l, v)) || is_among(v, out, used)) continue;
        out[used++] = v;
    }
    return used;
}

/* ---- a process that is split off ------------------------------------------------------------- */

/* What came of each value; shared with the process that tries them. */
typedef struct outcome {
    int tried, back;
    ff_status status;
} outcome;

static void allow_time(int seconds)
{
    const struct itimerval processor = {{0, 0}, {seconds, 0}};
    setitimer(ITIMER_PROF, &processor, NULL);
    alarm((unsigned)(20 * seconds));
}

static void try_values(scene *s, const probe *p, const value *v, size_t from, size_t n, outcome *out)
{
    for (size_t i = from; i < n; i++) {
        allow_time(SECONDS);
        out[i].tried = 1;
        out[i].status = p->call(s, v[i], p);
        out[i].back = 1;
    }
}

static int fork_and_try(scene *s, const probe *p, const value *v, size_t from, size_t n, outcome *out)
{
    int ended = 0;
    fflush(stdout);
    const pid_t child = fork();
    if (child == 0) {
        try_values(s, p, v, from, n, out);
        _exit(0);
    }
    if (child < 0 || waitpid(child, &ended, 0) != child) return -1;
    return WIFSIGNALED(ended) ? WTERMSIG(ended) : 0;
}

static void judge(const probe *p, limits l, value v, const outcome *o)
{
    char text[32];
    if (p->kind == REAL)
        snprintf(text, sizeof text, "%.17g", v.x);
    else
        snprintf(text, sizeof text, "%lld", v.k);
    FF_CHECK(o->status >= 0 && o->status < FF_ERR_INTERNAL, "%s, %s = %s: status %d", p->function, p->argument, text,
             (int)o->status);
    if (p->flags & ANY || o->status < 0) return;
    if (!is_legal(p, l, v)) FF_CHECK(o->status != FF_OK, "%s, %s = %s is accepted", p->function, p->argument, text);
    if (is_legal(p, l, v) && !(p->flags & MAYBE))
        FF_CHECK(o->status == FF_OK, "%s, %s = %s is refused: %s", p->function, p->argument, text, ff_status_str(o->status));
}

static void run(scene *s, const probe *p, outcome *shared)
{
    const limits l = p->limits(s);
    value v[MOST_VALUES];
    const size_t n = values_of_kind(p, l, v);
    memset(shared, 0, MOST_VALUES * sizeof *shared);
    for (size_t from = 0; from < n;) {
        const int signal = fork_and_try(s, p, v, from, n, shared);
        while (from < n && shared[from].back) judge(p, l, v[from], &shared[from]), from++;
        if (from == n) break;
        FF_CHECK(0, "%s, %s = %g (%lld) %s (signal %d)", p->function, p->argument, v[from].x, v[from].k,
                 signal == SIGPROF || signal == SIGALRM ? "does not come back" : "crashes", signal);
        from++;
    }
}

/* ---- tests ----------------------------------------------------------------------------------- */

static scene *made;
static outcome *shared;

static void free_scene(void)
{
    scene_free(made);
}

static int begin(void)
{
    static scene s;
    if (made) return 1;
    shared = mmap(NULL, MOST_VALUES * sizeof *shared, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    (void)ff_test_path("made"); /* the directory is this process's */
    if (!FF_CHECK(shared != MAP_FAILED, "no memory is shared") || !scene_make(&s)) return 0;
    made = &s;
    atexit(free_scene);
    return 1;
}

static void arguments(void)
{
    if (!begin()) return;
    for (size_t i = 0; i < sizeof probes / sizeof *probes; i++) run(made, &probes[i], shared);
}

static void members_of_options(void)
{
    if (!begin()) return;
    for (size_t i = 0; i < sizeof options / sizeof *options; i++)
        for (size_t k = 0; k < sizeof members / sizeof *members; k++) {
            if (strcmp(options[i].type, members[k].type) != 0) continue;
            const probe p = {.function = options[i].function,
                             .argument = members[k].name,
                             .kind = members[k].kind,
                             .flags = options[i].flags | members[k].flags,
                             .limits = members[k].limits,
                             .call = call_with_options,
                             .offset = members[k].offset,
                             .size = members[k].size,
                             .with_options = options[i].call,
                             .init = options[i].init};
            run(made, &p, shared);
        }
}

static void cells_of_tables(void)
{
    if (!begin()) return;
    for (size_t i = 0; i < sizeof tables / sizeof *tables; i++)
        for (int plane = 0; plane < PLANES; plane++) {
            const probe p = {.function = tables[i].function,
                             .argument = plane_name[plane],
                             .kind = REAL,
                             .flags = ANY,
                             .limits = no_limits,
                             .call = call_with_table,
                             .plane = plane,
                             .with_table = tables[i].call};
            run(made, &p, shared);
        }
}

FF_TEST_MAIN(FF_TEST(arguments), FF_TEST(members_of_options), FF_TEST(cells_of_tables))
