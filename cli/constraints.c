/* What the command line says of parameters besides the data: bounds, priors, ties, the conservation of energy. */
#define _GNU_SOURCE
#include "internal_cli.h"
#include "models/internal_model.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The first n characters of text, owned by c; NULL without memory. */
static const char *keep_name(cli_constraints *c, const char *text, size_t n)
{
    char **more = realloc(c->names, (c->n_names + 1) * sizeof *more);
    if (!more) return NULL;
    c->names = more;
    char *name = strndup(text, n);
    if (name) c->names[c->n_names++] = name;
    return name;
}

/* ---- words ----------------------------------------------------------------------------------- */

static int said_twice(const cli_args *args, cli_flag_id flag, const cli_assignment *a)
{
    return cli_usage(args, "--%s: %s%s%s%s is given twice", cli_flag_name(flag), a->name, *a->channel ? "[" : "", a->channel,
                     *a->channel ? "]" : "");
}

static int no_list(const cli_args *args, cli_flag_id flag, const char *word, const char *expected)
{
    return cli_usage(args, "--%s %s: a list of values has no meaning here; expected %s", cli_flag_name(flag), word, expected);
}

/* Both NULL, or the same word. */
static int same_word(const char *a, const char *b)
{
    return a == b || (a && b && !strcmp(a, b));
}

/* The names of an assignment, owned by c. 0 without memory. */
static int keep_names(cli_constraints *c, const cli_assignment *a, const char **name, const char **channel)
{
    *name = keep_name(c, a->name, strlen(a->name));
    *channel = *a->channel ? keep_name(c, a->channel, strlen(a->channel)) : NULL;
    return *name && (*channel || !*a->channel);
}

static int add_bound(const cli_args *args, const char *word, void *context)
{
    static const char expected[] = "NAME=LOW:HIGH, e.g. alpha=0.05:0.5";
    cli_constraints *c = context;
    cli_assignment a;
    ff_bound b = {0};
    double x[2];
    const int read = cli_assignment_read(word, &a) && a.rest;
    if (read && cli_is_list(a.rest)) return no_list(args, FLAG_BOUND, word, expected);
    if (!read || cli_numbers_read(a.rest, ':', 2, x) != 2) return cli_usage(args, "--bound %s: expected %s", word, expected);
    if (!(x[0] < x[1])) return cli_usage(args, "--bound %s: the bounds must rise", word);
    b.lo = x[0];
    b.hi = x[1];
    if (!keep_names(c, &a, &b.name, &b.channel)) return cli_failed(FF_ERR_MEMORY, NULL);
    for (size_t i = 0; i < c->c.n_bounds; i++)
        if (!strcmp(c->bound[i].name, b.name) && same_word(c->bound[i].channel, b.channel)) return said_twice(args, FLAG_BOUND, &a);
    c->bound[c->c.n_bounds++] = b;
    return EXIT_DONE;
}

/* "MEAN+-SD", the sign also as one character. */
static int read_prior(const char *text, double *mean, double *sd)
{
    static const char one[] = "\u00b1";
    char left[CLI_NAME];
    const char *two = strstr(text, "+-"), *sign = two ? two : strstr(text, one);
    if (!sign || (size_t)(sign - text) >= sizeof left) return 0;
    snprintf(left, sizeof left, "%.*s", (int)(sign - text), text);
    return cli_number_read(left, mean) && cli_number_read(sign + (two ? 2 : strlen(one)), sd);
}

static int add_prior(const cli_args *args, const char *word, void *context)
{
    static const char expected[] = "NAME=MEAN+-SD, e.g. f0=0.04+-0.01";
    cli_constraints *c = context;
    cli_assignment a;
    ff_prior p = {0};
    const int read = cli_assignment_read(word, &a) && a.rest;
    if (read && cli_is_list(a.rest)) return no_list(args, FLAG_PRIOR, word, expected);
    if (!read || !read_prior(a.rest, &p.mean, &p.sd)) return cli_usage(args, "--prior %s: expected %s", word, expected);
    if (!(p.sd > 0)) return cli_usage(args, "--prior %s: the standard deviation must be above 0", word);
    if (!keep_names(c, &a, &p.name, &p.channel)) return cli_failed(FF_ERR_MEMORY, NULL);
    for (size_t i = 0; i < c->c.n_priors; i++)
        if (!strcmp(c->prior[i].name, p.name) && same_word(c->prior[i].channel, p.channel)) return said_twice(args, FLAG_PRIOR, &a);
    c->prior[c->c.n_priors++] = p;
    return EXIT_DONE;
}

