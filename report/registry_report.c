/* The registries of models and formats as lists. */
#include "ff_report.h"
#include "internal_columns.h"
#include "targets/internal_target.h"
#include <stdio.h>
#include <string.h>

/* ---- models ---------------------------------------------------------------------------------- */

static const struct {
    uint32_t bit;
    const char *name;
} claims[] = {{FF_RECIPROCAL, "reciprocal"},     {FF_PASSIVE, "passive"},           {FF_ISOTROPIC, "isotropic"},
              {FF_WEAK_FURNACE, "weak-furnace"}, {FF_FURNACE_ONLY, "furnace-only"}, {FF_NEEDS_CENTRED, "needs-centred"},
              {FF_UNIT_AREA, "unit-area"}},
  flags[] = {{FF_PARAM_PER_CHANNEL, "per-channel"},
             {FF_PARAM_LINEAR, "linear"},
             {FF_PARAM_LOG, "log"},
             {FF_PARAM_ATANH, "atanh"},
             {FF_PARAM_HELD, "held"}};
enum { N_CLAIMS = sizeof claims / sizeof claims[0], N_FLAGS = sizeof flags / sizeof flags[0] };

static const ff_param *param_at(ff_where w)
{
    return &((const ff_term *)w.of)->params[w.row];
}

static void name_cell(ff_cell *out, ff_where w)
{
    ff_cell_text(out, "%s", param_at(w)->name);
}

static void range_cell(ff_cell *out, ff_where w)
{
    char lo[FF_TEXT_NUMBER], hi[FF_TEXT_NUMBER];
    ff_cell_text(out, "[%s, %s]", ff_text_exact(param_at(w)->lo, lo), ff_text_exact(param_at(w)->hi, hi));
}

static void initial_cell(ff_cell *out, ff_where w)
{
    ff_cell_exact(out, param_at(w)->init);
}

static void unit_cell(ff_cell *out, ff_where w)
{
    ff_cell_text(out, "%s", param_at(w)->unit);
}

static void meaning_cell(ff_cell *out, ff_where w)
{
    const ff_param *p = param_at(w);
    ff_cell_text(out, "%s%s%s", p->meaning, p->flags & FF_PARAM_PER_CHANNEL ? ", per channel" : "",
                 p->flags & FF_PARAM_HELD ? ", held unless freed" : "");
}

/* Without a head: the text above says what they are. */
static const ff_column parameter_columns[] = {{.head = "", .cell = name_cell},
                                              {.head = "", .cell = range_cell},
                                              {.head = "", .align = FF_RIGHT, .cell = initial_cell},
                                              {.head = "", .cell = unit_cell},
                                              {.head = "", .cell = meaning_cell, .least = 16}};

enum { CLAIMS_TEXT = 128 };
/* "reciprocal, passive", or "nothing". */
static const char *claims_text(uint32_t bits, char out[CLAIMS_TEXT])
{
    size_t at = 0;
    for (int i = 0; i < N_CLAIMS && at < CLAIMS_TEXT; i++)
        if (bits & claims[i].bit) at += (size_t)snprintf(out + at, CLAIMS_TEXT - at, "%s%s", at ? ", " : "", claims[i].name);
    return at ? out : "nothing";
}

/* The other names, "a, b", of "a,b". */
static void put_also(const char *before, const char *also, const char *after, FILE *out)
{
    fputs(before, out);
    for (; *also; also++) fprintf(out, "%c%s", *also, *also == ',' ? " " : "");
    fputs(after, out);
}

static ff_status put_term(const ff_term *term, const ff_report_style *style, FILE *out)
{
    char claimed[CLAIMS_TEXT];
    fprintf(out, "  %s\n      %s\n", term->name, term->title);
    if (term->source[0]) fprintf(out, "      source: %s\n", term->source);
    fprintf(out, "      claims: %s\n", claims_text(term->claims, claimed));
    if (term->also) put_also("      also: ", term->also, "\n", out);
    if (term->note[0]) fprintf(out, "      note: %s\n", term->note);
    if (term->n_params == 0) return FF_OK;
    return ff_columns_print(parameter_columns, FF_COUNT(parameter_columns), term, term->n_params, FF_TABLE_TEXT, "      ", style,
                            out);
}

static void put_preset(const ff_preset *p, FILE *out)
{
    fprintf(out, "  %s\n      %s\n      source: %s\n      stands for: %s", p->name, p->title, p->source, p->expression);
    for (int k = 0; k < 3 && p->hold[k]; k++) fprintf(out, "%s%s", k ? ", " : " with ", p->hold[k]);
    fputc('\n', out);
    if (p->note[0]) fprintf(out, "      note: %s\n", p->note);
}

