/* The one table of flags: the parser, --help and the usage errors read it. */
#include "internal_cli.h"
#include <stdlib.h>
#include <string.h>

enum {
    C_FIT = 1u << 0,
    C_COMPARE = 1u << 1,
    C_CONVERT = 1u << 2,
    C_EVAL = 1u << 3,
    C_SIMULATE = 1u << 4,
    C_FURNACE = 1u << 5,
    C_SAMPLE = 1u << 6,
    C_INFO = 1u << 7,
    C_MODELS = 1u << 8,
    C_FORMATS = 1u << 9,
    C_NDF = 1u << 10,
    C_RESAMPLE = 1u << 11,
    C_FITTING = C_FIT | C_COMPARE,
    C_MEASURED = C_FITTING | C_NDF,
    C_READS = C_MEASURED | C_INFO | C_RESAMPLE,
    C_SCENE = C_EVAL | C_SIMULATE | C_FURNACE | C_SAMPLE,
    C_ALL = (1u << 12) - 1
};

/* Bit i is command i of this table. */
static const cli_command commands[] = {
    {"fit", "FILE", "find the parameters of one model in measured data",
     "Prints parameters with standard errors, the roughness ellipse, residuals and warnings.\n"
     "Exit status 1 when the fit did not converge.\n",
     INPUT_FILE, NO_FILE, 1, 1, cmd_fit},
    {"compare", "FILE", "fit every distribution under every masking to the same samples",
     "Rows are ranked by the objective; the best is marked '*'. 'all' leaves out maskings that exist for the furnace test alone.\n"
     "Exit status 1 when the best fit did not converge.\n",
     INPUT_FILE, NO_FILE, 1, 1, cmd_compare},
    {"convert", "[--from NAME --to NAME NAME=VALUE ...]", "roughness of one convention in terms of another",
     "Prints 'name value' lines; without --by, every criterion as a third word. What is assumed goes to stderr.\n"
     "Angles are in degrees. Without --from, lists the conversions.\n",
     NO_FILE, NO_FILE, 0, 8, cmd_convert},
    {"eval", "EXPR [FILE]", "values of a model for pairs of directions",
     "Reads CSV with the columns theta_i,phi_i,theta_o,phi_o in degrees (others are ignored) from FILE or stdin ('-') and prints "
     "the\n"
     "same rows with f in 1/sr (f_r,f_g,f_b when parameters are given for three channels).\n",
     NO_FILE, INPUT_FILE, 1, 2, cmd_eval},
    {"simulate", "EXPR", "make a data set from a model",
     "Values are f (1 + noise g1) + noise-floor g2 with standard normal g1, g2. MERL files hold no negative values: there a value "
     "that\n"
     "noise pushes below 0 is stored as 0, and a message counts them.\n",
     NO_FILE, NO_FILE, 1, 1, cmd_simulate},
    {"furnace", "EXPR", "directional albedo of a model, or its weak white furnace integral",
     "Prints 'mu,albedo' rows, mu the cosine of the view. With --weak, exit status 1 when a masking that claims an integral of 1\n"
     "misses it by more than 1e-6.\n",
     NO_FILE, NO_FILE, 1, 1, cmd_furnace},
    {"sample", "EXPR", "directions of light drawn in proportion to a model",
     "Prints 'theta_i,phi_i,pdf,f,weight' rows for one view: angles in degrees, pdf and f in 1/sr, weight = f cos(theta_i) / pdf. "
     "A\n"
     "direction below the horizon is lost: its pdf, f and weight are 0. The mean of weight over all rows is the directional "
     "albedo.\n",
     NO_FILE, NO_FILE, 1, 1, cmd_sample},
    {"info", "FILE", "what is in a file", "", INPUT_FILE, NO_FILE, 1, 1, cmd_info},
    {"models", "", "distributions, maskings, Fresnel and diffuse terms with their parameters; presets", "", NO_FILE, NO_FILE, 0, 0,
     cmd_models},
    {"formats", "", "file formats", "", NO_FILE, NO_FILE, 0, 0, cmd_formats},
    {"ndf", "FILE", "the distribution of normals behind measured data, without a formula",
     "Prints measures of the roughness, F0 and kd, and the residual beside those of the parametric fits; -o writes the table that "
     "the\n"
     "distribution `tabulated` reads, '-o -' to stdout and nothing else. Exit status 1 when the retrieval did not converge.\n",
     INPUT_FILE, NO_FILE, 1, 1, cmd_ndf},
    {"resample", "IN OUT", "convert measured data to another format",
     "The format of OUT is that of its extension, or --to. Where it needs other directions than IN has, values are interpolated; "
     "what\n"
     "was interpolated, taken by reciprocity, extrapolated or dropped is counted on stdout.\n",
     INPUT_FILE, OUTPUT_FILE, 2, 2, cmd_resample},
};
enum { COMMANDS = sizeof commands / sizeof commands[0] };

