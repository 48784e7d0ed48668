/* JSON as RFC 8259 has it, and nothing else. */
#include "ff_test.h"
#include "base/internal_json.h"

static ff_status parse(const char *text, ff_json_tree **tree, ff_error *err)
{
    return ff_json_parse(text, strlen(text), "a.json", tree, err);
}

static void accepted(void)
{
    static const char *const texts[] = {"null",
                                        " true ",
                                        "[]",
                                        "{}",
                                        "[1,2]",
                                        "-0",
                                        "1e5",
                                        "1.5E-3",
                                        "\"\"",
                                        "\"\\u00e9\\ud83d\\ude00\"",
                                        "{\"a\":{\"b\":[null,false,{}]}}",
                                        "\n\t[ 1 ,\r\n 2 ]\n",
                                        "\"\xc3\xa9\"",
                                        "\xef\xbb\xbf[]"};
    for (size_t k = 0; k < sizeof texts / sizeof *texts; k++) {
        ff_json_tree *tree = NULL;
        ff_error err = {0};
        FF_CHECK(parse(texts[k], &tree, &err) == FF_OK, "'%s' is JSON: %s", texts[k], err.message);
        ff_json_free(tree);
    }
}

static void refused(void)
{
    static const char *const texts[] = {"",
                                        " ",
                                        "nul",
                                        "[1,]",
                                        "{\"a\":1,}",
                                        "{a:1}",
                                        "[1 2]",
                                        "01",
                                        "1.",
                                        ".5",
                                        "+1",
                                        "1e",
                                        "NaN",
                                        "Infinity",
                                        "'a'",
                                        "\"\\x\"",
                                        "\"\\u12\"",
                                        "\"\\ud800\"",
                                        "\"\\ud800\\u0041\"",
                                        "\"\\udc00\"",
                                        "\"\\u0000\"",
                                        "\"\n\"",
                                        "\"a",
                                        "[",
                                        "{\"a\"",
                                        "{\"a\":",
                                        "[]]",
                                        "[] x",
                                        "// a\n[]",
                                        "\"\xff\"",
                                        "\"\xc0\x80\"",
                                        "\"\xed\xa0\x80\"",
                                        "\"\xf5\x80\x80\x80\"",
                                        "1e999",
                                        "-",
                                        "truefalse",
                                        "{\"a\" 1}",
                                        "{1:2}"};
    for (size_t k = 0; k < sizeof texts / sizeof *texts; k++) {
        ff_json_tree *tree = NULL;
        ff_error err = {0};
        FF_CHECK(parse(texts[k], &tree, &err) == FF_ERR_FORMAT, "'%s' is no JSON", texts[k]);
        FF_CHECK(!tree && err.message[0] && !strcmp(err.path, "a.json"), "'%s': nothing is said", texts[k]);
        ff_json_free(tree);
    }
}

static void values(void)
{
    ff_json_tree *tree = NULL;
    ff_error err = {0};
    FF_CHECK(parse("{\"n\":[1,-2.5e-3,1e300],\"t\":\"a\\\"\\\\\\n\\u03b8\\ud83d\\ude00z\",\"y\":true,\"n\":7,\"o\":{\"k\":null}}",
                   &tree, &err) == FF_OK,
             "%s", err.message);
    const ff_json_node *root = ff_json_root(tree), *n = ff_json_member(root, "n");
    FF_CHECK(ff_json_count(root) == 5 && ff_json_count(n) == 3, "counts %zu, %zu", ff_json_count(root), ff_json_count(n));
    FF_CHECK_CLOSE(ff_json_real(ff_json_first(n)), 1, 0, 0);
    FF_CHECK_CLOSE(ff_json_real(ff_json_next(ff_json_first(n))), -2.5e-3, 0, 0);
    FF_CHECK(!strcmp(ff_json_text(ff_json_member(root, "t")), "a\"\\\n\xce\xb8\xf0\x9f\x98\x80z"), "text");
    FF_CHECK(ff_json_is_true(ff_json_member(root, "y")), "true");
    FF_CHECK(ff_json_kind_of(ff_json_member(ff_json_member(root, "o"), "k")) == FF_JSON_NULL, "null");
    FF_CHECK(!strcmp(ff_json_name(ff_json_first(root)), "n"), "name");
    ff_json_free(tree);
}

