/* facetfit plot KIND SOURCE...: a figure. */
#include "internal_plotting.h"
#include <stdlib.h>
#include <string.h>

/* By the extension of -o; standard output gets SVG. */
static int form_of(const cli_args *args, const char *path, ff_figure_form *out)
{
    const int form = strcmp(path, "-") ? ff_figure_form_find(path) : FF_FIGURE_SVG;
    if (form < 0) return cli_usage(args, "-o %s: expected a name that ends in .svg, .pdf or .csv", path);
    *out = (ff_figure_form)form;
    return EXIT_DONE;
}

static int write_figure(const cli_args *args, const char *path, const ff_figure *fig, ff_figure_form form)
{
    ff_output out;
    ff_error err = {0};
    ff_status status = ff_output_open_with(path, args->outputs, &out, &err);
    if (status != FF_OK) return cli_failed(status, &err);
    status = ff_figure_write(fig, form, out.file, &err);
    if (status == FF_OK)
        status = ff_output_commit(&out, &err);
    else
        ff_output_abort(&out);
    return status == FF_OK ? EXIT_DONE : status == FF_ERR_RANGE ? cli_failed(FF_ERR_SYNTAX, &err) : cli_failed(status, &err);
}

/* A choice that the kind does not look at would go unnoticed. */
static int check_choices(const cli_args *args, const ff_plot_kind *kind)
{
    static const struct {
        cli_flag_id flag;
        unsigned use;
    } choices[] = {{FLAG_INCIDENCE, FF_PLOT_INCIDENCE}, {FLAG_LOG, FF_PLOT_LOG},
                   {FLAG_CHANNEL, FF_PLOT_CHANNEL},     {FLAG_PARAMETER, FF_PLOT_PARAMETER},
                   {FLAG_ROUGHNESS, FF_PLOT_ROUGHNESS}, {FLAG_BOOTSTRAP, FF_PLOT_REFITS},
                   {FLAG_SEED, FF_PLOT_REFITS},         {FLAG_PROFILE, FF_PLOT_PROFILE}};
    for (size_t k = 0; k < sizeof choices / sizeof *choices; k++)
        if (cli_given(args, choices[k].flag) && !(kind->uses & choices[k].use))
            return cli_usage(args, "--%s has no effect on '%s': leave it out", cli_flag_name(choices[k].flag), kind->name);
    return EXIT_DONE;
}

static int draw(const cli_args *args, const ff_plot_kind *kind, const ff_plot_choice *choice, const cli_subject *s, ff_figure *fig)
{
    ff_error err = {0};
    ff_status failed = kind->build(&s->subject, choice, fig, &err);
    if (failed == FF_OK) failed = fig->status;
    if (failed != FF_OK) {
        if (!err.path[0] && s->subject.path && failed == FF_ERR_DATA) snprintf(err.path, sizeof err.path, "%s", s->subject.path);
        return cli_failed(failed, &err);
    }
    if (cli_given(args, FLAG_TITLE)) snprintf(fig->title, sizeof fig->title, "%s", cli_value(args, FLAG_TITLE, ""));
    if (!cli_given(args, FLAG_PER_ROW)) ff_figure_narrow(fig);
    fig->columns = (size_t)cli_integer(args, FLAG_PER_ROW, fig->columns);
    return EXIT_DONE;
}

int cmd_plot(const cli_args *args)
{
    const ff_plot_kind *kind = ff_plot_kind_at((size_t)cli_words_find(cli_words_plot, args->word[0], strlen(args->word[0])));
    const char *path = cli_value(args, FLAG_OUTPUT, "-");
    ff_figure_form form = FF_FIGURE_SVG;
    ff_figure fig;
    ff_plot_choice choice;
    cli_subject *s = calloc(1, sizeof *s);
    if (!s) return cli_failed(FF_ERR_MEMORY, NULL);
    int status = form_of(args, path, &form);
    if (status == EXIT_DONE) status = check_choices(args, kind);
    if (status == EXIT_DONE) status = cli_figure_read(args, &fig, &choice);
    if (status == EXIT_DONE) {
        status = cli_subject_gather(args, kind, &choice, s);
        if (status == EXIT_DONE) status = draw(args, kind, &choice, s, &fig);
        if (status == EXIT_DONE) status = write_figure(args, path, &fig, form);
        ff_figure_clear(&fig);
        if (status == EXIT_DONE) status = s->outcome;
        cli_subject_free(s);
    }
    free(s);
    return status;
}