/* Values by channel, owned by c; NULL without memory. */
static const double *keep_values(cli_constraints *c, const double *x, size_t n)
{
    double *copy = malloc(n * sizeof *copy);
    double **more = copy ? realloc(c->values, (c->n_values + 1) * sizeof *more) : NULL;
    if (!more) {
        free(copy);
        return NULL;
    }
    c->values = more;
    c->values[c->n_values++] = copy;
    return memcpy(copy, x, n * sizeof *copy);
}

/* --fix with a value for each channel, or for one of them; one value for all was done to the models. */
static int add_fixed(const cli_args *args, const char *word, void *context)
{
    cli_constraints *c = context;
    cli_assignment a;
    ff_fixed f = {0};
    double *x = malloc(CLI_VALUES * sizeof *x);
    if (!x) return cli_failed(FF_ERR_MEMORY, NULL);
    f.n = cli_assignment_read(word, &a) && a.rest ? cli_numbers_read(a.rest, ':', CLI_VALUES, x) : 0;
    if (f.n == 1 && !*a.channel) f.n = 0;
    f.value = f.n ? keep_values(c, x, f.n) : NULL;
    free(x);
    if (f.n == 0) return EXIT_DONE;
    if (!f.value || !keep_names(c, &a, &f.name, &f.channel)) return cli_failed(FF_ERR_MEMORY, NULL);
    for (size_t i = 0; i < c->c.n_fixed; i++)
        if (!strcmp(c->fixed[i].name, f.name) && same_word(c->fixed[i].channel, f.channel)) return said_twice(args, FLAG_FIX, &a);
    c->fixed[c->c.n_fixed++] = f;
    return EXIT_DONE;
}

static int add_tie(const cli_args *args, const char *word, void *context)
{
    cli_constraints *c = context;
    ff_tie t = {NULL, NULL};
    const size_t length = strcspn(word, "=");
    const int two = word[length] == '=';
    if (strpbrk(word, "[{"))
        return cli_usage(args, "--tie %s: a tie is between parameters of all channels; expected NAME=NAME, or one NAME", word);
    if (length == 0 || (two && (!word[length + 1] || strchr(word + length + 1, '='))))
        return cli_usage(args, "--tie %s: expected NAME=NAME, or one NAME for a single value in all channels", word);
    if (!(t.name = keep_name(c, word, length)) || (two && !(t.to = keep_name(c, word + length + 1, strlen(word + length + 1)))))
        return cli_failed(FF_ERR_MEMORY, NULL);
    c->tie[c->c.n_ties++] = t;
    return EXIT_DONE;
}

static int count_word(const cli_args *args, const char *word, void *context)
{
    (void)args;
    (void)word;
    (*(size_t *)context)++;
    return EXIT_DONE;
}

/* ---- names ----------------------------------------------------------------------------------- */

static int has_name(const ff_model *model, const char *name)
{
    ff_model m = *model;
    return ff_model_vary(&m, name, NULL) == FF_OK;
}

/* A usage error, with the nearest name of all models, for one that none of them has. */
static int check_name(const cli_args *args, const ff_model *model, size_t n, cli_flag_id flag, const char *name)
{
    for (size_t i = 0; i < n; i++)
        if (has_name(&model[i], name)) return EXIT_DONE;
    const char *nearest = cli_param_nearest(model, n, name);
    return cli_usage(args, "--%s: %s a parameter '%s'%s%s%s", cli_flag_name(flag),
                     n == 1 ? "the model does not have" : "none of the models has", name, nearest ? "; did you mean '" : "",
                     nearest ? nearest : "", nearest ? "'?" : "");
}

/* ---- parameters that are held or free -------------------------------------------------------- */

typedef struct holding {
    ff_model *m;
    int where_present;
} holding;

