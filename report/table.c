/* What is in a file. */
#include "internal_report.h"
#include "internal_text.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { BLOCK = 1024 };

typedef struct range {
    double lo, hi;
} range;

typedef struct channel_summary {
    double min, median, max;
} channel_summary;

typedef struct table_summary {
    range theta_i, theta_o;   /* degrees, of the valid samples above the horizon; NaN when there is none */
    size_t below_horizon;     /* of the valid ones */
    channel_summary *channel; /* [n_channels] */
} table_summary;

static void widen(range *r, double x)
{
    if (!(r->lo <= x)) r->lo = x;
    if (!(r->hi >= x)) r->hi = x;
}

static double theta_degrees(double x, double y, double z)
{
    return ff_report_degrees(atan2(hypot(x, y), z));
}

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void summarise_angles(const ff_table *t, table_summary *s)
{
    double plane[6][BLOCK], *const planes[6] = {plane[0], plane[1], plane[2], plane[3], plane[4], plane[5]};
    s->theta_i = s->theta_o = (range){NAN, NAN};
    s->below_horizon = 0;
    for (size_t first = 0; first < t->n; first += BLOCK) {
        const size_t n = t->n - first < BLOCK ? t->n - first : BLOCK;
        ff_table_directions(t, first, n, planes);
        for (size_t i = 0; i < n; ++i) {
            if (!t->valid[first + i]) continue;
            if (plane[2][i] <= FF_COS_MIN || plane[5][i] <= FF_COS_MIN) {
                s->below_horizon++;
                continue;
            }
            widen(&s->theta_i, theta_degrees(plane[0][i], plane[1][i], plane[2][i]));
            widen(&s->theta_o, theta_degrees(plane[3][i], plane[4][i], plane[5][i]));
        }
    }
}

/* Finite values of the valid samples of channel c, sorted in `value` [n]; their count. */
static size_t sorted_values(const ff_table *t, size_t c, double *value)
{
    size_t n = 0;
    ff_table_values(t, c, 0, t->n, value);
    for (size_t i = 0; i < t->n; ++i)
        if (t->valid[i] && isfinite(value[i])) value[n++] = value[i];
    qsort(value, n, sizeof *value, ascending);
    return n;
}

static ff_status summarise(const ff_table *t, table_summary *s)
{
    double *value = malloc((t->n ? t->n : 1) * sizeof *value);
    s->channel = malloc(t->n_channels * sizeof *s->channel);
    if (!value || !s->channel) {
        free(value);
        free(s->channel);
        return FF_ERR_MEMORY;
    }
    summarise_angles(t, s);
    for (size_t c = 0; c < t->n_channels; ++c) {
        const size_t n = sorted_values(t, c, value);
        s->channel[c] = n ? (channel_summary){value[0], (value[(n - 1) / 2] + value[n / 2]) / 2, value[n - 1]}
                          : (channel_summary){NAN, NAN, NAN};
    }
    free(value);
    return FF_OK;
}

static const char *quantity_name(ff_quantity q)
{
    return q == FF_BRDF ? "brdf" : q == FF_BRDF_COS ? "brdf-cos" : "reflectance-factor";
}

static const char *quantity_meaning(ff_quantity q)
{
    return q == FF_BRDF       ? "BRDF, 1/sr, without the cosine"
           : q == FF_BRDF_COS ? "BRDF times cos(theta_o); converted to BRDF on reading"
                              : "reflectance factor (pi times the BRDF); converted to BRDF on reading";
}

static void put_range(FILE *out, const char *what, range r)
{
    char a[FF_TEXT_NUMBER], b[FF_TEXT_NUMBER];
    fprintf(out, "%s %s to %s degrees\n", what, ff_text_number(r.lo, 6, a), ff_text_number(r.hi, 6, b));
}

static ff_status put_channels(const ff_table *t, const table_summary *s, FILE *out)
{
    ff_text_table rows = {.right = {0, 1, 1, 1, 1}};
    char n[FF_TEXT_NUMBER];
    ff_text_row(&rows);
    ff_text_cell(&rows, "channel");
    ff_text_cell(&rows, "wavelength/nm");
    ff_text_cell(&rows, "min/(1/sr)");
    ff_text_cell(&rows, "median");
    ff_text_cell(&rows, "max");
    for (size_t c = 0; c < t->n_channels; ++c) {
        ff_text_row(&rows);
        ff_text_cell(&rows, "%s", t->channels[c].name);
        ff_text_cell(&rows, "%s",
                     isfinite(t->channels[c].wavelength_nm) ? ff_text_number(t->channels[c].wavelength_nm, 6, n) : "-");
        ff_text_cell(&rows, "%s", ff_text_number(s->channel[c].min, 5, n));
        ff_text_cell(&rows, "%s", ff_text_number(s->channel[c].median, 5, n));
        ff_text_cell(&rows, "%s", ff_text_number(s->channel[c].max, 5, n));
    }
    return ff_text_print(&rows, out, "  ");
}

