/* How much stack the public functions need. What arguments/internal_scene.h makes by them, and more, is done twice: on a thread
 * whose stack was painted before, where the paint that is left says how deep it went, and on one that has no more than is stated,
 * where one byte beyond is the end. Functions of other libraries (Ceres, Eigen, OpenEXR, expat) count, and so does what the C
 * library keeps in the stack of a thread before anything runs there: the thread-local variables of every library in the process.
 * What threads of the pool need is seen likewise, since with one thread the caller does their work. */
#include "arguments/internal_scene.h"
#include "models/internal_model.h"
#include <dirent.h>
#include <pthread.h>

enum { STACK = 8 << 20, STATED = 128 << 10, PAINT = 0x5c };

typedef struct visit {
    const char *name;
    ff_status (*call)(scene *s);
    int made;
    ff_status status;
    scene *scene;
} visit;

static ff_error err;
static int pictures; /* that were read */

static void *run(void *argument)
{
    visit *v = argument;
    v->status = v->call(v->scene);
    return NULL;
}

static int run_with(const pthread_attr_t *attributes, visit *v)
{
    pthread_t thread;
    if (!FF_CHECK(pthread_create(&thread, attributes, run, v) == 0, "no thread for %s", v->name)) return 0;
    pthread_join(thread, NULL);
    return 1;
}

/* Bytes of stack that a call needs, those of a thread that does nothing included. */
static size_t measure(visit *v)
{
    unsigned char *stack = aligned_alloc(4096, STACK);
    pthread_attr_t attributes;
    size_t left = 0;
    if (!FF_CHECK(stack != NULL, "no memory")) return 0;
    memset(stack, PAINT, STACK);
    pthread_attr_init(&attributes);
    pthread_attr_setstack(&attributes, stack, STACK);
    run_with(&attributes, v);
    pthread_attr_destroy(&attributes);
    while (left < STACK && stack[left] == PAINT) left++;
    free(stack);
    return STACK - left;
}

/* Within what is stated, and a page beyond it that nobody may touch. */
static void confine(visit *v)
{
    pthread_attr_t attributes;
    pthread_attr_init(&attributes);
    FF_CHECK(pthread_attr_setstacksize(&attributes, STATED) == 0, "a stack of %d bytes", (int)STATED);
    run_with(&attributes, v);
    pthread_attr_destroy(&attributes);
}

/* ---- calls ----------------------------------------------------------------------------------- */

static ff_status nothing(scene *s)
{
    (void)s;
    return FF_OK;
}

static ff_status make(scene *s)
{
    scene_free(s);
    *s = (scene){.n = 0};
    return scene_make(s) ? FF_OK : FF_ERR_INTERNAL;
}

/* A model with derivatives, and its albedo; what needs a table of its own is left out. */
static ff_status evaluate_one(const char *expression)
{
    const double zero = 0, z = 0.8, side = 0.6, wo[3] = {0.6, 0, 0.8};
    const ff_dirs w = {&side, &zero, &z, &zero, &side, &z};
    double shape[2 * N_SHAPE_MOST], channel[N_CHANNEL_MOST], f, df[2 * N_SHAPE_MOST + N_CHANNEL_MOST];
    ff_integral albedo;
    ff_model *m;
    ff_status status = ff_model_new(expression, &m, &err);
    if (status) return status;
    ff_model_defaults(m, 1, shape, channel);
    if (ff_model_check(m, 1, shape, channel, &err) == FF_OK) {
        double d, lambda, g, fresnel;
        const ff_terms terms = {&d, &lambda, &lambda, &g, &fresnel};
        status = ff_model_eval(m, FF_ISA_BEST, 1, shape, channel, &w, 1, &f, df, 1);
        if (!status) status = ff_model_terms(m, FF_ISA_BEST, 1, shape, channel, 0, 0, &w, 1, &terms);
        if (!status) status = ff_albedo_directional(m, FF_ISA_BEST, 1, shape, channel, wo, &albedo, &err);
    }
    ff_model_free(m);
    return status;
}

/* Every distribution, masking and Fresnel term, and every diffuse term under two lobes. */
static ff_status evaluate(scene *s)
{
    ff_status status = FF_OK;
    char expression[FF_MODEL_NAME];
    (void)s;
    for (size_t k = 0; k < ff_term_count(FF_NDF) && !status; k++) {
        snprintf(expression, sizeof expression, "%s/v-cavity+ggx", ff_term_at(FF_NDF, k)->name);
        status = evaluate_one(expression);
    }
    for (size_t k = 0; k < ff_term_count(FF_MASKING) && !status; k++) {
        const char *only = ff_masking_at((int)k)->only;
        snprintf(expression, sizeof expression, "%s/%s", only ? only : "ggx", ff_term_at(FF_MASKING, k)->name);
        status = evaluate_one(expression);
    }
    for (size_t k = 0; k < ff_term_count(FF_FRESNEL) && !status; k++) {
        snprintf(expression, sizeof expression, "ggx/v-cavity/%s", ff_term_at(FF_FRESNEL, k)->name);
        status = evaluate_one(expression);
    }
    for (size_t k = 0; k < ff_term_count(FF_DIFFUSE) && !status; k++) {
        snprintf(expression, sizeof expression, "ggx+beckmann+%s", ff_term_at(FF_DIFFUSE, k)->name);
        status = evaluate_one(expression);
        if (status != FF_ERR_UNSUPPORTED) continue;
        snprintf(expression, sizeof expression, "ggx+%s", ff_term_at(FF_DIFFUSE, k)->name); /* one that goes with one lobe alone */
        status = evaluate_one(expression);
    }
    return status;
}