/* What is not there gives nothing, and does not crash. */
static void looking(void)
{
    ff_json_tree *tree = NULL;
    FF_CHECK(parse("[1]", &tree, NULL) == FF_OK, "no error wanted");
    const ff_json_node *root = ff_json_root(tree);
    FF_CHECK(!ff_json_member(root, "a") && !ff_json_text(root) && isnan(ff_json_real(root)) && !ff_json_is_true(root), "an array");
    FF_CHECK(!ff_json_member(NULL, "a") && !ff_json_first(NULL) && !ff_json_next(NULL) && !ff_json_text(NULL) &&
                 isnan(ff_json_real(NULL)),
             "NULL");
    FF_CHECK(!ff_json_next(ff_json_first(root)) && !ff_json_name(ff_json_first(root)), "the last one");
    ff_json_free(tree);
    ff_json_free(NULL);
}

static void bounds(void)
{
    enum { DEEP = 100000 };
    char *deep = malloc(DEEP + 1);
    ff_json_tree *tree = NULL;
    ff_error err = {0};
    memset(deep, '[', DEEP);
    deep[DEEP] = '\0';
    FF_CHECK(parse(deep, &tree, &err) == FF_ERR_FORMAT && strstr(err.message, "nested"), "%s", err.message);
    memset(deep + FF_JSON_NESTING, ']', FF_JSON_NESTING);
    FF_CHECK(ff_json_parse(deep, 2 * FF_JSON_NESTING, NULL, &tree, &err) == FF_OK, "as deep as is allowed: %s", err.message);
    ff_json_free(tree);
    free(deep);
}

/* Every prefix of a document is none, and its error is in a line that is there. */
static void prefixes(void)
{
    static const char whole[] = "{\"a\": [1, 2.5, \"x\\u00e9\"],\n \"b\": {\"c\": true}}";
    for (size_t n = 0; n < sizeof whole - 1; n++) {
        ff_json_tree *tree = NULL;
        ff_error err = {0};
        FF_CHECK(ff_json_parse(whole, n, NULL, &tree, &err) == FF_ERR_FORMAT, "%zu bytes are a document", n);
        FF_CHECK(err.line >= 1 && err.line <= 2, "line %ld", err.line);
        ff_json_free(tree);
    }
}

static void files(void)
{
    const char *path = ff_test_path("a.json");
    ff_json_tree *tree = NULL;
    ff_error err = {0};
    ff_test_write(path, "\n\n[1,\nx]", 8);
    FF_CHECK(ff_json_read(path, &tree, &err) == FF_ERR_FORMAT && err.line == 4, "line %ld: %s", err.line, err.message);
    FF_CHECK(ff_json_read(ff_test_path("none.json"), &tree, &err) == FF_ERR_OPEN, "%s", err.message);
    /* more than a piece, across its end */
    const size_t n = 200000;
    char *text = malloc(n + 1);
    memset(text, ' ', n);
    text[0] = '[', text[65535] = '1', text[65536] = '2', text[n - 1] = ']';
    ff_test_write(path, text, n);
    FF_CHECK(ff_json_read(path, &tree, &err) == FF_OK, "%s", err.message);
    FF_CHECK_CLOSE(ff_json_real(ff_json_first(ff_json_root(tree))), 12, 0, 0);
    ff_json_free(tree);
    free(text);
}

FF_TEST_MAIN(FF_TEST(accepted), FF_TEST(refused), FF_TEST(values), FF_TEST(looking), FF_TEST(bounds), FF_TEST(prefixes),
             FF_TEST(files))
