/* The program's own CSV. With --locale everything runs again where numbers are written with a decimal comma. */
#include "check_table.h"
#include <locale.h>

#define H "theta_i,phi_i,theta_o,phi_o,f\n"

/* Reads text as a file; 1 when it could be read. */
static int reads_bytes(const char *label, const char *text, size_t n, ff_table *t)
{
    const char *path = ff_test_path("t.csv");
    ff_test_write(path, text, n);
    ff_error err = {0};
    char all[2048];
    ff_status status = ff_table_read_into(path, NULL, t, &err);
    ff_error_format(&err, all, sizeof all);
    if (!FF_CHECK(status == FF_OK, "%s: %s", label, all)) return 0;
    FF_CHECK(strcmp(t->format, "csv") == 0, "%s: format '%s'", label, t->format);
    return 1;
}
static int reads(const char *label, const char *text, ff_table *t)
{
    return reads_bytes(label, text, strlen(text), t);
}

static double value(const ff_table *t, size_t c, size_t i)
{
    double v;
    ff_table_values(t, c, i, 1, &v);
    return v;
}

/* ---- what is understood ---------------------------------------------------------------------- */

static void test_columns(void)
{
    ff_table t;
    if (!reads("columns in any order",
               "# facetfit-csv: 1\n# quantity: brdf\n# a remark\n"
               "weight,f_r,phi_o,465nm,theta_o,sigma_465nm,theta_i,sigma_r,phi_i,f_b x,\"sigma_b x\"\n"
               "0.5,1,180,2,45,0.2,30,0.1,10,-3,0.3\n\n# between\n 0.25 ,\t11,181 ,12,46,1.2,31,1.1,10,13,1.3\n",
               &t))
        return;
    FF_CHECK(t.n == 2 && t.n_channels == 3 && t.sigma && t.weight, "%zu x %zu", t.n, t.n_channels);
    FF_CHECK(strcmp(t.channels[0].name, "r") == 0 && strcmp(t.channels[1].name, "465nm") == 0 &&
                 strcmp(t.channels[2].name, "b x") == 0,
             "%s %s %s", t.channels[0].name, t.channels[1].name, t.channels[2].name);
    FF_CHECK(isnan(t.channels[0].wavelength_nm) && t.channels[1].wavelength_nm == 465, "%g", t.channels[1].wavelength_nm);
    FF_CHECK(t.angle[0][1] == 31 && t.angle[1][1] == 10 && t.angle[2][1] == 46 && t.angle[3][1] == 181, "angles");
    FF_CHECK(value(&t, 0, 1) == 11 && value(&t, 1, 1) == 12 && value(&t, 2, 1) == 13 && t.weight[1] == 0.25, "values");
    FF_CHECK(t.sigma[1] == 1.1 && t.sigma[3] == 1.2 && t.sigma[5] == 1.3, "sigmas");
    FF_CHECK(t.n_negative == 1 && t.n_invalid == 0 && t.isotropic == 1 && t.radians_per_unit == acos(-1) / 180, "%zu %d",
             t.n_negative, t.isotropic);
    FF_CHECK(t.note[0] == '\0', "note '%s'", t.note);
    ff_table_clear(&t);
}

static void variants(void)
{
    static const struct {
        const char *label, *text;
    } same[] = {{"plain", H "10,0,20,180,1.5\n30,0,120,90,-2\n"},
                {"crlf", "theta_i,phi_i,theta_o,phi_o,f\r\n10,0,20,180,1.5\r\n30,0,120,90,-2\r\n"},
                {"byte-order mark", "\xEF\xBB\xBF" H "10,0,20,180,1.5\n30,0,120,90,-2\n"},
                {"mark and crlf and comment",
                 "\xEF\xBB\xBF# angles: degrees\r\ntheta_i,phi_i,theta_o,phi_o,f\r\n10,0,20,180,1.5\r\n\r\n30,0,120,90,-2\r\n"},
                {"quotes", "\"theta_i\", \"phi_i\" ,\"theta_o\",\"phi_o\",\"f\"\n\"10\",0,20,180,1.5\n30,0, \"120\" ,90,-2\n"},
                {"spaces", " theta_i , phi_i,\ttheta_o,phi_o ,f \n 10 ,0 , 20,180,\t1.5 \n  \n30,0,120,90,-2  \n"},
                {"a spreadsheet's comments",
                 "\"# angles: degrees\",,,,\n# quantity: brdf,,,,\n" H "1e1,0,2.0e+1,180,+1.5\n30,0,120,90,-2\n"},
                {"capitals in comments", "# Angles: Degrees\n# QUANTITY : BRDF\n" H "10,0,20,180,1.5\n30,0,120,90,-2\n"}};
    for (size_t k = 0; k < sizeof same / sizeof same[0]; k++) {
        ff_table t;
        if (!reads(same[k].label, same[k].text, &t)) continue;
        FF_CHECK(t.n == 2 && t.angle[0][0] == 10 && t.angle[3][0] == 180 && t.angle[2][1] == 120 && value(&t, 0, 0) == 1.5 &&
                     value(&t, 0, 1) == -2,
                 "%s", same[k].label);
        FF_CHECK(strcmp(t.channels[0].name, "f") == 0 && t.n_negative == 1 && !t.note[0], "%s: %s", same[k].label, t.note);
        ff_table_clear(&t);
    }
    ff_table t;
    if (reads("no end of line", H "10,0,20,180,1.5", &t)) {
        FF_CHECK(t.n == 1 && strstr(t.note, "end-of-line"), "note '%s'", t.note);
        ff_table_clear(&t);
    }
}

