/* How far fits can be trusted, as people read it. */
#include "internal_fits_text.h"
#include <math.h>
#include <string.h>

/* ---- under a fit ----------------------------------------------------------------------------- */

static void put_effective(const ff_fit_result *f, double values, FILE *out)
{
    char n[FF_TEXT_NUMBER], m[FF_TEXT_NUMBER], c[FF_TEXT_NUMBER];
    if (!f->correlation) return;
    fputs("\n  ", out);
    if (f->effective_samples < values)
        fprintf(out, "%s values count as %s independent ones", ff_text_number(values, 9, n),
                ff_text_fixed(f->effective_samples, 0, m));
    else
        fprintf(out, "%s values count as independent", ff_text_number(values, 9, n));
    if (f->correlated_over > 1) fprintf(out, "; errors go together over %zu neighbouring samples", f->correlated_over);
    fprintf(out, "; condition of the Jacobian %s\n", ff_text_number(f->condition, 2, c));
}

/* "4.8 % of the value + 0.0003/sr", the level of a channel. */
static void put_level(const ff_noise_level *l, FILE *out)
{
    char x[FF_TEXT_NUMBER];
    const char *plus = "";
    if (l->square > 0) {
        fprintf(out, "%s %% of the value", ff_text_number(100 * sqrt(l->square), 2, x));
        plus = " + ";
    }
    if (l->linear > 0) {
        fprintf(out, "%s%s/sr^0.5 of its root", plus, ff_text_number(sqrt(l->linear), 2, x));
        plus = " + ";
    }
    if (l->constant > 0) fprintf(out, "%s%s/sr", plus, ff_text_number(sqrt(l->constant), 2, x));
}

/* What is made of the angles: a factor at 60 degrees that is worth a word. */
static const char *growth(double power)
{
    const double at_60 = pow(0.5, 0.5 * power);
    return at_60 > 1.25 ? "growing" : at_60 < 0.8 ? "falling" : NULL;
}

static void put_noise(const ff_problem *p, const ff_fit_result *f, FILE *out)
{
    const ff_noise *n = ff_fit_result_noise(f);
    if (!n) return;
    const char *by_i = growth(ff_noise_cos_i(n)), *by_o = growth(ff_noise_cos_o(n));
    const size_t levels = ff_noise_level_count(n);
    fputs("  noise: ", out);
    for (size_t k = 0; k < levels && k < FF_REPORT_CHANNELS; k++) {
        const ff_noise_level l = ff_noise_level_at(n, k);
        if (k) fputs("; ", out);
        if (levels > 1) fprintf(out, "%s ", ff_problem_channel_name(p, k));
        put_level(&l, out);
    }
    if (levels > FF_REPORT_CHANNELS) fprintf(out, "; and so on for %zu channels", levels);
    if (by_i && by_o && by_i == by_o)
        fprintf(out, ", %s towards grazing", by_i);
    else {
        if (by_i) fprintf(out, ", %s towards grazing incidence", by_i);
        if (by_o) fprintf(out, ", %s towards grazing exit", by_o);
    }
    if (ff_noise_along_scan(n, 1) > 0) {
        char r[FF_TEXT_NUMBER];
        fprintf(out, "; neighbours err together (correlation %s)", ff_text_number(ff_noise_along_scan(n, 1), 2, r));
    }
    if (ff_noise_between_channels(n) > 0) {
        char r[FF_TEXT_NUMBER];
        fprintf(out, "; so do channels (%s)", ff_text_number(ff_noise_between_channels(n), 2, r));
    }
    fputc('\n', out);
}

static void put_bootstrap(const ff_bootstrap *b, FILE *out)
{
    fprintf(out, "  std errors and intervals by %zu refits %s %zu %s", b->repeats,
            b->kind == FF_GROUP_VALUES ? "with the noise drawn anew in" : "with random weights of", b->n_groups,
            ff_grouping_name((int)b->kind));
    if (b->failed) fprintf(out, " (%zu did not converge)", b->failed);
    fputc('\n', out);
    if (b->kind == FF_GROUP_RUNS)
        fputs("  there are too few incident directions to reweight them: errors that a whole one shares are not in these\n", out);
}

