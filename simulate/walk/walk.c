/* Walks: what they can be made of, their paths divided into items that threads share, and what comes of the sums. */
#include "internal_walk.h"
#include "base/internal_gauss.h"
#include "base/internal_isa.h"
#include "base/internal_options.h"
#include "base/internal_pool.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* What tables and roundings leave; without it values that all paths agree on, as of order 1 seen from the normal, would weigh all.
 */
static const double least_error = 1e-6;
enum { ITEM_PATHS = 16384, ROUND_ITEMS = 64 }; /* paths of an item; items between two looks at the clock, for each thread */

/* ---- options --------------------------------------------------------------------------------- */

void ff_walk_options_init_size(ff_walk_options *o, size_t size)
{
    const ff_walk_options defaults = {.seed = 1, .paths = 10000, .n_orders = 1, .orders = {{1, 0}}};
    ff_options_init(o, size, &defaults, sizeof defaults);
}

static ff_status check_orders(const ff_orders *orders, size_t n, ff_error *err)
{
    if (n < 1 || n > FF_WALK_ORDERS)
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "%zu groups of orders, expected 1 to %d", n, (int)FF_WALK_ORDERS);
    for (size_t k = 0; k < n; k++)
        if (orders[k].first < 1 || orders[k].first > FF_WALK_MOST || (orders[k].last && orders[k].last < orders[k].first))
            return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "orders %u to %u, expected 1 to %d, and none backwards",
                                (unsigned)orders[k].first, (unsigned)orders[k].last, (int)FF_WALK_MOST);
    return FF_OK;
}

static ff_status check_options(const ff_walk_options *o, ff_error *err)
{
    if ((unsigned)o->facets > FF_FACETS_COUPLED)
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "facets of number %d, expected 0 to %d", (int)o->facets,
                            (int)FF_FACETS_COUPLED);
    if ((unsigned)o->descent > FF_DESCENT_SYMMETRIC)
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "a descent of number %d, expected 0 to %d", (int)o->descent,
                            (int)FF_DESCENT_SYMMETRIC);
    if (o->paths < 2 || o->paths > UINT64_C(1000000000000))
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "%llu paths, expected 2 to 1e12", (unsigned long long)o->paths);
    if (o->threads < 0 || o->threads > 1024)
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "%d threads, expected 0 to 1024", o->threads);
    if (!ff_isa_available(o->isa))
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "this processor has no %s", ff_isa_name(o->isa));
    return check_orders(o->orders, o->n_orders, err);
}

/* A whole number at text, and what follows it; 0 where there is none. */
static uint32_t read_order(const char **text)
{
    uint32_t n = 0;
    while (**text >= '0' && **text <= '9' && n <= FF_WALK_MOST) n = 10 * n + (uint32_t)(*(*text)++ - '0');
    return n;
}

ff_status ff_orders_parse(const char *text, ff_orders *orders, size_t *n, ff_error *err)
{
    ff_orders found[FF_WALK_ORDERS];
    size_t count = 0;
    for (const char *at = text;; at++) {
        if (count == FF_WALK_ORDERS)
            return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "more than %d groups of orders", (int)FF_WALK_ORDERS);
        ff_orders *o = &found[count++];
        *o = (ff_orders){1, 0};
        if (!strncmp(at, "all", 3)) {
            at += 3;
        } else {
            o->first = o->last = read_order(&at);
            if (*at == '+') {
                o->last = 0;
                at++;
            } else if (*at == '-') {
                at++;
                o->last = read_order(&at);
                if (o->last == 0) o->first = 0;
            }
        }
        if ((*at != ',' && *at != '\0') || o->first == 0)
            return ff_error_set(err, FF_ERR_SYNTAX, NULL, 0, -1, "found '%.40s', expected orders as in all,1,2,3-5,6+", text);
        if (*at == '\0') break;
    }
    const ff_status status = check_orders(found, count, err);
    if (status) return status;
    memcpy(orders, found, count * sizeof *found);
    *n = count;
    return FF_OK;
}

void ff_orders_name(ff_orders o, char *out, size_t size)
{
    if (o.first == 1 && o.last == 0)
        snprintf(out, size, "all");
    else if (o.last == 0)
        snprintf(out, size, "%u+", (unsigned)o.first);
    else if (o.first == o.last)
        snprintf(out, size, "%u", (unsigned)o.first);
    else
        snprintf(out, size, "%u-%u", (unsigned)o.first, (unsigned)o.last);
}

/* ---- what a walk is made of ------------------------------------------------------------------ */

static ff_status refuse(ff_error *err, const char *what)
{
    return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "a walk on Smith's surface %s", what);
}

