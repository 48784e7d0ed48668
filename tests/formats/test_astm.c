/* ASTM files, made here: those of the standard, those with the unnamed column, and those that are wrong. */
#include "check_text.h"

#define HEAD "LAB_NAME somebody\n\nAPERTURE\nNUM_POINTS 2\n"

static void variants(void)
{
    const double pi = acos(-1);
    static const struct {
        const char *label, *text, *note;
        double phi_i, phi_s;
        size_t n_channels;
    } cases[] = {
        {"all four angles", HEAD "VARS theta_i,phi_i,theta_s,phi_s,465nm,b\n0.1,3,0.2,1,5,6\n0.1,3,0.2,1,7,-8\n", "", 3, 1, 2},
        {"other order, crlf", "NUM_POINTS 2\r\nVARS b,phi_s,theta_s,theta_i,phi_i\r\n5,1,0.2,0.1,3\r\n-8,1,.2,.1,3\r\n", "", 3, 1,
         1},
        {"unnamed phi_s", HEAD "VARS theta_i,phi_i,theta_s,465nm,b\n0.1,3,0.2,1,5,6\n0.1,3,0.2,1,7,-8\n",
         "VARS names 5 columns, the rows have 6: the one after theta_s is taken to be phi_s", 3, 1, 2},
        {"no phi_s", HEAD "VARS theta_i,phi_i,theta_s,465nm,b\n\n0.1,3,0.2,5,6\n0.1,3,0.2,7,-8\n", "no phi_s: 0 is assumed", 3, 0,
         2},
        {"no phi_i", HEAD "VARS theta_i,theta_s,phi_s,465nm,b\n0.1,0.2,1,5,6\n0.1,0.2,1,7,-8\n", "no phi_i: pi is assumed", -1, 1,
         2},
        {"in the plane", HEAD "VARS Theta_i, Theta_r, brdf\n 0.1, 0.2, 5\n0.1,0.2,-8\n", "no phi_i: pi is assumed", -1, 0, 1},
        {"no count", "VARS theta_i,phi_i,theta_s,phi_s,b\n0.1,3,0.2,1,5\n0.1,3,0.2,1,-8\n", "NUM_POINTS is missing", 3, 1, 1},
        {"no end of line", HEAD "VARS theta_i,phi_i,theta_s,phi_s,b\n0.1,3,0.2,1,5\n0.1,3,0.2,1,-8", "end-of-line", 3, 1, 1}};
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        ff_table t;
        if (!check_reads(cases[k].label, "astm", cases[k].text, &t)) continue;
        double phi_i = cases[k].phi_i < 0 ? pi : cases[k].phi_i;
        FF_CHECK(t.n == 2 && t.n_channels == cases[k].n_channels, "%s: %zu x %zu", cases[k].label, t.n, t.n_channels);
        for (size_t i = 0; i < 2; i++)
            FF_CHECK(t.angle[0][i] == 0.1 && t.angle[1][i] == phi_i && t.angle[2][i] == 0.2 && t.angle[3][i] == cases[k].phi_s,
                     "%s: angles %g %g %g %g", cases[k].label, t.angle[0][i], t.angle[1][i], t.angle[2][i], t.angle[3][i]);
        FF_CHECK(t.value[0] == 5 && t.value[t.n * t.n_channels - 1] == -8, "%s: values", cases[k].label);
        FF_CHECK(t.n_negative == 1 && t.n_invalid == 0 && t.isotropic == 1 && t.radians_per_unit == 1, "%s: counts",
                 cases[k].label);
        FF_CHECK(cases[k].note[0] ? strstr(t.note, cases[k].note) != NULL : t.note[0] == '\0', "%s: note '%s'", cases[k].label,
                 t.note);
        if (strcmp(t.channels[0].name, "465nm") == 0)
            FF_CHECK(t.channels[0].wavelength_nm == 465, "%s: wavelength", cases[k].label);
        ff_table_clear(&t);
    }
    ff_table t;
    if (check_reads("two azimuths", "astm", HEAD "VARS theta_i,phi_i,theta_s,phi_s,b\n0,3,0,0,1\n0,2,0,0,1\n", &t)) {
        FF_CHECK(t.isotropic == 0, "two azimuths of incidence");
        ff_table_clear(&t);
    }
}