typedef struct flag {
    const char *name;
    char letter;          /* short form, 0 = none      */
    const char *argument; /* NULL for a switch         */
    cli_file file;        /* what the value names      */
    unsigned commands;
    const char *help;
} flag;

/* Indexed by cli_flag_id. */
static const flag flags[FLAG_COUNT] = {
    [FLAG_MODEL] = {"model", 0, "EXPR", NO_FILE, C_FIT, "sum of lobes NDF[/MASKING[/FRESNEL]] and a diffuse name (ggx+lambert)"},
    [FLAG_NDF] = {"ndf", 0, "LIST|all", NO_FILE, C_COMPARE, "distributions, separated by commas (all)"},
    [FLAG_MASKING] = {"masking", 0, "LIST|all", NO_FILE, C_COMPARE | C_NDF,
                      "masking functions (all); of ndf one (smith-height-correlated)"},
    [FLAG_FRESNEL] = {"fresnel", 0, "LIST|all", NO_FILE, C_COMPARE, "Fresnel terms (schlick)"},
    [FLAG_DIFFUSE] = {"diffuse", 0, "LIST|all|none", NO_FILE, C_COMPARE, "diffuse terms (lambert)"},
    [FLAG_SET] = {"set", 0, "P=V,...", NO_FILE, C_SCENE,
                  "parameters; v1:v2:v3 gives one value per channel; alpha=v sets both axes"},
    [FLAG_FREE] = {"free", 0, "P,...", NO_FILE, C_FITTING, "also fit parameters that are held at a value otherwise (ks, ginneken)"},
    [FLAG_FIX] = {"fix", 0, "P=V,...", NO_FILE, C_FITTING, "hold parameters at a value"},
    [FLAG_BOUND] = {"bound", 0, "P=LO:HI,...", NO_FILE, C_FITTING, "keep parameters between bounds"},
    [FLAG_PRIOR] = {"prior", 0, "P=M+-S,...", NO_FILE, C_FITTING,
                    "parameters known before: mean and standard deviation, f0=0.04+-0.01"},
    [FLAG_TIE] = {"tie", 0, "P=Q,...|P", NO_FILE, C_FITTING,
                  "make parameters equal, lobe2.f0=f0; one name: one value for all channels"},
    [FLAG_ENERGY] = {"energy-conserving", 0, NULL, NO_FILE, C_FITTING,
                     "reflect no more than arrives, at any incidence and in any channel"},
    [FLAG_TABLE] = {"table", 0, "FILE", INPUT_FILE, C_FITTING | C_SCENE, "profile of the distribution `tabulated`"},
    [FLAG_SHAPE] = {"shape", 0, "NAME", NO_FILE, C_FITTING, "auto, isotropic, axis or correlated (auto)"},
    [FLAG_LOSS] = {"loss", 0, "NAME", NO_FILE, C_MEASURED, "cosine, log, cube-root, relative or plain (cosine)"},
    [FLAG_ROBUST] = {"robust", 0, "NAME[:SCALE]", NO_FILE, C_FITTING,
                     "huber, cauchy or tukey; SCALE in units of the weighted residual, else estimated; counts outliers (none)"},
    [FLAG_SATURATION] = {"saturation", 0, "X", NO_FILE, C_FITTING, "values at or above X (1/sr) are only known to be at least X"},
    [FLAG_NEGATIVE] = {"negative", 0, "keep|drop", NO_FILE, C_FITTING, "samples with a negative value: noise, or left out (keep)"},
    [FLAG_WEIGHT] = {"weight", 0, "NAME", NO_FILE, C_MEASURED, "solid-angle, sigma or sample (auto: the first the file offers)"},
    [FLAG_MAX_THETA] = {"max-theta", 0, "DEG", NO_FILE, C_MEASURED, "leave out samples beyond this angle (80)"},
    [FLAG_CUT_OFF] = {"cut-off", 0, "DEG", NO_FILE, C_FIT,
                      "fit again up to this angle and say what moves; 0: not (10 below --max-theta)"},
    [FLAG_PROFILE] = {"profile", 0, NULL, NO_FILE, C_FIT, "intervals by the profile of the objective, not by standard errors"},
    [FLAG_BOOTSTRAP] = {"bootstrap", 0, "N", NO_FILE, C_FIT, "errors and intervals by N refits to reweighted incident directions"},
    [FLAG_CROSS_VALIDATE] = {"cross-validate", 0, "K", NO_FILE, C_COMPARE,
                             "also compare on incident directions that a fit has not seen, in K parts"},
    [FLAG_RESIDUALS] = {"residuals", 0, "FILE", OUTPUT_FILE, C_FITTING,
                        "write model - data of every sample (compare: of the best) as .csv or .exr"},
    [FLAG_CHANNELS] = {"channels", 0, "rgb|mean|each", NO_FILE, C_MEASURED,
                       "share the shape, average first, or fit each alone (rgb)"},
    [FLAG_MEAN_SLOPE] = {"mean-slope", 0, NULL, NO_FILE, C_FITTING, "fit the mean slope too: a sample mounted at a tilt"},
    [FLAG_MAX_ITERATIONS] = {"max-iterations", 0, "N", NO_FILE, C_MEASURED, "of the solver (100)"},
    [FLAG_SMOOTH] = {"smooth", 0, "S", NO_FILE, C_NDF, "weight of the penalty on what is not smooth (by cross-validation)"},
    [FLAG_NODES] = {"nodes", 0, "N", NO_FILE, C_NDF, "angles at which D is free, 31 to 100 (by the range of the data)"},
    [FLAG_MONOTONE] = {"monotone", 0, "slopes|d", NO_FILE, C_NDF,
                       "what must not rise with the angle: the density of slopes, D cos^4, or D itself (slopes)"},
    [FLAG_FROM] = {"from", 0, "NAME", NO_FILE, C_CONVERT, "convention of the numbers given"},
    [FLAG_TO] = {"to", 0, "NAME", NO_FILE, C_CONVERT | C_RESAMPLE, "convention wanted"},
    [FLAG_BY] = {"by", 0, "CRITERION", NO_FILE, C_CONVERT, "what is to be equal, where there is a choice (all of them)"},
    [FLAG_LIST] = {"list", 0, NULL, NO_FILE, C_CONVERT, "list the conversions"},
    [FLAG_TERMS] = {"terms", 0, NULL, NO_FILE, C_EVAL, "also D, Lambda of both directions, G and F"},
    [FLAG_MARKDOWN] = {"markdown", 0, NULL, NO_FILE, C_MODELS, "as the page docs/models.md"},
    [FLAG_ROWS] = {"rows", 0, "N", NO_FILE, C_COMPARE, "rows of the table, the best ones; 0 for all (25). The JSON has all"},
    [FLAG_GRID] = {"grid", 0, "NAME", NO_FILE, C_SIMULATE | C_READS,
                   "merl, goniometer[:STEP] or scattered:N[:FRACTION near the mirror direction] (goniometer:5)"},
    [FLAG_NOISE] = {"noise", 0, "REL", NO_FILE, C_SIMULATE, "standard deviation of multiplicative noise (0)"},
    [FLAG_NOISE_FLOOR] = {"noise-floor", 0, "X", NO_FILE, C_SIMULATE | C_FITTING, "standard deviation of additive noise, 1/sr (0)"},
    [FLAG_SIGMA] = {"sigma", 0, NULL, NO_FILE, C_SIMULATE, "write the standard deviations too (csv)"},
    [FLAG_SEED] = {"seed", 0, "N", NO_FILE, C_SIMULATE | C_SAMPLE | C_FIT, "of noise and random directions (1)"},
    [FLAG_COLUMNS] = {"columns", 0, "K=NAME,...", NO_FILE, C_READS,
                      "columns of a CSV: theta_i=incidence,f=reflectance,phi_i=0 (by their names)"},
    [FLAG_QUANTITY] = {"quantity", 0, "NAME", NO_FILE, C_READS,
                       "what the numbers are: brdf, brdf-cos or reflectance-factor (as the file says)"},
    [FLAG_SCALE] = {"scale", 0, "X", NO_FILE, C_READS, "factor on all values, of a file that is not calibrated"},
    [FLAG_PART] = {"part", 0, "NAME", NO_FILE, C_READS, "which data set of a file that has several, e.g. reflection-back"},
    [FLAG_REDUCE] = {"reduce", 0, "TO", NO_FILE, C_READS,
                     "channels: srgb[:d65|e], bands:NAME=LO-HI,..., channels:NAME,... or mean (as they are)"},
    [FLAG_EXTRAPOLATE] = {"extrapolate", 0, NULL, NO_FILE, C_RESAMPLE, "fill what lies beyond the data with the nearest values"},
    [FLAG_OUTPUT] = {"output", 'o', "FILE", OUTPUT_FILE, C_SIMULATE | C_NDF, "where to write; '-' is stdout"},
    [FLAG_WEAK] = {"weak", 0, NULL, NO_FILE, C_FURNACE, "the weak white furnace integral instead of the albedo"},
    [FLAG_MU] = {"mu", 0, "LIST", NO_FILE, C_FURNACE, "cosines of the view, in (0, 1] (1,0.9,...,0.1)"},
    [FLAG_THETA] = {"theta", 0, "DEG", NO_FILE, C_SAMPLE, "angle of the view from the normal (0)"},
    [FLAG_PHI] = {"phi", 0, "DEG", NO_FILE, C_FURNACE | C_SAMPLE, "azimuth of the view (0)"},
    [FLAG_SAMPLES] = {"samples", 'n', "N", NO_FILE, C_SAMPLE, "how many (1000)"},
    [FLAG_FORMAT] = {"format", 0, "NAME", NO_FILE, C_READS | C_SIMULATE, "of FILE (reading: by content; writing: by extension)"},
    [FLAG_THREADS] = {"threads", 0, "N", NO_FILE, C_MEASURED | C_RESAMPLE, "the result does not depend on it (one per processor)"},
    [FLAG_ISA] = {"isa", 0, "NAME", NO_FILE, C_MEASURED | C_SCENE, "best, scalar, avx2 or avx512 (best)"},
    [FLAG_JSON] = {"json", 0, "FILE|-", OUTPUT_FILE, C_ALL & ~(unsigned)C_SIMULATE,
                   "write JSON; '-' is stdout and nothing else goes there"},
    [FLAG_PROGRESS] = {"progress", 0, NULL, NO_FILE, C_MEASURED, "show progress (when stderr is a terminal)"},
    [FLAG_NO_PROGRESS] = {"no-progress", 0, NULL, NO_FILE, C_MEASURED, "do not"},
    [FLAG_HELP] = {"help", 'h', NULL, NO_FILE, C_ALL, "this text"},
};