static ff_status check_lobe(const ff_model *m, const double *shape, ff_error *err)
{
    const uint32_t needed = FF_UNIT_AREA | FF_WEAK_FURNACE;
    ff_lobe_pass pass;
    if (m->n_lobes != 1) return refuse(err, "needs a model of one lobe: its facets are of one distribution");
    const ff_ndf *ndf = ff_ndf_at(m->lobe[0].ndf);
    if (strcmp(ff_masking_at(m->lobe[0].masking)->term.name, "smith-height-correlated"))
        return refuse(err, "has the masking smith-height-correlated, and no other: leave it out");
    if (!ndf->lambda || (ndf->term.claims & needed) != needed) {
        char what[128];
        snprintf(what, sizeof what, "needs a distribution of normals over a unit area with Smith's Lambda; %s is none",
                 ndf->term.name);
        return refuse(err, what);
    }
    ff_model_lobe(m, 0, shape, &pass, NULL);
    return pass.s.x0 != 0 || pass.s.y0 != 0 ? refuse(err, "has no mean slope: leave slope_x and slope_y at 0") : FF_OK;
}

static ff_status check_bases(const ff_model *m, ff_facets facets, ff_error *err)
{
    if (facets == FF_FACETS_MIRROR)
        return m->n_bases ? refuse(err, "of mirrors has nothing under them: leave the diffuse term out, or choose other facets")
                          : FF_OK;
    if (m->n_bases != 1 || strcmp(ff_diffuse_at(m->base[0].diffuse)->term.name, "lambert"))
        return refuse(err, "whose facets scatter takes their kd from the model's term lambert, and no other: +lambert");
    return FF_OK;
}

static ff_status check_scales(const ff_model *m, size_t n_channels, const double *channel, ff_error *err)
{
    const ff_lobe *lobe = &m->lobe[0];
    for (size_t c = 0; c < n_channels; c++)
        if (channel[c * m->n_channel + lobe->channel0 + lobe->n_channel - 1] != 1)
            return refuse(err, "has no scale: leave ks at 1");
    return FF_OK;
}

/* 1 / (1 - 2 integral F(mu) mu dmu); 0 where all of it is reflected. mu = x^2: F is steep near the horizon. */
static double share_of(const ff_fresnel *fresnel, const double *params)
{
    enum { NODES = 4 * FF_GAUSS };
    double x[NODES], w[NODES], F[NODES], sum = 0;
    ff_geometry g = {{NULL}};
    ff_gauss_panels(0, 1, NODES / FF_GAUSS, x, w);
    for (int k = 0; k < NODES; k++) {
        w[k] *= 4 * x[k] * x[k] * x[k];
        x[k] *= x[k];
    }
    g.plane[FF_G_C] = x;
    fresnel->eval(params, &g, NODES, F, NULL);
    for (int k = 0; k < NODES; k++) sum += w[k] * (1 - F[k]);
    return sum > 0 ? 1 / sum : 0;
}

static void fill_setting(ff_walk *w, size_t n_channels, const double *channel)
{
    ff_walk_setting *s = &w->setting;
    const ff_prepared *p = &w->prepared;
    const ff_stretch *t = &p->lobe[0].s;
    const ff_walk_options *o = &w->o;
    s->ndf = p->kernels->ndf[p->lobe[0].ndf];
    s->pass = &p->lobe[0].ndf_pass;
    s->fresnel = p->kernels->fresnel[w->model.lobe[0].fresnel];
    s->l11 = t->ax;
    s->l21 = t->r * t->ay;
    s->l22 = t->ay * sqrt((1 - t->r) * (1 + t->r));
    s->n_channels = n_channels;
    s->channel = w->channel + w->model.lobe[0].channel0;
    s->stride = w->model.n_channel;
    s->facets = o->facets;
    s->descent = o->descent;
    s->seed = o->seed;
    s->paths = o->paths;
    s->n_orders = o->n_orders;
    memcpy(s->orders, o->orders, sizeof s->orders);
    for (size_t k = 0; k < o->n_orders; k++) {
        const uint32_t last = o->orders[k].last && o->orders[k].last < FF_WALK_MOST ? o->orders[k].last : FF_WALK_MOST;
        s->last = last > s->last ? last : s->last;
    }
    s->kd = w->kd;
    s->share = w->kd + n_channels;
    for (size_t c = 0; c < n_channels && o->facets != FF_FACETS_MIRROR; c++) {
        w->kd[c] = channel[c * w->model.n_channel + w->model.base[0].channel0];
        w->kd[n_channels + c] = share_of(s->fresnel, s->channel + c * s->stride);
    }
}

