/* What the texts of fits and of comparisons share: what was fitted, and parameters in short. */
#include "internal_fits_text.h"
#include "models/tools/internal_aperture.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- what was fitted ------------------------------------------------------------------------- */

const char *ff_report_plural(size_t n)
{
    return n == 1 ? "" : "s";
}

/* What the values are means over; nothing of points. */
static void put_aperture(const ff_aperture *a, FILE *out)
{
    char text[FF_APERTURE_TEXT], number[FF_TEXT_NUMBER];
    if (!a || !ff_aperture_extended(a)) return;
    fprintf(out, "values are means over an aperture of %s degrees", ff_aperture_text(a, text));
    if (a->source > 0) fprintf(out, " and a source of %s", ff_text_number(ff_report_degrees(a->source), 6, number));
    fputs(", half angles\n", out);
}

static void put_count(FILE *out, const char **separator, size_t n, const char *what)
{
    if (n == 0) return;
    fprintf(out, "%s%zu %s", *separator, n, what);
    *separator = ", ";
}

/* "eta held at 0.18:0.42:1.45", of many channels the first ones */
static void put_fixed(const ff_fixed *f, const char *separator, FILE *out)
{
    enum { SHOWN = 4 };
    char key[FF_REPORT_KEY], number[FF_TEXT_NUMBER];
    fprintf(out, "%s%s held at ", separator, ff_report_key(f->name, f->channel, key));
    for (size_t k = 0; k < f->n && k < SHOWN; k++) fprintf(out, "%s%s", k ? ":" : "", ff_text_number(f->value[k], 6, number));
    if (f->n > SHOWN) fprintf(out, ":... (%zu values)", f->n);
}

/* Bounds that nobody asked for, and why they are assumed. */
static void put_assumed(const ff_constraints *c, FILE *out)
{
    char a[FF_TEXT_NUMBER], b[FF_TEXT_NUMBER];
    for (size_t i = 0; i < c->n_bounds; i++)
        if (c->because && c->because[i])
            fprintf(out, "assumed: %s in [%s, %s], since %s; --bound says otherwise\n", c->bound[i].name,
                    ff_text_number(c->bound[i].lo, 6, a), ff_text_number(c->bound[i].hi, 6, b), c->because[i]);
}

/* A line of what was given besides the data. */
static void put_constraints(const ff_constraints *c, FILE *out)
{
    char a[FF_TEXT_NUMBER], b[FF_TEXT_NUMBER], key[FF_REPORT_KEY];
    const char *separator = "given: ";
    if (!c) return;
    for (size_t i = 0; i < c->n_bounds; i++) {
        if (c->because && c->because[i]) continue;
        fprintf(out, "%s%s in [%s, %s]", separator, ff_report_key(c->bound[i].name, c->bound[i].channel, key),
                ff_text_number(c->bound[i].lo, 6, a), ff_text_number(c->bound[i].hi, 6, b));
        separator = "; ";
    }
    for (size_t i = 0; i < c->n_priors; i++, separator = "; ")
        fprintf(out, "%s%s = %s +- %s", separator, ff_report_key(c->prior[i].name, c->prior[i].channel, key),
                ff_text_number(c->prior[i].mean, 6, a), ff_text_number(c->prior[i].sd, 6, b));
    for (size_t i = 0; i < c->n_ties; i++, separator = "; ")
        fprintf(out, "%s%s %s%s", separator, c->tie[i].name, c->tie[i].to ? "= " : "the same in all channels",
                c->tie[i].to ? c->tie[i].to : "");
    for (size_t i = 0; i < c->n_fixed; i++, separator = "; ") put_fixed(&c->fixed[i], separator, out);
    if (c->energy_conserving) fprintf(out, "%senergy is conserved", separator), separator = "; ";
    if (*separator == ';') fputc('\n', out);
    put_assumed(c, out);
}

