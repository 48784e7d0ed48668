/* What a conversion to the directions of another format did. */
#include "internal_report.h"
#include "internal_columns.h"
#include <math.h>
#include <string.h>

static void put_prediction(const char *how, const ff_prediction *p, FILE *out)
{
    char a[FF_TEXT_NUMBER], b[FF_TEXT_NUMBER], c[FF_TEXT_NUMBER];
    if (p->n == 0) return;
    fprintf(out, "its error     %s: %s %% in the median, %s %% at 95 %%, %s %% at most\n", how, ff_report_percent(p->median, a),
            ff_report_percent(p->most, b), ff_report_percent(p->largest, c));
}

/* What was not measured, and that no error can be stated for it. */
static void put_beyond(const ff_resample_report *r, FILE *out)
{
    if (r->beyond == 0) return;
    const char *where = r->in_plane ? "beyond the data, which lie in the plane of incidence" : "beyond the data";
    if (r->invalid > r->below_horizon)
        fprintf(out, "extrapolated  %zu %s, marked as not measured\n", r->beyond, where);
    else
        fprintf(out, "extrapolated  %zu %s, %s; their error is not known\n", r->beyond, where,
                r->in_plane ? "with the value of a half vector in it that leans as far" : "with the nearest value");
}

static void prediction_json(ff_json *j, const char *key, const ff_prediction *p)
{
    ff_json_object(j, key, FF_JSON_LINE);
    ff_json_integer(j, "samples", (int64_t)p->n);
    ff_json_number(j, "median", expm1(p->median));
    ff_json_number(j, "percentile_95", expm1(p->most));
    ff_json_number(j, "largest", expm1(p->largest));
    ff_json_close(j);
}

static void energy_json(ff_json *j, const ff_resample_report *r)
{
    ff_json_object(j, "energy", FF_JSON_LINE);
    ff_json_integer(j, "incidences", (int64_t)r->incidences);
    ff_json_integer(j, "missed", (int64_t)r->missed);
    ff_json_number(j, "lost", r->lost);
    ff_json_number(j, "lost_most", r->lost_most);
    ff_json_number(j, "lost_most_theta_i_deg", r->lost_at);
    ff_json_close(j);
}

static const char *lost_or_gained(double lost)
{
    return lost < 0 ? "gained" : "lost";
}

/* A share of the energy in percent, without its sign. */
static const char *share(double lost, char out[FF_TEXT_NUMBER])
{
    const double x = 100 * fabs(lost);
    return x < 10 ? ff_text_number(x, 2, out) : ff_text_fixed(x, 0, out);
}

static void put_energy(const ff_resample_report *r, FILE *out)
{
    char all[FF_TEXT_NUMBER], most[FF_TEXT_NUMBER], at[FF_TEXT_NUMBER];
    if (r->missed)
        fprintf(out, "energy        of %zu incidence%s of the data that were looked at the result has nothing\n", r->missed,
                r->missed > 1 ? "s" : "");
    if (r->incidences == 0) return;
    share(r->lost, all), share(r->lost_most, most);
    ff_text_number(r->lost_at, 4, at);
    fprintf(out, "energy        %s %% %s over %zu incidences, %s %% %s at %s degrees, where it is most\n", all,
            lost_or_gained(r->lost), r->incidences, most, lost_or_gained(r->lost_most), at);
}

void ff_report_resample_warning(const ff_resample_report *r, char out[FF_WORDS_SENTENCE])
{
    char most[FF_TEXT_NUMBER], at[FF_TEXT_NUMBER];
    out[0] = '\0';
    if (!(fabs(r->lost_most) > FF_RESAMPLE_LOSS)) return;
    const char *how = r->as_it_is ? "the data are means over cells, and what is interpolated between the centres of these loses or "
                                    "invents peaks; a format with a grid (zemax, rgl) keeps it better"
                                  : "a finer --grid, or a format that takes the directions as they are, keeps it better";
    snprintf(out, FF_WORDS_SENTENCE, "at theta_i = %s degrees the result has %s %% %s reflected energy than the data: %s",
             ff_text_number(r->lost_at, 4, at), share(r->lost_most, most), r->lost_most < 0 ? "more" : "less", how);
}

