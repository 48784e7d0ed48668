/* Options and results of callers that were compiled with another version of the headers: nothing beyond their structs is read or
 * written. Every struct here is allocated with exactly its bytes, so that a sanitizer sees a single one too many; without a
 * sanitizer a guard behind it does. */
#include "base/internal_options.h"
#include "data_formats/interpolation/resample_struct.h"
#include "ff_test.h"
#include "fit/ndf/ndf_struct.h"
#include "fit/picture/picture_struct.h"
#include "fit/trust/trust_struct.h"
#include "simulate/simulate_struct.h"

enum { GUARD = 64, FILL = 0xa5 };

/* Is every byte behind the first `size` as it was filled? */
static int is_untouched(const unsigned char *bytes, size_t size)
{
    for (size_t i = 0; i < GUARD; i++)
        if (bytes[size + i] != FILL) return 0;
    return 1;
}

/* ---- writing the defaults -------------------------------------------------------------------- */

static void init_fit(void *o, size_t size)
{
    ff_fit_options_init_size(o, size);
}

static void init_ndf(void *o, size_t size)
{
    ff_ndf_options_init_size(o, size);
}

static void init_simulate(void *o, size_t size)
{
    ff_simulate_options_init_size(o, size);
}

static void init_resample(void *o, size_t size)
{
    ff_resample_options_init_size(o, size);
}

static void init_read(void *o, size_t size)
{
    ff_read_options_init_size(o, size);
}

static const struct {
    const char *name;
    size_t size;
    void (*init)(void *o, size_t size);
} all[] = {{"fit", sizeof(ff_fit_options), init_fit},
           {"ndf", sizeof(ff_ndf_options), init_ndf},
           {"simulate", sizeof(ff_simulate_options), init_simulate},
           {"resample", sizeof(ff_resample_options), init_resample},
           {"read", sizeof(ff_read_options), init_read}};

/* As long as it is, shorter down to nothing, and longer. */
static void defaults_stay_inside(void)
{
    for (size_t k = 0; k < sizeof all / sizeof *all; k++) {
        _Alignas(max_align_t) unsigned char whole[512];
        FF_CHECK(all[k].size < sizeof whole, "the test itself is wrong");
        memset(whole, FILL, sizeof whole);
        all[k].init(whole, all[k].size);
        for (size_t size = 0; size <= all[k].size + 32; size++) {
            _Alignas(max_align_t) unsigned char guarded[1024];
            unsigned char *exact = malloc(size > 0 ? size : 1);
            size_t said;
            memset(guarded, FILL, sizeof guarded);
            all[k].init(exact, size);
            all[k].init(guarded, size);
            FF_CHECK(is_untouched(guarded, size), "%s, %zu bytes: written beyond", all[k].name, size);
            const size_t common = size < all[k].size ? size : all[k].size, head = sizeof said;
            FF_CHECK(size < head || memcmp(exact + head, whole + head, common - head) == 0, "%s, %zu bytes: not the defaults",
                     all[k].name, size);
            for (size_t i = all[k].size; i < size; i++) FF_CHECK(exact[i] == 0, "%s: byte %zu is not 0", all[k].name, i);
            if (size >= head) {
                memcpy(&said, exact, head);
                FF_CHECK(said == size, "%s: says %zu, has %zu bytes", all[k].name, said, size);
            }
            free(exact);
        }
    }
}

/* ---- reading --------------------------------------------------------------------------------- */

/* The first version of a struct, the present one, and one to come. */
typedef struct first_options {
    size_t size;
    int a;
    double b;
} first_options;
typedef struct present_options {
    size_t size;
    int a;
    double b;
    int c;
} present_options;
typedef struct later_options {
    size_t size;
    int a;
    double b;
    int c;
    double d;
} later_options;

static ff_status take(const void *from, present_options *out, ff_error *err)
{
    *out = (present_options){.size = sizeof *out, .c = 7};
    return ff_options_take("present_options", from, sizeof(first_options), out, sizeof *out, err);
}

/* A copy with exactly the struct's bytes. */
static void *exactly(const void *from, size_t size)
{
    void *to = malloc(size);
    memcpy(to, from, size);
    return to;
}