void ff_report_selection_text(const ff_report_fits *r, FILE *out)
{
    char number[FF_TEXT_NUMBER], grazing[FF_TEXT_NUMBER + 32];
    const char *separator = "; left out: ";
    ff_selection s;
    ff_problem_selection(r->problem[0], &s);
    ff_text_print(r->path, out);
    fprintf(out, ": %s, %zu sample%s, %zu used", r->table->format, s.samples, ff_report_plural(s.samples), s.used);
    snprintf(grazing, sizeof grazing, "beyond %s degrees", ff_text_number(ff_report_degrees(r->options->max_theta), 6, number));
    put_count(out, &separator, s.invalid, "invalid");
    put_count(out, &separator, s.below_horizon, "below the horizon");
    put_count(out, &separator, s.grazing, grazing);
    put_count(out, &separator, s.dropped, "negative");
    put_count(out, &separator, s.copies, s.copies == 1 ? "copy of another one" : "copies of others");
    fputc('\n', out);
    if (s.weighting == FF_WEIGHT_NOISE)
        fputs("in standard deviations of the noise that a first fit has found", out);
    else
        fprintf(out, "loss %s%s, weights by %s", ff_loss_name((int)r->options->loss), r->adaptive ? " (chosen)" : "",
                ff_weighting_name((int)s.weighting));
    if (r->options->robust != FF_ROBUST_NONE)
        fprintf(out, ", robust %s at %s", ff_robust_name((int)r->options->robust),
                r->options->robust_scale > 0 ? ff_text_number(r->options->robust_scale, 6, number)
                : r->options->noise          ? "the standard deviations of the noise model"
                                             : "the spread of the residuals about each magnitude");
    if (s.saturated > 0) fprintf(out, "; %zu saturated value%s", s.saturated, ff_report_plural(s.saturated));
    if (s.below_noise > 0) fprintf(out, "; %zu value%s below the noise floor", s.below_noise, ff_report_plural(s.below_noise));
    if (s.negative > 0)
        fprintf(out, "; %zu used sample%s with a negative value (kept as noise)", s.negative, ff_report_plural(s.negative));
    fputc('\n', out);
    put_aperture(r->options->aperture, out);
    put_constraints(r->options->constraints, out);
    const ff_side odd = ff_brightest_odd(&s.brightest);
    if (odd != FF_SIDE_NONE)
        fprintf(out, "brightest samples %s, not about the mirror direction: %s\n", ff_words_side(odd), ff_words_side_hint(odd));
}

void ff_report_problem_text(const ff_report_fits *r, size_t p, FILE *out)
{
    if (r->n_problems > 1) fprintf(out, "channel %s: ", ff_problem_channel_name(r->problem[p], 0));
}

/* ---- parameters in short --------------------------------------------------------------------- */

int ff_report_left_alone(const ff_fit_value *v, const ff_param *info)
{
    return v->held && (info->flags & FF_PARAM_HELD) && v->value == info->init;
}

int ff_report_all_left_alone(const ff_fit_result *f, uint32_t k)
{
    int all = 1;
    for (size_t c = 0; c < f->n_channels; c++)
        all &= ff_report_left_alone(&f->channel_value[c * f->model.n_channel + k], f->model.channel[k].info);
    return all;
}

void ff_report_shape_cell(ff_cell *out, const ff_fit_result *f)
{
    size_t at = 0;
    for (uint32_t k = 0; k < f->model.n_shape; k++) {
        const ff_fit_value *v = &f->shape_value[k];
        const char *name = f->model.shape[k].name;
        char number[FF_TEXT_NUMBER], label[FF_PARAM_NAME + 2];
        if (v->tied || v->held || at >= sizeof out->text) continue;
        snprintf(label, sizeof label, "%s%s=", at ? " " : "", strcmp(name, "r_xy") ? name : "r");
        if (!strcmp(name, "alpha_x") || !strcmp(name, "alpha")) label[0] = '\0';
        if (!strcmp(name, "alpha_y")) strcpy(label, "/");
        at += (size_t)snprintf(out->text + at, sizeof out->text - at, "%s%s%s", label, ff_text_number(v->value, 4, number),
                               v->at_bound ? "!" : "");
    }
}