static void quantities(void)
{
    ff_table t;
    const double pi = acos(-1);
    if (reads("cosine", "# quantity: brdf-cos\ntheta_i,phi_i,theta_o,phi_o,f,sigma\n0,0,60,0,1,0.5\n0,0,90,0,1,1\n0,0,100,0,1,1\n",
              &t)) {
        FF_CHECK(fabs(value(&t, 0, 0) - 2) < 1e-14 && fabs(t.sigma[0] - 1) < 1e-14, "%g %g", value(&t, 0, 0), t.sigma[0]);
        FF_CHECK(t.valid[0] && !t.valid[1] && !t.valid[2] && t.n_invalid == 2 && t.quantity == FF_BRDF_COS, "validity");
        FF_CHECK(value(&t, 0, 1) == 0 && isfinite(t.sigma[1]), "what was not measured is no number to compute with");
        ff_table_clear(&t);
    }
    if (reads("reflectance factor", "# quantity: reflectance-factor\n" H "0,0,60,0,1\n", &t)) {
        FF_CHECK(fabs(value(&t, 0, 0) - 1 / pi) < 1e-16 && t.quantity == FF_REFLECTANCE_FACTOR, "%g", value(&t, 0, 0));
        ff_table_clear(&t);
    }
    if (reads("radians", "# angles: radians\n" H "0.5,0,3.14159265358979,-7,1\n", &t)) {
        FF_CHECK(t.radians_per_unit == 1 && t.angle[3][0] == -7, "%g", t.radians_per_unit);
        ff_table_clear(&t);
    }
    if (reads("isotropic", "# isotropic: yes\n" H "1,0,1,0,1\n1,5,1,0,1\n", &t)) {
        FF_CHECK(t.isotropic == 1, "declared");
        ff_table_clear(&t);
    }
    if (reads("not isotropic", "# isotropic: no\n" H "1,0,1,0,1\n1,0,1,0,1\n", &t)) {
        FF_CHECK(t.isotropic == 0, "declared not");
        ff_table_clear(&t);
    }
    if (reads("two azimuths of incidence", H "1,0,1,0,1\n1,5,1,0,1\n", &t)) {
        FF_CHECK(t.isotropic == 0, "two azimuths");
        ff_table_clear(&t);
    }
}

/* What the name of the values says holds whether the angles have our names, bare, or others with units; the file's own word in a
 * comment goes before it, and a file that says that it is ours has names of channels and nothing else. */
