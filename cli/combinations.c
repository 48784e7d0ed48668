/* Every combination of the terms that flags name. */
#include "internal_cli.h"
#include <stdlib.h>
#include <string.h>

enum { TERMS = 64 };

/* Indices of the terms that a list names. */
typedef struct term_list {
    size_t n;
    int term[TERMS];
} term_list;

static void list_all(ff_term_kind kind, term_list *list)
{
    for (size_t i = 0; i < ff_term_count(kind); i++) {
        if (ff_term_at(kind, i)->claims & FF_FURNACE_ONLY || list->n == TERMS) continue;
        list->term[list->n++] = (int)i;
    }
}

/* The terms of a list, which the parser knows; "none" of the diffuse ones is -1, a model of lobes alone. One that stands there
 * twice is taken once. */
static void read_list(const cli_args *args, cli_flag_id flag, ff_term_kind kind, const char *otherwise, term_list *list)
{
    const char *word = cli_value(args, flag, otherwise);
    list->n = 0;
    for (;; word++) {
        char name[CLI_NAME];
        const size_t n = strcspn(word, ",");
        snprintf(name, sizeof name, "%.*s", (int)n, word);
        const int term = ff_term_find(kind, name);
        int seen = 0;
        for (size_t i = 0; i < list->n; i++) seen |= list->term[i] == term;
        if (!strcmp(name, "all")) {
            list->n = 0;
            list_all(kind, list);
            return;
        }
        if (!seen && list->n < TERMS) list->term[list->n++] = term;
        word += n;
        if (!*word) return;
    }
}

static void leave_out(cli_combinations *all, const ff_error *err)
{
    if (all->left_out++ == 0) snprintf(all->example, sizeof all->example, "%.250s", err->message);
}

/* Is one of the lists `all`, said or by default? Then it is no news that some terms do not go together. */
static int says_all(const cli_args *args)
{
    return !strcmp(cli_value(args, FLAG_NDF, "all"), "all") || !strcmp(cli_value(args, FLAG_MASKING, "all"), "all") ||
           !strcmp(cli_value(args, FLAG_FRESNEL, ""), "all") || !strcmp(cli_value(args, FLAG_DIFFUSE, ""), "all");
}

/* Every combination that means something, in the order NDF, masking, Fresnel, diffuse. */
static int compose_all(const cli_args *args, const cli_tables *tables, const term_list *ndf, const term_list *masking,
                       const term_list *fresnel, const term_list *diffuse, cli_combinations *all)
{
    for (size_t d = 0; d < ndf->n; d++)
        for (size_t g = 0; g < masking->n; g++)
            for (size_t f = 0; f < fresnel->n; f++)
                for (size_t b = 0; b < diffuse->n; b++) {
                    ff_error err = {0};
                    ff_model *m = &all->model[all->n];
                    ff_status status =
                        ff_model_compose(ndf->term[d], masking->term[g], fresnel->term[f], diffuse->term[b], m, &err);
                    if (status == FF_OK) status = cli_tables_give(tables, m, &err);
                    if (status == FF_ERR_UNSUPPORTED) {
                        leave_out(all, &err);
                        continue;
                    }
                    if (status != FF_OK) return cli_failed(status, &err);
                    const int held = cli_hold_and_free(args, m, 1);
                    if (held != EXIT_DONE) return held;
                    all->n++;
                }
    if (all->n == 0) return cli_usage(args, "no combination of these terms has a meaning: %s", all->example);
    if (all->left_out && !says_all(args))
        cli_note("left out %zu combination%s of terms that do not go together: %s%s", all->left_out, all->left_out == 1 ? "" : "s",
                 all->example, all->left_out == 1 ? "" : ", ...");
    return EXIT_DONE;
}

int cli_combine(const cli_args *args, const cli_tables *tables, const char *all_ndf, const char *all_masking, cli_combinations *out)
{
    term_list ndf, masking, fresnel, diffuse;
    read_list(args, FLAG_NDF, FF_NDF, all_ndf, &ndf);
    read_list(args, FLAG_MASKING, FF_MASKING, all_masking, &masking);
    read_list(args, FLAG_FRESNEL, FF_FRESNEL, "schlick", &fresnel);
    read_list(args, FLAG_DIFFUSE, FF_DIFFUSE, "lambert", &diffuse);
    *out = (cli_combinations){.model = malloc((ndf.n * masking.n * fresnel.n * diffuse.n + 1) * sizeof *out->model)};
    if (!out->model) return cli_failed(FF_ERR_MEMORY, NULL);
    return compose_all(args, tables, &ndf, &masking, &fresnel, &diffuse, out);
}
