/* Warnings: the registry of their codes, lists that grow and lose nothing, the sentences; hints of errors and notes; and memory
 * that runs out on the way. */
#include "fit_samples.h"
#include "warnings.h"
#include "ff_test.h"
#include "ff_report.h"
#include "fit/warning/internal_warning.h"
#include "data_formats/table/internal_table.h"

/* ---- memory that runs out -------------------------------------------------------------------- */

static long allocations, failing = -1; /* the failing-th one fails; -1: none */

void *__real_malloc(size_t size);
void *__real_calloc(size_t n, size_t size);
void *__real_realloc(void *p, size_t size);
void *__wrap_malloc(size_t size);
void *__wrap_calloc(size_t n, size_t size);
void *__wrap_realloc(void *p, size_t size);

void *__wrap_malloc(size_t size)
{
    return allocations++ == failing ? NULL : __real_malloc(size);
}
void *__wrap_calloc(size_t n, size_t size)
{
    return allocations++ == failing ? NULL : __real_calloc(n, size);
}
void *__wrap_realloc(void *p, size_t size)
{
    return allocations++ == failing ? NULL : __real_realloc(p, size);
}

/* ---- the registry ---------------------------------------------------------------------------- */

static int is_name(const char *s, char between)
{
    const size_t n = strlen(s);
    return n > 0 && strspn(s, "abcdefghijklmnopqrstuvwxyz0123456789-_") == n && !strchr(s, between == '-' ? '_' : '-');
}

static void registry(void)
{
    for (int code = 0; code < FF_WARNING_COUNT; code++) {
        const ff_warning_kind *k = ff_warning_kind_of(code);
        FF_CHECK(k && is_name(k->name, '-') && ff_warning_find(k->name) == code && k->meaning[0], "code %d", code);
        FF_CHECK(ff_severity_name((int)k->severity), "%s: severity %d", k->name, (int)k->severity);
        for (int v = 0; v < FF_WARNING_VALUES; v++) {
            FF_CHECK(!k->value[v] || (is_name(k->value[v], '_') && (v == 0 || k->value[v - 1])), "%s: value %d", k->name, v);
            for (int u = 0; u < v; u++) FF_CHECK(!k->value[v] || strcmp(k->value[u], k->value[v]), "%s: twice", k->name);
        }
    }
    FF_CHECK(!ff_warning_kind_of(-1) && !ff_warning_kind_of(FF_WARNING_COUNT) && ff_warning_find("at bound") == -1, "of no code");
    FF_CHECK(!ff_severity_name(-1) && !ff_severity_name(FF_SEVERITY_COUNT), "of no severity");
}

/* ---- lists ----------------------------------------------------------------------------------- */

/* The k-th of many warnings that are all different. */
static void make(size_t k, size_t channel[3], ff_warning_parameter parameter[2], ff_warning *w)
{
    for (size_t i = 0; i < 3; i++) channel[i] = 10 * k + i;
    for (size_t i = 0; i < 2; i++) parameter[i] = (ff_warning_parameter){{FF_PARAM_SHAPE, (uint32_t)(k + i)}, FF_NO_CHANNEL};
    *w = (ff_warning){.code = FF_WARNING_CORRELATED,
                      .severity = FF_SEVERITY_WARNING,
                      .n_parameters = k % 3,
                      .n_channels = k % 4,
                      .parameter = parameter,
                      .channel = channel,
                      .value = {(double)k}};
}

static void lists_keep_everything(void)
{
    enum { MANY = 100 };
    ff_warnings list = {0, NULL};
    ff_warning w;
    size_t channel[3];
    ff_warning_parameter parameter[2];
    for (size_t k = 0; k < MANY; k++) {
        make(k, channel, parameter, &w);
        FF_CHECK(ff_warnings_add(&list, &w) == FF_OK, "warning %zu", k);
    }
    FF_CHECK(list.n == MANY, "%zu of %d warnings", list.n, MANY);
    for (size_t k = 0; k < list.n; k++) {
        make(k, channel, parameter, &w);
        FF_CHECK(same_warning(&list.item[k], &w), "warning %zu is another", k);
    }
    ff_warnings_clear(&list);
    FF_CHECK(list.n == 0 && !list.item, "not freed");
}

/* Each allocation in turn: the list is as it was. */
static void lists_without_memory(void)
{
    ff_warnings list = {0, NULL};
    ff_warning w;
    size_t channel[3];
    ff_warning_parameter parameter[2];
    for (size_t k = 0; k < 40; k++) {
        make(11, channel, parameter, &w); /* both arrays */
        for (long at = 0; at < 10; at++) {
            allocations = 0;
            failing = at;
            const ff_status status = ff_warnings_add(&list, &w);
            failing = -1;
            FF_CHECK(status == (allocations > at ? FF_ERR_MEMORY : FF_OK) && list.n == k + (status == FF_OK), "%d at %ld",
                     (int)status, at);
            if (status == FF_OK) break;
        }
    }
    ff_warnings_clear(&list);
}