static int has_moved(const ff_cut_off *c, size_t k)
{
    return fabs(c->move[k]) > c->limit && fabs(c->shift[k]) > FF_CUT_OFF_MATTERS;
}

static void put_cut_off(const ff_report_fits *r, size_t i, FILE *out)
{
    const ff_fit_result *f = &r->fit[i];
    const ff_cut_off *c = &r->trust[i].cut_off;
    const ff_problem *p = r->problem[i / (r->n_fits / r->n_problems)];
    char limit[FF_TEXT_NUMBER], usual[FF_TEXT_NUMBER], name[FF_REPORT_NAME], a[FF_TEXT_NUMBER], b[FF_TEXT_NUMBER],
        chance[FF_TEXT_NUMBER];
    size_t moved = 0;
    ff_text_number(ff_report_degrees(c->max_theta), 4, limit);
    for (size_t k = 0; k < c->n_columns; k++) moved += (size_t)has_moved(c, k);
    if (moved == 0) {
        fprintf(out, "  up to %s degrees (%zu samples) no parameter moves by more than its errors\n", limit, c->used);
        return;
    }
    fprintf(out, "  warning: with samples up to %s instead of %s degrees (%zu) parameters move by more than by chance:\n", limit,
            ff_text_number(ff_report_degrees(r->options->max_theta), 4, usual), c->used);
    for (size_t k = 0; k < c->n_columns; k++)
        if (has_moved(c, k))
            fprintf(out, "    %s is %s, %s%s of its errors; leaving these samples out moves it by %s by chance\n",
                    ff_report_column_name(p, f, k, name), ff_text_number(c->value[k], 5, a), c->shift[k] > 0 ? "+" : "",
                    ff_text_number(c->shift[k], 2, b), ff_text_number(fabs(c->shift[k] / c->move[k]), 2, chance));
}

void ff_report_trust_of_fit(const ff_report_fits *r, size_t i, FILE *out)
{
    ff_selection s;
    ff_problem_selection(r->problem[i / (r->n_fits / r->n_problems)], &s);
    put_effective(&r->fit[i], (double)s.used * (double)s.n_channels, out);
    put_noise(ff_report_problem_of(r, i), &r->fit[i], out);
    if (!r->trust) return;
    if (r->trust[i].has_bootstrap) put_bootstrap(&r->trust[i].bootstrap, out);
    if (r->trust[i].has_cut_off) put_cut_off(r, i, out);
    if (r->trust[i].has_outliers) ff_report_outliers_text(r, i, out);
}

/* ---- outliers -------------------------------------------------------------------------------- */

/* The band with the largest share of the outliers. */
static size_t fullest(const size_t *in_band)
{
    size_t most = 0;
    for (size_t b = 1; b < FF_BANDS; b++)
        if (in_band[b] > in_band[most]) most = b;
    return most;
}

/* In [0, 360). */
static double azimuth(const double w[3])
{
    const double phi = ff_report_degrees(atan2(w[1], w[0]));
    return phi < 0 ? phi + 360 : phi;
}

static void put_sample(const ff_report_fits *r, uint32_t sample, FILE *out)
{
    double w[6], *const planes[6] = {w, w + 1, w + 2, w + 3, w + 4, w + 5};
    char a[FF_TEXT_NUMBER], b[FF_TEXT_NUMBER], c[FF_TEXT_NUMBER], d[FF_TEXT_NUMBER];
    fprintf(out, "sample %u", sample + 1);
    if (!r->table->valid) return; /* the samples have been released */
    ff_table_directions(r->table, sample, 1, planes);
    fprintf(out, " (theta_i %s, phi_i %s, theta_o %s, phi_o %s)",
            ff_text_number(ff_report_degrees(atan2(hypot(w[0], w[1]), w[2])), 4, a), ff_text_number(azimuth(w), 4, b),
            ff_text_number(ff_report_degrees(atan2(hypot(w[3], w[4]), w[5])), 4, c), ff_text_number(azimuth(w + 3), 4, d));
}