static void quantities_by_name(void)
{
    static const char *const angles[2] = {"theta_i,phi_i,theta_o,phi_o", "theta_i (deg),phi_i (deg),theta_o (deg),phi_o (deg)"};
    static const struct {
        const char *before, *name;
        double divided_by;
        int quantity;
        const char *note; /* NULL: nothing has to be said */
    } cases[] = {{"", "reflectance factor", 3.14159265358979323846, FF_REFLECTANCE_FACTOR, "is taken for pi times the BRDF"},
                 {"", "Reflectance factor (%)", 314.159265358979323846, FF_REFLECTANCE_FACTOR, "in per cent"},
                 {"", "Reflectance (%)", 100, FF_BRDF, "'Reflectance (%)' is taken for the BRDF in 1/sr, in per cent"},
                 {"", "Reflectance", 1, FF_BRDF, "is taken for the BRDF"},
                 {"", "BRDF cos", 0.5, FF_BRDF_COS, "times cos(theta_o)"},
                 {"", "counts", 1, FF_BRDF, "proportional to the BRDF at best"},
                 {"", "BRDF (%)", 100, FF_BRDF, "in per cent"},
                 {"", "BRDF", 1, FF_BRDF, NULL}};
    static const struct {
        const char *before, *name;
        double divided_by;
        int quantity;
    } said[] = {{"# quantity: brdf\n", "Reflectance factor", 1, FF_BRDF},
                {"# quantity: reflectance-factor\n", "Reflectance (%)", 314.159265358979323846, FF_REFLECTANCE_FACTOR},
                {"# facetfit-csv: 1\n", "reflectance factor", 1, FF_BRDF},
                {"# facetfit-csv: 1\n", "Reflectance (%)", 1, FF_BRDF}};
    char text[256];
    ff_table t;
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++)
        for (size_t a = 0; a < 2; a++) {
            snprintf(text, sizeof text, "%s%s,%s\n30,0,60,180,12\n50,0,60,180,6\n", cases[k].before, angles[a], cases[k].name);
            if (!reads(text, text, &t)) continue;
            FF_CHECK(fabs(value(&t, 0, 0) * cases[k].divided_by / 12 - 1) < 1e-12 && (int)t.quantity == cases[k].quantity, "%s: %g",
                     text, value(&t, 0, 0));
            FF_CHECK(!cases[k].note || strstr(t.note, cases[k].note), "%s: note '%s'", text, t.note);
            ff_table_clear(&t);
        }
    for (size_t k = 0; k < sizeof said / sizeof said[0]; k++) {
        snprintf(text, sizeof text, "%s%s,%s\n30,0,60,180,12\n50,0,60,180,6\n", said[k].before, angles[0], said[k].name);
        if (!reads(text, text, &t)) continue;
        FF_CHECK(fabs(value(&t, 0, 0) * said[k].divided_by / 12 - 1) < 1e-12 && (int)t.quantity == said[k].quantity, "%s: %g", text,
                 value(&t, 0, 0));
        FF_CHECK(!strstr(t.note, "is taken for pi") && !strstr(t.note, "is taken for the BRDF"), "%s: note '%s'", text, t.note);
        ff_table_clear(&t);
    }
    if (reads("radians", "# angles: radians\ntheta_i,phi_i,theta_o,phi_o,Reflectance (%)\n0.5,0,1,3.1,1\n", &t)) {
        FF_CHECK(t.radians_per_unit == 1, "the file's own word for its angles: %g", t.radians_per_unit);
        ff_table_clear(&t);
    }
}

static void not_measured(void)
{
    ff_table t;
    if (!reads("empty cells",
               "theta_i,phi_i,theta_o,phi_o,f_r,f_g,sigma_r,sigma_g\n1,0,1,0,,-2,,1\n1,0,1,0,3,4,1,1\n1,0,1,0, , ,,\n", &t))
        return;
    FF_CHECK(t.n_invalid == 2 && !t.valid[0] && t.valid[1] && !t.valid[2], "%zu invalid", t.n_invalid);
    FF_CHECK(value(&t, 0, 0) == 0 && value(&t, 1, 0) == -2 && t.sigma[0] == 0 && t.n_negative == 0, "cells of an invalid sample");
    ff_table_clear(&t);
}

/* A code for what was not measured is none of noise, and stands in a file before its cosine is taken out. */
static void codes(void)
{
    static const struct {
        const char *label, *text;
        size_t invalid;
        const char *note;
    } cases[] = {{"a code", H "0,0,0,0,1\n0,0,10,0,-9999\n0,0,20,0,-0.01\n0,0,30,0,-9999\n", 2, "2 values are -9999"},
                 {"behind a cosine", "# quantity: brdf-cos\n" H "0,0,0,0,1\n0,0,60,0,-999\n0,0,45,0,0.5\n", 1, "1 value is -999,"},
                 {"of one channel", "theta_i,phi_i,theta_o,phi_o,f_r,f_g\n0,0,0,0,1,2\n0,0,10,0,1,-99\n", 1, "1 value is -99,"},
                 {"rounded", H "0,0,0,0,1\n0,0,10,0,-9.999e3\n0,0,10,0,1e30\n", 2, "1 value is 1e+30"},
                 {"noise of counts", H "0,0,0,0,50000\n0,0,10,0,-99\n0,0,20,0,-73\n", 0, ""},
                 {"no code", H "0,0,0,0,1\n0,0,10,0,-9998\n", 0, ""}};
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        ff_table t;
        if (!reads(cases[k].label, cases[k].text, &t)) continue;
        FF_CHECK(t.n_invalid == cases[k].invalid, "%s: %zu left out, expected %zu", cases[k].label, t.n_invalid, cases[k].invalid);
        FF_CHECK(strstr(t.note, cases[k].note) && (*cases[k].note || !*t.note), "%s: '%s'", cases[k].label, t.note);
        ff_table_clear(&t);
    }
}