static void refusals(void)
{
#define VARS HEAD "VARS theta_i,phi_i,theta_s,phi_s,b\n"
    check_refuses("astm", "", FF_ERR_READ, 0, WORDS("end of the file", "expected a line VARS"));
    check_refuses("astm", HEAD, FF_ERR_READ, 4, WORDS("end of the file", "expected a line VARS"));
    check_refuses("astm", HEAD "0,1,2,3,4\n", FF_ERR_FORMAT, 5, WORDS("'0,1,2,3,4'", "expected 'KEY value' or VARS"));
    check_refuses("astm", VARS, FF_ERR_READ, 5, WORDS("no rows", "NUM_POINTS"));
    check_refuses("astm", VARS "0,0,0,0,1\n", FF_ERR_READ, 6, WORDS("after 1 rows", "expected 2", "NUM_POINTS"));
    check_refuses("astm", VARS "0,0,0,0,1\n0,0,0,0,2\n0,0,0,0,3\n", FF_ERR_FORMAT, 8,
                  WORDS("found more rows", "expected 2", "NUM_POINTS"));
    check_refuses("astm", "NUM_POINTS many\nVARS theta_i,theta_s,b\n0,0,1\n", FF_ERR_FORMAT, 1, WORDS("'many'", "whole number"));
    check_refuses("astm", "NUM_POINTS 0\nVARS theta_i,theta_s,b\n0,0,1\n", FF_ERR_FORMAT, 1, WORDS("'0'", "whole number >= 1"));
    check_refuses("astm", "NUM_POINTS -5\nVARS theta_i,theta_s,b\n0,0,1\n", FF_ERR_FORMAT, 1, WORDS("'-5'", "whole number >= 1"));
    check_refuses("astm", "NUM_POINTS 99999999999999999999999\nVARS theta_i,theta_s,b\n0,0,1\n", FF_ERR_FORMAT, 1,
                  WORDS("whole number"));
    check_refuses("astm", "NUM_POINTS 4000000000000000000\nVARS theta_i,theta_s,b\n0,0,1\n", FF_ERR_READ, 3,
                  WORDS("after 1 rows", "4000000000000000000"));
    check_refuses("astm", HEAD "VARS theta_i,phi_i,phi_s,b\n", FF_ERR_FORMAT, 5,
                  WORDS("theta_i, phi_i, phi_s, b", "expected a column theta_s"));
    check_refuses("astm", HEAD "VARS phi_i,theta_s,b\n", FF_ERR_FORMAT, 5, WORDS("expected a column theta_i"));
    check_refuses("astm", HEAD "VARS theta_i,phi_i,theta_s,phi_s\n", FF_ERR_FORMAT, 5,
                  WORDS("expected at least one column of values"));
    check_refuses("astm", HEAD "VARS theta_i,theta_s,theta_r,b\n", FF_ERR_FORMAT, 5, WORDS("theta_s and theta_r", "expected one"));
    check_refuses("astm", HEAD "VARS theta_i,theta_s,b,b\n", FF_ERR_FORMAT, 5, WORDS("'b' twice"));
    check_refuses("astm", HEAD "VARS\n", FF_ERR_FORMAT, 5, WORDS("column 1", "no name"));
    check_refuses("astm", VARS "0,0,0,0\n", FF_ERR_FORMAT, 6, WORDS("found 4 cells", "expected 5"));
    check_refuses("astm", VARS "0,0,0,0,1,2\n", FF_ERR_FORMAT, 6, WORDS("found 6 cells", "expected 5"));
    check_refuses("astm", HEAD "VARS theta_i,phi_i,theta_s,b\n0,0,0,0,1,2\n", FF_ERR_FORMAT, 6,
                  WORDS("found 6 cells", "expected 4"));
    check_refuses("astm", HEAD "VARS theta_i,phi_i,theta_s,b\n0,0,0,0,1\n0,0,0,1\n", FF_ERR_FORMAT, 7,
                  WORDS("found 4 cells", "expected 5"));
    check_refuses("astm", VARS "0,0,0,0,nan\n", FF_ERR_DATA, 6, WORDS("column 'b'", "'nan'", "expected a finite number"));
    check_refuses("astm", VARS "0,0,0,0,1\n0,inf,0,0,1\n", FF_ERR_DATA, 7,
                  WORDS("column 'phi_i'", "'inf'", "expected a finite number"));
    check_refuses("astm", VARS "0,0,0,0,\n", FF_ERR_DATA, 6, WORDS("column 'b'", "an empty cell", "expected a finite number"));
    check_refuses("astm", VARS "45,0,0,0,1\n", FF_ERR_DATA, 6, WORDS("column 'theta_i'", "found 45", "radians", "degrees?"));
    check_refuses("astm", VARS "0,0,-4,0,1\n", FF_ERR_DATA, 6, WORDS("column 'theta_s'", "found -4", "radians"));
}