static void put_renderers(FILE *out)
{
    fputs("\nrenderer, for --for\n", out);
    for (size_t i = 0; i < ff_target_count(); i++) {
        const ff_target *t = ff_target_at(i);
        fprintf(out, "  %s\n      %s, %s\n      source: %s\n", t->name, t->title, t->version, t->source);
        for (size_t k = 0; k < FF_TARGET_ALIASES && t->alias[k]; k++)
            fprintf(out, "%s%s%s", k ? ", " : "      also: ", t->alias[k],
                    k + 1 == FF_TARGET_ALIASES || !t->alias[k + 1] ? "\n" : "");
        for (size_t k = 0; k < t->n_materials; k++) fprintf(out, "      %s: %s\n", t->material[k].name, t->material[k].expression);
        fprintf(out, "      %s%s\n", t->rendered ? "compared with it: " : "not rendered", t->rendered ? t->rendered : "");
    }
}

ff_status ff_report_models_text(const ff_report_style *style, FILE *out)
{
    ff_status status = FF_OK;
    fputs("A model is a sum of lobes NDF[/MASKING[/FRESNEL]] and diffuse names: ggx, beckmann/v-cavity, "
          "ggx/smith-separable/schlick+lambert.\n"
          "Left out: masking smith-height-correlated, Fresnel schlick, no diffuse term. Or it is a preset, by its name alone.\n"
          "Parameters: name, [least, most], initial value, unit, meaning. Every lobe also has a scale ks (1, held unless freed).\n"
          "The Fresnel term `shared` of a second or third lobe is that of the first; such a lobe has a `weight` instead of ks.\n",
          out);
    for (int kind = 0; kind < FF_TERM_KINDS; kind++) {
        fprintf(out, "\n%s\n", ff_term_kind_name((ff_term_kind)kind));
        for (size_t i = 0; i < ff_term_count((ff_term_kind)kind) && status == FF_OK; i++)
            status = put_term(ff_term_at((ff_term_kind)kind, i), style, out);
    }
    fputs("\npreset\n", out);
    for (size_t i = 0; i < ff_preset_count(); i++) put_preset(ff_preset_at(i), out);
    put_renderers(out);
    return status;
}

ff_status ff_report_model_text(const char *name, const ff_report_style *style, FILE *out)
{
    const ff_preset *preset = ff_preset_find(name);
    ff_status status = FF_ERR_UNKNOWN;
    for (int kind = 0; kind < FF_TERM_KINDS; kind++) {
        const int i = ff_term_find((ff_term_kind)kind, name);
        if (i < 0) continue;
        fprintf(out, "%s\n", ff_term_kind_name((ff_term_kind)kind));
        status = put_term(ff_term_at((ff_term_kind)kind, (size_t)i), style, out);
        if (status != FF_OK) return status;
    }
    if (!preset) return status;
    fputs("preset\n", out);
    put_preset(preset, out);
    return FF_OK;
}

/* ---- the same as a table: terms of all kinds, one after another ------------------------------- */

typedef struct term_at {
    ff_term_kind kind;
    const ff_term *term;
} term_at;

static term_at term_of(size_t row)
{
    int kind = 0;
    for (; row >= ff_term_count((ff_term_kind)kind); kind++) row -= ff_term_count((ff_term_kind)kind);
    return (term_at){(ff_term_kind)kind, ff_term_at((ff_term_kind)kind, row)};
}

static void kind_cell(ff_cell *out, ff_where w)
{
    ff_cell_text(out, "%s", ff_term_kind_name(term_of(w.row).kind));
}

static void term_cell(ff_cell *out, ff_where w)
{
    ff_cell_text(out, "%s", term_of(w.row).term->name);
}

static void title_cell(ff_cell *out, ff_where w)
{
    ff_cell_text(out, "%s", term_of(w.row).term->title);
}

static void parameters_cell(ff_cell *out, ff_where w)
{
    const ff_term *t = term_of(w.row).term;
    size_t at = 0;
    for (uint32_t i = 0; i < t->n_params && at < sizeof out->text; i++)
        at += (size_t)snprintf(out->text + at, sizeof out->text - at, "%s%s", at ? " " : "", t->params[i].name);
}

static void claims_cell(ff_cell *out, ff_where w)
{
    char text[CLAIMS_TEXT];
    ff_cell_text(out, "%s", claims_text(term_of(w.row).term->claims, text));
}