/* A fit with many warnings, each of its last allocations failing in turn: it says so, and its result is not touched. */
static void fits_without_memory(void)
{
    enum { LAST = 150 };
    const fit_surface s = fit_surface_make("ggx+lambert", 3, "alpha=0.3 f0=0.5 kd=0.2");
    const fit_sampling how = {.n = 100, .max_theta = 60, .seed = 1};
    ff_table t = fit_measure(&s, &how);
    for (size_t i = 1; i < t.n; i++) { /* one sample again and again determines nothing */
        for (size_t k = 0; k < 4; k++) t.angle[k][i] = t.angle[k][0];
        for (size_t c = 0; c < 3; c++) t.value[c * t.n + i] = t.value[c * t.n] * (1 + 1e-12 * (double)i); /* no mere copies */
    }
    ff_fit_options o = fit_options();
    ff_error err = {0};
    ff_problem *p = NULL;
    ff_fit_result r;
    o.threads = 1;
    FF_CHECK(ff_problem_make(&t, &s.model, 1, &o, &p, &err) == FF_OK, "%s", err.message);
    if (!p) return;
    allocations = 0;
    FF_CHECK(ff_problem_fit_into(p, &s.model, &o, &r, &err) == FF_OK && r.warnings.n > 3, "%zu warnings", r.warnings.n);
    const long all = allocations;
    const size_t said = r.warnings.n;
    ff_fit_result_clear(&r);
    long failed = 0;
    for (long at = all > LAST ? all - LAST : 0; at < all; at++) {
        memset(&r, 0x5A, sizeof r);
        allocations = 0;
        failing = at;
        const ff_status status = ff_problem_fit_into(p, &s.model, &o, &r, &err);
        failing = -1;
        failed += status == FF_ERR_MEMORY;
        FF_CHECK(status == FF_ERR_MEMORY || status == FF_OK, "allocation %ld of %ld: %s", at, all, err.message);
        if (status == FF_OK) {
            FF_CHECK(r.warnings.n == said, "allocation %ld of %ld: %zu of %zu warnings", at, all, r.warnings.n, said);
            ff_fit_result_clear(&r);
        } else
            FF_CHECK(r.warnings.n == (size_t)0x5A5A5A5A5A5A5A5A, "written all the same");
    }
    FF_CHECK(failed > LAST / 2, "%ld of %d failures are told", failed, LAST);
    ff_problem_free(p);
    ff_table_clear(&t);
}

/* ---- sentences ------------------------------------------------------------------------------- */

/* A problem with many channels, whose names count. */
static ff_problem *problem_of(size_t n_channels, const ff_model *m)
{
    const fit_surface s = fit_surface_make("ggx+lambert", n_channels, "alpha=0.3 f0=0.5 kd=0.2");
    const fit_sampling how = {.n = 200, .max_theta = 60, .seed = 1};
    ff_table t = fit_measure(&s, &how);
    const ff_fit_options o = fit_options();
    ff_problem *p = NULL;
    ff_error err = {0};
    for (size_t c = 0; c < n_channels; c++) snprintf(t.channels[c].name, sizeof t.channels[c].name, "%zunm", 400 + 10 * c);
    FF_CHECK(ff_problem_make(&t, m, 1, &o, &p, &err) == FF_OK, "%s", err.message);
    ff_table_clear(&t);
    return p;
}

