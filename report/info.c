/* What is in a file. */
#include "base/internal_order.h"
#include "internal_report.h"
#include "internal_columns.h"
#include "data_formats/analysis/survey_struct.h"
#include "data_formats/table/internal_table.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct channel_summary {
    double min, median, max;
} channel_summary;

typedef struct table_summary {
    ff_survey survey;
    channel_summary *channel; /* [n_channels] */
} table_summary;

/* Of the finite values of valid samples; value [n] is memory for them. */
static channel_summary summary_of(const ff_table *t, size_t c, double *value)
{
    channel_summary s = {INFINITY, NAN, -INFINITY};
    size_t n = 0;
    ff_table_values(t, c, 0, t->n, value);
    for (size_t i = 0; i < t->n; i++)
        if (t->valid[i] && isfinite(value[i])) value[n++] = value[i];
    for (size_t i = 0; i < n; i++) s.min = fmin(s.min, value[i]), s.max = fmax(s.max, value[i]);
    if (n) s.median = ff_order_median(value, n);
    return n ? s : (channel_summary){NAN, NAN, NAN};
}

static void summary_free(table_summary *s)
{
    ff_survey_clear(&s->survey);
    free(s->channel);
}

static ff_status summarise(const ff_table *t, table_summary *s)
{
    ff_status status = ff_survey_init(t, &s->survey, NULL);
    if (status != FF_OK) return status;
    double *value = malloc((t->n ? t->n : 1) * sizeof *value);
    s->channel = malloc(t->n_channels * sizeof *s->channel);
    if (!value || !s->channel) {
        free(value);
        summary_free(s);
        return FF_ERR_MEMORY;
    }
    for (size_t c = 0; c < t->n_channels; c++) s->channel[c] = summary_of(t, c, value);
    free(value);
    return FF_OK;
}

static const char *quantity_meaning(ff_quantity q)
{
    return q == FF_BRDF       ? "BRDF, 1/sr, without the cosine"
           : q == FF_BRDF_COS ? "BRDF times cos(theta_o); converted to BRDF on reading"
                              : "reflectance factor (pi times the BRDF); converted to BRDF on reading";
}

static void put_range(FILE *out, const char *what, const double range[2])
{
    char a[FF_TEXT_NUMBER], b[FF_TEXT_NUMBER];
    fprintf(out, "%s %s to %s degrees\n", what, ff_text_number(range[0], 6, a), ff_text_number(range[1], 6, b));
}

static const char *axes_name(ff_axes_kind kind)
{
    return kind == FF_AXES_HALF_DIFFERENCE ? "theta_h x phi_h x theta_d x phi_d"
           : kind == FF_AXES_INCIDENT_EXIT ? "theta_i x phi_i x theta_o x phi_o"
           : kind == FF_AXES_SPECULAR      ? "rotation x incidence x azimuth x angle from the mirror direction"
                                           : "";
}

static void put_structure(const ff_table *t, FILE *out)
{
    const size_t *n = t->axes.n;
    if (t->grid) fprintf(out, "grid       %s\n", t->grid->name);
    if (t->axes.kind) fprintf(out, "grid       %zu x %zu x %zu x %zu, %s\n", n[0], n[1], n[2], n[3], axes_name(t->axes.kind));
    if (!t->grid && !t->axes.kind) fprintf(out, "grid       none: a list of pairs of directions\n");
}

/* ---- coverage and symmetry ------------------------------------------------------------------- */

static char azimuth_sign(unsigned n)
{
    return n == 0 ? ' ' : n < 3 ? '.' : n < 6 ? ':' : n < 10 ? 'o' : n < FF_SURVEY_AZIMUTHS ? 'O' : '#';
}

