/* The flags that say how a figure looks and what of its subject it shows. */
#include "internal_plotting.h"
#include <math.h>
#include <string.h>

static const struct {
    const char *name;
    double points;
} units[] = {{"mm", 72 / 25.4}, {"cm", 720 / 25.4}, {"in", 72}, {"pt", 1}};

/* "85mm" in points; a number alone is in `unit`. 0 when it is none. */
static int length_read(const char *text, double unit, double *out)
{
    char number[CLI_NAME];
    const size_t n = strlen(text);
    for (size_t k = 0; k < sizeof units / sizeof *units; k++) {
        if (n < 3 || strcmp(text + n - 2, units[k].name)) continue;
        snprintf(number, sizeof number, "%.*s", (int)(n - 2), text);
        if (n - 2 >= sizeof number || !cli_number_read(number, out)) return 0;
        *out *= units[k].points;
        return 1;
    }
    if (!cli_number_read(text, out)) return 0;
    *out *= unit;
    return 1;
}

static int take_length(const cli_args *args, cli_flag_id flag, double unit, double lo, double hi, const char *range, double *out)
{
    const char *text = cli_value(args, flag, NULL);
    double points;
    if (!text) return EXIT_DONE;
    if (!length_read(text, unit, &points) || !(points >= lo * (1 - 1e-9) && points <= hi * (1 + 1e-9)))
        return cli_usage(args, "--%s %s: expected a length %s", cli_flag_name(flag), text, range);
    *out = points;
    return EXIT_DONE;
}

static void take_numbers(const cli_args *args, cli_flag_id flag, double *out, size_t *n)
{
    const char *text = cli_value(args, flag, NULL);
    *n = text ? cli_list_read(text, FF_PLOT_LIST, out) : 0;
}

static int take_lists(const cli_args *args, ff_plot_choice *c)
{
    static const cli_flag_id flag[] = {FLAG_INCIDENCE, FLAG_ROUGHNESS};
    double *const list[] = {c->incidence, c->roughness};
    size_t *const n[] = {&c->n_incidence, &c->n_roughness};
    for (size_t k = 0; k < 2; k++) {
        take_numbers(args, flag[k], list[k], n[k]);
        if (cli_given(args, flag[k]) && *n[k] == 0)
            return cli_usage(args, "--%s: at most %d values", cli_flag_name(flag[k]), (int)FF_PLOT_LIST);
    }
    return EXIT_DONE;
}

int cli_figure_read(const cli_args *args, ff_figure *fig, ff_plot_choice *c)
{
    const double mm = 72 / 25.4;
    *c = (ff_plot_choice){.log = cli_switch(args, FLAG_LOG, -1),
                          .channel = cli_value(args, FLAG_CHANNEL, NULL),
                          .parameter = cli_value(args, FLAG_PARAMETER, NULL),
                          .repeats = (size_t)cli_integer(args, FLAG_BOOTSTRAP, 200),
                          .seed = cli_integer(args, FLAG_SEED, 1)};
    ff_figure_init(fig);
    int status = cli_isa(args, &c->isa);
    if (status == EXIT_DONE)
        status = take_length(args, FLAG_WIDTH, mm, 20 * mm, 2000 * mm, "from 20mm to 2000mm, with mm, cm, in or pt", &fig->width);
    if (status == EXIT_DONE)
        status = take_length(args, FLAG_HEIGHT, mm, 15 * mm, 2000 * mm, "from 15mm to 2000mm, with mm, cm, in or pt", &fig->height);
    if (status == EXIT_DONE)
        status = take_length(args, FLAG_FONT_SIZE, 1, 3, 72, "from 3pt to 72pt, with pt, mm, cm or in", &fig->font);
    return status == EXIT_DONE ? take_lists(args, c) : status;
}
