/* What an export wrote, and what was lost on the way. */
#include "ff_report.h"
#include "fit/controls/internal_refit.h"
#include "internal_columns.h"
#include "internal_report.h"
#include <math.h>
#include <string.h>

void ff_report_export_take(const ff_target *target, const ff_refit *r, const double *control, ff_report_export *out)
{
    out->target = target;
    out->material = r->material;
    out->n_channels = r->n_channels;
    out->control = control;
    out->is_own = r->is_own;
    out->left = r->left;
    out->n_lost = r->n_lost;
    out->lost = r->lost;
}

/* ---- controls -------------------------------------------------------------------------------- */

static const ff_control *control_at(const ff_report_export *r, size_t row, size_t *c)
{
    for (size_t k = 0; k < ff_control_count(r->material); k++) {
        const size_t n = r->material->control[k].is_color ? r->n_channels : 1;
        if (row < n) {
            *c = row;
            return &r->material->control[k];
        }
        row -= n;
    }
    return NULL;
}

static size_t control_rows(const ff_report_export *r)
{
    size_t n = 0, c;
    while (control_at(r, n, &c)) n++;
    return n;
}

static const ff_setting *setting_at(const ff_report_export *r, size_t row)
{
    return &r->material->setting[row - control_rows(r)];
}

static void name_cell(ff_cell *out, ff_where w)
{
    static const char *const rgb[] = {"r", "g", "b"};
    const ff_report_export *r = w.of;
    size_t c = 0;
    const ff_control *k = control_at(r, w.row, &c);
    if (!k)
        ff_cell_text(out, "%s", setting_at(r, w.row)->name);
    else if (k->is_color && r->n_channels == 3)
        ff_cell_text(out, "%s[%s]", k->made.name, rgb[c]);
    else
        ff_cell_text(out, "%s", k->made.name);
}

static void value_cell(ff_cell *out, ff_where w)
{
    const ff_report_export *r = w.of;
    size_t c = 0;
    const ff_control *k = control_at(r, w.row, &c);
    if (k)
        ff_cell_number(out, r->control[(size_t)(k - r->material->control) * r->n_channels + c], 6);
    else
        ff_cell_number(out, setting_at(r, w.row)->value, 6);
}

static void unit_cell(ff_cell *out, ff_where w)
{
    const ff_report_export *r = w.of;
    size_t c = 0;
    const ff_control *k = control_at(r, w.row, &c);
    ff_cell_text(out, "%s", k ? k->unit : "1");
}

static const ff_column columns[] = {{.head = "control", .cell = name_cell},
                                    {.head = "value", .align = FF_RIGHT, .cell = value_cell},
                                    {.head = "unit", .cell = unit_cell}};

/* ---- text ------------------------------------------------------------------------------------ */

static void put_lost(const ff_report_export *r, FILE *out)
{
    char share[FF_TEXT_NUMBER];
    fputs("\nlost on the way, each by itself, in % of the model (rms over directions, with the cosine of the light):\n", out);
    for (size_t i = 0; i < r->n_lost; i++)
        fprintf(out, "  %s: %s %%\n", r->lost[i].what,
                isnan(r->lost[i].share) ? "not separable," : ff_text_number(100 * r->lost[i].share, 2, share));
    if (r->n_lost == 0) fputs("  nothing\n", out);
    if (r->material && !r->is_own)
        fprintf(out, "  all together, after the material was fitted: %s %%\n", ff_text_number(100 * r->left, 2, share));
}

ff_status ff_report_export_text(const ff_report_export *r, FILE *out)
{
    ff_status status = FF_OK;
    ff_text_print(r->path, out);
    fprintf(out, ": %s\n", r->title);
    if (r->material) {
        size_t settings = 0;
        while (settings < FF_TARGET_SETTINGS && r->material->setting[settings].name) settings++;
        fprintf(out, "for %s, %s (%s)\n\n", r->target->title, r->target->version, r->material->title);
        status = ff_columns_print(columns, FF_COUNT(columns), r, control_rows(r) + settings, FF_TABLE_TEXT, "  ", NULL, out);
    }
    put_lost(r, out);
    if (r->material) {
        fprintf(out, "not in it: %s\n", r->target->lacks);
        if (r->target->rendered)
            fprintf(out, "the model was compared with the renderer (%s)\n", r->target->rendered);
        else
            fputs("the model is from its documentation: it was not rendered\n", out);
    }
    return status;
}

/* ---- JSON ------------------------------------------------------------------------------------ */

static void put_controls(ff_json *j, const ff_report_export *r)
{
    ff_json_object(j, "controls", FF_JSON_BLOCK);
    for (size_t k = 0; k < ff_control_count(r->material); k++) {
        const ff_control *control = &r->material->control[k];
        if (control->is_color) ff_json_array(j, control->made.name, FF_JSON_LINE);
        for (size_t c = 0; c < (control->is_color ? r->n_channels : 1); c++)
            ff_json_number(j, control->is_color ? NULL : control->made.name, r->control[k * r->n_channels + c]);
        if (control->is_color) ff_json_close(j);
    }
    ff_json_close(j);
    ff_json_object(j, "settings", FF_JSON_LINE);
    for (size_t k = 0; k < FF_TARGET_SETTINGS && r->material->setting[k].name; k++)
        ff_json_number(j, r->material->setting[k].name, r->material->setting[k].value);
    ff_json_close(j);
}

ff_status ff_report_export_json(const ff_report_export *r, FILE *out)
{
    ff_json j;
    ff_json_begin(&j, out);
    ff_json_object(&j, NULL, FF_JSON_BLOCK);
    ff_report_head_json(&j, FF_SCHEMA_EXPORT, &r->head);
    ff_json_string(&j, "from", r->from);
    ff_json_string(&j, "model", r->expression);
    ff_json_string(&j, "to", r->path);
    ff_json_string(&j, "as", r->as);
    ff_json_string(&j, "renderer", r->target ? r->target->name : NULL);
    ff_json_string(&j, "material", r->material ? r->material->name : NULL);
    ff_json_string(&j, "rendered", r->target ? r->target->rendered : NULL);
    if (r->material) put_controls(&j, r);
    ff_json_array(&j, "lost", FF_JSON_BLOCK);
    for (size_t i = 0; i < r->n_lost; i++) {
        ff_json_object(&j, NULL, FF_JSON_LINE);
        ff_json_string(&j, "what", r->lost[i].what);
        ff_json_number(&j, "share", r->lost[i].share);
        ff_json_close(&j);
    }
    ff_json_close(&j);
    ff_json_bool(&j, "refitted", r->material && !r->is_own);
    ff_json_number(&j, "left", r->left);
    ff_json_close(&j);
    ff_json_end(&j);
    return FF_OK;
}