static void put_coverage(const ff_survey *s, FILE *out)
{
    fprintf(out, "\nazimuths met, by theta_i (down) and theta_o (across): . few of |phi_o - phi_i|, : o O more, # all\n"
                 "         0     15    30    45    60    75    90\n");
    for (int i = 0; i < FF_SURVEY_ROWS; i++) {
        fprintf(out, "  %2d-%2d  |", 10 * i, 10 * i + 10);
        for (int o = 0; o < FF_SURVEY_COLUMNS; o++) {
            const char sign = azimuth_sign(s->azimuths[i][o]);
            fprintf(out, "%c%c", sign, sign);
        }
        fprintf(out, "|\n");
    }
    fprintf(out, "half vectors within 1, 2, 5, 10 degrees of the normal: %zu, %zu, %zu, %zu samples\n", s->near_mirror[0],
            s->near_mirror[1], s->near_mirror[2], s->near_mirror[3]);
    if (s->in_plane) fprintf(out, "all samples lie in the plane of incidence: beside it nothing was measured\n");
}

/* Up to 80 degrees, as fits have it unless they are told otherwise. */
static const double looked_at = 80 * 3.14159265358979323846 / 180;

/* At which incidences the brightest sample lies on which side. */
static ff_status put_brightest(const ff_table *t, FILE *out)
{
    ff_brightest b;
    char number[FF_TEXT_NUMBER];
    const ff_status status = ff_brightest_find(t, looked_at, &b);
    if (status != FF_OK) return status;
    for (int side = FF_SIDE_MIRROR; side < FF_SIDES; side++) {
        if (b.count[side] == 0) continue;
        const char *separator = "";
        fprintf(out, "brightest samples %s at theta_i ", ff_words_side((ff_side)side));
        for (int row = 0; row < FF_BRIGHTEST_ROWS; row++) {
            if ((int)b.side[row] != side) continue;
            fprintf(out, "%s%s", separator, ff_text_number(b.theta_i[row], 3, number));
            separator = ", ";
        }
        fprintf(out, " degrees\n");
    }
    if (ff_brightest_odd(&b) == FF_SIDE_ACROSS) fprintf(out, "  %s\n", ff_words_side_hint(FF_SIDE_ACROSS));
    return FF_OK;
}

/* What the data say of their angles and values, with the flag that mends it. */
static ff_status put_geometry(const ff_table *t, FILE *out)
{
    ff_diagnosis g;
    char text[FF_WORDS_SENTENCE];
    const ff_status status = ff_diagnosis_find(t, looked_at, &g);
    for (size_t k = 0; status == FF_OK && k < g.n; k++) /* a cosine is said where reciprocity is */
        if (g.finding[k].kind != FF_DIAGNOSIS_COSINE && g.finding[k].kind != FF_DIAGNOSIS_NO_COSINE)
            fprintf(out, "warning: %s\n", ff_words_finding(&g.finding[k], text));
    return status;
}

const char *ff_report_percent(double deviation, char *out)
{
    const double x = 100 * expm1(deviation);
    return x < 100 ? ff_text_number(x, 2, out) : ff_text_fixed(x, 0, out);
}

static void put_symmetry(const char *name, const char *what, const ff_symmetry *s, FILE *out)
{
    char a[FF_TEXT_NUMBER], b[FF_TEXT_NUMBER];
    if (s->given) {
        fprintf(out, "%s given by the parametrisation\n", name);
    } else if (s->pairs == 0) {
        fprintf(out, "%s not to be told: no pairs of samples to compare\n", name);
    } else {
        fprintf(out, "%s %s differ by %s %% (median of %zu pairs", name, what, ff_report_percent(s->deviation, a), s->pairs);
        if (isfinite(s->interpolation)) fprintf(out, "; interpolation alone: %s %%", ff_report_percent(s->interpolation, b));
        fprintf(out, ")\n");
    }
}

static void put_cosine(const ff_survey *s, FILE *out)
{
    char a[FF_TEXT_NUMBER], b[FF_TEXT_NUMBER];
    const int cosine = ff_survey_cosine(s);
    if (cosine > 0)
        fprintf(
            out,
            "warning: is a cosine counted in the values? Taken as f cos(theta_o) they differ from reciprocity by %s %%, as they "
            "are by %s %%; if so, say --quantity brdf-cos\n",
            ff_report_percent(s->with_cosine, a), ff_report_percent(s->reciprocity.deviation, b));
    if (cosine < 0)
        fprintf(
            out,
            "warning: was a cosine divided out that was not there? Multiplied by it the values differ from reciprocity by %s %%, "
            "as they are by %s %%; if so, say --quantity brdf\n",
            ff_report_percent(s->without_cosine, a), ff_report_percent(s->reciprocity.deviation, b));
}

