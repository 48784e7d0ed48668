/* A retrieved distribution of normals as people read it. */
#include "internal_fits_text.h"
#include <math.h>

/* At which angles D is known, and how well. */
static void put_known(const ff_ndf_result *r, FILE *out)
{
    char a[FF_TEXT_NUMBER], b[FF_TEXT_NUMBER], c[FF_TEXT_NUMBER];
    double first = NAN, last = NAN, least = INFINITY;
    for (size_t i = 0; i < r->n_rows; i++) {
        if (!r->row[i].known) continue;
        if (isnan(first)) first = r->row[i].theta;
        last = r->row[i].theta;
        least = fmin(least, r->row[i].d_error);
    }
    if (isnan(first))
        fprintf(out, "D is known at no angle: its standard error is above %.0f %% everywhere\n", 100 * FF_NDF_KNOWN);
    else
        fprintf(out, "D is known %s %s to %s degrees, to %s %% at best\n", last > r->sure ? "at some angles from" : "from",
                ff_text_number(ff_report_degrees(first), 3, a), ff_text_number(ff_report_degrees(last), 3, b),
                ff_text_number(100 * least, 2, c));
}

static void put_head(const ff_report_ndf *n, FILE *out)
{
    const ff_ndf_result *r = n->result;
    char a[FF_TEXT_NUMBER], b[FF_TEXT_NUMBER], c[FF_TEXT_NUMBER];
    ff_selection s;
    ff_problem_selection(n->problem, &s);
    ff_text_print(n->path, out);
    fprintf(out, ": %s, %zu samples, %zu used\n", n->table->format, s.samples, s.used);
    fprintf(out, "loss %s, weights by %s, masking %s\n", ff_loss_name((int)n->options->fit->loss),
            ff_weighting_name((int)s.weighting), ff_term_at(FF_MASKING, (size_t)n->options->masking)->name);
    if (r->from_back_scatter)
        fprintf(out, "start: power iteration over %zu samples that look back within %s degrees of the half vector, f0 %s\n",
                r->back_samples, ff_text_number(ff_report_degrees(r->back_angle), 3, a), ff_text_number(r->back_f0, 3, b));
    else
        fprintf(out, "start: the best parametric fit\n");
    fprintf(out, "%zu angles, half vectors from %s to %s degrees\n", r->n_nodes, ff_text_number(ff_report_degrees(r->first), 3, a),
            ff_text_number(ff_report_degrees(r->reach), 3, b));
    put_known(r, out);
    fprintf(out, "smooth %s%s: %s effective parameters, drawn to %s; %s after %d iterations, %s s\n\n",
            ff_text_number(r->smooth, 3, a), isnan(n->options->smooth) ? " by cross-validation" : "",
            ff_text_number(r->effective, 3, b), ff_term_at(FF_NDF, (size_t)r->fit[r->reference].model.lobe[0].ndf)->name,
            ff_outcome_name((int)r->outcome), r->iterations, ff_text_number(r->time_s, 2, c));
}

/* ---- what was retrieved: the roughness, then the parameters ---------------------------------- */

enum { HALF_WIDTH, MEAN, RMS, PEAK, BECKMANN, GGX, MEASURES };
typedef struct quantity {
    char name[FF_REPORT_KEY];
    double value, error;
    const char *unit, *note;
} quantity;

static quantity measure(const ff_ndf_result *r, size_t row)
{
    static const char *const name[MEASURES] = {[HALF_WIDTH] = "half width of D",
                                               [MEAN] = "mean slope",
                                               [PEAK] = "alpha of beckmann or ggx, same peak",
                                               [BECKMANN] = "alpha of beckmann, same mean slope",
                                               [GGX] = "alpha of ggx, same mean slope"};
    const ff_ndf_measures *m = &r->measures;
    char number[FF_TEXT_NUMBER];
    const double value[MEASURES] = {[HALF_WIDTH] = ff_report_degrees(m->half_width),
                                    [MEAN] = m->mean_slope,
                                    [RMS] = m->rms_slope,
                                    [PEAK] = m->alpha_peak,
                                    [BECKMANN] = m->beckmann_mean,
                                    [GGX] = m->ggx_mean};
    quantity q = {.value = value[row], .error = NAN, .unit = row == HALF_WIDTH ? "degrees" : "1", .note = ""};
    if (row == RMS)
        snprintf(q.name, sizeof q.name, "rms slope up to %s degrees", ff_text_number(ff_report_degrees(r->reach), 3, number));
    else
        snprintf(q.name, sizeof q.name, "%s", name[row]);
    return q;
}

/* The scale of every channel, then its diffuse part. */
static quantity parameter(const ff_report_ndf *n, size_t row)
{
    const ff_ndf_result *r = n->result;
    const size_t c = row % r->n_channels;
    const ff_ndf_channel *v = &r->channel[c];
    const int diffuse = row >= r->n_channels;
    const char *name = diffuse ? "kd" : r->scaled ? "ks" : "f0";
    quantity q = {.value = diffuse     ? v->kd
                           : r->scaled ? v->ks
                                       : v->f0,
                  .error = diffuse ? v->kd_error : v->scale_error,
                  .unit = "1"};
    q.note = isnan(q.error) ? "on its bound" : "";
    snprintf(q.name, sizeof q.name, "%s", name);
    if (r->n_channels > 1) ff_report_key(name, ff_problem_channel_name(n->problem, c), q.name);
    return q;
}