/* What is no reflectance is not taken for a channel in silence. */
static void foreign_columns(void)
{
    ff_table t;
    if (reads("std", "theta_i,phi_i,theta_o,phi_o,f,std\n0,0,0,0,1,0.1\n", &t)) {
        FF_CHECK(t.n_channels == 1 && t.sigma && t.sigma[0] == 0.1, "%zu channels", t.n_channels);
        ff_table_clear(&t);
    }
    if (reads("stddev_NAME", "theta_i,phi_i,theta_o,phi_o,f_r,f_g,stddev_g,stddev_r\n0,0,0,0,1,2,0.2,0.1\n", &t)) {
        FF_CHECK(t.n_channels == 2 && t.sigma && t.sigma[0] == 0.1 && t.sigma[1] == 0.2, "%zu channels", t.n_channels);
        ff_table_clear(&t);
    }
    if (reads("a name that begins so", "theta_i,phi_i,theta_o,phi_o,stdlight\n0,0,0,0,1\n", &t)) {
        FF_CHECK(t.n_channels == 1 && !t.sigma && !*t.note, "'%s'", t.note);
        ff_table_clear(&t);
    }
    if (reads("temperature", "theta_i,phi_i,theta_o,phi_o,f,temp\n0,0,0,0,1,293\n", &t)) {
        FF_CHECK(t.n_channels == 1 && strcmp(t.channels[0].name, "f") == 0 && strstr(t.note, "'temp'"), "'%s'", t.note);
        ff_table_clear(&t);
    }
    if (reads("wavelength",
              "Wavelength,theta_i,phi_i,theta_o,phi_o,f,std\n532,0,0,0,0,1,.1\n633,0,0,0,0,2,.2\n532,0,0,9,0,3,.3\n633,0,0,9,0,4,."
              "4\n",
              &t)) {
        FF_CHECK(t.n == 2 && t.n_channels == 2 && t.channels[0].wavelength_nm == 532 && t.channels[1].wavelength_nm == 633,
                 "%zu samples, %zu channels", t.n, t.n_channels);
        FF_CHECK(value(&t, 0, 1) == 3 && value(&t, 1, 0) == 2 && t.sigma && t.sigma[3] == 0.4 && strstr(t.note, "wavelength"),
                 "'%s'", t.note);
        ff_table_clear(&t);
    }
}

static void refuses(const char *text, ff_status code, long line, const char *const *words);

/* What programs leave in a table that they write. */
static void left_by_programs(void)
{
    static const struct {
        const char *label, *text;
        size_t invalid;
    } cases[] = {
        {"a spreadsheet's padding", "theta_i,phi_i,theta_o,phi_o,f,,\n0,0,0,0,1,,\n0,0,10,0,, ,\n0,0,20,0,2\n,,,,,,\n", 1},
        {"numpy.savetxt", "# theta_i,phi_i,theta_o,phi_o,f\n0,0,0,0,1\n0,0,10,0,2\n0,0,10,0,\n", 1},
        {"behind a remark", "# angle: theta_i, theta_o\n#theta_i,phi_i,theta_o,phi_o,f\n0,0,0,0,1\n0,0,10,0,2\n0,0,10,0,\n", 1}};
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        ff_table t;
        if (!reads(cases[k].label, cases[k].text, &t)) continue;
        FF_CHECK(t.n == 3 && t.n_channels == 1 && t.n_invalid == cases[k].invalid && value(&t, 0, 0) == 1,
                 "%s: %zu samples, %zu left out", cases[k].label, t.n, t.n_invalid);
        ff_table_clear(&t);
    }
    ff_table t;
    if (reads("errors of a spreadsheet", H "0,0,0,0,1\n0,0,10,0,#DIV/0!\n0,0,20,0,#N/A\n0,0,20,0, #WERT! \n", &t)) {
        FF_CHECK(t.n == 4 && t.n_invalid == 3 && strstr(t.note, "3 cells"), "%zu left out, '%s'", t.n_invalid, t.note);
        ff_table_clear(&t);
    }
    refuses(H "#DIV/0!,0,0,0,1\n0,0,0,#N/A,1\n", FF_ERR_DATA, 3, WORDS("'#N/A'"));
    refuses("theta_i,phi_i,theta_o,phi_o,f,\n0,0,0,0,1,5\n", FF_ERR_FORMAT, 2, WORDS("found 6 cells, expected 5"));
}

static void radian_note(void)
{
    char text[2000] = H;
    for (int k = 0; k < 20; k++) snprintf(text + strlen(text), 40, "%d.5,0,1.5708,3,1\n", k % 2);
    ff_table t;
    if (!reads("suspicious", text, &t)) return;
    FF_CHECK(strstr(t.note, "1.5708") && strstr(t.note, "say angles radians"), "note '%s'", t.note);
    ff_table_clear(&t);
    strcat(text, "2,0,0,0,1\n");
    if (!reads("not suspicious", text, &t)) return;
    FF_CHECK(!t.note[0], "note '%s'", t.note);
    ff_table_clear(&t);
}