static int said(cli_flag_id flag, const char *word, const holding *h, ff_status status, const ff_error *err)
{
    if (status == FF_OK || (status == FF_ERR_UNKNOWN && h->where_present)) return EXIT_DONE;
    cli_error("--%s %s: %s", cli_flag_name(flag), word, err->message);
    return cli_exit_status(status);
}

static int free_one(const cli_args *args, const char *word, void *context)
{
    const holding *h = context;
    ff_error err = {0};
    (void)args;
    return said(FLAG_FREE, word, h, ff_model_vary(h->m, word, &err), &err);
}

/* What --bound lets a parameter reach. */
typedef struct reach {
    const char *name;
    double most;
} reach;

static int look_at_bound(const cli_args *args, const char *word, void *context)
{
    reach *r = context;
    cli_assignment a;
    double x[2];
    (void)args;
    if (cli_assignment_read(word, &a) && a.rest && !strcmp(a.name, r->name) && cli_numbers_read(a.rest, ':', 2, x) == 2)
        r->most = fmax(r->most, x[1]);
    return EXIT_DONE;
}

/* A share of light is at most 1, unless a bound says that it may be more, or the data have a unit or a gamut of their own. */
static int check_share(const cli_args *args, const ff_model *m, const char *word, const char *name, double value)
{
    const ff_param_ref at = ff_model_param_find(m, name);
    reach r = {name, 1};
    if (at.kind != FF_PARAM_CHANNEL || value <= 1 || cli_boxes_are_open(args)) return EXIT_DONE;
    const ff_model_param *p = &m->channel[at.index];
    if (ff_param_box_end(ff_model_param_domain(m, p)) != 1) return EXIT_DONE;
    cli_each_word(args, FLAG_BOUND, look_at_bound, &r);
    if (value <= r.most) return EXIT_DONE;
    return cli_usage(args,
                     "--fix %s: %g lies outside [%g, 1]: %s is a share of the light; --bound %s=0:%g says that it may be more",
                     word, value, p->info->lo, name, name, value);
}

/* One value for all channels holds the parameter in the model; what is said of channels is a constraint of the fit. */
static int fix_one(const cli_args *args, const char *word, void *context)
{
    const holding *h = context;
    ff_error err = {0};
    cli_assignment a;
    double *x = malloc(CLI_VALUES * sizeof *x);
    const int read = cli_assignment_read(word, &a) && a.rest;
    const size_t n = x && read ? cli_numbers_read(a.rest, ':', CLI_VALUES, x) : 0;
    const double value = n == 1 ? x[0] : 0;
    int status = EXIT_DONE;
    for (size_t k = 0; k < n && status == EXIT_DONE; k++) status = check_share(args, h->m, word, a.name, x[k]);
    free(x);
    if (status != EXIT_DONE) return status;
    if (!x) return cli_failed(FF_ERR_MEMORY, NULL);
    if (read && cli_is_list(a.rest))
        return cli_usage(
            args, "--fix %s: a list of values has no meaning here; expected NAME=VALUE, or NAME=v1:v2:... for the channels", word);
    if (n == 0) return cli_usage(args, "--fix %s: expected NAME=VALUE", word);
    if (n > 1 && *a.channel)
        return cli_usage(args, "--fix %s: found %zu values, expected one for the channel %s", word, n, a.channel);
    if (n > 1 || *a.channel) return EXIT_DONE;
    return said(FLAG_FIX, word, h, ff_model_hold(h->m, a.name, value, &err), &err);
}

int cli_hold_and_free(const cli_args *args, ff_model *m, int where_present)
{
    holding h = {m, where_present};
    int status = cli_polarize(args, m);
    if (status == EXIT_DONE) status = cli_each_word(args, FLAG_FREE, free_one, &h);
    return status == EXIT_DONE ? cli_each_word(args, FLAG_FIX, fix_one, &h) : status;
}

/* Models of a comparison. */
typedef struct model_set {
    cli_flag_id flag;
    const ff_model *model;
    size_t n;
} model_set;

static int known_to_any(const cli_args *args, const char *word, void *context)
{
    const model_set *set = context;
    cli_assignment a;
    if (!cli_assignment_read(word, &a)) return EXIT_DONE; /* said where it is read */
    return check_name(args, set->model, set->n, set->flag, a.name);
}