enum { SHOWN = 6 };

typedef struct reflectances {
    const ff_table *t;
    const ff_survey *s;
} reflectances;

/* The k-th of the channels that are shown, the first and the last among them. */
static size_t channel_shown(const ff_table *t, size_t k)
{
    const size_t shown = t->n_channels < SHOWN ? t->n_channels : SHOWN;
    return k * (t->n_channels - 1) / (shown > 1 ? shown - 1 : 1);
}

static const ff_reflectance *reflectance_at(ff_where w)
{
    return &((const reflectances *)w.of)->s->reflectance[w.row];
}

static void theta_cell(ff_cell *out, ff_where w)
{
    ff_cell_number(out, reflectance_at(w)->theta_i, 4);
}

static void phi_cell(ff_cell *out, ff_where w)
{
    const size_t n = ((const reflectances *)w.of)->s->azimuths_of[w.row];
    if (n > 1)
        ff_cell_text(out, "mean of %zu", n);
    else
        ff_cell_number(out, reflectance_at(w)->phi_i, 4);
}

static void over_azimuths_cell(ff_cell *out, ff_where w)
{
    const ff_survey *s = ((const reflectances *)w.of)->s;
    char a[FF_TEXT_NUMBER], b[FF_TEXT_NUMBER];
    const double *range = s->over_azimuths[w.row];
    if (s->azimuths_of[w.row] > 1)
        ff_cell_text(out, "%s to %s", ff_text_number(range[0], 3, a), ff_text_number(range[1], 3, b));
    else
        ff_cell_text(out, "%s", "");
}

static void covered_cell(ff_cell *out, ff_where w)
{
    ff_cell_text(out, "%.0f %%", 100 * reflectance_at(w)->covered);
}

/* index: the channel; raised: of values whose negative ones count as 0. */
static void put_reflectance(ff_cell *out, ff_where w, const double *albedo)
{
    const double value = albedo[w.row * ((const reflectances *)w.of)->t->n_channels + w.index];
    ff_cell_number(out, value, 3);
    if (isnan(value)) ff_cell_rounded(out, NAN, "-");
}

static void reflectance_cell(ff_cell *out, ff_where w)
{
    put_reflectance(out, w, ((const reflectances *)w.of)->s->albedo);
}

static void raised_cell(ff_cell *out, ff_where w)
{
    put_reflectance(out, w, ((const reflectances *)w.of)->s->albedo_raised);
}

static void warn_of_reflectance(const ff_table *t, const ff_survey *s, FILE *out)
{
    double largest = 0, at = 0;
    char n[FF_TEXT_NUMBER], m[FF_TEXT_NUMBER];
    for (size_t k = 0; k < s->n_reflectances; k++)
        for (size_t c = 0; c < t->n_channels; c++)
            if (s->albedo[k * t->n_channels + c] > largest) {
                largest = s->albedo[k * t->n_channels + c];
                at = s->reflectance[k].theta_i;
            }
    if (largest > 1)
        fprintf(
            out,
            "warning: the reflectance of %s at %s degrees is above 1: a peak between too few samples, another unit than 1/sr, or a "
            "cosine or a factor pi counted\n",
            ff_text_number(largest, 4, n), ff_text_number(at, 4, m));
}

/* Whether negative values change a reflectance by more than is to be noticed. */
static int negatives_matter(const ff_table *t, const ff_survey *s)
{
    for (size_t k = 0; k < s->n_reflectances * t->n_channels; k++)
        if (s->albedo_raised[k] - s->albedo[k] > 0.002) return 1;
    return 0;
}