/* ---- what is refused, and in which words ----------------------------------------------------- */

static void refuses_bytes(const char *label, const char *text, size_t n, ff_status code, long line, const char *const *words)
{
    const char *path = ff_test_path("bad.csv");
    ff_test_write(path, text, n);
    check_fails(label, path, "csv", code, line, words);
}
static void refuses(const char *text, ff_status code, long line, const char *const *words)
{
    refuses_bytes(text, text, strlen(text), code, line, words);
}

static void bad_headers(void)
{
    refuses("", FF_ERR_READ, 0, WORDS("end of the file", "header"));
    refuses("# only a remark\n\n", FF_ERR_READ, 2, WORDS("header"));
    refuses(H, FF_ERR_DATA, 1, WORDS("no rows", "expected at least one"));
    refuses("theta_i,phi_i,theta_o,f\n1,2,3,4\n", FF_ERR_FORMAT, 1,
            WORDS("phi_o", "180", "theta_i, phi_i, theta_o, f", "say columns"));
    refuses("a,b\n1,2\n", FF_ERR_FORMAT, 1, WORDS("a, b", "theta_i", "say columns", "f=#2"));
    refuses("theta_i,phi_i,theta_o,phi_o\n", FF_ERR_FORMAT, 1, WORDS("'f'", "missing"));
    refuses("theta_i,phi_i,theta_o,phi_o,f,f\n", FF_ERR_FORMAT, 1, WORDS("'f'", "twice", "5", "6"));
    refuses("theta_i,phi_i,theta_o,phi_o,f_r,r\n", FF_ERR_FORMAT, 1, WORDS("'r'", "already"));
    refuses("theta_i,phi_i,theta_o,phi_o,,f\n", FF_ERR_FORMAT, 1, WORDS("column 5", "no name"));
    refuses("theta_i,phi_i,theta_o,phi_o,f\x01\n", FF_ERR_FORMAT, 1, WORDS("control", "f\\x01"));
    refuses("theta_i,phi_i,theta_o,phi_o,f_r,f_g,sigma_r\n", FF_ERR_FORMAT, 1, WORDS("found 1 sigma", "2 channels"));
    refuses("theta_i,phi_i,theta_o,phi_o,f_r,sigma_g\n", FF_ERR_FORMAT, 1, WORDS("'sigma_g'", "missing"));
    refuses("theta_i,phi_i,theta_o,phi_o,f,sigma,sigma_f\n", FF_ERR_FORMAT, 1, WORDS("'sigma_f'", "second"));
    refuses("theta_i;phi_i;theta_o;phi_o;f\n1;2;3;4;5,5\n1;2;3;4;5.5\n", FF_ERR_DATA, 2,
            WORDS("comma", "say dialect decimal=comma"));
    refuses("theta_i\tphi_i\ttheta_o\tphi_o\tf\n", FF_ERR_FORMAT, 1, WORDS("tabs", "expected ','"));
    refuses("# facetfit-csv: 2\n" H "1,2,3,4,5\n", FF_ERR_FORMAT, 1, WORDS("facetfit-csv", "'2'", "version 1"));
    refuses("# x\n# quantity: radiance\n" H "1,2,3,4,5\n", FF_ERR_FORMAT, 2, WORDS("quantity", "'radiance'", "brdf-cos"));
    refuses("# angles: gon\n" H "1,2,3,4,5\n", FF_ERR_FORMAT, 1, WORDS("angles", "'gon'", "degrees or radians"));
    refuses("# isotropic: maybe\n" H "1,2,3,4,5\n", FF_ERR_FORMAT, 1, WORDS("isotropic", "'maybe'", "yes or no"));
    refuses(H "1,2,3,4,5\n# angles: radians\n", FF_ERR_FORMAT, 3, WORDS("angles", "after the header", "expected it before"));
}