static void every_code_has_a_sentence(void)
{
    ff_fit_result fit = {.n_channels = 3};
    static ff_ndf_result retrieved = {.n_channels = 3};
    FF_CHECK(ff_model_parse("ggx+lambert", &fit.model, NULL) == FF_OK, "model");
    retrieved.fit[0].model = fit.model;
    ff_problem *p = problem_of(3, &fit.model);
    if (!p) return;
    const ff_words_subject of_fit = {.problem = p, .fit = &fit}, of_ndf = {.problem = p, .retrieved = &retrieved};
    const ff_warning_parameter both[] = {{{FF_PARAM_SHAPE, 0}, FF_NO_CHANNEL}, {{FF_PARAM_CHANNEL, 0}, FF_NO_CHANNEL}};
    const size_t channel[] = {1};
    for (int code = 0; code < FF_WARNING_COUNT; code++) {
        const ff_words_subject *of = code < FF_WARNING_RETRIEVAL_NOT_CONVERGED || code == FF_WARNING_FEW_CARRIERS ||
                                             code == FF_WARNING_ONE_INCIDENCE || code == FF_WARNING_NARROW_LOBE
                                         ? &of_fit
                                         : &of_ndf;
        const ff_warning w = {.code = (ff_warning_code)code,
                              .n_parameters = 2,
                              .parameter = both,
                              .n_channels = 1,
                              .channel = channel,
                              .value = {7, 1, 0, 7}};
        char text[FF_WORDS_SENTENCE] = "";
        const char *name = ff_warning_kind_of(code)->name;
        FF_CHECK(ff_words_warning(of, &w, text) == text && strlen(text) > 20 && !strstr(text, "(null)"), "%s: '%s'", name, text);
        FF_CHECK(text[strlen(text) - 1] != '.' && !strchr(text, '\n'), "%s: '%s'", name, text);
        if (ff_warning_kind_of(code)->value[0]) FF_CHECK(strpbrk(text, "1234567890"), "%s without its numbers: '%s'", name, text);
    }
    ff_problem_free(p);
}

static void check_sentence(const ff_words_subject *s, ff_warning w, const char *expected)
{
    char text[FF_WORDS_SENTENCE], cut[8];
    FF_CHECK(!strcmp(ff_words_warning(s, &w, text), expected), "'%s', expected '%s'", text, expected);
    if (!s->fit) return;
    const size_t length = ff_words_fit_warning(s->problem, s->fit, &w, cut, sizeof cut);
    FF_CHECK(length == strlen(expected) && !strncmp(cut, expected, 7) && strlen(cut) == 7, "cut to '%s'", cut);
}

/* Few channels are named, of many their number and range. */
static void channels_in_sentences(void)
{
    ff_fit_result fit = {.n_channels = 3};
    FF_CHECK(ff_model_parse("ggx+lambert", &fit.model, NULL) == FF_OK, "model");
    const ff_param_ref kd = ff_model_param_find(&fit.model, "kd"), f0 = ff_model_param_find(&fit.model, "f0");
    const ff_warning_parameter pair[] = {{kd, FF_NO_CHANNEL}, {f0, FF_NO_CHANNEL}},
                               own[] = {{kd, 0}, {f0, 2}, {{FF_PARAM_SHAPE, 0}, FF_NO_CHANNEL}};
    const size_t channel[] = {0, 2, 5, 11};
    const ff_warning on = {.code = FF_WARNING_AT_BOUND, .n_parameters = 1, .parameter = pair, .value = {1, 1, 0}};
    ff_warning more = on, some = on, unknown = {.code = FF_WARNING_NOT_DETERMINED, .n_parameters = 1, .parameter = pair};
    ff_warning both = {.code = FF_WARNING_CORRELATED, .n_parameters = 2, .parameter = pair, .value = {-0.9951}};
    ff_warning dark = {.code = FF_WARNING_DARK_CHANNEL, .n_channels = 2, .channel = channel};
    some.channel = unknown.channel = both.channel = channel;
    some.n_channels = unknown.n_channels = 2;
    ff_words_subject s = {.problem = problem_of(3, &fit.model), .fit = &fit};
    if (!s.problem) return;
    more.value[3] = 1.885;
    check_sentence(&s, on, "kd is on its upper bound, 1");
    check_sentence(&s, more, "kd is on its upper bound, 1"); /* once for all parameters, by the verdict */
    check_sentence(&s, some, "kd (400nm, 420nm) is on its upper bound, 1");
    check_sentence(&s, unknown, "kd (400nm, 420nm) is not determined by these data; --profile says how far it may go");
    check_sentence(&s, both, "kd and f0 are correlated by -0.9951: these data hardly tell them apart");
    both.parameter = own;
    check_sentence(&s, both, "kd[400nm] and f0[420nm] are correlated by -0.9951: these data hardly tell them apart");
    check_sentence(&s, (ff_warning){.code = FF_WARNING_TRADE_OFF, .n_parameters = 3, .parameter = own, .value = {250}},
                   "kd[400nm], f0[420nm], alpha_x trade off: along one combination of them the data say 250 times less than of "
                   "each alone");
    dark.n_channels = 1;
    check_sentence(
        &s, dark,
        "channel 400nm is zero everywhere, which no lobe is: it pulls the shape of the others; --channels each keeps them "
        "apart");
    ff_problem_free((ff_problem *)s.problem);
    fit.n_channels = 12;
    s.problem = problem_of(12, &fit.model);
    if (!s.problem) return;
    some.value[1] = -1, some.value[0] = 0, some.value[2] = 1;
    check_sentence(&s, some, "kd (400nm, 420nm) is on the given lower bound, 0");
    some.n_channels = unknown.n_channels = both.n_channels = dark.n_channels = 4;
    check_sentence(&s, some, "kd (4 of 12 channels, 400nm to 510nm) is on the given lower bound, 0");
    check_sentence(&s, unknown, "kd (4 of 12 channels, 400nm to 510nm) is not determined by these data");
    both.parameter = pair;
    check_sentence(
        &s, both,
        "kd and f0 (4 of 12 channels, 400nm to 510nm) are correlated by up to -0.9951: these data hardly tell them apart");
    check_sentence(&s, dark,
                   "channels that are zero everywhere (4 of 12 channels, 400nm to 510nm), which no lobe is, pull the shape of the "
                   "others; --channels each keeps them apart");
    ff_problem_free((ff_problem *)s.problem);
}

