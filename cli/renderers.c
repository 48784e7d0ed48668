/* Renderers that fits are made for: what --for names. */
#include "internal_cli.h"
#include <stdlib.h>
#include <string.h>

enum { MOST = 128 };

static int unknown(const cli_args *args, const char *word)
{
    char known[600];
    const char *nearest = cli_words_nearest(cli_words_for, word, strlen(word));
    return cli_usage(args, "--for %s: no such renderer%s%s%s; known are %s", word, nearest ? "; did you mean '" : "",
                     nearest ? nearest : "", nearest ? "'?" : "", cli_words_list(cli_words_for, known, sizeof known));
}

static int no_material(const cli_args *args, const ff_target *t, const char *word)
{
    char known[200] = "";
    for (size_t i = 0; i < t->n_materials; i++) {
        const size_t used = strlen(known);
        snprintf(known + used, sizeof known - used, "%s%s", used ? ", " : "", t->material[i].name);
    }
    return cli_usage(args, "--for %s: %s has no such material; it has %s", word, t->name, known);
}

/* One material, unless it is there. */
static int add_material(const cli_args *args, const ff_target *t, const ff_material *m, cli_combinations *out)
{
    ff_error err = {0};
    for (size_t i = 0; i < out->n; i++)
        if (out->target[i].material == m) return EXIT_DONE;
    if (out->n == MOST) return cli_usage(args, "--for: more than %d materials", (int)MOST);
    const ff_status status = ff_material_model(m, &out->model[out->n], &err);
    if (status != FF_OK) return cli_failed(status, &err);
    out->target[out->n] = (ff_report_target){.target = t, .material = m};
    return cli_hold_and_free(args, &out->model[out->n++], 1);
}

static int add_target(const cli_args *args, const ff_target *t, cli_combinations *out)
{
    int status = EXIT_DONE;
    for (size_t i = 0; i < t->n_materials && status == EXIT_DONE; i++) status = add_material(args, t, &t->material[i], out);
    return status;
}

/* "blender" or "blender:metal" */
static int add_word(const cli_args *args, const char *word, cli_combinations *out)
{
    const char *colon = strchr(word, ':');
    char name[CLI_NAME];
    snprintf(name, sizeof name, "%.*s", (int)(colon ? colon - word : (int)strlen(word)), word);
    const ff_target *t = ff_target_find(name);
    if (!t) return unknown(args, name);
    if (!colon) return add_target(args, t, out);
    const ff_material *m = ff_material_find(t, colon + 1, strlen(colon + 1));
    return m ? add_material(args, t, m, out) : no_material(args, t, word);
}

int cli_renderers_read(const cli_args *args, int several, cli_combinations *out)
{
    const char *list = cli_value(args, FLAG_FOR, "");
    int status = EXIT_DONE;
    *out = (cli_combinations){.model = malloc((MOST + 1) * sizeof *out->model), .target = calloc(MOST, sizeof *out->target)};
    if (!out->model || !out->target) return cli_failed(FF_ERR_MEMORY, NULL);
    if (several && !strcmp(list, "all")) {
        for (size_t i = 0; i < ff_target_count() && status == EXIT_DONE; i++) status = add_target(args, ff_target_at(i), out);
        return status;
    }
    for (;; list++) {
        char word[2 * CLI_NAME];
        const size_t n = strcspn(list, several ? "," : "");
        if (n >= sizeof word) return unknown(args, "a name so long");
        snprintf(word, sizeof word, "%.*s", (int)n, list);
        status = add_word(args, word, out);
        list += n;
        if (status != EXIT_DONE || !*list) return status;
    }
}