static void shorter_and_longer_are_understood(void)
{
    present_options o;
    ff_error err = {0};
    first_options *first = exactly(&(first_options){sizeof(first_options), 1, 2}, sizeof(first_options));
    FF_CHECK(take(first, &o, &err) == FF_OK && o.a == 1 && o.b == 2 && o.c == 7 && o.size == sizeof o, "older: %s", err.message);
    later_options *later = exactly(&(later_options){.size = sizeof(later_options), .a = 3, .c = 4}, sizeof(later_options));
    FF_CHECK(take(later, &o, &err) == FF_OK && o.a == 3 && o.c == 4, "newer, nothing set: %s", err.message);
    later->d = 1;
    FF_CHECK(take(later, &o, &err) == FF_ERR_RANGE && strstr(err.message, "present_options"), "newer, set: '%s'", err.message);
    const size_t absurd[] = {0, 1, sizeof(first_options) - 1, (size_t)1 << 40, SIZE_MAX};
    for (size_t k = 0; k < sizeof absurd / sizeof *absurd; k++) {
        first->size = absurd[k];
        err.message[0] = 0;
        FF_CHECK(take(first, &o, &err) == FF_ERR_RANGE && err.message[0], "a size of %zu is taken", absurd[k]);
    }
    free(first);
    free(later);
}

/* ---- through the library --------------------------------------------------------------------- */

typedef struct scene {
    ff_model *model;
    ff_table *table;
    double shape[8], channel[8];
} scene;

static int make_scene(scene *s)
{
    ff_error err = {0};
    ff_simulate_options o;
    ff_simulate_options_init(&o);
    o.sampling = (ff_sampling){FF_SAMPLING_SCATTERED, 5, 2000, 0.3};
    o.relative = 0.01;
    ff_status status = ff_model_new("ggx+lambert", &s->model, &err);
    if (!status) ff_model_defaults(s->model, 1, s->shape, s->channel);
    if (!status) status = ff_model_set(s->model, 1, "alpha=0.3", s->shape, s->channel, &err);
    if (!status) status = ff_simulate(s->model, 1, s->shape, s->channel, &o, &s->table, &err);
    FF_CHECK(status == FF_OK, "%s", err.message);
    return status == FF_OK;
}

static void free_scene(scene *s)
{
    ff_model_free(s->model);
    ff_table_free(s->table);
}

/* A program that was compiled before dense_channels gets the same fit as one of today. */
static void an_older_program_fits(void)
{
    const volatile size_t before = offsetof(ff_fit_options, dense_channels); /* the compiler is not to know what is missing */
    const size_t old = before;
    ff_fit_options *o = malloc(old), now;
    ff_problem *p = NULL;
    ff_fit_result *fit[2] = {NULL, NULL};
    ff_bands bands;
    double *model;
    scene s = {0};
    ff_error err = {0};
    if (!make_scene(&s)) return;
    const ff_model *models[] = {s.model};
    ff_fit_options_init_size(o, old);
    ff_fit_options_init(&now);
    o->shape = now.shape = FF_SHAPE_ISOTROPIC;
    FF_CHECK(ff_problem_new(s.table, models, 1, o, &p, &err) == FF_OK, "problem: %s", err.message);
    FF_CHECK(p && ff_problem_fit(p, s.model, o, &fit[0], &err) == FF_OK, "an older program: %s", err.message);
    FF_CHECK(p && ff_problem_fit(p, s.model, &now, &fit[1], &err) == FF_OK, "a program of today: %s", err.message);
    if (!fit[0] || !fit[1]) return;
    FF_CHECK(ff_fit_result_objective(fit[0]) == ff_fit_result_objective(fit[1]), "the fits differ");
    ff_places *places;
    FF_CHECK(ff_places_new(p, s.table, &places, &err) == FF_OK, "%s", err.message);
    FF_CHECK(ff_trust_bands(p, places, o, fit[0], &bands, &err) == FF_OK, "bands: %s", err.message);
    FF_CHECK(ff_trust_profile(p, o, fit[0], &err) == FF_OK, "profile: %s", err.message);
    model = malloc(ff_problem_selected(p)->used * sizeof *model);
    FF_CHECK(ff_trust_evaluate(p, o, fit[0], model, NULL, NULL, &err) == FF_OK, "values: %s", err.message);
    o->robust = FF_ROBUST_HUBER;
    FF_CHECK(ff_problem_estimate_scale(p, s.model, o, &err) == FF_OK, "scale: %s", err.message);
    ff_picture *picture;
    FF_CHECK(ff_picture_new(s.table, o, &picture, &err) == FF_OK, "pictures: %s", err.message);
    ff_picture_free(picture);
    free(model);
    ff_places_free(places);
    for (int k = 0; k < 2; k++) ff_fit_result_free(fit[k]);
    ff_problem_free(p);
    free_scene(&s);
    free(o);
}