static void source_cell(ff_cell *out, ff_where w)
{
    ff_cell_text(out, "%s", term_of(w.row).term->source);
}

static const ff_column model_columns[] = {{.head = "kind", .cell = kind_cell},
                                          {.head = "name", .cell = term_cell},
                                          {.head = "what it is", .key = "title", .cell = title_cell},
                                          {.head = "parameters", .cell = parameters_cell},
                                          {.head = "claims", .cell = claims_cell},
                                          {.head = "source", .cell = source_cell}};

ff_status ff_report_models_table(ff_table_form form, FILE *out)
{
    size_t rows = 0;
    for (int kind = 0; kind < FF_TERM_KINDS; kind++) rows += ff_term_count((ff_term_kind)kind);
    return ff_columns_print(model_columns, FF_COUNT(model_columns), NULL, rows, form, "", NULL, out);
}

/* ---- the same as a page ---------------------------------------------------------------------- */

/* Text with the characters escaped that a table of Markdown would take as its own. */
static void put_escaped(const char *text, FILE *out)
{
    for (; *text; text++) {
        if (*text == '|' || *text == '*' || *text == '<') fputc('\\', out);
        fputc(*text, out);
    }
}

static void markdown_term(const ff_term *t, FILE *out)
{
    char claimed[CLAIMS_TEXT];
    fprintf(out, "\n### %s\n", t->name);
    put_escaped(t->title, out);
    if (t->source[0]) {
        fputs("  \nSource: ", out);
        put_escaped(t->source, out);
    }
    if (t->also) put_also("  \nAlso: ", t->also, "", out);
    fprintf(out, "  \nClaims: %s", claims_text(t->claims, claimed));
    if (t->note[0]) {
        fputs("  \nNote: ", out);
        put_escaped(t->note, out);
    }
    fputc('\n', out);
    if (t->n_params) fputs("\n| parameter | range | initial | unit | meaning |\n|---|---|---|---|---|\n", out);
    for (uint32_t i = 0; i < t->n_params; i++) {
        const ff_param *p = &t->params[i];
        char lo[FF_TEXT_NUMBER], hi[FF_TEXT_NUMBER], init[FF_TEXT_NUMBER];
        fprintf(out, "| `%s` | %s to %s | %s | %s | ", p->name, ff_text_exact(p->lo, lo), ff_text_exact(p->hi, hi),
                ff_text_exact(p->init, init), p->unit);
        put_escaped(p->meaning, out);
        fprintf(out, "%s%s |\n", p->flags & FF_PARAM_PER_CHANNEL ? ", per channel" : "",
                p->flags & FF_PARAM_HELD ? ", held unless freed" : "");
    }
}

/* What a renderer is set by, and of which parameters each control is made. */
static void markdown_material(const ff_material *m, FILE *out)
{
    fprintf(out, "\n`%s` (%s): `%s`", m->name, m->title, m->expression);
    for (size_t k = 0; k < FF_TARGET_HOLDS && m->hold[k]; k++) fprintf(out, "%s `%s`", k ? "," : " with", m->hold[k]);
    fputs("\n\n| control | range | unit | of |\n|---|---|---|---|\n", out);
    for (size_t k = 0; k < FF_TARGET_CONTROLS && m->control[k].made.name; k++) {
        const ff_control *c = &m->control[k];
        char lo[FF_TEXT_NUMBER], hi[FF_TEXT_NUMBER];
        fprintf(out, "| `%s` | %s to %s | %s | ", c->made.name, ff_text_number(c->lo, 6, lo), ff_text_number(c->hi, 6, hi),
                c->unit);
        for (size_t i = 0; i < FF_FORMULA_INPUTS && c->made.of[i]; i++) fprintf(out, "%s`%s`", i ? ", " : "", c->made.of[i]);
        fprintf(out, "%s |\n", c->is_color ? ", per channel" : "");
    }
    for (size_t k = 0; k < FF_TARGET_SETTINGS && m->setting[k].name; k++) {
        char value[FF_TEXT_NUMBER];
        fprintf(out, "| `%s` | %s | 1 | to be set |\n", m->setting[k].name, ff_text_number(m->setting[k].value, 6, value));
    }
}

