/* Ways from one convention to another: the cheapest walk over the graph of conversions. */
#include "internal_conversions.h"
#include <string.h>

/* A convention that the walk has come to: the least cost, and the one before. */
enum { MOST_NODES = 128, MATCH = 100, STEP = 1 };
typedef struct node {
    const char *name;
    int cost, before, done;
} node;

typedef struct walk {
    size_t n;
    node at[MOST_NODES];
} walk;

static int place_of(walk *w, const char *name)
{
    for (size_t i = 0; i < w->n; i++)
        if (!strcmp(w->at[i].name, name)) return (int)i;
    if (w->n == MOST_NODES) return -1;
    w->at[w->n] = (node){name, 0, -1, 0};
    return (int)w->n++;
}

static int nearest_open(const walk *w)
{
    int best = -1;
    for (size_t i = 0; i < w->n; i++)
        if (!w->at[i].done && (best < 0 || w->at[i].cost < w->at[best].cost)) best = (int)i;
    return best;
}

static void leave(walk *w, int here)
{
    const ff_conversion *c;
    w->at[here].done = 1;
    for (size_t i = 0; (c = ff_conversion_at(i)); i++) {
        if (strcmp(c->from, w->at[here].name)) continue;
        const int cost = w->at[here].cost + (c->matches ? MATCH : 0) + STEP, known = (int)w->n, there = place_of(w, c->to);
        if (there < 0 || (there < known && w->at[there].cost <= cost)) continue;
        w->at[there].cost = cost;
        w->at[there].before = here;
    }
}

/* The conventions from `from` to `to`, both included; 0 where there is no way. */
static size_t conventions(walk *w, const char *from, const char *to, const char *name[FF_CONVERSION_STEPS + 1])
{
    size_t n = 0;
    w->n = 0;
    place_of(w, from);
    for (int here; (here = nearest_open(w)) >= 0;) {
        if (!strcmp(w->at[here].name, to)) {
            for (int i = here; i >= 0; i = w->at[i].before) n++;
            if (n > FF_CONVERSION_STEPS + 1) return 0;
            for (int i = here, k = (int)n - 1; i >= 0; i = w->at[i].before) name[k--] = w->at[i].name;
            return n;
        }
        leave(w, here);
    }
    return 0;
}

/* 1 where a conversion between these two is one of those asked for: by the criterion, or where none is named by the one that has
 * none, or by any where all have one. */
static int is_asked(const ff_conversion *c, const char *by)
{
    const int has_plain = ff_conversion_find(c->from, c->to, "", 0) >= 0;
    if (by && ff_conversion_find(c->from, c->to, by, 0) >= 0) return !strcmp(c->by, by);
    if (by && *by && !has_plain) return 0;
    return has_plain ? !*c->by : 1;
}

/* Ways that begin like `path`, from the convention name[k] on. */
static void branch(const char *const *name, size_t n, size_t k, const char *by, ff_conversion_path *path, size_t most,
                   ff_conversion_path *out, size_t *found)
{
    if (k + 1 == n) {
        if (*found < most) out[(*found)++] = *path;
        return;
    }
    for (int i = ff_conversion_find(name[k], name[k + 1], NULL, 0); i >= 0;
         i = ff_conversion_find(name[k], name[k + 1], NULL, (size_t)i + 1)) {
        const ff_conversion *c = ff_conversion_at((size_t)i);
        if (!is_asked(c, by)) continue;
        path->step[path->n++] = c;
        branch(name, n, k + 1, by, path, most, out, found);
        path->n--;
    }
}

/* 1 where a step of the way knows the criterion. */
static int is_used(const ff_conversion_path *path, const char *by)
{
    for (size_t k = 0; k < path->n; k++)
        if (!strcmp(path->step[k]->by, by)) return 1;
    return 0;
}

size_t ff_conversion_paths(const char *from, const char *to, const char *by, size_t most, ff_conversion_path *out)
{
    const char *name[FF_CONVERSION_STEPS + 1];
    walk w;
    ff_conversion_path path = {0};
    size_t found = 0;
    const size_t n = strcmp(from, to) ? conventions(&w, from, to, name) : 0;
    if (n > 1) branch(name, n, 0, by, &path, most, out, &found);
    return found && by && *by && !is_used(&out[0], by) ? 0 : found;
}

ff_status ff_conversion_follow(const ff_conversion_path *path, const double *in, double theta_i, double *out, const char **doubt,
                               ff_error *err)
{
    const char *doubted = NULL;
    double here[FF_CONVERSION_VALUES] = {0}, there[FF_CONVERSION_VALUES] = {0};
    memcpy(here, in, path->step[0]->n_in * sizeof *here);
    for (size_t k = 0; k < path->n; k++) {
        ff_error why = {0};
        const ff_conversion *c = path->step[k];
        const ff_status status = ff_conversion_apply(c, here, theta_i, there, &why);
        if (status && path->n > 1) return ff_error_set(err, status, NULL, 0, -1, "from %s to %s: %s", c->from, c->to, why.message);
        if (status) {
            if (err) *err = why;
            return status;
        }
        if (!doubted) doubted = ff_conversion_doubt(c, here, there);
        memcpy(here, there, sizeof here);
    }
    if (doubt) *doubt = doubted;
    memcpy(out, here, path->step[path->n - 1]->n_out * sizeof *out);
    return FF_OK;
}