/* ---- hints ----------------------------------------------------------------------------------- */

static void hints_of_errors(void)
{
    ff_error err = {0};
    char text[FF_ERROR_PATH + FF_ERROR_MESSAGE], plain[sizeof text];
    for (int hint = 0; hint < FF_HINT_COUNT; hint++) {
        const char *words = ff_words_hint((ff_hint)hint);
        FF_CHECK(!words[0] == (hint == FF_HINT_NONE || hint == FF_HINT_SAY) && (!words[0] || strstr(words, " --")), "hint %d: '%s'",
                 hint, words);
        const ff_status status = ff_error_hint(&err, ff_error_set(&err, FF_ERR_DATA, "a", 3, -1, "found x"), (ff_hint)hint);
        ff_error_format(&err, plain, sizeof plain);
        ff_words_error(&err, text, sizeof text);
        FF_CHECK(status == FF_ERR_DATA && !strcmp(plain, "a:3: found x") && !strncmp(text, plain, strlen(plain)) &&
                     !strcmp(text + strlen(plain), words),
                 "'%s'", text);
        ff_words_error(&err, text, 6);
        FF_CHECK(!strcmp(text, "a:3: "), "'%s' is not cut to 5", text);
        ff_words_error(&err, text, 0);
    }
    FF_CHECK(!ff_words_hint((ff_hint)99)[0], "words of no hint");
    ff_error_hint(&err, ff_error_set(&err, FF_ERR_DATA, "a", 3, -1, "found x; say columns 'y=#1'"), FF_HINT_SAY);
    ff_words_error(&err, text, sizeof text);
    FF_CHECK(!strcmp(text, "a:3: found x; say --columns 'y=#1'"), "'%s'", text);
    ff_words_error(&err, text, 28);
    FF_CHECK(strlen(text) == 27 && !strncmp(text, "a:3: found x; say columns ", 26), "'%s' is not cut to 27", text);
    ff_error_hint(&err, ff_error_set(&err, FF_ERR_DATA, NULL, 0, -1, "the option 'columns' or the option 'part'; the option 'R 1'"),
                  FF_HINT_NONE);
    ff_words_error(&err, text, sizeof text);
    FF_CHECK(!strcmp(text, "--columns or --part; the option 'R 1'"), "'%s'", text);
    static const char *const quoted[][2] = {
        {"found say x, say f; say columns 'theta_o=say x,f=say f'", "found say x, say f; say --columns 'theta_o=say x,f=say f'"},
        {"found a; say columns 'f=b; say angles c'", "found a; say --columns 'f=b; say angles c'"},
        {"column 2 (f, say angles rad): found '1,5'; say dialect decimal=comma",
         "column 2 (f, say angles rad): found '1,5'; say --dialect decimal=comma"},
        {"'f, say x' is what a detector gave: say quantity brdf-cos if not",
         "'f, say x' is what a detector gave: say --quantity brdf-cos if not"},
        {"'essay columns ' is left out", "'essay columns ' is left out"}};
    for (size_t k = 0; k < sizeof quoted / sizeof quoted[0]; k++) {
        ff_error_hint(&err, ff_error_set(&err, FF_ERR_DATA, NULL, 0, -1, "%s", quoted[k][0]), FF_HINT_SAY);
        ff_words_error(&err, text, sizeof text);
        FF_CHECK(!strcmp(text, quoted[k][1]), "'%s', expected '%s'", text, quoted[k][1]);
    }
    ff_error_set(&err, FF_ERR_DATA, NULL, 0, -1, "another");
    FF_CHECK(err.hint == FF_HINT_NONE && ff_error_hint(NULL, FF_ERR_DATA, FF_HINT_SCALE) == FF_ERR_DATA, "a hint that stays");
}