static void markdown_renderers(FILE *out)
{
    fputs("\n## Renderers\n\nWhat `fit --for` and `compare --for` know: the model that a renderer evaluates, and its controls as "
          "functions of the "
          "model's parameters. [renderers.md](renderers.md) has the way through.\n",
          out);
    for (size_t i = 0; i < ff_target_count(); i++) {
        const ff_target *t = ff_target_at(i);
        fprintf(out, "\n### %s\n%s, %s  \n", t->name, t->title, t->version);
        if (t->alias[0]) {
            fputs("Also called: ", out);
            for (size_t k = 0; k < FF_TARGET_ALIASES && t->alias[k]; k++) fprintf(out, "%s%s", k ? ", " : "", t->alias[k]);
            fputs("  \n", out);
        }
        fprintf(out, "Source: %s  \n%s%s  \nNot in it: %s\n", t->source,
                t->rendered ? "Compared with the renderer: " : "Not rendered.", t->rendered ? t->rendered : "", t->lacks);
        for (size_t k = 0; k < t->n_materials; k++) markdown_material(&t->material[k], out);
    }
}

static ff_status models_page(const void *none, FILE *out)
{
    static const char *const heading[FF_TERM_KINDS] = {"Distributions of normals", "Masking and shadowing", "Fresnel terms",
                                                       "Diffuse terms and multiple scattering"};
    (void)none;
    fputs(
        "# Models\n\nWritten by `facetfit models --markdown`; the same registry is behind `facetfit models`, the parser and the "
        "tests.\n\nA model is a sum of lobes `NDF[/MASKING[/FRESNEL]]` and diffuse names, or one of the presets at the end. Left "
        "out: masking `smith-height-correlated`, Fresnel `schlick`, no diffuse term. Every lobe also has, per channel, a scale "
        "`ks`, which is 1 and held unless freed. The Fresnel term `shared` of a second or third lobe is that of the first one; "
        "such a lobe has a `weight` (0 to 1) instead: its share of what the lobes up to it weigh. A lobe whose masking or diffuse "
        "term is isotropic has one `alpha` instead of `alpha_x`, `alpha_y`, `r_xy` and the mean slope.\n\nClaims are tested for "
        "every combination: *reciprocal*; *passive*: reflects at most what arrives; *isotropic*; *unit-area*: integral D cos = 1; "
        "*weak-furnace*: the weak white furnace integral is 1, of a distribution for the Smith forms; *needs-centred*: has no "
        "meaning with a mean slope; *furnace-only*: exists for that test, `all` leaves it out.\n",
        out);
    for (int kind = 0; kind < FF_TERM_KINDS; kind++) {
        fprintf(out, "\n## %s\n", heading[kind]);
        for (size_t i = 0; i < ff_term_count((ff_term_kind)kind); i++) markdown_term(ff_term_at((ff_term_kind)kind, i), out);
    }
    fputs("\n## Presets\n\n| name | stands for | what it is | source |\n|---|---|---|---|\n", out);
    for (size_t i = 0; i < ff_preset_count(); i++) {
        const ff_preset *p = ff_preset_at(i);
        fprintf(out, "| `%s` | `%s`", p->name, p->expression);
        for (int k = 0; k < 3 && p->hold[k]; k++) fprintf(out, "%s `%s`", k ? "," : " with", p->hold[k]);
        fputs(" | ", out);
        put_escaped(p->title, out);
        if (p->note[0]) {
            fputs("; ", out);
            put_escaped(p->note, out);
        }
        fputs(" | ", out);
        put_escaped(p->source, out);
        fputs(" |\n", out);
    }
    markdown_renderers(out);
    return FF_OK;
}

ff_status ff_report_models_markdown(FILE *out)
{
    return ff_report_page(models_page, NULL, out);
}

static void put_bits(ff_json *j, const char *key, uint32_t bits, int of_claims)
{
    ff_json_array(j, key, FF_JSON_LINE);
    for (int i = 0; i < (of_claims ? N_CLAIMS : N_FLAGS); i++)
        if (bits & (of_claims ? claims[i].bit : flags[i].bit)) ff_json_string(j, NULL, of_claims ? claims[i].name : flags[i].name);
    ff_json_close(j);
}