static void bad_rows(void)
{
    static const struct {
        const char *cell, *found;
    } cells[] = {{"no", "'no'"},       {"1.5.2", "'1.5.2'"}, {"inf", "'inf'"},     {"-Infinity", "'-Infinity'"},
                 {"1e999", "'1e999'"}, {"abc", "'abc'"},     {"1.2.3", "'1.2.3'"}, {"0x10", "'0x10'"},
                 {"1 2", "'1 2'"},     {"--1", "'--1'"},     {"1e", "'1e'"},       {"\"x\"", "'\"x\"'"},
                 {"\"1", "'\"1'"},     {"1\r2", "'1\\x0d2'"}};
    for (size_t k = 0; k < sizeof cells / sizeof cells[0]; k++) {
        char text[200];
        snprintf(text, sizeof text, H "1,2,3,4,5\n# remark\n1,2,3,4,%s\n", cells[k].cell);
        refuses(text, FF_ERR_DATA, 4, WORDS("column 'f'", cells[k].found, "expected a finite number", "leave the cell empty"));
    }
    refuses(H "1,,3,4,5\n", FF_ERR_DATA, 2, WORDS("'phi_i'", "an empty cell", "finite number"));
    refuses(H "1,2,3,4\n", FF_ERR_FORMAT, 2, WORDS("found 4 cells", "expected 5"));
    refuses(H "1,2,3,4,5,\n", FF_ERR_FORMAT, 2, WORDS("found 6 cells", "expected 5"));
    refuses(H "1,5,2,5,3,5,4,5,5,5\n", FF_ERR_FORMAT, 2, WORDS("found 10 cells", "expected 5", "decimal commas"));
    refuses(H "1;2;3;4;5\n", FF_ERR_FORMAT, 2, WORDS("found 1 cells", "expected 5", "';'"));
    refuses(H "1;2,2,3,4,5\n", FF_ERR_DATA, 2, WORDS("'theta_i'", "'1;2'", "';'"));
    refuses(H "1,2,180.5,4,5\n", FF_ERR_DATA, 2, WORDS("'theta_o'", "180.5", "degrees from -180 to 180"));
    refuses(H "-181,2,0,4,5\n", FF_ERR_DATA, 2, WORDS("'theta_i'", "-181", "180"));
    refuses("# angles: radians\n" H "45,2,0,4,5\n", FF_ERR_DATA, 3, WORDS("'theta_i'", "45", "radians"));
    refuses("theta_i,phi_i,theta_o,phi_o,f,sigma\n1,2,3,4,5,0\n", FF_ERR_DATA, 2, WORDS("'sigma'", "found 0", "> 0"));
    refuses("theta_i,phi_i,theta_o,phi_o,f,sigma\n1,2,3,4,5,-1\n", FF_ERR_DATA, 2, WORDS("'sigma'", "found -1", "> 0"));
    refuses("theta_i,phi_i,theta_o,phi_o,f,sigma\n1,2,3,4,5,\n", FF_ERR_DATA, 2, WORDS("'sigma'", "empty cell", "> 0"));
    refuses("theta_i,phi_i,theta_o,phi_o,f,weight\n1,2,3,4,5,-1\n", FF_ERR_DATA, 2, WORDS("'weight'", "found -1", ">= 0"));
    refuses("theta_i,phi_i,theta_o,phi_o,f,weight\n1,2,3,4,5,\n", FF_ERR_DATA, 2, WORDS("'weight'", "empty cell", "finite"));
    refuses(H "1,2,3,4,\n1,2,3,4,\n", FF_ERR_DATA, 0, WORDS("found 2 samples", "at least one measurement"));
    refuses("# quantity: brdf-cos\n" H "1,2,95,4,1\n", FF_ERR_DATA, 0, WORDS("found 1 samples", "at least one measurement"));
}

static void test_bytes(void)
{
    static const char nul[] = H "1,2,3,4,5\n1,2,3,4,5\0\n";
    refuses_bytes("NUL byte", nul, sizeof nul - 1, FF_ERR_FORMAT, 3, WORDS("NUL", "byte 49", "expected UTF-8 text"));
    static const char utf16[] = "\xFF\xFEt\0h\0e\0t\0a\0"; /* text that is no table */
    refuses_bytes("UTF-16", utf16, sizeof utf16 - 1, FF_ERR_FORMAT, 1, WORDS("'theta_i'", "missing", "the columns theta"));

    size_t n = (1 << 24) + 300000;
    char *text = malloc(n);
    if (!text) exit(1);
    memset(text, '1', n);
    memcpy(text, H, strlen(H));
    refuses_bytes("endless line", text, n, FF_ERR_FORMAT, 2, WORDS("found a line of more than 16777216 bytes"));
    memset(text, ',', 100000);
    refuses_bytes("too many columns", text, 100000, FF_ERR_FORMAT, 1, WORDS("found 100001 columns", "at most 4096"));
    memset(text, 'n', 100000);
    refuses_bytes("long name", text, 100000, FF_ERR_FORMAT, 1, WORDS("100000 bytes", "at most 63"));

    /* a number of a million digits is still a number */
    size_t head = strlen(H);
    memcpy(text, H "1,2,3,4,0.", head + 10);
    memset(text + head + 10, '3', 1000000);
    text[head + 10 + 1000000] = '\n';
    ff_table t;
    if (reads_bytes("a million digits", text, head + 10 + 1000001, &t)) {
        FF_CHECK(value(&t, 0, 0) == 1.0 / 3, "%.17g", value(&t, 0, 0));
        ff_table_clear(&t);
    }
    free(text);
}