static ff_status put_reflectance_table(const reflectances *of, void (*cell)(ff_cell *, ff_where), const ff_report_style *style,
                                       FILE *out)
{
    ff_column column[4 + SHOWN] = {{.head = "theta_i", .align = FF_RIGHT, .cell = theta_cell}};
    size_t n = 1;
    int several = 0;
    for (size_t k = 0; k < of->s->n_reflectances; k++) several |= of->s->azimuths_of[k] > 1;
    if (!of->t->isotropic) column[n++] = (ff_column){.head = "phi_i", .align = FF_RIGHT, .cell = phi_cell};
    column[n++] = (ff_column){.head = "covered", .align = FF_RIGHT, .cell = covered_cell};
    for (size_t k = 0; k < SHOWN && k < of->t->n_channels; k++) {
        const size_t c = channel_shown(of->t, k);
        column[n++] =
            (ff_column){.head = of->t->channels[c].name, .align = FF_RIGHT, .cell = cell, .index = c, .drop = (unsigned)(k + 2)};
    }
    if (several && cell == reflectance_cell)
        column[n++] = (ff_column){.head = of->t->n_channels > 1 ? "mean of channels, by phi_i" : "by phi_i",
                                  .align = FF_RIGHT,
                                  .cell = over_azimuths_cell,
                                  .drop = 1};
    return ff_columns_print(column, n, of, of->s->n_reflectances, FF_TABLE_TEXT, "  ", style, out);
}

static ff_status put_reflectances(const ff_table *t, const ff_survey *s, const ff_report_style *style, FILE *out)
{
    const reflectances of = {t, s};
    if (s->n_reflectances == 0) return FF_OK;
    if (s->in_plane) {
        fprintf(out, "\nreflectance into the hemisphere: not known, since nothing was measured beside the plane of incidence\n");
        return FF_OK;
    }
    fprintf(out, "\nreflectance into the covered part of the hemisphere (%s)\n", s->method);
    ff_status status = put_reflectance_table(&of, reflectance_cell, style, out);
    if (status == FF_OK && negatives_matter(t, s)) {
        fprintf(out, "the same with negative values as 0, as renderers take them\n");
        status = put_reflectance_table(&of, raised_cell, style, out);
    }
    if (status == FF_OK) warn_of_reflectance(t, s, out);
    return status;
}

/* ---- channels -------------------------------------------------------------------------------- */

typedef struct channels {
    const ff_table *t;
    const table_summary *s;
} channels;

static void channel_cell(ff_cell *out, ff_where w)
{
    ff_cell_text(out, "%s", ((const channels *)w.of)->t->channels[w.row].name);
}

static void wavelength_cell(ff_cell *out, ff_where w)
{
    const double nm = ((const channels *)w.of)->t->channels[w.row].wavelength_nm;
    ff_cell_number(out, isfinite(nm) ? nm : NAN, 6);
    if (!isfinite(nm)) ff_cell_rounded(out, NAN, "-");
}

enum { LEAST, MEDIAN, MOST };
static void summary_cell(ff_cell *out, ff_where w)
{
    const channel_summary *c = &((const channels *)w.of)->s->channel[w.row];
    ff_cell_number(out, w.index == LEAST ? c->min : w.index == MEDIAN ? c->median : c->max, 5);
}

static const ff_column channel_columns[] = {
    {.head = "channel", .cell = channel_cell, .least = 10},
    {.head = "wavelength/nm", .key = "wavelength_nm", .align = FF_RIGHT, .cell = wavelength_cell},
    {.head = "min/(1/sr)", .key = "min", .align = FF_RIGHT, .cell = summary_cell, .index = LEAST},
    {.head = "median", .align = FF_RIGHT, .cell = summary_cell, .index = MEDIAN},
    {.head = "max", .align = FF_RIGHT, .cell = summary_cell, .index = MOST}};

static ff_status put_channels(const ff_table *t, const table_summary *s, ff_table_form form, const char *indent,
                              const ff_report_style *style, FILE *out)
{
    const channels of = {t, s};
    return ff_columns_print(channel_columns, FF_COUNT(channel_columns), &of, t->n_channels, form, indent, style, out);
}