/* One number per channel, "0.91/0.62/0.31"; '!' marks one on its bound. Of many channels the range, "0.31..0.91". */
static void channel_cell(const ff_fit_result *f, uint32_t k, char *out, size_t size)
{
    size_t at = 0;
    int bounds = 0;
    double lowest = INFINITY, highest = -INFINITY;
    char number[FF_TEXT_NUMBER], other[FF_TEXT_NUMBER];
    out[0] = '\0';
    for (size_t c = 0; c < f->n_channels && at < size; c++) {
        const ff_fit_value *v = &f->channel_value[c * f->model.n_channel + k];
        lowest = fmin(lowest, v->value);
        highest = fmax(highest, v->value);
        bounds |= v->at_bound != 0;
        if (f->n_channels <= FF_REPORT_CHANNELS)
            at += (size_t)snprintf(out + at, size - at, "%s%s%s", c ? "/" : "", ff_text_number(v->value, 3, number),
                                   v->at_bound ? "!" : "");
    }
    if (f->n_channels > FF_REPORT_CHANNELS)
        snprintf(out, size, "%s..%s%s", ff_text_number(lowest, 3, number), ff_text_number(highest, 3, other), bounds ? "!" : "");
}

void ff_report_channel_cells(ff_cell *out, const ff_fit_result *f, int of_lobes, const char *lone)
{
    size_t at = 0;
    ff_cell_text(out, "-");
    for (uint32_t k = 0; k < f->model.n_channel && at < sizeof out->text; k++) {
        const ff_model_param *p = &f->model.channel[k];
        char cell[FF_CELL];
        if ((p->lobe < f->model.n_lobes) != of_lobes || ff_report_all_held(f, k)) continue;
        channel_cell(f, k, cell, sizeof cell);
        if (strcmp(p->name, lone))
            at += (size_t)snprintf(out->text + at, sizeof out->text - at, "%s%s=%s", at ? " " : "", p->name, cell);
        else
            at += (size_t)snprintf(out->text + at, sizeof out->text - at, "%s%s", at ? " " : "", cell);
    }
}

const char *ff_report_masking_name(const ff_fit_result *f)
{
    return f->model.n_lobes ? ff_term_at(FF_MASKING, (size_t)f->model.lobe[0].masking)->name : "-";
}

const char *ff_report_ndf_name(const ff_fit_result *f)
{
    return f->model.n_lobes ? ff_term_at(FF_NDF, (size_t)f->model.lobe[0].ndf)->name : "-";
}

void ff_report_base_names(ff_cell *out, const ff_model *m)
{
    size_t at = 0;
    ff_cell_text(out, "-");
    for (uint32_t b = 0; b < m->n_bases && at < sizeof out->text; b++)
        at += (size_t)snprintf(out->text + at, sizeof out->text - at, "%s%s", b ? "+" : "",
                               ff_term_at(FF_DIFFUSE, (size_t)m->base[b].diffuse)->name);
}

void ff_report_outcome_cell(ff_cell *out, const ff_fit_result *f)
{
    if (f->outcome != FF_CONVERGED) ff_cell_text(out, "%s", ff_outcome_name((int)f->outcome));
}

void ff_report_fit_warnings(const ff_report_fits *r, size_t i, FILE *out)
{
    const ff_words_subject subject = {.problem = ff_report_problem_of(r, i), .fit = &r->fit[i]};
    ff_report_warnings_text(&subject, &r->fit[i].warnings, out);
}

const ff_problem *ff_report_problem_of(const ff_report_fits *r, size_t i)
{
    return r->problem[i / (r->n_fits / r->n_problems)];
}
