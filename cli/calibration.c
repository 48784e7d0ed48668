/* --reference and --dark: signals become reflectance. */
#include "internal_cli.h"
#include "data_formats/table/ff_calibration.h"
#include "data_formats/table/internal_table.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { PATH_SIZE = 4096 };

/* A second measurement, read as the data are. */
static int read_second(const cli_args *args, const ff_read_options *o, const char *flag, const char *path, ff_table *out)
{
    ff_error err = {0};
    ff_status failed = cli_files_ask(args, path, &err);
    if (failed == FF_OK) failed = ff_table_read_with_into(path, o, out, &err);
    if (failed == FF_OK) return EXIT_DONE;
    if (!err.path[0]) snprintf(err.path, sizeof err.path, "%s %s", flag, path);
    return cli_failed(failed, &err);
}

/* "FILE:R" apart; a name may hold colons of its own. *r = 1 where there is no R. */
static int take_reflectance(const cli_args *args, const char *word, char path[PATH_SIZE], double *r)
{
    const char *colon = strrchr(word, ':');
    const int has_r = colon && cli_number_read(colon + 1, r);
    const size_t n = has_r ? (size_t)(colon - word) : strlen(word);
    if (!has_r) *r = 1;
    if (n == 0 || n >= PATH_SIZE) return cli_usage(args, "--reference %s: expected FILE or FILE:R", word);
    if (!(*r > 0 && isfinite(*r))) return cli_usage(args, "--reference %s: expected a reflectance above 0", word);
    memcpy(path, word, n);
    path[n] = '\0';
    return EXIT_DONE;
}

static const char *by_what(ff_matched how)
{
    return how == FF_MATCHED_PAIRS ? "pair by pair" : how == FF_MATCHED_INCIDENCE ? "by the mean at each incidence" : "by its mean";
}

/* What was done, as sentences of the table. */
static void note(const ff_calibration *c, const ff_calibrated *done, const char *reference, ff_table *t)
{
    if (c->dark || c->dark_signal != 0)
        ff_table_note(t, "the dark was subtracted%s%s", c->dark ? ", " : "", c->dark ? by_what(done->dark) : "");
    if (!c->reference) return;
    ff_table_note(t, "values are BRDFs by the standard %s of reflectance %g, %s", reference, c->reflectance,
                  by_what(done->reference));
    if (done->reference_error > 1e-4)
        ff_table_note(
            t,
            "the standard's means are known to %.2g %%, which all values share: --scale-uncertainty %.2g%% adds it to the errors",
            100 * done->reference_error, 100 * done->reference_error);
    else if (isnan(done->reference_error) && done->reference != FF_MATCHED_PAIRS)
        ff_table_note(t, "the standard was read once: how well its signal is known is not said, and is in no error; "
                         "--scale-uncertainty takes it");
    if (done->n_lost)
        ff_table_note(t, "%zu samples whose standard reads no more than the dark count as not measured", done->n_lost);
}

static int calibrate(const cli_args *args, const ff_read_options *o, ff_calibration *c, ff_table *reference, ff_table *dark,
                     ff_table *t)
{
    const char *standard = cli_value(args, FLAG_REFERENCE, NULL), *signal = cli_value(args, FLAG_DARK, NULL);
    char path[PATH_SIZE] = "";
    ff_calibrated done;
    ff_error err = {0};
    int status = standard ? take_reflectance(args, standard, path, &c->reflectance) : EXIT_DONE;
    if (status == EXIT_DONE && standard) {
        status = read_second(args, o, "--reference", path, reference);
        c->reference = reference;
    }
    if (status == EXIT_DONE && signal && !*signal) status = cli_usage(args, "--dark: expected a file or a number");
    if (status == EXIT_DONE && signal && !cli_number_read(signal, &c->dark_signal)) {
        status = read_second(args, o, "--dark", signal, dark);
        c->dark = dark;
    }
    if (status != EXIT_DONE) return status;
    const ff_status failed = ff_table_calibrate(t, c, &done, &err);
    if (failed != FF_OK) {
        const int of_dark = signal && (!standard || !strncmp(err.message, "the dark", strlen("the dark")));
        snprintf(err.path, sizeof err.path, "%s %.400s", of_dark ? "--dark" : "--reference", of_dark ? signal : path);
        return cli_failed(failed, &err);
    }
    note(c, &done, path, t);
    return EXIT_DONE;
}

int cli_calibrate(const cli_args *args, const ff_read_options *o, ff_table *t)
{
    ff_table reference = {.n = 0}, dark = {.n = 0};
    ff_calibration c = {.reflectance = 1};
    if (!cli_given(args, FLAG_REFERENCE) && !cli_given(args, FLAG_DARK)) return EXIT_DONE;
    const int status = calibrate(args, o, &c, &reference, &dark, t);
    ff_table_clear(&reference);
    ff_table_clear(&dark);
    return status;
}
