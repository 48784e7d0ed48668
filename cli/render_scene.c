/* The flags of `render` that say where light comes from and where it is seen from. */
#include "internal_rendering.h"
#include <math.h>
#include <string.h>

static const double degree = 3.14159265358979323846 / 180;

/* ---- lights ---------------------------------------------------------------------------------- */

/* "THETA,PHI" or "X,Y,Z"; 0 when it is neither. */
static int direction_read(const char *text, double out[3])
{
    double v[3];
    const size_t n = cli_numbers_read(text, ',', 3, v);
    if (n == 2) {
        if (!(fabs(v[0]) <= 180 && fabs(v[1]) <= 1e6)) return 0;
        out[0] = sin(v[0] * degree) * cos(v[1] * degree);
        out[1] = sin(v[0] * degree) * sin(v[1] * degree);
        out[2] = cos(v[0] * degree);
        return 1;
    }
    memcpy(out, v, sizeof v);
    return n == 3 && (v[0] != 0 || v[1] != 0 || v[2] != 0);
}

static int read_lights(const cli_args *args, cli_light *l)
{
    size_t n = 0;
    for (size_t i = 0; i < args->n_given; i++) {
        if (args->flag[i] != FLAG_LIGHT) continue;
        if (n == FF_RENDER_LIGHTS_MAX) return cli_usage(args, "--light: at most %d", (int)FF_RENDER_LIGHTS_MAX);
        if (!direction_read(args->value[i], l->direction[n++]))
            return cli_usage(
                args, "--light %s: expected THETA,PHI in degrees, theta from the view and at most 180, or X,Y,Z that are not all 0",
                args->value[i]);
    }
    if (n == 0 && !l->environment) direction_read("45,135", l->direction[n++]);
    l->options.n_lights = n;
    l->options.light = (const double(*)[3])l->direction;
    return EXIT_DONE;
}

/* ---- the environment ------------------------------------------------------------------------- */

static int failed_about(const char *text, ff_status status, ff_error *err)
{
    if (status != FF_ERR_RANGE) return cli_failed(status, err);
    cli_error("--environment %s: %s", text, err->message);
    return cli_exit_status(status);
}

/* "sky" or "sky:ELEVATION[:TURBIDITY[:GROUND]]" */
static int read_sky(const cli_args *args, const char *text, double turn, ff_environment **out)
{
    double v[4] = {35, 3, 0.2};
    ff_error err = {0};
    if (text[3] == ':') {
        double given[4];
        const size_t n = cli_numbers_read(text + 4, ':', 4, given);
        if (n < 1 || n > 3 || !(given[0] >= 0 && given[0] <= 90) || (n > 1 && !(given[1] >= 2 && given[1] <= 10)) ||
            (n > 2 && !(given[2] >= 0 && given[2] <= 1)))
            return cli_usage(
                args,
                "--environment %s: expected sky:ELEVATION[:TURBIDITY[:GROUND]], the sun's elevation in degrees from 0 to 90, "
                "turbidity from 2 to 10, reflectance of the ground from 0 to 1",
                text);
        memcpy(v, given, n * sizeof *v);
    }
    const ff_status status = ff_environment_sky(v[0] * degree, v[1], v[2], turn, out, &err);
    return status == FF_OK ? EXIT_DONE : failed_about(text, status, &err);
}

static int read_environment(const cli_args *args, cli_light *l)
{
    const char *text = cli_value(args, FLAG_ENVIRONMENT, NULL);
    const double turn = cli_number(args, FLAG_TURN, 0) * degree;
    ff_error err = {0};
    if (!text)
        return cli_given(args, FLAG_TURN) ? cli_usage(args, "--turn turns the environment, and there is none: add --environment")
                                          : EXIT_DONE;
    if (!*text) return cli_usage(args, "--environment: expected uniform, sky[:...] or the name of a file");
    if (!strcmp(text, "uniform")) {
        const ff_status status = ff_environment_new(1, 1, (const float[]){1, 1, 1}, 0, &l->environment, &err);
        return status == FF_OK ? EXIT_DONE : cli_failed(status, &err);
    }
    if (!strncmp(text, "sky", 3) && (!text[3] || text[3] == ':')) return read_sky(args, text, turn, &l->environment);
    ff_status status = cli_files_ask(args, text, &err);
    if (status == FF_OK) status = ff_environment_read(text, turn, &l->environment, &err);
    return status == FF_OK ? EXIT_DONE : failed_about(text, status, &err);
}

/* ---- all ------------------------------------------------------------------------------------- */

int cli_light_read(const cli_args *args, cli_light *out)
{
    ff_render_options *o = &out->options;
    ff_render_options_init(o);
    o->pixels = (size_t)cli_integer(args, FLAG_SIZE, o->pixels);
    o->samples = (size_t)cli_integer(args, FLAG_SAMPLES, o->samples);
    o->seed = cli_integer(args, FLAG_SEED, o->seed);
    o->threads = (int)cli_integer(args, FLAG_THREADS, 0);
    o->perspective = cli_number(args, FLAG_PERSPECTIVE, 0) * degree;
    if (o->samples < 1 || o->samples > FF_RENDER_SAMPLES_MAX)
        return cli_usage(args, "--samples %s: expected 1 to %d", cli_value(args, FLAG_SAMPLES, ""), (int)FF_RENDER_SAMPLES_MAX);
    int status = cli_isa(args, &o->isa);
    if (status == EXIT_DONE) status = read_environment(args, out);
    if (status == EXIT_DONE) status = read_lights(args, out);
    o->environment = out->environment;
    return status;
}

void cli_light_free(cli_light *l)
{
    ff_environment_free(l->environment);
    l->environment = NULL;
}

int cli_sweep_read(const cli_args *args, cli_flag_id flag, cli_sweep *out)
{
    const char *text = cli_value(args, flag, NULL);
    cli_assignment a;
    *out = (cli_sweep){0};
    if (!text) return EXIT_DONE;
    const int read = cli_assignment_read(text, &a) && a.rest && !*a.channel;
    const size_t most = sizeof out->value / sizeof *out->value;
    if (read) out->n = cli_list_read(a.rest, most, out->value);
    if (!out->n)
        return cli_usage(args, "--%s %s: expected a parameter and at most %zu values: alpha={0.1,0.3,1}", cli_flag_name(flag), text,
                         most);
    snprintf(out->name, sizeof out->name, "%s", a.name);
    return EXIT_DONE;
}