/* What a flag means to some commands, where it is not what the table says. */
static const struct {
    cli_flag_id flag;
    unsigned commands;
    const char *help;
} other_help[] = {
    {FLAG_NOISE_FLOOR, C_FITTING, "values below (1/sr, or 3sigma of the file's) are only known to be at most this"},
    {FLAG_SEED, C_FIT, "of the bootstrap (1)"},
    {FLAG_GRID, C_RESAMPLE, "directions of OUT, in the words of its format (as the format likes)"},
    {FLAG_GRID, C_READS, "where to sample a file that holds a function: merl, goniometer:STEP, ... (as it was measured)"},
    {FLAG_LOSS, C_FIT,
     "cosine, log, cube-root, relative, plain, or auto: the one whose pictures are nearest to the data's (cosine)"},
    {FLAG_TO, C_RESAMPLE, "format of OUT (by its extension)"},
    {FLAG_FORMAT, C_RESAMPLE, "of IN (by content)"},
};

static const char *help_of(int flag, unsigned command)
{
    for (size_t k = 0; k < sizeof other_help / sizeof other_help[0]; ++k)
        if ((int)other_help[k].flag == flag && other_help[k].commands & command) return other_help[k].help;
    return flags[flag].help;
}

size_t cli_command_count(void)
{
    return COMMANDS;
}

