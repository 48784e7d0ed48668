/* Every allocation of a picture, an environment and a sheet may fail: the status then says so, nothing is lost, nothing crashes. */
#include "ff_test.h"
#include "memory/failing.h"
#include "ff_render.h"
#include "ff_simulate.h"

enum { SIZE = 6 };

typedef struct scene {
    ff_model *m;
    ff_table *t;
    double shape[32], channel[16];
    char path[64];
} scene;

static ff_render_options small(void)
{
    ff_render_options o;
    ff_render_options_init(&o);
    o.pixels = SIZE;
    o.samples = 8;
    o.threads = 1;
    return o;
}

static ff_status picture_of_model(const scene *s, ff_error *err)
{
    float to[4 * SIZE * SIZE];
    ff_environment *e = NULL;
    ff_render_options o = small();
    ff_status status = ff_environment_sky(0.5, 3, 0.2, 0, &e, err);
    o.environment = e;
    if (status == FF_OK) status = ff_render_model(s->m, 1, s->shape, s->channel, &o, to, NULL, err);
    ff_environment_free(e);
    return status;
}

static ff_status picture_of_table(const scene *s, ff_error *err)
{
    static const double light[1][3] = {{0, 0, 1}};
    float to[4 * SIZE * SIZE];
    ff_render_options o = small();
    o.n_lights = 1;
    o.light = light;
    return ff_render_table(s->t, NULL, 0, NULL, NULL, &o, to, NULL, err);
}

static const float rgba[4 * SIZE * SIZE] = {1, 1, 1, 1};

static ff_status png_of_sheet(const scene *s, ff_error *err)
{
    (void)s;
    const ff_render_cell cell[2] = {{rgba, "one", FF_CELL_PICTURE}, {rgba, "two", FF_CELL_DIFFERENCE}};
    unsigned char *png = NULL;
    size_t n = 0;
    ff_render_sheet sheet;
    ff_render_sheet_init(&sheet);
    sheet.pixels = SIZE;
    sheet.n = 2;
    sheet.cell = cell;
    ff_status status = ff_render_png(&sheet, &png, &n, err);
    if (status == FF_OK) ff_render_png_free(png);
    return status;
}

static ff_status exr_of_sheet(const scene *s, ff_error *err)
{
    const ff_render_cell cell = {rgba, "", FF_CELL_PICTURE};
    const ff_render_layer layer[2] = {{"", &cell}, {"data", &cell}};
    ff_render_sheet sheet;
    ff_render_sheet_init(&sheet);
    sheet.pixels = SIZE;
    sheet.n = 1;
    return ff_render_exr(s->path, &sheet, 2, layer, err);
}

static ff_status map(const scene *s, ff_error *err)
{
    static const float rgb[3 * 8] = {1};
    ff_environment *e = NULL;
    (void)s;
    const ff_status status = ff_environment_new(4, 2, rgb, 0, &e, err);
    ff_environment_free(e);
    return status;
}

/* may_do_without: the C library writes a file, and sorts, also where it has no buffer for it. */
static void each_fails(const char *name, ff_status (*make)(const scene *, ff_error *), const scene *s, long least,
                       int may_do_without)
{
    ff_error err = {0};
    FF_CHECK(make(s, &err) == FF_OK, "%s: %s", name, err.message); /* what is allocated once and kept */
    failing_begin(-1, 0);
    if (!FF_CHECK(make(s, &err) == FF_OK, "%s: %s", name, err.message)) return;
    const long n = atomic_load(&failing_count);
    FF_CHECK(n >= least, "%s: %ld allocations", name, n);
    for (long at = 0; at < n; at++)
        for (int all = 0; all < 2; all++) {
            const long before = atomic_load(&failing_live);
            failing_begin(at, all);
            const ff_status status = make(s, &err);
            const long refused = atomic_load(&failing_refused);
            failing_begin(-1, 0);
            FF_CHECK(refused > 0 && (status == FF_ERR_MEMORY || (status == FF_OK && may_do_without)),
                     "%s, allocation %ld of %ld: %s", name, at, n, ff_status_str(status));
            FF_CHECK(atomic_load(&failing_live) == before, "%s, allocation %ld: %ld blocks are lost", name, at,
                     atomic_load(&failing_live) - before);
        }
}

static void every_allocation(void)
{
    scene s = {0};
    ff_error err = {0};
    ff_simulate_options o;
    ff_simulate_options_init(&o);
    o.sampling.step_deg = 30;
    FF_CHECK(ff_model_new("ggx+lambert", &s.m, &err) == FF_OK, "%s", err.message);
    ff_model_defaults(s.m, 1, s.shape, s.channel);
    FF_CHECK(ff_simulate(s.m, 1, s.shape, s.channel, &o, &s.t, &err) == FF_OK, "%s", err.message);
    snprintf(s.path, sizeof s.path, "/tmp/facetfit-render-XXXXXX");
    const int fd = mkstemp(s.path);
    FF_CHECK(fd >= 0, "no file");
    close(fd);
    each_fails("map", map, &s, 6, 0);
    each_fails("picture of a model", picture_of_model, &s, 15, 0);
    each_fails("picture of a table", picture_of_table, &s, 15, 1);
    each_fails("PNG", png_of_sheet, &s, 5, 0);
    each_fails("OpenEXR", exr_of_sheet, &s, 10, 1);
    remove(s.path);
    ff_table_free(s.t);
    ff_model_free(s.m);
}

FF_TEST_MAIN(FF_TEST(every_allocation))