static void term_json(ff_json *j, ff_term_kind kind, const ff_term *term)
{
    ff_json_object(j, NULL, FF_JSON_BLOCK);
    ff_json_string(j, "kind", ff_term_kind_name(kind));
    ff_json_string(j, "name", term->name);
    ff_json_string(j, "title", term->title);
    ff_json_string(j, "source", term->source);
    ff_json_string(j, "note", term->note);
    ff_json_array(j, "also", FF_JSON_LINE);
    for (const char *name = term->also; name && *name; name += strcspn(name, ",") + (name[strcspn(name, ",")] == ',')) {
        char one[64];
        snprintf(one, sizeof one, "%.*s", (int)strcspn(name, ","), name);
        ff_json_string(j, NULL, one);
    }
    ff_json_close(j);
    put_bits(j, "claims", term->claims, 1);
    ff_json_array(j, "parameters", FF_JSON_BLOCK);
    for (uint32_t i = 0; i < term->n_params; i++) {
        const ff_param *p = &term->params[i];
        ff_json_object(j, NULL, FF_JSON_LINE);
        ff_json_string(j, "name", p->name);
        ff_json_string(j, "unit", p->unit);
        ff_json_string(j, "meaning", p->meaning);
        ff_json_number(j, "min", p->lo);
        ff_json_number(j, "max", p->hi);
        ff_json_number(j, "initial", p->init);
        put_bits(j, "flags", p->flags, 0);
        ff_json_close(j);
    }
    ff_json_close(j);
    ff_json_close(j);
}

static void preset_json(ff_json *j, const ff_preset *p)
{
    ff_json_object(j, NULL, FF_JSON_BLOCK);
    ff_json_string(j, "name", p->name);
    ff_json_string(j, "title", p->title);
    ff_json_string(j, "source", p->source);
    ff_json_string(j, "note", p->note);
    ff_json_string(j, "model", p->expression);
    ff_json_array(j, "hold", FF_JSON_LINE);
    for (int k = 0; k < 3 && p->hold[k]; k++) ff_json_string(j, NULL, p->hold[k]);
    ff_json_close(j);
    ff_json_close(j);
}

static void renderer_json(ff_json *j, const ff_target *t)
{
    ff_json_object(j, NULL, FF_JSON_BLOCK);
    ff_json_string(j, "name", t->name);
    ff_json_array(j, "aliases", FF_JSON_LINE);
    for (size_t k = 0; k < FF_TARGET_ALIASES && t->alias[k]; k++) ff_json_string(j, NULL, t->alias[k]);
    ff_json_close(j);
    ff_json_string(j, "title", t->title);
    ff_json_string(j, "version", t->version);
    ff_json_string(j, "source", t->source);
    ff_json_string(j, "lacks", t->lacks);
    ff_json_string(j, "rendered", t->rendered);
    ff_json_array(j, "materials", FF_JSON_BLOCK);
    for (size_t k = 0; k < t->n_materials; k++) {
        ff_json_object(j, NULL, FF_JSON_LINE);
        ff_json_string(j, "name", t->material[k].name);
        ff_json_string(j, "title", t->material[k].title);
        ff_json_string(j, "model", t->material[k].expression);
        ff_json_array(j, "controls", FF_JSON_LINE);
        for (size_t i = 0; i < FF_TARGET_CONTROLS && t->material[k].control[i].made.name; i++)
            ff_json_string(j, NULL, t->material[k].control[i].made.name);
        ff_json_close(j);
        ff_json_close(j);
    }
    ff_json_close(j);
    ff_json_close(j);
}

ff_status ff_report_models_json(const ff_report_head *head, FILE *out)
{
    ff_json j;
    ff_json_begin(&j, out);
    ff_json_object(&j, NULL, FF_JSON_BLOCK);
    ff_report_head_json(&j, FF_SCHEMA_MODELS, head);
    ff_json_array(&j, "terms", FF_JSON_BLOCK);
    for (int kind = 0; kind < FF_TERM_KINDS; kind++)
        for (size_t i = 0; i < ff_term_count((ff_term_kind)kind); i++)
            term_json(&j, (ff_term_kind)kind, ff_term_at((ff_term_kind)kind, i));
    ff_json_close(&j);
    ff_json_array(&j, "presets", FF_JSON_BLOCK);
    for (size_t i = 0; i < ff_preset_count(); i++) preset_json(&j, ff_preset_at(i));
    ff_json_close(&j);
    ff_json_array(&j, "renderers", FF_JSON_BLOCK);
    for (size_t i = 0; i < ff_target_count(); i++) renderer_json(&j, ff_target_at(i));
    ff_json_close(&j);
    ff_json_close(&j);
    ff_json_end(&j);
    return FF_OK;
}

/* ---- formats --------------------------------------------------------------------------------- */

