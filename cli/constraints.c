/* What the command line says of parameters besides the data: bounds, priors, ties, the conservation of energy. */
#define _GNU_SOURCE
#include "internal_cli.h"
#include "base/internal_number.h"
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

/* Reads "NAME=A<separator>B" with one of two separators. Returns the length of the name, 0 when that is not what stands there. */
static size_t read_pair(const char *word, const char *separator, const char *other, double *a, double *b)
{
    const size_t length = strcspn(word, "=");
    if (length == 0 || !word[length]) return 0;
    const char *end = ff_number_read(word + length + 1, a);
    if (!end) return 0;
    const char *found = !strncmp(end, separator, strlen(separator))    ? separator
                        : other && !strncmp(end, other, strlen(other)) ? other
                                                                       : NULL;
    if (!found) return 0;
    end = ff_number_read(end + strlen(found), b);
    return end && !*end && isfinite(*a) && isfinite(*b) ? length : 0;
}

static int said_twice(const cli_args *args, cli_flag_id flag, const char *name)
{
    return cli_usage(args, "--%s: %s is given twice", cli_flag_name(flag), name);
}

static int add_bound(const cli_args *args, const char *word, void *context)
{
    cli_constraints *c = context;
    ff_bound b;
    const size_t length = read_pair(word, ":", NULL, &b.lo, &b.hi);
    if (length == 0) return cli_usage(args, "--bound %s: expected NAME=LOW:HIGH, e.g. alpha=0.05:0.5", word);
    if (!(b.lo < b.hi)) return cli_usage(args, "--bound %s: the bounds must rise", word);
    if (!(b.name = keep_name(c, word, length))) return cli_failed(FF_ERR_MEMORY, NULL);
    for (size_t i = 0; i < c->c.n_bounds; ++i)
        if (!strcmp(c->bound[i].name, b.name)) return said_twice(args, FLAG_BOUND, b.name);
    c->bound[c->c.n_bounds++] = b;
    return EXIT_DONE;
}

static int add_prior(const cli_args *args, const char *word, void *context)
{
    cli_constraints *c = context;
    ff_prior p;
    const size_t length = read_pair(word, "+-", "\u00b1", &p.mean, &p.sd);
    if (length == 0) return cli_usage(args, "--prior %s: expected NAME=MEAN+-SD, e.g. f0=0.04+-0.01", word);
    if (!(p.sd > 0)) return cli_usage(args, "--prior %s: the standard deviation must be above 0", word);
    if (!(p.name = keep_name(c, word, length))) return cli_failed(FF_ERR_MEMORY, NULL);
    for (size_t i = 0; i < c->c.n_priors; ++i)
        if (!strcmp(c->prior[i].name, p.name)) return said_twice(args, FLAG_PRIOR, p.name);
    c->prior[c->c.n_priors++] = p;
    return EXIT_DONE;
}

static int add_tie(const cli_args *args, const char *word, void *context)
{
    cli_constraints *c = context;
    ff_tie t = {NULL, NULL};
    const size_t length = strcspn(word, "=");
    const int two = word[length] == '=';
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
    ++*(size_t *)context;
    return EXIT_DONE;
}

/* ---- names ----------------------------------------------------------------------------------- */

static int has_name(const ff_model *model, const char *name)
{
    ff_model m = *model;
    return ff_model_free(&m, name, NULL) == FF_OK;
}

/* A usage error, with the nearest name of all models, for one that none of them has. */
static int check_name(const cli_args *args, const ff_model *model, size_t n, cli_flag_id flag, const char *name)
{
    const char *names[2 * (FF_MAX_SHAPE + FF_MAX_CHANNEL_PARAMS)], *nearest = NULL;
    for (size_t i = 0; i < n; ++i)
        if (has_name(&model[i], name)) return EXIT_DONE;
    for (size_t i = 0; i < n && !nearest; ++i) {
        size_t count = 0;
        names[count++] = "alpha";
        for (uint32_t k = 0; k < model[i].n_shape; ++k) names[count++] = model[i].shape[k].name;
        for (uint32_t k = 0; k < model[i].n_channel; ++k) names[count++] = model[i].channel[k].name;
        nearest = cli_nearest(name, names, count);
        if (nearest && !has_name(&model[i], nearest)) nearest = NULL;
    }
    return cli_usage(args, "--%s: %s a parameter '%s'%s%s%s", cli_flag_name(flag),
                     n == 1 ? "the model does not have" : "none of the models has", name, nearest ? "; did you mean '" : "",
                     nearest ? nearest : "", nearest ? "'?" : "");
}

static int check_names(const cli_args *args, const ff_model *model, size_t n, const ff_constraints *c)
{
    int status = EXIT_DONE;
    for (size_t i = 0; i < c->n_bounds && status == EXIT_DONE; ++i)
        status = check_name(args, model, n, FLAG_BOUND, c->bound[i].name);
    for (size_t i = 0; i < c->n_priors && status == EXIT_DONE; ++i)
        status = check_name(args, model, n, FLAG_PRIOR, c->prior[i].name);
    for (size_t i = 0; i < c->n_ties && status == EXIT_DONE; ++i) {
        status = check_name(args, model, n, FLAG_TIE, c->tie[i].name);
        if (status == EXIT_DONE && c->tie[i].to) status = check_name(args, model, n, FLAG_TIE, c->tie[i].to);
    }
    return status;
}

/* What the names stand for has to make sense too: of every model, or where some are left out of a comparison of those that are not.
 */
static int check_models(const ff_model *model, size_t n, int where_present, const ff_constraints *c)
{
    for (size_t i = 0; i < n; ++i) {
        ff_error err = {0};
        const ff_status status = ff_constraints_check(c, &model[i], &err);
        if (status == FF_OK || (status == FF_ERR_UNSUPPORTED && where_present)) continue;
        return cli_failed(status, &err);
    }
    return EXIT_DONE;
}

int cli_constraints_read(const cli_args *args, const ff_model *model, size_t n, int where_present, cli_constraints *out)
{
    size_t words = 0;
    int status;
    *out = (cli_constraints){.c = {.where_present = where_present}};
    cli_each_word(args, FLAG_BOUND, count_word, &words);
    cli_each_word(args, FLAG_PRIOR, count_word, &words);
    cli_each_word(args, FLAG_TIE, count_word, &words);
    out->bound = calloc(words + 1, sizeof *out->bound);
    out->prior = calloc(words + 1, sizeof *out->prior);
    out->tie = calloc(words + 1, sizeof *out->tie);
    if (!out->bound || !out->prior || !out->tie) return cli_failed(FF_ERR_MEMORY, NULL);
    out->c.bound = out->bound;
    out->c.prior = out->prior;
    out->c.tie = out->tie;
    out->c.energy_conserving = cli_given(args, FLAG_ENERGY) > 0;
    if ((status = cli_each_word(args, FLAG_BOUND, add_bound, out)) || (status = cli_each_word(args, FLAG_PRIOR, add_prior, out)) ||
        (status = cli_each_word(args, FLAG_TIE, add_tie, out)) || (status = check_names(args, model, n, &out->c)))
        return status;
    return check_models(model, n, where_present, &out->c);
}

void cli_constraints_free(cli_constraints *constraints)
{
    for (size_t i = 0; i < constraints->n_names; ++i) free(constraints->names[i]);
    free(constraints->names);
    free(constraints->bound);
    free(constraints->prior);
    free(constraints->tie);
    *constraints = (cli_constraints){.n_names = 0};
}