const cli_command *cli_command_at(size_t i)
{
    return i < COMMANDS ? &commands[i] : NULL;
}

const char *cli_flag_name(cli_flag_id flag)
{
    return flags[flag].name;
}

cli_file cli_flag_file(cli_flag_id flag)
{
    return flags[flag].file;
}

static unsigned bit_of(const cli_command *command)
{
    return 1u << (command - commands);
}

/* ---- suggestions ----------------------------------------------------------------------------- */

/* Levenshtein's distance of two short words; long ones are not near. */
static size_t distance(const char *a, const char *b)
{
    enum { LONGEST = 40 };
    const size_t na = strlen(a), nb = strlen(b);
    size_t row[LONGEST + 1];
    if (na > LONGEST || nb > LONGEST) return LONGEST;
    for (size_t j = 0; j <= nb; ++j) row[j] = j;
    for (size_t i = 1; i <= na; ++i) {
        size_t diagonal = row[0];
        row[0] = i;
        for (size_t j = 1; j <= nb; ++j) {
            const size_t replace = diagonal + (a[i - 1] != b[j - 1]), insert = row[j] + 1, drop = row[j - 1] + 1;
            diagonal = row[j];
            row[j] = replace < insert ? replace : insert;
            if (drop < row[j]) row[j] = drop;
        }
    }
    return row[nb];
}