static ff_status fill(ff_walk *w, size_t n_channels, const double *shape, const double *channel, ff_error *err)
{
    const ff_kernels *kernels = ff_kernels_get(w->o.isa);
    ff_status status =
        ff_prepare(&w->model, kernels, FF_CHEAPEST_MODE, n_channels, shape, w->channel, NULL, 0, INFINITY, &w->prepared);
    if (!status) {
        fill_setting(w, n_channels, channel);
        status = ff_walk_radial_make(w->setting.ndf, w->setting.pass, w->setting.radial, &w->setting.mean);
        if (status == FF_ERR_UNSUPPORTED) return refuse(err, "needs slopes with a mean; here too many are too steep");
    }
    w->run = FF_ISA_PICK(w->o.isa, ff_walk_run);
    return status ? ff_error_set(err, status, NULL, 0, -1, "no walk can be made of this model: %s", ff_status_str(status)) : FF_OK;
}

ff_status ff_walk_new(const ff_model *m, size_t n_channels, const double *shape, const double *channel, const ff_walk_options *o,
                      ff_walk **out, ff_error *err)
{
    ff_walk_options own;
    ff_walk_options_init(&own);
    ff_status status =
        o ? ff_options_take("ff_walk_options", o, FF_END_OF(ff_walk_options, progress_context), &own, sizeof own, err) : FF_OK;
    if (!status) status = check_options(&own, err);
    if (!status) status = ff_model_check(m, n_channels, shape, channel, err);
    if (!status) status = check_lobe(m, shape, err);
    if (!status) status = check_bases(m, own.facets, err);
    if (!status) status = check_scales(m, n_channels, channel, err);
    if (status) return status;
    ff_walk *w = calloc(1, sizeof *w);
    if (w) w->channel = malloc((n_channels * m->n_channel + 1) * sizeof *w->channel);
    if (w) w->kd = calloc(2 * n_channels, sizeof *w->kd);
    if (!w || !w->channel || !w->kd) {
        ff_walk_free(w);
        return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for a walk of %zu channels", n_channels);
    }
    w->model = *m;
    w->o = own;
    memcpy(w->channel, channel, n_channels * m->n_channel * sizeof *channel);
    status = fill(w, n_channels, shape, channel, err);
    if (status) {
        ff_walk_free(w);
        return status;
    }
    *out = w;
    return FF_OK;
}

void ff_walk_free(ff_walk *w)
{
    if (!w) return;
    ff_prepared_free(&w->prepared);
    free(w->channel);
    free(w->kd);
    free(w);
}

ff_walk_lanes *ff_walk_lanes_new(size_t n_channels, size_t n_orders)
{
    const size_t planes = n_channels * (1 + n_orders);
    ff_walk_lanes *l = malloc(sizeof *l + planes * FF_BLOCK * sizeof(double));
    if (!l) return NULL;
    l->weight = (double *)(l + 1);
    l->sum = l->weight + n_channels * FF_BLOCK;
    return l;
}

/* ---- threads --------------------------------------------------------------------------------- */

/* Items of equal work. The sums of each are its own, and are added up in their order. */
typedef struct job {
    const ff_walk *walk;
    ff_walk_item *item;
    ff_walk_lanes **lanes; /* [threads] */
} job;

static void run_item(void *context, size_t k, int worker)
{
    const job *j = context;
    j->walk->run(&j->walk->setting, &j->item[k], j->lanes[worker]);
}

static ff_pool *threads_new(const ff_walk *w, ff_walk_lanes ***lanes)
{
    const int threads = w->o.threads ? w->o.threads : ff_threads_default();
    ff_pool *pool = ff_pool_new(threads);
    if (!pool) return NULL;
    const int n = ff_pool_threads(pool);
    ff_walk_lanes **made = calloc((size_t)n, sizeof *made);
    int whole = made != NULL;
    for (int k = 0; k < n && whole; k++) whole = (made[k] = ff_walk_lanes_new(w->setting.n_channels, w->setting.n_orders)) != NULL;
    *lanes = made;
    if (whole) return pool;
    for (int k = 0; k < n && made; k++) free(made[k]);
    free(made);
    ff_pool_free(pool);
    return NULL;
}

static void threads_free(ff_pool *pool, ff_walk_lanes **lanes)
{
    for (int k = 0; k < ff_pool_threads(pool); k++) free(lanes[k]);
    free(lanes);
    ff_pool_free(pool);
}

static ff_status look_up(const ff_walk *w, double done, ff_error *err)
{
    if (w->o.cancel && *w->o.cancel) return ff_error_set(err, FF_ERR_CANCELLED, NULL, 0, -1, "cancelled at %.0f %%", 100 * done);
    if (w->o.progress) w->o.progress(w->o.progress_context, done);
    return FF_OK;
}

