/* The key "renderer" of a fit. */
#include "internal_controls_report.h"
#include "internal_report.h"
#include <math.h>

static void put_interval(ff_json *j, const char *key, const ff_control_estimate *e)
{
    if (isnan(e->low)) {
        ff_json_null(j, key);
        return;
    }
    ff_json_array(j, key, FF_JSON_LINE);
    ff_json_number(j, NULL, e->low);
    ff_json_number(j, NULL, e->high);
    ff_json_close(j);
}

/* Of a colour arrays by channel. */
static void put_control(ff_json *j, const ff_control *k, const ff_fit_result *f, size_t n)
{
    ff_json_object(j, k->made.name, FF_JSON_LINE);
    for (int part = 0; part < 3; part++) {
        static const char *const key[] = {"value", "std_error", "interval"};
        if (k->is_color) ff_json_array(j, key[part], FF_JSON_LINE);
        for (size_t c = 0; c < n; c++) {
            const ff_control_estimate e = ff_control_estimate_of(k, f, c);
            const char *name = k->is_color ? NULL : key[part];
            if (part == 2)
                put_interval(j, name, &e);
            else
                ff_json_number(j, name, part ? e.std_error : e.value);
        }
        if (k->is_color) ff_json_close(j);
    }
    ff_json_string(j, "unit", k->unit);
    ff_json_close(j);
}

static void put_free(ff_json *j, const ff_fit_result *f)
{
    char expression[FF_MODEL_NAME];
    ff_model_expression(&f->model, expression, sizeof expression);
    ff_json_object(j, "free", FF_JSON_LINE);
    ff_json_string(j, "model", expression);
    ff_json_number(j, "objective", f->residual.objective);
    ff_json_number(j, "rmse", f->residual.rmse);
    ff_json_close(j);
}

static void put_shortfalls(ff_json *j, const ff_bands *fit, const ff_bands *other)
{
    ff_shortfall at[2 * FF_BANDS];
    const size_t n = ff_shortfalls_find(fit, other, 0.01, 2 * FF_BANDS, at);
    ff_json_array(j, "cannot_show", FF_JSON_BLOCK);
    for (size_t i = 0; i < n; i++) {
        ff_json_object(j, NULL, FF_JSON_LINE);
        ff_json_string(j, "angle", ff_place_name(at[i].place));
        ff_json_number(j, "from", at[i].band * FF_BAND_DEGREES);
        ff_json_number(j, "to", (at[i].band + 1) * FF_BAND_DEGREES);
        ff_json_number(j, "mean", at[i].mean);
        ff_json_number(j, "rms", at[i].rms);
        ff_json_number(j, "free_rms", at[i].free_rms);
        ff_json_close(j);
    }
    ff_json_close(j);
}

void ff_report_controls_json(ff_json *j, const ff_report_fits *r, size_t i)
{
    const ff_report_target *t = &r->target[i];
    const ff_material *m = t->material;
    ff_json_object(j, "renderer", FF_JSON_BLOCK);
    ff_json_string(j, "name", t->target->name);
    ff_json_string(j, "version", t->target->version);
    ff_json_string(j, "material", m->name);
    ff_json_string(j, "rendered", t->target->rendered);
    ff_json_object(j, "controls", FF_JSON_BLOCK);
    for (size_t k = 0; k < ff_control_count(m); k++) {
        const size_t n = ff_report_control_shown(t, &r->fit[i], k);
        if (n) put_control(j, &m->control[k], &r->fit[i], n);
    }
    ff_json_close(j);
    ff_json_object(j, "settings", FF_JSON_LINE);
    for (size_t k = 0; k < FF_TARGET_SETTINGS && m->setting[k].name; k++)
        ff_json_number(j, m->setting[k].name, m->setting[k].value);
    ff_json_close(j);
    if (t->free) put_free(j, t->free);
    if (t->free_bands && r->trust && r->trust[i].has_bands) put_shortfalls(j, &r->trust[i].bands, t->free_bands);
    ff_json_string(j, "lacks", t->target->lacks);
    ff_json_close(j);
}