ff_status ff_report_samples_text(const ff_table *t, size_t most, FILE *out)
{
    enum { CHANNELS = 6 };
    const size_t n = ff_table_there(t, 0, most), channels = t->n_channels < CHANNELS ? t->n_channels : CHANNELS;
    fprintf(out, "\nthe first samples as they are understood, in degrees and 1/sr\n  theta_i,phi_i,theta_o,phi_o");
    for (size_t c = 0; c < channels; c++) {
        fputc(',', out);
        ff_text_print(t->channels[c].name, out);
    }
    fputs(channels < t->n_channels ? ",...\n" : "\n", out);
    for (size_t i = 0; i < n; i++) {
        double angle[4], *const planes[4] = {angle, angle + 1, angle + 2, angle + 3};
        char text[FF_TEXT_NUMBER];
        ff_table_angles(t, 3.14159265358979323846 / 180, i, 1, planes);
        for (int k = 0; k < 4; k++) fprintf(out, "%s%s", k ? "," : "  ", ff_text_number(angle[k], 6, text));
        for (size_t c = 0; c < channels; c++) {
            double v;
            ff_table_values(t, c, i, 1, &v);
            fprintf(out, ",%s", t->valid[i] ? ff_text_number(v, 6, text) : "");
        }
        fputc('\n', out);
    }
    return FF_OK;
}

void ff_report_put_notes(const ff_table *t, FILE *out)
{
    char text[FF_WORDS_SENTENCE];
    for (size_t k = 0; ff_words_note(t, k, text); k++) {
        fputs("note: ", out);
        ff_text_print(text, out);
        fputc('\n', out);
    }
}

ff_status ff_report_table_text(const char *path, const ff_table *t, const ff_report_style *style, FILE *out)
{
    table_summary s;
    ff_status status = summarise(t, &s);
    if (status != FF_OK) return status;
    ff_text_print(path, out);
    fprintf(out, ": %s\n", t->format);
    fprintf(out, "samples    %zu", t->n);
    if (t->n_invalid > 0) fprintf(out, ", %zu marked invalid", t->n_invalid);
    if (s.survey.below_horizon > 0) fprintf(out, ", %zu below the horizon", s.survey.below_horizon);
    if (t->n_negative > 0) fprintf(out, ", %zu with a negative value", t->n_negative);
    fprintf(out, "\nquantity   %s\n", quantity_meaning(t->quantity));
    fprintf(out, "azimuth    %s\n", t->isotropic ? "isotropic parametrisation: only azimuth differences" : "both azimuths");
    put_structure(t, out);
    put_range(out, "theta_i   ", s.survey.theta_i);
    put_range(out, "theta_o   ", s.survey.theta_o);
    fprintf(out, "weights    %s\n",
            ff_table_has_weights(t) ? "solid angle"
            : t->sigma              ? "sigma"
                                    : "none: every sample counts the same");
    if (t->sigma) fprintf(out, "sigma      every value has a standard deviation\n");
    fputc('\n', out);
    status = put_channels(t, &s, FF_TABLE_TEXT, "  ", style, out);
    put_coverage(&s.survey, out);
    if (status == FF_OK) status = put_brightest(t, out);
    if (status == FF_OK) status = put_geometry(t, out);
    if (status == FF_OK) status = put_reflectances(t, &s.survey, style, out);
    fputc('\n', out);
    if (s.survey.every > 1) fprintf(out, "from one sample in %zu:\n", s.survey.every);
    put_symmetry("isotropy  ", "values turned about the normal", &s.survey.isotropy, out);
    put_symmetry("reciprocity", "values with light and detector exchanged", &s.survey.reciprocity, out);
    put_cosine(&s.survey, out);
    if (t->note[0]) fputc('\n', out);
    ff_report_put_notes(t, out);
    summary_free(&s);
    return status;
}

ff_status ff_report_channels_table(const ff_table *t, ff_table_form form, FILE *out)
{
    table_summary s;
    ff_status status = summarise(t, &s);
    if (status != FF_OK) return status;
    status = put_channels(t, &s, form, "", NULL, out);
    summary_free(&s);
    return status;
}

static void range_json(ff_json *j, const char *key, const double range[2])
{
    ff_json_array(j, key, FF_JSON_LINE);
    ff_json_number(j, NULL, range[0]);
    ff_json_number(j, NULL, range[1]);
    ff_json_close(j);
}