static const struct {
    unsigned bit;
    const char *name;
} reads[] = {{FF_READS_COLUMNS, "columns"}, {FF_READS_GRID, "grid"}, {FF_READS_PART, "part"}, {FF_READS_QUANTITY, "quantity"}},
  holds[] = {{FF_HOLDS_SIGMA, "sigma"},       {FF_HOLDS_INVALID, "invalid"}, {FF_HOLDS_NEGATIVE, "negative"},
             {FF_HOLDS_NAMES, "names"},       {FF_HOLDS_DOUBLE, "double"},   {FF_HOLDS_WEIGHTS, "weights"},
             {FF_HOLDS_MANY, "any-channels"}, {FF_HOLDS_NM, "wavelengths"}};
enum { N_READS = sizeof reads / sizeof reads[0], N_HOLDS = sizeof holds / sizeof holds[0] };

static void format_cell(ff_cell *out, ff_where w)
{
    ff_cell_text(out, "%s", ff_format_at(w.row)->name);
}

static void writes_cell(ff_cell *out, ff_where w)
{
    const ff_format *f = ff_format_at(w.row);
    ff_cell_text(out, "%s", !f->write ? "-" : f->holds & FF_HOLDS_DOUBLE ? "exactly" : "rounded");
}

static void extensions_cell(ff_cell *out, ff_where w)
{
    ff_cell_text(out, "%s", ff_format_at(w.row)->extensions);
}

static void options_cell(ff_cell *out, ff_where w)
{
    const unsigned bits = ff_format_at(w.row)->reads;
    size_t at = 0;
    ff_cell_text(out, "-");
    for (int k = 0; k < N_READS && at < sizeof out->text; k++)
        if (bits & reads[k].bit)
            at += (size_t)snprintf(out->text + at, sizeof out->text - at, "%s%s", at ? " " : "", reads[k].name);
}

static void format_title_cell(ff_cell *out, ff_where w)
{
    ff_cell_text(out, "%s", ff_format_at(w.row)->title);
}

static const ff_column format_columns[] = {
    {.head = "format", .cell = format_cell},
    {.head = "writes", .cell = writes_cell},
    {.head = "names", .cell = extensions_cell, .drop = 1},
    {.head = "options", .cell = options_cell, .drop = 2},
    {.head = "what it is", .key = "title", .cell = format_title_cell, .least = 20, .wraps = 1}};

static ff_status put_formats(ff_table_form form, const ff_report_style *style, FILE *out)
{
    return ff_columns_print(format_columns, FF_COUNT(format_columns), NULL, ff_format_count(), form, "", style, out);
}

ff_status ff_report_formats_table(ff_table_form form, FILE *out)
{
    return put_formats(form, NULL, out);
}

ff_status ff_report_formats_text(const ff_report_style *style, FILE *out)
{
    const ff_status status = put_formats(FF_TABLE_TEXT, style, out);
    fputs("\nAll can be read. A format is recognised by the content of the file; --format NAME overrides. Options are those of "
          "fit, compare,\n"
          "ndf, info and resample: --columns, --grid, --part, --quantity; --scale and --reduce go with every format. "
          "docs/formats.md has more.\n",
          out);
    return status;
}

ff_status ff_report_formats_json(const ff_report_head *head, FILE *out)
{
    ff_json j;
    ff_json_begin(&j, out);
    ff_json_object(&j, NULL, FF_JSON_BLOCK);
    ff_report_head_json(&j, FF_SCHEMA_FORMATS, head);
    ff_json_array(&j, "formats", FF_JSON_BLOCK);
    for (size_t i = 0; i < ff_format_count(); i++) {
        const ff_format *f = ff_format_at(i);
        ff_json_object(&j, NULL, FF_JSON_LINE);
        ff_json_string(&j, "name", f->name);
        ff_json_string(&j, "title", f->title);
        ff_json_string(&j, "extensions", f->extensions);
        ff_json_string(&j, "source", f->source);
        ff_json_bool(&j, "reads", f->read != NULL);
        ff_json_bool(&j, "writes", f->write != NULL);
        ff_json_array(&j, "options", FF_JSON_LINE);
        for (int k = 0; k < N_READS; k++)
            if (f->reads & reads[k].bit) ff_json_string(&j, NULL, reads[k].name);
        ff_json_close(&j);
        ff_json_array(&j, "holds", FF_JSON_LINE);
        for (int k = 0; k < N_HOLDS; k++)
            if (f->holds & holds[k].bit) ff_json_string(&j, NULL, holds[k].name);
        ff_json_close(&j);
        ff_json_close(&j);
    }
    ff_json_close(&j);
    ff_json_close(&j);
    ff_json_end(&j);
    return FF_OK;
}