static void put_notes(const char *note, FILE *out)
{
    while (*note) {
        const size_t n = strcspn(note, "\n");
        if (n > 0) fprintf(out, "note: %.*s\n", (int)n, note);
        note += n + (note[n] == '\n');
    }
}

ff_status ff_report_table_text(const char *path, const ff_table *t, FILE *out)
{
    table_summary s;
    ff_status status = summarise(t, &s);
    if (status != FF_OK) return status;
    fprintf(out, "%s: %s\n", path, t->format);
    fprintf(out, "samples    %zu", t->n);
    if (t->n_invalid > 0) fprintf(out, ", %zu marked invalid", t->n_invalid);
    if (s.below_horizon > 0) fprintf(out, ", %zu below the horizon", s.below_horizon);
    if (t->n_negative > 0) fprintf(out, ", %zu with a negative value", t->n_negative);
    fprintf(out, "\nquantity   %s\n", quantity_meaning(t->quantity));
    fprintf(out, "azimuth    %s\n", t->isotropic ? "isotropic parametrisation: only azimuth differences" : "both azimuths");
    put_range(out, "theta_i   ", s.theta_i);
    put_range(out, "theta_o   ", s.theta_o);
    fprintf(out, "weights    %s\n",
            ff_table_has_weights(t) ? "solid angle"
            : t->sigma              ? "sigma"
                                    : "none: every sample counts the same");
    if (t->sigma) fprintf(out, "sigma      every value has a standard deviation\n");
    fputc('\n', out);
    status = put_channels(t, &s, out);
    if (t->note[0]) fputc('\n', out);
    put_notes(t->note, out);
    free(s.channel);
    return status;
}

static void range_json(ff_json *j, const char *key, range r)
{
    ff_json_array(j, key, FF_JSON_LINE);
    ff_json_number(j, NULL, r.lo);
    ff_json_number(j, NULL, r.hi);
    ff_json_close(j);
}

static void notes_json(ff_json *j, const char *note)
{
    ff_json_array(j, "notes", FF_JSON_BLOCK);
    while (*note) {
        char line[sizeof((ff_table *)NULL)->note];
        const size_t n = strcspn(note, "\n");
        snprintf(line, sizeof line, "%.*s", (int)n, note);
        if (n > 0) ff_json_string(j, NULL, line);
        note += n + (note[n] == '\n');
    }
    ff_json_close(j);
}

ff_status ff_report_table_json(const ff_report_head *head, const char *path, const ff_table *t, FILE *out)
{
    table_summary s;
    ff_json j;
    const ff_status status = summarise(t, &s);
    if (status != FF_OK) return status;
    ff_json_begin(&j, out);
    ff_json_object(&j, NULL, FF_JSON_BLOCK);
    ff_report_head_json(&j, "facetfit.info/1", head);
    ff_json_string(&j, "path", path);
    ff_json_string(&j, "format", t->format);
    ff_json_integer(&j, "samples", (int64_t)t->n);
    ff_json_integer(&j, "invalid", (int64_t)t->n_invalid);
    ff_json_integer(&j, "below_horizon", (int64_t)s.below_horizon);
    ff_json_integer(&j, "negative", (int64_t)t->n_negative);
    ff_json_string(&j, "quantity", quantity_name(t->quantity));
    ff_json_bool(&j, "isotropic", t->isotropic);
    range_json(&j, "theta_i_deg", s.theta_i);
    range_json(&j, "theta_o_deg", s.theta_o);
    ff_json_bool(&j, "solid_angle_weights", ff_table_has_weights(t));
    ff_json_bool(&j, "sigma", t->sigma != NULL);
    ff_json_array(&j, "channels", FF_JSON_BLOCK);
    for (size_t c = 0; c < t->n_channels; ++c) {
        ff_json_object(&j, NULL, FF_JSON_LINE);
        ff_json_string(&j, "name", t->channels[c].name);
        ff_json_number(&j, "wavelength_nm", t->channels[c].wavelength_nm);
        ff_json_number(&j, "min", s.channel[c].min);
        ff_json_number(&j, "median", s.channel[c].median);
        ff_json_number(&j, "max", s.channel[c].max);
        ff_json_close(&j);
    }
    ff_json_close(&j);
    notes_json(&j, t->note);
    ff_json_close(&j);
    ff_json_end(&j);
    free(s.channel);
    return FF_OK;
}