const char *cli_nearest(const char *word, const char *const *names, size_t n)
{
    const char *nearest = NULL;
    size_t least = strlen(word) < 4 ? 2 : 3 + strlen(word) / 8; /* one slip in a short word, two in a long one */
    for (size_t i = 0; i < n; ++i) {
        const size_t d = distance(word, names[i]);
        if (d >= least) continue;
        least = d;
        nearest = names[i];
    }
    return nearest;
}

/* ---- parsing --------------------------------------------------------------------------------- */

static int find_long(const char *name, size_t length)
{
    for (int i = 0; i < FLAG_COUNT; ++i)
        if (strlen(flags[i].name) == length && !strncmp(flags[i].name, name, length)) return i;
    return -1;
}

static int find_letter(char letter)
{
    for (int i = 0; i < FLAG_COUNT; ++i)
        if (flags[i].letter && flags[i].letter == letter) return i;
    return -1;
}

static int unknown_flag(const cli_args *args, const char *word)
{
    const char *names[FLAG_COUNT];
    char bare[64];
    size_t n = 0;
    for (int i = 0; i < FLAG_COUNT; ++i)
        if (flags[i].commands & bit_of(args->command)) names[n++] = flags[i].name;
    snprintf(bare, sizeof bare, "%.*s", (int)strcspn(word + strspn(word, "-"), "="), word + strspn(word, "-"));
    const char *nearest = cli_nearest(bare, names, n);
    if (nearest) return cli_usage(args, "unknown flag %s; did you mean --%s?", word, nearest);
    return cli_usage(args, "unknown flag %s", word);
}

static int misplaced_flag(const cli_args *args, const flag *f)
{
    char where[128] = "";
    for (size_t i = 0; i < COMMANDS; ++i)
        if (f->commands & 1u << i)
            snprintf(where + strlen(where), sizeof where - strlen(where), "%s%s", *where ? ", " : "", commands[i].name);
    return cli_usage(args, "--%s is not a flag of '%s'; it belongs to %s", f->name, args->command->name, where);
}