static ff_status furnace(scene *s)
{
    const double wo[3] = {0.6, 0, 0.8};
    ff_integral out;
    return ff_albedo_weak_furnace(s->model, FF_ISA_BEST, s->shape, 0, wo, &out, &err);
}

static ff_status sample(scene *s)
{
    const double wo[3] = {0.6, 0, 0.8}, u[3] = {0.3, 0.4, 0.5};
    double wi[3], pdf, f[N_CHANNELS], weight[N_CHANNELS];
    ff_sampler_sample(s->sampler, 1, wo, u, NULL, wi, &pdf, f, weight, 1);
    ff_sampler_pdf(s->sampler, 1, wo, wi, &pdf, 1);
    return FF_OK;
}

static ff_status fit(scene *s)
{
    ff_fit_result *out;
    const ff_status status = ff_problem_fit(s->robust_problem, s->model, &s->robust, &out, &err);
    if (!status) ff_fit_result_free(out);
    return status;
}

/* More channels than are solved for together. */
static ff_status fit_channels(scene *s)
{
    ff_fit_options o = s->options;
    ff_fit_result *out;
    o.dense_channels = 1;
    const ff_status status = ff_problem_fit(s->problem, s->model, &o, &out, &err);
    if (!status) ff_fit_result_free(out);
    return status;
}

static ff_status trust(scene *s)
{
    ff_bootstrap b = {.size = sizeof b};
    ff_versus versus[2];
    ff_cut_off *cut;
    const ff_fit_result *const *fits = (const ff_fit_result *const *)s->fit;
    ff_status status = ff_trust_compare(s->problem, s->places, &s->options, fits, 2, 0, 2, versus, &err);
    if (!status) status = ff_trust_cut_off(s->problem, &s->options, s->fit[0], 1, &cut, &err);
    if (!status) ff_cut_off_free(cut);
    if (!status) status = ff_trust_bootstrap(s->problem, s->places, &s->options, 20, 1, s->fit[0], &b, &err);
    if (!status) status = ff_trust_jackknife(s->problem, s->places, &s->options, s->fit[0], &err);
    return status ? status : ff_trust_profile(s->problem, &s->options, s->fit[1], &err);
}

static ff_status retrieve(scene *s)
{
    ff_ndf_result *out;
    const ff_status status = ff_ndf_retrieve(s->ndf_problem, &s->ndf_options, &out, &err);
    if (!status) ff_ndf_result_free(out);
    return status;
}

/* The table in every format that can be written, and back. */
static ff_status write_formats(scene *s)
{
    ff_table *mean;
    ff_status status = ff_table_reduce(s->table, "mean", &mean, &err);
    if (status) return status;
    for (size_t k = 0; k < ff_format_count() && !status; k++) {
        const ff_format *to = ff_format_at(k);
        ff_resample_options o;
        ff_table *t, *back;
        ff_resample_options_init(&o);
        o.threads = 1;
        if (!strcmp(ff_format_name(to), "zemax")) o.grid = "rotation:90,incidence:20,azimuth:30,radial:0/2/5/10";
        if (!ff_format_can_write(to) || ff_resample(mean, to, &o, &t, NULL, &err) != FF_OK) continue; /* not of these data */
        status = ff_table_write(ff_test_path("a.file"), ff_format_name(to), t, &err);
        ff_table_free(t);
        if (!status) status = ff_table_read(ff_test_path("a.file"), ff_format_name(to), &back, &err);
        if (!status) ff_table_free(back);
    }
    ff_table_free(mean);
    return status;
}

/* One file by its format, which may refuse it, and by whichever takes it. */
static void read_file(const char *format, const char *path)
{
    const char *const how[] = {format, NULL};
    for (int k = 0; k < 2; k++) {
        ff_table *t;
        if (ff_table_read(path, how[k], &t, &err) == FF_OK) ff_table_free(t);
    }
}