/* A hint belongs to its sentence, also where one did not fit. */
static void hints_of_notes(void)
{
    ff_table t = {.n = 0};
    char text[FF_WORDS_SENTENCE], longest[sizeof t.note];
    memset(longest, 'x', sizeof longest);
    FF_CHECK(!ff_words_note(&t, 0, text), "a note of an empty table");
    ff_table_note(&t, "first");
    ff_table_note_hint(&t, FF_HINT_SCALE, "second %d", 2);
    ff_table_note_hint(&t, FF_HINT_QUANTITY, "%.*s", (int)sizeof longest - 1, longest); /* does not fit */
    ff_table_note(&t, "third\nfourth");
    ff_table_note_hint(&t, FF_HINT_QUANTITY_BRDF, "fifth");
    static const char *const expected[] = {"first", "second 2; say --scale, the 1/sr of one of them", "third", "fourth",
                                           "fifth; --quantity brdf says otherwise"};
    for (size_t k = 0; k < 5; k++)
        FF_CHECK(ff_words_note(&t, k, text) && !strcmp(text, expected[k]), "'%s', expected '%s'", text, expected[k]);
    FF_CHECK(!ff_words_note(&t, 5, text), "a note too many");
    t.note[0] = '\0';
    ff_table_note(&t, "anew\nand more\nand more\nand more\nand more");
    for (size_t k = 0; k < 5; k++) FF_CHECK(ff_words_note(&t, k, text) && !strchr(text, ';'), "'%s' has a hint of before", text);
}

/* What readers cannot know has a hint, and its flag is named. */
static void readers(void)
{
    static const struct {
        const char *text, *note, *error;
        double scale;
    } cases[] = {
        {"#pgII BSDF data\n#incident_angle\t30\t15\n#format: theta\tphi\t[uA]\n0\t0\t0.5\n", NULL,
         ":3: #format: found readings of the detector in 'uA', not calibrated, expected a BRDF; say --scale, the 1/sr of one of "
         "them",
         NAN},
        {"#pgII BSDF data\n#incident_angle\t30\t15\n#format: theta\tphi\t[uA]\n0\t0\t0.5\n",
         "the values are readings of the detector in uA: taken as proportional to f cos(theta_o), the power on the detector; "
         "--quantity brdf says otherwise",
         NULL, 2},
        {"#DIM 4 1\n#PARAM_IN SPHERICAL_TL_PL_TV_PV\n#PARAM_OUT ENERGY\n0 0 0 0 1\n", NULL,
         ":3: #PARAM_OUT: found ENERGY, which ALTA does not define, expected INV_STERADIAN or the like; --quantity says what the "
         "values are",
         NAN},
        {"#DIM 4 1\n#PARAM_IN SPHERICAL_TL_PL_TV_PV\n0 0 0 0 1\n",
         "there is no #PARAM_OUT: the values are taken as the BRDF without a cosine; --quantity brdf-cos says otherwise", NULL,
         NAN}};
    char path[] = "/tmp/facetfit-words-XXXXXX", text[FF_WORDS_SENTENCE];
    const int fd = mkstemp(path);
    FF_CHECK(fd >= 0, "no temporary file");
    if (fd < 0) return;
    close(fd);
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        FILE *file = fopen(path, "w");
        if (file) fputs(cases[k].text, file);
        if (file) fclose(file);
        ff_read_options o;
        ff_table t;
        ff_error err = {0};
        ff_read_options_init(&o);
        o.scale = cases[k].scale;
        o.format = strstr(cases[k].text, "pgII") ? "pgii" : "alta";
        const ff_status status = ff_table_read_with_into(path, &o, &t, &err);
        FF_CHECK((status != FF_OK) == (cases[k].error != NULL), "case %zu: %s", k, err.message);
        ff_words_error(&err, text, sizeof text);
        if (status) FF_CHECK(cases[k].error && !strcmp(text + strlen(path), cases[k].error), "case %zu: '%s'", k, text);
        if (status) continue;
        int found = 0;
        for (size_t i = 0; ff_words_note(&t, i, text); i++) found |= cases[k].note && !strcmp(text, cases[k].note);
        FF_CHECK(found, "case %zu: '%s'", k, t.note);
        ff_table_clear(&t);
    }
    remove(path);
}

FF_TEST_MAIN(FF_TEST(registry), FF_TEST(lists_keep_everything), FF_TEST(lists_without_memory), FF_TEST(fits_without_memory),
             FF_TEST(every_code_has_a_sentence), FF_TEST(channels_in_sentences), FF_TEST(hints_of_errors), FF_TEST(hints_of_notes),
             FF_TEST(readers))