/* One word that starts with '-': the flag, and its value from after '=' or from the next word. */
static int parse_flag(cli_args *args, int argc, char **argv, int *i)
{
    const char *word = argv[*i], *value = NULL;
    const int is_long = word[1] == '-';
    const size_t length = is_long ? strcspn(word + 2, "=") : 1;
    const int id = is_long ? find_long(word + 2, length) : word[2] == '\0' ? find_letter(word[1]) : -1;
    if (id < 0) return unknown_flag(args, word);
    const flag *f = &flags[id];
    if (!(f->commands & bit_of(args->command))) return misplaced_flag(args, f);
    if (is_long && word[2 + length] == '=') value = word + 2 + length + 1;
    if (value && !f->argument) return cli_usage(args, "--%s takes no value", f->name);
    if (!value && f->argument) {
        if (*i + 1 >= argc) return cli_usage(args, "--%s needs a value: %s", f->name, f->argument);
        value = argv[++*i];
    }
    args->flag[args->n_given] = id;
    args->value[args->n_given++] = value;
    return EXIT_DONE;
}

int cli_args_parse(const cli_command *command, int argc, char **argv, cli_args *out)
{
    int only_words = 0, status = EXIT_DONE;
    const size_t n = (size_t)argc;
    *out = (cli_args){.command = command};
    out->word = malloc(n * sizeof *out->word);
    out->value = malloc(n * sizeof *out->value);
    out->flag = malloc(n * sizeof *out->flag);
    if (!out->word || !out->value || !out->flag) return cli_failed(FF_ERR_MEMORY, NULL);
    for (int i = 1; i < argc && status == EXIT_DONE; ++i) {
        const char *word = argv[i];
        if (!only_words && !strcmp(word, "--")) {
            only_words = 1;
        } else if (only_words || word[0] != '-' || word[1] == '\0') {
            out->word[out->n_words++] = word;
        } else {
            status = parse_flag(out, argc, argv, &i);
        }
    }
    if (status != EXIT_DONE || cli_given(out, FLAG_HELP)) return status;
    if (out->n_words < command->least)
        return cli_usage(out, "%s is missing: facetfit %s %s", out->n_words ? "a word" : command->usage, command->name,
                         command->usage);
    if (out->n_words > command->most) return cli_usage(out, "unexpected '%s'", out->word[command->most]);
    return cli_files_check(out);
}

void cli_args_free(cli_args *args)
{
    free(args->word);
    free(args->value);
    free(args->flag);
    *args = (cli_args){.command = NULL};
}

int cli_given(const cli_args *args, cli_flag_id id)
{
    int n = 0;
    for (size_t i = 0; i < args->n_given; ++i) n += args->flag[i] == (int)id;
    return n;
}

const char *cli_value(const cli_args *args, cli_flag_id id, const char *otherwise)
{
    for (size_t i = args->n_given; i-- > 0;)
        if (args->flag[i] == (int)id) return args->value[i];
    return otherwise;
}

/* ---- help ------------------------------------------------------------------------------------ */

void cli_help_command(const cli_command *command, FILE *out)
{
    fprintf(out, "facetfit %s %s%s[flags]\n\n%s.\n%s\n", command->name, command->usage, *command->usage ? " " : "",
            command->summary, command->more);
    for (int i = 0; i < FLAG_COUNT; ++i) {
        const flag *f = &flags[i];
        char left[64];
        if (!(f->commands & bit_of(command))) continue;
        snprintf(left, sizeof left, "%s%c%s--%s%s%s", f->letter ? "-" : " ", f->letter ? f->letter : ' ', f->letter ? ", " : "  ",
                 f->name, f->argument ? " " : "", f->argument ? f->argument : "");
        fprintf(out, "  %-28s %s\n", left, help_of(i, bit_of(command)));
    }
}

void cli_help(FILE *out)
{
    fputs("facetfit finds microfacet BRDF parameters in measured reflectance.\n\nfacetfit COMMAND ...\n\n", out);
    for (size_t i = 0; i < COMMANDS; ++i) fprintf(out, "  %-10s %s\n", commands[i].name, commands[i].summary);
    fputs("\n'facetfit COMMAND --help' lists the flags of a command; 'facetfit --version' prints the version.\n"
          "Exit status: 0 done, 1 the answer is no (not converged, a check failed), 2 usage, 3 input, 4 output, 5 internal, 130 "
          "Ctrl-C.\n",
          out);
}