static void symmetry_json(ff_json *j, const char *key, const ff_symmetry *s)
{
    ff_json_object(j, key, FF_JSON_LINE);
    ff_json_bool(j, "by_parametrisation", s->given);
    ff_json_integer(j, "pairs", (int64_t)s->pairs);
    ff_json_number(j, "deviation", expm1(s->deviation));
    ff_json_number(j, "interpolation", expm1(s->interpolation));
    ff_json_close(j);
}

static void structure_json(ff_json *j, const ff_table *t)
{
    ff_json_string(j, "parametrisation", t->grid ? t->grid->name : t->axes.kind ? axes_name(t->axes.kind) : "scattered");
    ff_json_array(j, "axes", FF_JSON_LINE);
    for (int k = 0; k < 4 && t->axes.kind; k++) ff_json_integer(j, NULL, (int64_t)t->axes.n[k]);
    ff_json_close(j);
}

static void survey_json(ff_json *j, const ff_table *t, const ff_survey *s)
{
    ff_json_array(j, "near_mirror", FF_JSON_LINE);
    for (int k = 0; k < 4; k++) ff_json_integer(j, NULL, (int64_t)s->near_mirror[k]);
    ff_json_close(j);
    ff_json_array(j, "azimuths_met", FF_JSON_BLOCK);
    for (int i = 0; i < FF_SURVEY_ROWS; i++) {
        ff_json_array(j, NULL, FF_JSON_LINE);
        for (int o = 0; o < FF_SURVEY_COLUMNS; o++) ff_json_integer(j, NULL, s->azimuths[i][o]);
        ff_json_close(j);
    }
    ff_json_close(j);
    ff_json_bool(j, "in_plane", s->in_plane);
    ff_json_integer(j, "surveyed_every", (int64_t)s->every);
    symmetry_json(j, "isotropy", &s->isotropy);
    symmetry_json(j, "reciprocity", &s->reciprocity);
    ff_json_number(j, "reciprocity_if_cosine_counted", expm1(s->with_cosine));
    ff_json_number(j, "reciprocity_if_cosine_missing", expm1(s->without_cosine));
    ff_json_integer(j, "cosine_hint", ff_survey_cosine(s));
    ff_json_array(j, "reflectance", FF_JSON_BLOCK);
    for (size_t k = 0; k < s->n_reflectances; k++) {
        ff_json_object(j, NULL, FF_JSON_LINE);
        ff_json_number(j, "theta_i_deg", s->reflectance[k].theta_i);
        ff_json_number(j, "phi_i_deg", s->reflectance[k].phi_i);
        ff_json_number(j, "covered", s->reflectance[k].covered);
        ff_json_array(j, "value", FF_JSON_LINE);
        for (size_t c = 0; c < t->n_channels; c++) ff_json_number(j, NULL, s->albedo[k * t->n_channels + c]);
        ff_json_close(j);
        ff_json_array(j, "negative_as_zero", FF_JSON_LINE);
        for (size_t c = 0; c < t->n_channels; c++) ff_json_number(j, NULL, s->albedo_raised[k * t->n_channels + c]);
        ff_json_close(j);
        ff_json_integer(j, "azimuths", (int64_t)s->azimuths_of[k]);
        range_json(j, "over_azimuths", s->over_azimuths[k]);
        ff_json_close(j);
    }
    ff_json_close(j);
}

static void brightest_json(ff_json *j, const ff_brightest *b)
{
    static const char *const name[FF_SIDES] = {"none", "mirror", "light", "across"};
    const ff_side odd = ff_brightest_odd(b);
    ff_json_object(j, "brightest", FF_JSON_BLOCK);
    ff_json_array(j, "incidences", FF_JSON_BLOCK);
    for (int row = 0; row < FF_BRIGHTEST_ROWS; row++) {
        if (!isfinite(b->theta_i[row])) continue;
        ff_json_object(j, NULL, FF_JSON_LINE);
        ff_json_number(j, "theta_i_deg", b->theta_i[row]);
        ff_json_string(j, "side", name[b->side[row]]);
        ff_json_close(j);
    }
    ff_json_close(j);
    ff_json_string(j, "odd", name[odd]);
    ff_json_string(j, "hint", ff_words_side_hint(odd));
    ff_json_close(j);
}