/* A stack of one picture, which the corpus keeps behind a byte of 0 in a file that ends in its kind. */
static void read_picture(const char *path)
{
    static char data[1 << 20];
    char name[32], stack[200];
    FILE *in = fopen(path, "rb");
    const size_t n = in ? fread(data, 1, sizeof data, in) : 0;
    if (in) fclose(in);
    if (n < 2 || data[0] != 0 || !strrchr(path, '-')) return;
    snprintf(name, sizeof name, "p.%.20s", strrchr(path, '-') + 1);
    const int length =
        snprintf(stack, sizeof stack, "# encoding: linear\nimage,theta_i,phi_i,theta_o,phi_o\n%s,30,0,30,180\n", name);
    FILE *picture = fopen(ff_test_path(name), "wb"), *list = fopen(ff_test_path("stack.csv"), "wb");
    if (picture) fwrite(data + 1, 1, n - 1, picture), fclose(picture);
    if (list) fwrite(stack, 1, (size_t)length, list), fclose(list);
    ff_table *t;
    if (ff_table_read(ff_test_path("stack.csv"), "images", &t, &err) == FF_OK) {
        pictures++;
        ff_table_free(t);
    }
}

/* What the fuzzers' corpora hold: files of every format, sound and not. */
static ff_status read_formats(scene *s)
{
    size_t read = 0;
    (void)s;
    for (size_t k = 0; k < ff_format_count(); k++) {
        char path[4096];
        const char *name = ff_format_name(ff_format_at(k));
        snprintf(path, sizeof path, "%s/fuzz/corpus/%s", FF_TEST_SOURCE_DIR, name);
        DIR *folder = opendir(path);
        if (!folder) return FF_ERR_INTERNAL;
        for (const struct dirent *entry; (entry = readdir(folder)); read++) {
            snprintf(path, sizeof path, "%s/fuzz/corpus/%s/%s", FF_TEST_SOURCE_DIR, name, entry->d_name);
            if (entry->d_name[0] == '.') continue;
            read_file(name, path);
            if (!strcmp(name, "images")) read_picture(path);
        }
        closedir(folder);
    }
    return read > 2 * ff_format_count() ? FF_OK : FF_ERR_INTERNAL;
}

static ff_status tables(scene *s)
{
    ff_resample_options o;
    ff_survey *survey;
    ff_table *t, *mean;
    ff_resample_options_init(&o);
    o.threads = 1;
    o.grid = "rotation:90,incidence:20,azimuth:30,radial:0/2/5/10";
    ff_status status = ff_survey_new(s->table, &survey, &err);
    if (!status) ff_survey_free(survey);
    if (!status) status = ff_table_reduce(s->table, "mean", &mean, &err);
    if (!status) status = ff_resample(mean, ff_format_find("zemax"), &o, &t, NULL, &err);
    if (!status) ff_table_free(mean);
    if (!status) status = ff_table_write(ff_test_path("a.zemax.bsdf"), "zemax", t, &err);
    if (!status) ff_table_free(t);
    if (!status) status = ff_table_read(ff_test_path("a.zemax.bsdf"), NULL, &t, &err);
    if (!status) ff_table_free(t);
    return status;
}

/* ---- the test -------------------------------------------------------------------------------- */

static void public_functions(void)
{
    static scene s;
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    FF_SKIP("a sanitizer makes frames larger");
#endif
    visit all[] = {{.name = "all of a scene", .call = make},
                   {.name = "evaluation, albedo", .call = evaluate},
                   {.name = "furnace", .call = furnace},
                   {.name = "sample", .call = sample},
                   {.name = "robust fit", .call = fit},
                   {.name = "fit of many channels", .call = fit_channels},
                   {.name = "trust", .call = trust},
                   {.name = "retrieval", .call = retrieve},
                   {.name = "survey, resample", .call = tables},
                   {.name = "every format read", .call = read_formats},
                   {.name = "every format written", .call = write_formats}};
    visit idle = {.name = "nothing", .call = nothing};
    const size_t before = measure(&idle);
    printf("  %-22s %4zu KiB\n", idle.name, before / 1024);
    for (size_t k = 0; k < sizeof all / sizeof *all; k++) {
        all[k].scene = &s;
        const size_t used = measure(&all[k]) - before;
        printf("  %-22s %4zu KiB\n", all[k].name, used / 1024);
        FF_CHECK(all[k].status == FF_OK, "%s: %s %s", all[k].name, ff_status_str(all[k].status), err.message);
        FF_CHECK(used <= STATED - STATED / 4, "%s needs %zu bytes of stack; %d are stated, of which a quarter stays free",
                 all[k].name, used, (int)STATED);
        if (before > STATED / 2 + 4096) continue; /* other libraries here than those that the statement knows */
        confine(&all[k]);
        FF_CHECK(all[k].status == FF_OK, "%s, confined: %s %s", all[k].name, ff_status_str(all[k].status), err.message);
    }
    printf("  %d pictures were read\n", pictures);
    scene_free(&s);
}

FF_TEST_MAIN(FF_TEST(public_functions))