/* ---- there and back -------------------------------------------------------------------------- */

static void fill(ff_table *t)
{
    for (size_t i = 0; i < t->n; i++) {
        for (int k = 0; k < 4; k++)
            t->angle[k][i] = (k % 2 ? 360 : 90) * ff_test_uniform() * (t->radians_per_unit == 1 ? acos(-1) / 180 : 1);
        if (t->weight) t->weight[i] = ff_test_uniform();
        t->valid[i] = i % 7 != 3;
        t->n_invalid += t->valid[i] == 0;
        int negative = 0;
        for (size_t c = 0; c < t->n_channels; c++) {
            double v = ldexp(ff_test_uniform() - 0.01, (int)(ff_test_random() % 60) - 40);
            t->value[c * t->n + i] = v;
            negative |= v < 0;
            if (t->sigma) t->sigma[c * t->n + i] = ff_test_uniform() + 1e-9;
        }
        t->n_negative += negative && t->valid[i];
    }
}

static void test_round_trip(int with_sigma, int with_weight, double unit)
{
    char label[64];
    snprintf(label, sizeof label, "round trip, sigma %d, weight %d, unit %g", with_sigma, with_weight, unit);
    ff_table t, back;
    ff_error err = {0};
    if (!FF_CHECK(ff_table_init(5000, 3, NULL, with_sigma, with_weight, &t, &err) == FF_OK, "%s", err.message)) return;
    strcpy(t.channels[0].name, "465nm");
    strcpy(t.channels[1].name, "a, \"b\"");
    strcpy(t.channels[2].name, "f");
    t.channels[1].scale = 1.15 / 1500;
    t.radians_per_unit = unit;
    fill(&t);
    const char *path = ff_test_path("round.csv"), *again = ff_test_path("again.csv");
    FF_CHECK(ff_table_write(path, NULL, &t, &err) == FF_OK, "%s: %s", label, err.message);
    if (FF_CHECK(ff_table_read_into(path, NULL, &back, &err) == FF_OK, "%s: line %ld %s", label, err.line, err.message)) {
        check_same_tables(label, &t, &back);
        check_same_angles(label, &t, &back);
        if (t.weight) FF_CHECK(back.weight && check_same_bits(t.weight, back.weight, t.n), "%s: weights", label);
        FF_CHECK(!t.weight == !back.weight, "%s: weights appeared", label);
        FF_CHECK(ff_table_write(again, NULL, &back, &err) == FF_OK, "%s: %s", label, err.message);
        size_t n, m;
        char *a = ff_test_slurp(path, &n), *b = ff_test_slurp(again, &m);
        FF_CHECK(n == m && memcmp(a, b, n) == 0, "%s: the second file differs", label);
        free(a);
        free(b);
        ff_table_clear(&back);
    }
    ff_table_clear(&t);
    FF_CHECK(check_leftovers() == 0, "%d unfinished files", check_leftovers());
}

/* Every prefix of a file is refused or gives fewer rows; which of them, the reader's rules say. */
static void prefixes(void)
{
    static const char text[] = "# quantity: brdf\ntheta_i,phi_i,theta_o,phi_o,f_r,f_g,sigma_r,sigma_g,weight\n"
                               "10,0,20,180,1.5,2,0.1,0.2,0.25\n11.25,0,20,180,,,,,0.5\r\n12,0,1e2,180,-1.5e-3,2,0.1,0.2,0.75\n";
    const char *path = ff_test_path("prefix.csv");
    size_t shorter = 0, refused = 0;
    for (size_t n = 0; n < sizeof text - 1; n++) {
        ff_test_write(path, text, n);
        ff_table t;
        ff_error err = {0};
        ff_status status = ff_table_read_into(path, n % 2 ? "csv" : NULL, &t, &err);
        if (status != FF_OK) {
            refused++;
            FF_CHECK(strcmp(err.path, path) == 0 && err.message[0], "prefix %zu: no message", n);
            continue;
        }
        shorter++;
        size_t ends = 0;
        for (size_t k = 0; k < n; k++) ends += text[k] == '\n';
        FF_CHECK(t.n <= 3 && t.n >= ends - 2, "prefix %zu: %zu rows", n, t.n);
        FF_CHECK(text[n - 1] == '\n' || strstr(t.note, "cut"), "prefix %zu: cut within a row and not noted", n);
        ff_table_clear(&t);
    }
    FF_CHECK(refused > 100 && shorter >= 10, "%zu refused, %zu shorter", refused, shorter);
}