static void geometry_json(ff_json *j, const ff_diagnosis *g)
{
    char text[FF_WORDS_SENTENCE], value[32];
    ff_json_object(j, "geometry", FF_JSON_BLOCK);
    ff_json_bool(j, "open", g->open);
    ff_json_array(j, "findings", FF_JSON_BLOCK);
    for (size_t k = 0; k < g->n; k++) {
        const char *option = ff_diagnosis_option(&g->finding[k], value);
        ff_json_object(j, NULL, FF_JSON_BLOCK);
        ff_json_string(j, "kind", ff_words_finding_kind((int)g->finding[k].kind));
        ff_json_bool(j, "sure", g->finding[k].sure);
        ff_json_string(j, "option", option);
        ff_json_string(j, "value", option ? value : NULL);
        ff_json_string(j, "text", ff_words_finding(&g->finding[k], text));
        ff_json_close(j);
    }
    ff_json_close(j);
    ff_json_close(j);
}

void ff_report_notes_json(ff_json *j, const ff_table *t)
{
    char text[FF_WORDS_SENTENCE];
    ff_json_array(j, "notes", FF_JSON_BLOCK);
    for (size_t k = 0; ff_words_note(t, k, text); k++) ff_json_string(j, NULL, text);
    ff_json_close(j);
}

ff_status ff_report_table_json(const ff_report_head *head, const char *path, const ff_table *t, FILE *out)
{
    table_summary s;
    ff_json j;
    ff_brightest brightest;
    ff_diagnosis geometry;
    ff_status status = summarise(t, &s);
    if (status != FF_OK) return status;
    status = ff_brightest_find(t, looked_at, &brightest);
    if (status == FF_OK) status = ff_diagnosis_find(t, looked_at, &geometry);
    if (status != FF_OK) {
        summary_free(&s);
        return status;
    }
    ff_json_begin(&j, out);
    ff_json_object(&j, NULL, FF_JSON_BLOCK);
    ff_report_head_json(&j, FF_SCHEMA_INFO, head);
    ff_json_string(&j, "path", path);
    ff_json_string(&j, "format", t->format);
    ff_json_integer(&j, "samples", (int64_t)t->n);
    ff_json_integer(&j, "invalid", (int64_t)t->n_invalid);
    ff_json_integer(&j, "below_horizon", (int64_t)s.survey.below_horizon);
    ff_json_integer(&j, "negative", (int64_t)t->n_negative);
    ff_json_string(&j, "quantity", ff_quantity_name((int)t->quantity));
    ff_json_bool(&j, "isotropic", t->isotropic);
    structure_json(&j, t);
    range_json(&j, "theta_i_deg", s.survey.theta_i);
    range_json(&j, "theta_o_deg", s.survey.theta_o);
    ff_json_bool(&j, "solid_angle_weights", ff_table_has_weights(t));
    ff_json_bool(&j, "sigma", t->sigma != NULL);
    ff_json_array(&j, "channels", FF_JSON_BLOCK);
    for (size_t c = 0; c < t->n_channels; c++) {
        ff_json_object(&j, NULL, FF_JSON_LINE);
        ff_json_string(&j, "name", t->channels[c].name);
        ff_json_number(&j, "wavelength_nm", t->channels[c].wavelength_nm);
        ff_json_number(&j, "min", s.channel[c].min);
        ff_json_number(&j, "median", s.channel[c].median);
        ff_json_number(&j, "max", s.channel[c].max);
        ff_json_close(&j);
    }
    ff_json_close(&j);
    survey_json(&j, t, &s.survey);
    brightest_json(&j, &brightest);
    geometry_json(&j, &geometry);
    ff_report_notes_json(&j, t);
    ff_json_close(&j);
    ff_json_end(&j);
    summary_free(&s);
    return FF_OK;
}