static void sizes_that_are_none_are_refused(void)
{
    scene s = {0};
    ff_error err = {0};
    ff_fit_options o;
    ff_problem *p = NULL;
    if (!make_scene(&s)) return;
    const ff_model *models[] = {s.model};
    ff_fit_options_init(&o);
    o.size = 0;
    FF_CHECK(ff_problem_new(s.table, models, 1, &o, &p, &err) == FF_ERR_RANGE && strstr(err.message, "ff_fit_options"), "fit: '%s'",
             err.message);
    ff_ndf_options ndf;
    ff_ndf_options_init(&ndf);
    ndf.size = 3;
    FF_CHECK(ff_ndf_problem_new(s.table, &ndf, &p, &err) == FF_ERR_RANGE && strstr(err.message, "ff_ndf_options"), "ndf: '%s'",
             err.message);
    ndf.size = sizeof ndf;
    ndf.fit = &o;
    FF_CHECK(ff_ndf_problem_new(s.table, &ndf, &p, &err) == FF_ERR_RANGE && strstr(err.message, "ff_fit_options"), "ndf: '%s'",
             err.message);
    ff_simulate_options simulate;
    ff_table *t = NULL;
    ff_simulate_options_init(&simulate);
    simulate.size = 8;
    FF_CHECK(ff_simulate(s.model, 1, s.shape, s.channel, &simulate, &t, &err) == FF_ERR_RANGE, "simulate");
    ff_read_options read;
    ff_read_options_init(&read);
    read.size = 0;
    FF_CHECK(ff_table_read_with("none.csv", &read, &t, &err) == FF_ERR_RANGE && strstr(err.message, "ff_read_options"),
             "read: '%s'", err.message);
    ff_resample_options resample;
    ff_resample_report report = {.size = 0};
    ff_resample_options_init(&resample);
    FF_CHECK(ff_resample(s.table, ff_format_find("csv"), &resample, &t, &report, &err) == FF_ERR_RANGE &&
                 strstr(err.message, "ff_resample_report"),
             "report: '%s'", err.message);
    resample.size = 1;
    FF_CHECK(ff_resample(s.table, ff_format_find("csv"), &resample, &t, NULL, &err) == FF_ERR_RANGE, "resample");
    FF_CHECK(!p && !t, "something was made");
    free_scene(&s);
}

/* A result is no longer than the caller's struct, and fills it. */
static void results_stay_inside(void)
{
    scene s = {0};
    ff_error err = {0};
    ff_table *t = NULL;
    if (!make_scene(&s)) return;
    _Alignas(max_align_t) unsigned char bytes[sizeof(ff_resample_report) + GUARD];
    ff_resample_report report;
    memset(bytes, FILL, sizeof bytes);
    memset(&report, FILL, sizeof report);
    report.size = sizeof report;
    memcpy(bytes, &report, sizeof report.size);
    FF_CHECK(ff_resample(s.table, ff_format_find("csv"), NULL, &t, (ff_resample_report *)(void *)bytes, &err) == FF_OK, "%s",
             err.message);
    memcpy(&report, bytes, sizeof report);
    FF_CHECK(is_untouched(bytes, sizeof report) && report.size == sizeof report && report.as_it_is == 1 && report.n == 2000,
             "%zu samples", report.n);
    ff_table_free(t);
    free_scene(&s);
}

FF_TEST_MAIN(FF_TEST(defaults_stay_inside), FF_TEST(shorter_and_longer_are_understood), FF_TEST(an_older_program_fits),
             FF_TEST(sizes_that_are_none_are_refused), FF_TEST(results_stay_inside))