static quantity quantity_at(ff_where w)
{
    const ff_report_ndf *n = w.of;
    return w.row < MEASURES ? measure(n->result, w.row) : parameter(n, w.row - MEASURES);
}

static void name_cell(ff_cell *out, ff_where w)
{
    ff_cell_text(out, "%s", quantity_at(w).name);
}

static void value_cell(ff_cell *out, ff_where w)
{
    const quantity q = quantity_at(w);
    char value[FF_TEXT_NUMBER], error[FF_TEXT_NUMBER];
    if (w.row < MEASURES) {
        ff_cell_number(out, q.value, 4);
        return;
    }
    ff_text_with_error(q.value, q.error, value, error);
    ff_cell_rounded(out, q.value, value);
}

static void error_cell(ff_cell *out, ff_where w)
{
    const quantity q = quantity_at(w);
    char value[FF_TEXT_NUMBER], error[FF_TEXT_NUMBER];
    if (w.row < MEASURES) return;
    ff_text_with_error(q.value, q.error, value, error);
    ff_cell_rounded(out, q.error, error);
}

static void unit_cell(ff_cell *out, ff_where w)
{
    ff_cell_text(out, "%s", quantity_at(w).unit);
}

static void note_cell(ff_cell *out, ff_where w)
{
    ff_cell_text(out, "%s", quantity_at(w).note);
}

static const ff_column quantity_columns[] = {{.head = "quantity", .cell = name_cell},
                                             {.head = "value", .align = FF_RIGHT, .cell = value_cell},
                                             {.head = "std error", .align = FF_RIGHT, .cell = error_cell},
                                             {.head = "unit", .cell = unit_cell},
                                             {.head = "", .key = "note", .cell = note_cell, .least = 10, .wraps = 1}};

static ff_status put_quantities(const ff_report_ndf *n, ff_table_form form, const char *indent, FILE *out)
{
    return ff_columns_print(quantity_columns, FF_COUNT(quantity_columns), n, MEASURES + 2 * n->result->n_channels, form, indent,
                            n->style, out);
}

ff_status ff_report_ndf_table(const ff_report_ndf *n, ff_table_form form, FILE *out)
{
    return put_quantities(n, form, "", out);
}

/* ---- beside the formulas --------------------------------------------------------------------- */

static const int fit_order[FF_NDF_FITS] = {FF_NDF_TABULATED, FF_NDF_STUDENT_T, FF_NDF_GGX, FF_NDF_BECKMANN};

static const ff_fit_result *fit_at(ff_where w)
{
    return &((const ff_ndf_result *)w.of)->fit[fit_order[w.row]];
}

static int is_retrieved(ff_where w)
{
    return fit_order[w.row] == FF_NDF_TABULATED;
}

static void ndf_cell(ff_cell *out, ff_where w)
{
    ff_cell_text(out, "%s", is_retrieved(w) ? "retrieved" : ff_term_at(FF_NDF, (size_t)fit_at(w)->model.lobe[0].ndf)->name);
}

/* "0.2007 gamma=1.892" */
static void shape_cell(ff_cell *out, ff_where w)
{
    if (is_retrieved(w))
        ff_cell_text(out, "-");
    else
        ff_report_shape_cell(out, fit_at(w));
}

enum { OBJECTIVE, RMSE, COSINE, LOG };
static void residual_cell(ff_cell *out, ff_where w)
{
    const ff_residual *r = &fit_at(w)->residual;
    const double x[] = {[OBJECTIVE] = r->objective, [RMSE] = r->rmse, [COSINE] = r->cosine_rmse, [LOG] = r->log_rmse};
    ff_cell_number(out, x[w.index], w.index == OBJECTIVE ? 5 : 4);
}

static const ff_column fit_columns[] = {{.head = "distribution", .cell = ndf_cell},
                                        {.head = "alpha", .cell = shape_cell},
                                        {.head = "objective", .align = FF_RIGHT, .cell = residual_cell, .index = OBJECTIVE},
                                        {.head = "rmse", .align = FF_RIGHT, .cell = residual_cell, .index = RMSE},
                                        {.head = "cosine rmse", .align = FF_RIGHT, .cell = residual_cell, .index = COSINE},
                                        {.head = "log rmse", .align = FF_RIGHT, .cell = residual_cell, .index = LOG}};

ff_status ff_report_ndf_text(const ff_report_ndf *n, FILE *out)
{
    const ff_words_subject subject = {.problem = n->problem, .retrieved = n->result};
    put_head(n, out);
    ff_status status = put_quantities(n, FF_TABLE_TEXT, "  ", out);
    fputc('\n', out);
    if (status == FF_OK)
        status = ff_columns_print(fit_columns, FF_COUNT(fit_columns), n->result, FF_NDF_FITS, FF_TABLE_TEXT, "  ", n->style, out);
    if (n->result->warnings.n) fputc('\n', out);
    ff_report_warnings_text(&subject, &n->result->warnings, out);
    return status;
}