static ff_status no_memory(ff_error *err, size_t n)
{
    return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for the paths of %zu directions", n);
}

/* ---- values ---------------------------------------------------------------------------------- */

static int is_up(double x, double y, double z)
{
    return z > FF_COS_MIN && fabs(x * x + y * y + z * z - 1) < 1e-8;
}

static ff_status check_pairs(const ff_dirs *w, size_t n, size_t ld, ff_error *err)
{
    if (ld < n) return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "planes of %zu values for %zu pairs", ld, n);
    for (size_t i = 0; i < n; i++)
        if (!is_up(w->wix[i], w->wiy[i], w->wiz[i]) || !is_up(w->wox[i], w->woy[i], w->woz[i]))
            return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "pair %zu: expected two unit vectors above the horizon", i);
    return FF_OK;
}

/* The next item from pair `at`, path `path` on. */
static void next_item(const ff_walk *w, size_t n, size_t *at, uint64_t *path, ff_walk_item *item)
{
    const uint64_t paths = w->o.paths;
    item->pair = *at;
    item->path = *path;
    item->n_pairs = 1;
    item->n_paths = paths - *path < ITEM_PATHS ? paths - *path : ITEM_PATHS;
    if (paths < ITEM_PATHS) {
        const uint64_t most = ITEM_PATHS / paths < FF_BLOCK ? ITEM_PATHS / paths : FF_BLOCK;
        item->n_pairs = n - *at < most ? n - *at : (size_t)most;
    }
    *path += item->n_paths;
    if (*path < paths) return;
    *path = 0;
    *at += item->n_pairs;
}

/* Sums of an item into f (of values) and error (of squares), as sums yet. */
static void collect(const ff_walk_setting *s, const ff_walk_item *item, double *f, double *error, size_t ld)
{
    for (size_t k = 0; k < s->n_orders * s->n_channels; k++)
        for (size_t i = 0; i < item->n_pairs; i++) {
            f[k * ld + item->pair + i] += item->sum[k * item->n_pairs + i];
            error[k * ld + item->pair + i] += item->sum2[k * item->n_pairs + i];
        }
}

static void means(const ff_walk_setting *s, size_t n, double *f, double *error, size_t ld)
{
    const double paths = (double)s->paths;
    for (size_t k = 0; k < s->n_orders * s->n_channels; k++)
        for (size_t i = 0; i < n; i++) {
            double *mean = &f[k * ld + i], *e = &error[k * ld + i];
            *mean /= paths;
            *e = fmax(sqrt(fmax(*e / paths - *mean * *mean, 0) / (paths - 1)), least_error * *mean);
        }
}

/* Rounds of items, until all pairs are done. sums [2][n_orders n_channels][FF_BLOCK] of each item of a round. */
static ff_status run_pairs(const ff_walk *w, const ff_dirs *dirs, size_t n, uint64_t first, ff_pool *pool, job *j, double *sums,
                           size_t round, double *f, double *error, size_t ld, ff_error *err)
{
    const size_t planes = w->setting.n_orders * w->setting.n_channels;
    ff_status status = FF_OK;
    uint64_t path = 0;
    for (size_t at = 0; at < n && !status;) {
        size_t items = 0;
        memset(sums, 0, round * 2 * planes * FF_BLOCK * sizeof *sums);
        for (; items < round && at < n; items++) {
            double *own = sums + items * 2 * planes * FF_BLOCK;
            j->item[items] = (ff_walk_item){.number = first, .w = dirs, .sum = own, .sum2 = own + planes * FF_BLOCK};
            next_item(w, n, &at, &path, &j->item[items]);
        }
        ff_pool_run(pool, items, run_item, j);
        for (size_t k = 0; k < items; k++) collect(&w->setting, &j->item[k], f, error, ld);
        status = look_up(w, ((double)at + (double)path / (double)w->o.paths) / (double)n, err);
    }
    return status;
}