int cli_names_known(const cli_args *args, const ff_model *model, size_t n)
{
    model_set free_ones = {FLAG_FREE, model, n}, fixed = {FLAG_FIX, model, n};
    const int status = cli_each_word(args, FLAG_FREE, known_to_any, &free_ones);
    return status == EXIT_DONE ? cli_each_word(args, FLAG_FIX, known_to_any, &fixed) : status;
}

/* ---- all of them ------------------------------------------------------------------------------ */

static int check_names(const cli_args *args, const ff_model *model, size_t n, const ff_constraints *c)
{
    int status = EXIT_DONE;
    for (size_t i = 0; i < c->n_bounds && status == EXIT_DONE; i++)
        status = check_name(args, model, n, FLAG_BOUND, c->bound[i].name);
    for (size_t i = 0; i < c->n_priors && status == EXIT_DONE; i++)
        status = check_name(args, model, n, FLAG_PRIOR, c->prior[i].name);
    for (size_t i = 0; i < c->n_fixed && status == EXIT_DONE; i++) status = check_name(args, model, n, FLAG_FIX, c->fixed[i].name);
    for (size_t i = 0; i < c->n_ties && status == EXIT_DONE; i++) {
        status = check_name(args, model, n, FLAG_TIE, c->tie[i].name);
        if (status == EXIT_DONE && c->tie[i].to) status = check_name(args, model, n, FLAG_TIE, c->tie[i].to);
    }
    return status;
}

/* What the names stand for has to make sense too: of every model, or where some are left out of a comparison of those that are not.
 */
static int check_models(const ff_model *model, size_t n, int where_present, const ff_constraints *c)
{
    for (size_t i = 0; i < n; i++) {
        ff_error err = {0};
        const ff_status status = ff_constraints_check(c, &model[i], &err);
        if (status == FF_OK || (status == FF_ERR_UNSUPPORTED && where_present)) continue;
        return cli_failed(status, &err);
    }
    return EXIT_DONE;
}

int cli_constraints_read(const cli_args *args, const ff_model *model, size_t n, int where_present, cli_constraints *out)
{
    enum { ASSUMED = 16 };
    size_t words = 0;
    int status;
    *out = (cli_constraints){.c = {.where_present = where_present}};
    cli_each_word(args, FLAG_BOUND, count_word, &words);
    cli_each_word(args, FLAG_PRIOR, count_word, &words);
    cli_each_word(args, FLAG_TIE, count_word, &words);
    cli_each_word(args, FLAG_FIX, count_word, &words);
    out->n_room = words + ASSUMED;
    out->bound = calloc(out->n_room, sizeof *out->bound);
    out->because = calloc(out->n_room, sizeof *out->because);
    out->prior = calloc(words + 1, sizeof *out->prior);
    out->tie = calloc(out->n_room, sizeof *out->tie); /* some are assumed here too */
    out->fixed = calloc(out->n_room, sizeof *out->fixed);
    if (!out->bound || !out->because || !out->prior || !out->tie || !out->fixed) return cli_failed(FF_ERR_MEMORY, NULL);
    out->c.bound = out->bound;
    out->c.because = out->because;
    out->c.prior = out->prior;
    out->c.tie = out->tie;
    out->c.fixed = out->fixed;
    out->c.energy_conserving = cli_switch(args, FLAG_ENERGY, 0);
    if ((status = cli_each_word(args, FLAG_BOUND, add_bound, out)) || (status = cli_each_word(args, FLAG_PRIOR, add_prior, out)) ||
        (status = cli_each_word(args, FLAG_TIE, add_tie, out)) || (status = cli_each_word(args, FLAG_FIX, add_fixed, out)) ||
        (status = check_names(args, model, n, &out->c)))
        return status;
    cli_boxes_assume(args, model, n, out);
    return check_models(model, n, where_present, &out->c);
}

void cli_constraints_free(cli_constraints *constraints)
{
    for (size_t i = 0; i < constraints->n_names; i++) free(constraints->names[i]);
    free(constraints->names);
    free(constraints->bound);
    free(constraints->because);
    free(constraints->prior);
    free(constraints->tie);
    free(constraints->fixed);
    for (size_t i = 0; i < constraints->n_values; i++) free(constraints->values[i]);
    free(constraints->values);
    *constraints = (cli_constraints){.n_names = 0};
}