ff_status ff_report_resample_text(const char *in, const char *out_path, const ff_format *to, const ff_table *t,
                                  const ff_table *made, const ff_resample_report *r, FILE *out)
{
    ff_text_print(in, out);
    fprintf(out, ": %s, %zu samples -> ", t->format, t->n);
    ff_text_print(out_path, out);
    fprintf(out, ": %s, %zu samples\n", to->name, made->n);
    if (r->as_it_is) {
        fprintf(out, "directions    as they were, nothing interpolated\n");
    } else {
        fprintf(out, "interpolation %s\n", r->method);
        fprintf(out, "at a sample   %zu\ninterpolated  %zu\n", r->at_sample, r->between);
        if (r->reciprocal)
            fprintf(out, "exchanged     %zu, where only light and detector exchanged were measured\n", r->reciprocal);
        put_beyond(r, out);
        if (r->below_horizon) fprintf(out, "below horizon %zu, marked as not measured\n", r->below_horizon);
        put_prediction("each sample predicted from the others", &r->near, out);
        put_prediction("from the incidences on both sides, twice as far apart", &r->across, out);
        if (r->across.n == 0 && strstr(r->method, "between incidences"))
            fprintf(out, "its error     between incidences: not known, no incidence can be predicted from those on both sides\n");
    }
    put_energy(r, out);
    char warning[FF_WORDS_SENTENCE];
    ff_report_resample_warning(r, warning);
    if (warning[0]) fprintf(out, "warning: %s\n", warning);
    ff_report_put_notes(made, out);
    return FF_OK;
}

ff_status ff_report_resample_json(const ff_report_head *head, const char *in, const char *out_path, const ff_format *to,
                                  const ff_table *t, const ff_table *made, const ff_resample_report *r, FILE *out)
{
    ff_json j;
    ff_json_begin(&j, out);
    ff_json_object(&j, NULL, FF_JSON_BLOCK);
    ff_report_head_json(&j, FF_SCHEMA_RESAMPLE, head);
    ff_json_string(&j, "from", in);
    ff_json_string(&j, "from_format", t->format);
    ff_json_integer(&j, "from_samples", (int64_t)t->n);
    ff_json_string(&j, "to", out_path);
    ff_json_string(&j, "to_format", to->name);
    ff_json_integer(&j, "samples", (int64_t)r->n);
    ff_json_bool(&j, "interpolated", !r->as_it_is);
    ff_json_string(&j, "method", r->method);
    ff_json_integer(&j, "at_sample", (int64_t)r->at_sample);
    ff_json_integer(&j, "between", (int64_t)r->between);
    ff_json_integer(&j, "reciprocal", (int64_t)r->reciprocal);
    ff_json_integer(&j, "beyond", (int64_t)r->beyond);
    ff_json_bool(&j, "in_plane", r->in_plane);
    ff_json_integer(&j, "below_horizon", (int64_t)r->below_horizon);
    prediction_json(&j, "error_at_incidence", &r->near);
    prediction_json(&j, "error_between_incidences", &r->across);
    energy_json(&j, r);
    ff_json_integer(&j, "invalid", (int64_t)r->invalid);
    ff_json_integer(&j, "negative_raised", (int64_t)r->raised);
    char warning[FF_WORDS_SENTENCE];
    ff_report_resample_warning(r, warning);
    ff_json_array(&j, "warnings", FF_JSON_BLOCK);
    if (warning[0]) ff_json_string(&j, NULL, warning);
    ff_json_close(&j);
    ff_report_notes_json(&j, made);
    ff_json_close(&j);
    ff_json_end(&j);
    return FF_OK;
}