/* Random damage: never a crash, always a message. */
static void test_damage(void)
{
    static const char text[] = "# angles: degrees\ntheta_i,phi_i,theta_o,phi_o,f_r,sigma_r\n10,0,20,180,1.5,0.25\n11,0,21,180,,\n";
    static const char bytes[] = ",\n\r\"#;-e.0\x00\xFF:9 f";
    const char *path = ff_test_path("damaged.csv");
    for (int k = 0; k < 3000; k++) {
        char copy[sizeof text];
        memcpy(copy, text, sizeof text);
        for (int j = 0; j <= k % 4; j++) copy[ff_test_random() % (sizeof text - 1)] = bytes[ff_test_random() % (sizeof bytes - 1)];
        ff_test_write(path, copy, sizeof text - 1);
        ff_table t;
        ff_error err = {0};
        if (ff_table_read_into(path, "csv", &t, &err) == FF_OK) {
            for (size_t i = 0; i < t.n; i++)
                FF_CHECK(isfinite(value(&t, 0, i)) && isfinite(t.angle[0][i]), "damaged %d: not finite", k);
            ff_table_clear(&t);
        } else {
            FF_CHECK(err.message[0] && err.path[0], "damaged %d: no message", k);
        }
    }
}

static void names_that_cannot_be_written(void)
{
    ff_table t;
    ff_error err = {0};
    if (!FF_CHECK(ff_table_init(1, 2, NULL, 0, 0, &t, &err) == FF_OK, "%s", err.message)) return;
    static const char *const names[] = {"", "a\nb", "c0"};
    for (int k = 0; k < 3; k++) {
        strcpy(t.channels[1].name, names[k]);
        ff_status status = ff_table_write(ff_test_path("names.csv"), NULL, &t, &err);
        FF_CHECK(status == FF_ERR_UNSUPPORTED && strstr(err.message, "channel 1"), "'%s': %d %s", names[k], status, err.message);
    }
    ff_table_clear(&t);
}

/* Sets a locale with decimal commas; makes one when the machine has none but can. */
static int set_comma_locale(void)
{
    static const char *const names[] = {"de_DE.UTF-8", "de_DE.utf8", "de_DE", "fr_FR.UTF-8"};
    for (size_t k = 0; k < 4; k++)
        if (setlocale(LC_ALL, names[k])) return 1;
    char command[512], dir[160];
    snprintf(dir, sizeof dir, "%s", ff_test_path("locale"));
    snprintf(command, sizeof command, "mkdir '%s' && localedef -i de_DE -f UTF-8 '%s/de_DE.UTF-8' >/dev/null 2>&1", dir, dir);
    if (system(command) != 0) return 0;
    setenv("LOCPATH", dir, 1);
    return setlocale(LC_ALL, "de_DE.UTF-8") != NULL;
}

static int with_comma; /* numbers have a decimal comma in this run */

static void decimal_comma(void)
{
    char comma[8];
    if (!with_comma) FF_SKIP("only with --locale");
    snprintf(comma, sizeof comma, "%.1f", 1.5);
    FF_CHECK(strcmp(comma, "1,5") == 0, "the locale has no decimal comma: %s", comma);
    ff_error err = {0};
    ff_error_set(&err, FF_ERR_DATA, NULL, 0, -1, "found %.1f", 1.5);
    FF_CHECK(strcmp(err.message, "found 1.5") == 0, "'%s'", err.message);
    snprintf(comma, sizeof comma, "%.1f", 1.5);
    FF_CHECK(strcmp(comma, "1,5") == 0, "the caller's locale was changed: %s", comma);
}

static void round_trips(void)
{
    for (int k = 0; k < 4; k++) test_round_trip(k & 1, k >> 1, acos(-1) / 180);
    test_round_trip(0, 0, 1);
}

static const ff_test_case cases[] = {FF_TEST(decimal_comma),
                                     FF_TEST(test_columns),
                                     FF_TEST(variants),
                                     FF_TEST(quantities),
                                     FF_TEST(quantities_by_name),
                                     FF_TEST(not_measured),
                                     FF_TEST(codes),
                                     FF_TEST(foreign_columns),
                                     FF_TEST(left_by_programs),
                                     FF_TEST(radian_note),
                                     FF_TEST(bad_headers),
                                     FF_TEST(bad_rows),
                                     FF_TEST(test_bytes),
                                     FF_TEST(round_trips),
                                     FF_TEST(prefixes),
                                     FF_TEST(test_damage),
                                     FF_TEST(names_that_cannot_be_written)};

int main(int argc, char **argv)
{
    if (argc > 1 && strcmp(argv[1], "--locale") == 0) {
        if (!set_comma_locale()) {
            printf("skipped: no locale with decimal commas (de_DE.UTF-8), and localedef cannot make one\n");
            return FF_TEST_SKIPPED;
        }
        with_comma = 1, argc = 1;
    }
    return ff_test_main(cases, sizeof cases / sizeof *cases, argc, argv);
}