void ff_report_outliers_text(const ff_report_fits *r, size_t i, FILE *out)
{
    const ff_outliers *o = &r->trust[i].outliers;
    const ff_problem *p = r->problem[i / (r->n_fits / r->n_problems)];
    char number[FF_TEXT_NUMBER];
    if (o->samples == 0) {
        fprintf(out, "  no outliers: no residual is beyond %g standard deviations\n", FF_OUTLIER);
        return;
    }
    fprintf(out, "  %zu sample%s with a residual beyond %g standard deviations", o->samples, o->samples == 1 ? "" : "s",
            FF_OUTLIER);
    const char *separator = "; most at ";
    for (int k = 0; k < FF_PLACE_COUNT; k++) {
        const size_t band = fullest(o->in_band[k]);
        fprintf(out, "%s%s %zu to %zu (%zu)", separator, ff_place_name(k), band * FF_BAND_DEGREES, (band + 1) * FF_BAND_DEGREES,
                o->in_band[k][band]);
        separator = ", ";
    }
    fputs("; the worst:\n", out);
    for (size_t k = 0; k < o->n_worst; k++) {
        fputs("    ", out);
        put_sample(r, o->worst[k].sample, out);
        fprintf(out, ", channel %s: data %s the model by %s\n", ff_problem_channel_name(p, o->worst[k].channel),
                o->worst[k].ratio > 0 ? "below" : "above", ff_text_number(fabs(o->worst[k].ratio), 3, number));
    }
}

/* ---- residuals by angle ---------------------------------------------------------------------- */

/* "+1.2": a mean in per cent. */
static const char *percent(double x, char *out)
{
    char number[FF_TEXT_NUMBER];
    if (isnan(x)) return strcpy(out, "");
    snprintf(out, FF_TEXT_NUMBER, "%s%.40s", x >= 0 ? "+" : "", ff_text_fixed(100 * x, fabs(x) < 0.0995 ? 1 : 0, number));
    return out;
}

/* Fits by the bands of one angle. */
typedef struct bands {
    const ff_report_fits *r;
    const size_t *row; /* of the fits that have bands */
    int place;
} bands;

static const ff_band *band_at(ff_where w)
{
    const bands *t = w.of;
    return &t->r->trust[t->row[w.row]].bands.band[t->place][w.index];
}

static const ff_fit_result *fit_at(ff_where w)
{
    const bands *t = w.of;
    return &t->r->fit[t->row[w.row]];
}

static void masking_cell(ff_cell *out, ff_where w)
{
    ff_cell_text(out, "%s", ff_report_masking_name(fit_at(w)));
}

static void ndf_cell(ff_cell *out, ff_where w)
{
    ff_cell_text(out, "%s", ff_report_ndf_name(fit_at(w)));
}

static void band_cell(ff_cell *out, ff_where w)
{
    char text[FF_TEXT_NUMBER];
    if (band_at(w)->n) ff_cell_rounded(out, 100 * band_at(w)->mean, percent(band_at(w)->mean, text));
}

/* The occupied bands: the samples are those of every fit. */
static ff_status put_bands_of(const ff_report_fits *r, const size_t *row, size_t n, int place, FILE *out)
{
    const bands t = {r, row, place};
    char angle[64], label[FF_BANDS][32];
    ff_column column[2 + FF_BANDS] = {{.head = angle, .cell = masking_cell, .least = 14},
                                      {.head = "", .cell = ndf_cell, .drop = 2}};
    size_t columns = 2;
    snprintf(angle, sizeof angle, "%s, degrees", ff_place_name(place));
    for (size_t b = 0; b < FF_BANDS && n; b++) {
        if (!r->trust[row[0]].bands.band[place][b].n) continue;
        snprintf(label[b], sizeof label[b], "%zu-%zu", b * FF_BAND_DEGREES, (b + 1) * FF_BAND_DEGREES);
        column[columns++] =
            (ff_column){.head = label[b], .align = FF_RIGHT, .cell = band_cell, .index = b, .drop = b % 2}; /* then every other */
    }
    return ff_columns_print(column, columns, &t, n, FF_TABLE_TEXT, "", r->style, out);
}

ff_status ff_report_bands_text(const ff_report_fits *r, const size_t *row, size_t n, FILE *out)
{
    ff_status status = FF_OK;
    fputs("\nmean of model - data by angle, per cent of the data there (times cos theta_i)\n", out);
    for (int place = 0; place < FF_PLACE_COUNT && status == FF_OK; place++) status = put_bands_of(r, row, n, place, out);
    return status;
}
