/* Bounds that are assumed where the flags say that reflectances may exceed 1: linear sRGB, whose gamut saturated metals leave, and
 * data in units of their own, which a free ks is for. What --bound says stands. */
#include "internal_cli.h"
#include <string.h>

/* How far linear sRGB may go: no spectrum between 0 and 1 has a channel above it. */
#define SRGB_MOST  2
#define UNITS_MOST 1e15

/* Do the words of --free name a scale? */
static int frees_scale(const cli_args *args, const char *word, void *context)
{
    const char *dot = strrchr(word, '.');
    (void)args;
    if (!strcmp(dot ? dot + 1 : word, "ks")) *(int *)context = 1;
    return EXIT_DONE;
}

static int is_reflectance(const ff_model_param *p)
{
    const uint32_t kind = FF_PARAM_PER_CHANNEL | FF_PARAM_LINEAR;
    return (p->flags & (kind | FF_PARAM_HELD)) == kind && p->info->lo == 0 && p->info->hi == 1;
}

static int is_said(const ff_constraints *c, const char *name)
{
    for (size_t i = 0; i < c->n_bounds; i++)
        if (!strcmp(c->bound[i].name, name)) return 1;
    for (size_t i = 0; i < c->n_fixed; i++)
        if (!c->fixed[i].channel && !strcmp(c->fixed[i].name, name)) return 1;
    return 0;
}

/* May all models that have the parameter go so far? */
static int may_reach(const ff_model *model, size_t n, const char *name, double most)
{
    for (size_t i = 0; i < n; i++) {
        ff_model m = model[i];
        if (ff_model_param_find(&m, name).kind != FF_PARAM_NONE && ff_model_bound(&m, name, 0, most, NULL) != FF_OK) return 0;
    }
    return 1;
}

int cli_boxes_are_open(const cli_args *args)
{
    int scaled = 0;
    cli_each_word(args, FLAG_FREE, frees_scale, &scaled);
    return scaled || !strncmp(cli_value(args, FLAG_REDUCE, ""), "srgb", 4);
}

void cli_boxes_assume(const cli_args *args, const ff_model *model, size_t n, cli_constraints *c)
{
    const char *to = cli_value(args, FLAG_REDUCE, "");
    const int srgb = !strncmp(to, "srgb", 4);
    int scaled = 0;
    cli_each_word(args, FLAG_FREE, frees_scale, &scaled);
    for (size_t i = 0; i < n && (srgb || scaled); i++)
        for (uint32_t k = 0; k < model[i].n_channel; k++) {
            const ff_model_param *p = &model[i].channel[k];
            const int of_base = p->lobe >= model[i].n_lobes, units = scaled && of_base;
            const double most = units ? UNITS_MOST : SRGB_MOST;
            if (c->c.n_bounds == c->n_room || !(srgb || units) || !is_reflectance(p) || is_said(&c->c, p->name)) continue;
            if (!may_reach(model, n, p->name, most)) continue;
            c->because[c->c.n_bounds] =
                units ? "a free ks is for data in units of their own" : "saturated colours lie outside the gamut of sRGB";
            c->bound[c->c.n_bounds++] = (ff_bound){.name = p->name, .lo = 0, .hi = most};
        }
}