static void test_prefixes(void)
{
    static const char text[] = HEAD "VARS theta_i,phi_i,theta_s,465nm\n\n0.5,3.25,0.125,1,5.5\n1,3.25,0.25,2,6.5\n";
    const char *path = ff_test_path("prefix.astm");
    size_t whole = 0;
    for (size_t n = 0; n < sizeof text; n++) {
        ff_test_write(path, text, n);
        ff_table t;
        ff_error err = {0};
        if (ff_table_read_into(path, n % 2 ? "astm" : NULL, &t, &err) == FF_OK) {
            whole++;
            FF_CHECK(t.n == 2, "prefix %zu: %zu rows", n, t.n);
            FF_CHECK(n >= sizeof text - 1 || strstr(t.note, "cut"), "prefix %zu: cut within the last number and not noted", n);
            ff_table_clear(&t);
        } else {
            FF_CHECK(strcmp(err.path, path) == 0 && err.message[0], "prefix %zu: no message", n);
        }
    }
    /* a file whose last number reads "6", "6." or "6.5" cannot be told from a whole one, but for its missing end of line */
    FF_CHECK(whole == 4, "%zu prefixes were read", whole);
}

static void round_trip(void)
{
    ff_table t, back;
    ff_error err = {0};
    if (!FF_CHECK(ff_table_init(3000, 2, NULL, 0, 0, &t, &err) == FF_OK, "%s", err.message)) return;
    for (size_t i = 0; i < t.n; i++) {
        for (int k = 0; k < 4; k++) t.angle[k][i] = ff_test_uniform() * (k % 2 ? 6.28 : 1.57);
        for (size_t c = 0; c < 2; c++) t.value[c * t.n + i] = ldexp(ff_test_uniform(), (int)(ff_test_random() % 40) - 30);
    }
    strcpy(t.channels[1].name, "632.8nm");
    const char *path = ff_test_path("round.astm");
    FF_CHECK(ff_table_write(path, NULL, &t, &err) == FF_OK, "%s", err.message);
    if (FF_CHECK(ff_table_read_into(path, NULL, &back, &err) == FF_OK, "%s", err.message)) {
        check_same_tables("round trip", &t, &back);
        check_same_angles("round trip", &t, &back);
        FF_CHECK(back.channels[1].wavelength_nm == 632.8, "wavelength");
        ff_table_clear(&back);
    }
    /* what was not measured is left out, and the count says so */
    t.valid[5] = 0;
    FF_CHECK(ff_table_write(path, NULL, &t, &err) == FF_OK, "%s", err.message);
    if (FF_CHECK(ff_table_read_into(path, NULL, &back, &err) == FF_OK, "%s", err.message)) {
        FF_CHECK(back.n == 2999 && back.value[5] == t.value[6], "%zu rows", back.n);
        ff_table_clear(&back);
    }
    strcpy(t.channels[0].name, "a b");
    ff_status status = ff_table_write(path, NULL, &t, &err);
    FF_CHECK(status == FF_ERR_UNSUPPORTED && strstr(err.message, "'a b'"), "%d %s", status, err.message);
    ff_table_clear(&t);
    if (!FF_CHECK(ff_table_init(1, 1, NULL, 1, 0, &t, &err) == FF_OK, "%s", err.message)) return;
    status = ff_table_write(path, NULL, &t, &err);
    FF_CHECK(status == FF_ERR_UNSUPPORTED && strstr(err.message, "standard deviations"), "%d %s", status, err.message);
    ff_table_clear(&t);
    FF_CHECK(check_leftovers() == 0, "%d unfinished files", check_leftovers());
}

static void byte_order_marks(void)
{
    check_byte_order_mark("astm", HEAD "VARS theta_i,theta_s,b\n0,0,1\n0,1,1\n");
    check_byte_order_mark("astm", "VARS theta_i,theta_s,b\n0,0,1\n0,1,1\n");
}

FF_TEST_MAIN(FF_TEST(variants), FF_TEST(refusals), FF_TEST(test_prefixes), FF_TEST(byte_order_marks), FF_TEST(round_trip))
