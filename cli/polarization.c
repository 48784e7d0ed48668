/* --polarization: models of polarized light, and channels whose names say which light they were measured with. */
#include "internal_cli.h"
#include "data_formats/analysis/ff_polarization.h"
#include "models/internal_model.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

int cli_polarize(const cli_args *args, ff_model *m)
{
    const char *light = cli_value(args, FLAG_POLARIZATION, NULL);
    ff_error err = {0};
    if (!light) return EXIT_DONE;
    if (ff_model_polarize(m, !strcmp(light, "s") ? 1 : !strcmp(light, "p") ? 0 : 0.5, &err) == FF_OK) return EXIT_DONE;
    return cli_usage(args, "--polarization %s: %s, as in %s", light, err.message,
                     cli_given(args, FLAG_MODEL) || !cli_given(args, FLAG_FRESNEL)
                         ? "--model ggx/smith-height-correlated/dielectric+lambert"
                         : "--fresnel dielectric");
}

/* The share of s light of every channel of a table, [n_channels]; NULL, and the status, when a name says nothing. */
static double *shares_of(const cli_args *args, const ff_table *t, int *status)
{
    double *share = malloc(t->n_channels * sizeof *share);
    *status = share ? EXIT_DONE : cli_failed(FF_ERR_MEMORY, NULL);
    if (!share) return NULL;
    for (size_t c = 0; c < t->n_channels && *status == EXIT_DONE; c++) {
        share[c] = ff_polarization_of_name(t->channels[c].name);
        if (isnan(share[c]))
            *status =
                cli_usage(args,
                          "--polarization both: the name of channel %zu, '%s', does not say its light; expected s or p, te or tm, "
                          "perpendicular or parallel among its words, or --polarization s for all channels",
                          c + 1, t->channels[c].name);
    }
    if (*status == EXIT_DONE) return share;
    free(share);
    return NULL;
}

/* Are all channels of one wavelength, or of none that is known? */
static int is_one_wavelength(const ff_table *t)
{
    for (size_t c = 1; c < t->n_channels; c++) {
        const double a = t->channels[0].wavelength_nm, b = t->channels[c].wavelength_nm;
        if (isfinite(a) != isfinite(b) || (isfinite(a) && a != b)) return 0;
    }
    return 1;
}

static int is_fixed(const cli_constraints *c, const char *name)
{
    for (size_t k = 0; k < c->c.n_fixed; k++)
        if (!strcmp(c->fixed[k].name, name)) return 1;
    return 0;
}

static int is_tied(const cli_constraints *c, const char *name)
{
    for (size_t k = 0; k < c->c.n_ties; k++)
        if (!strcmp(c->tie[k].name, name) || (c->tie[k].to && !strcmp(c->tie[k].to, name))) return 1;
    return 0;
}

/* Is the share what a name is to say, and not what the person has said of it? */
static int is_open(const cli_constraints *c, const ff_model_param *p)
{
    return (p->flags & FF_PARAM_HELD) && p->init == 0.5 && !is_fixed(c, p->name);
}

/* Channels of s and p light that are fitted as if it were the same light: the index would be another one of each. */
static void note_names(const ff_table *t)
{
    const char *s = NULL, *p = NULL;
    for (size_t c = 0; c < t->n_channels; c++) {
        const double share = ff_polarization_of_name(t->channels[c].name);
        if (share == 1 && !s) s = t->channels[c].name;
        if (share == 0 && !p) p = t->channels[c].name;
    }
    if (s && p)
        cli_note(
            "channels %s and %s are named like polarized light, and are fitted as if they were not: --polarization both, with the "
            "Fresnel term dielectric or conductor, tells them apart",
            s, p);
}

int cli_polarize_channels(const cli_args *args, const ff_table *table, const ff_model *model, size_t n, cli_constraints *c)
{
    int status;
    if (!cli_given(args, FLAG_POLARIZATION)) note_names(table);
    if (strcmp(cli_value(args, FLAG_POLARIZATION, ""), "both") != 0) return EXIT_DONE;
    double *share = shares_of(args, table, &status);
    if (!share) return status;
    double **more = realloc(c->values, (c->n_values + 1) * sizeof *more);
    if (more) c->values = more;
    if (!more) {
        free(share);
        return cli_failed(FF_ERR_MEMORY, NULL);
    }
    c->values[c->n_values++] = share;
    size_t n_shares = table->n_channels;
    if (!strcmp(cli_value(args, FLAG_CHANNELS, ""), "mean")) { /* one channel of light of all kinds */
        for (size_t k = 1; k < table->n_channels; k++) share[0] += share[k];
        share[0] /= (double)table->n_channels;
        n_shares = 1;
    }
    const int one = is_one_wavelength(table);
    if (!one) cli_note("the channels have several wavelengths: each keeps an index of refraction of its own");
    for (size_t i = 0; i < n; i++)
        for (uint32_t k = 0; k < model[i].n_channel; k++) {
            const ff_model_param *p = &model[i].channel[k];
            if (!strcmp(p->info->name, "s_share") && is_open(c, p))
                c->fixed[c->c.n_fixed++] = (ff_fixed){p->name, n_shares, share, NULL};
            const int is_index = !strcmp(p->info->name, "eta") || !strcmp(p->info->name, "k");
            if (one && table->n_channels > 1 && is_index && !is_fixed(c, p->name) && !is_tied(c, p->name))
                c->tie[c->c.n_ties++] = (ff_tie){p->name, NULL};
        }
    return EXIT_DONE;
}