ff_status ff_walk_values(const ff_walk *walk, const ff_dirs *w, size_t n, uint64_t first, double *f, double *error, size_t ld,
                         ff_error *err)
{
    const ff_walk_setting *s = &walk->setting;
    const size_t planes = s->n_orders * s->n_channels;
    ff_walk_lanes **lanes;
    ff_status status = check_pairs(w, n, ld, err);
    if (status) return status;
    ff_pool *pool = threads_new(walk, &lanes);
    if (!pool) return no_memory(err, n);
    const size_t round = (size_t)ff_pool_threads(pool) * ROUND_ITEMS;
    double *sums = malloc(round * 2 * planes * FF_BLOCK * sizeof *sums), *made = calloc(2 * planes * n + 1, sizeof *made);
    job j = {walk, calloc(round, sizeof *j.item), lanes};
    if (sums && made && j.item)
        status = run_pairs(walk, w, n, first, pool, &j, sums, round, made, made + planes * n, n, err);
    else
        status = no_memory(err, n);
    if (!status) {
        means(s, n, made, made + planes * n, n);
        for (size_t k = 0; k < planes; k++) memcpy(f + k * ld, made + k * n, n * sizeof *f);
        for (size_t k = 0; k < planes; k++) memcpy(error + k * ld, made + (planes + k) * n, n * sizeof *f);
    }
    free(j.item);
    free(made);
    free(sums);
    threads_free(pool, lanes);
    return status;
}

/* ---- lobes ----------------------------------------------------------------------------------- */

static ff_lobe_mean lobe_of(const double *m, double paths)
{
    ff_lobe_mean out = {.albedo = m[FF_WALK_W] / paths};
    out.albedo_error = sqrt(fmax(m[FF_WALK_WW] / paths - out.albedo * out.albedo, 0) / (paths - 1));
    for (int j = 0; j < 3; j++) {
        const double mean = m[FF_WALK_WR + j] / m[FF_WALK_W];
        const double rest = m[FF_WALK_WWRR + j] - 2 * mean * m[FF_WALK_WWR + j] + mean * mean * m[FF_WALK_WW];
        out.mean[j] = m[FF_WALK_W] > 0 ? mean : NAN;
        out.mean_error[j] = m[FF_WALK_W] > 0 ? sqrt(fmax(rest, 0)) / m[FF_WALK_W] : NAN;
    }
    return out;
}

/* all [moments of all orders and channels, then what is lost of each channel]; sums the same of each item of a round */
static ff_status run_direction(const ff_walk *w, const double wi[3], ff_pool *pool, job *j, double *sums, size_t round, double *all,
                               ff_error *err)
{
    const ff_walk_setting *s = &w->setting;
    const size_t own = s->n_orders * s->n_channels * FF_WALK_SUMS, each = own + s->n_channels;
    const ff_dirs dirs = {&wi[0], &wi[1], &wi[2], NULL, NULL, NULL};
    ff_status status = FF_OK;
    uint64_t path = 0;
    for (size_t at = 0; at < 1 && !status;) {
        size_t items = 0;
        memset(sums, 0, round * each * sizeof *sums);
        for (; items < round && at < 1; items++) {
            j->item[items] = (ff_walk_item){.w = &dirs, .moments = sums + items * each, .lost = sums + items * each + own};
            next_item(w, 1, &at, &path, &j->item[items]);
        }
        ff_pool_run(pool, items, run_item, j);
        for (size_t k = 0; k < items; k++)
            for (size_t i = 0; i < each; i++) all[i] += sums[k * each + i];
        status = look_up(w, (double)at + (double)path / (double)w->o.paths, err);
    }
    return status;
}

ff_status ff_walk_lobe(const ff_walk *walk, const double wi[3], ff_lobe_mean *lobe, double *lost, ff_error *err)
{
    const ff_walk_setting *s = &walk->setting;
    const size_t planes = s->n_orders * s->n_channels, each = planes * FF_WALK_SUMS + s->n_channels;
    ff_walk_lanes **lanes;
    if (!is_up(wi[0], wi[1], wi[2]))
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "light from (%g, %g, %g), expected a unit vector above the horizon",
                            wi[0], wi[1], wi[2]);
    ff_pool *pool = threads_new(walk, &lanes);
    if (!pool) return no_memory(err, 1);
    const size_t round = (size_t)ff_pool_threads(pool) * ROUND_ITEMS;
    double *sums = malloc(round * each * sizeof *sums), *all = calloc(each, sizeof *all), most = 0;
    job j = {walk, calloc(round, sizeof *j.item), lanes};
    const ff_status status = sums && all && j.item ? run_direction(walk, wi, pool, &j, sums, round, all, err) : no_memory(err, 1);
    for (size_t k = 0; k < planes && !status; k++) lobe[k] = lobe_of(all + k * FF_WALK_SUMS, (double)walk->o.paths);
    for (size_t c = 0; c < s->n_channels && !status; c++) most = fmax(most, all[planes * FF_WALK_SUMS + c] / (double)walk->o.paths);
    if (!status && lost) *lost = most;
    free(j.item);
    free(all);
    free(sums);
    threads_free(pool, lanes);
    return status;
}
