/* Files of the pgII gonio-photometer, made here; a real one where it is. */
#include "check_text.h"

#define HEAD(kind)                                                                                                                 \
    "#pgII BSDF data\n#sample_name\t\"x\"\n#incident_angle\t30\t15\n#datapoints_in_file\t3\n#format: theta\tphi\t" kind "\n"
#define ROWS "0\t0\t0.5\n60\t195\t-0.25\n30 195 4\n"

static void test_reading(void)
{
    static const struct {
        const char *label, *text;
        double factor_at_60, scale; /* of the stored value at theta 60 */
        int quantity, asked;
        const char *note;
    } cases[] = {{"BSDF", HEAD("BSDF") ROWS, 1, NAN, FF_BRDF, -1, ""},
                 {"BRDF", HEAD("brdf") ROWS, 1, NAN, FF_BRDF, -1, ""},
                 {"DSF", HEAD("DSF") ROWS, 2, NAN, FF_BRDF_COS, -1, ""},
                 {"BSDF that is none", HEAD("BSDF") ROWS, 2, NAN, FF_BRDF_COS, FF_BRDF_COS, ""},
                 {"current", HEAD("[uA]") ROWS, 20, 10, FF_BRDF_COS, -1, "in uA: taken as proportional to f cos(theta_o)"},
                 {"current like f", HEAD("[uA]") ROWS, 10, 10, FF_BRDF, FF_BRDF, "what the option 'quantity' says"},
                 {"the light by its parts", "#intheta 30\r\n#inphi:\t15\r\n#format: theta phi BSDF\r\n" ROWS, 1, NAN, FF_BRDF, -1,
                  "datapoints_in_file is missing"},
                 {"fewer rows", "#datapoints_in_file 9\n#incident_angle 30 15\n#format: theta phi BSDF\n" ROWS "# end\n", 1, NAN,
                  FF_BRDF, -1, "says 9, the file has 3 rows"}};
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        const char *label = cases[k].label;
        ff_read_options o;
        ff_read_options_init(&o);
        o.quantity = cases[k].asked;
        o.scale = cases[k].scale;
        ff_table t;
        if (!check_reads_with(label, "pgii", cases[k].text, &o, &t)) continue;
        FF_CHECK(t.n == 3 && t.n_channels == 1 && t.isotropic == 1 && t.n_invalid == 0 && t.n_negative == 1, "%s: %zu samples",
                 label, t.n);
        FF_CHECK(t.quantity == (ff_quantity)cases[k].quantity && t.radians_per_unit == check_pi / 180, "%s: quantity, unit", label);
        for (size_t i = 0; i < 3; i++) FF_CHECK(t.angle[0][i] == 30 && t.angle[1][i] == 15, "%s: the light", label);
        FF_CHECK(t.angle[2][1] == 60 && t.angle[3][1] == 195 && t.angle[2][2] == 30 && t.angle[3][2] == 195, "%s: directions",
                 label);
        double v;
        ff_table_values(&t, 0, 1, 1, &v);
        FF_CHECK(fabs(v / (-0.25 * cases[k].factor_at_60) - 1) < 1e-15, "%s: %g", label, v);
        if (cases[k].note[0])
            FF_CHECK(strstr(t.note, cases[k].note), "%s: '%s'", label, t.note);
        else
            FF_CHECK(t.note[0] == '\0', "%s: '%s'", label, t.note);
        ff_table_clear(&t);
    }
    ff_table t;
    if (check_reads("colours", "pgii", "#colorimetry: CIE-XYZ\n" HEAD("BSDF") "10 20 1 2 3\n40 50 4 5 6\n60 70 7 8 9\n", &t)) {
        FF_CHECK(t.n_channels == 3 && strcmp(t.channels[2].name, "Z") == 0 && t.value[3 * 2 + 1] == 6, "%zu channels",
                 t.n_channels);
        ff_table_clear(&t);
    }
    if (check_reads("transmission too", "pgii", HEAD("BSDF") "10 0 1\n150 0 2\n90 0 3\n", &t)) {
        FF_CHECK(t.n == 3 && t.n_invalid == 1 && !t.valid[1] && strstr(t.note, "1 samples"), "%zu invalid, '%s'", t.n_invalid,
                 t.note);
        ff_table_clear(&t);
    }
    /* the mirror direction of the light behind the sample, as the file's own frame has it */
    if (check_reads("from behind", "pgii", "#incident_angle 150 10\n#format: theta phi BSDF\n150 190 5\n30 190 6\n", &t)) {
        double w[6];
        check_directions(&t, 0, w);
        FF_CHECK(t.n_invalid == 1 && t.valid[0] && t.angle[0][0] == 30 && strstr(t.note, "turned over"), "'%s'", t.note);
        FF_CHECK(fabs(w[0] + w[3]) < 1e-15 && fabs(w[1] + w[4]) < 1e-15 && w[2] > 0 && fabs(w[2] - w[5]) < 1e-15,
                 "mirror reflection");
        ff_table_clear(&t);
    }
}

static void refusals(void)
{
    check_refuses("pgii", "", FF_ERR_READ, 0, WORDS("no rows"));
    check_refuses("pgii", HEAD("BSDF"), FF_ERR_READ, 5, WORDS("no rows of numbers"));
    check_refuses("pgii", "#format: theta phi BSDF\n1 2 3\n", FF_ERR_FORMAT, 2, WORDS("before a line #incident_angle"));
    check_refuses("pgii", "#intheta 10\n#format: theta phi BSDF\n1 2 3\n", FF_ERR_FORMAT, 3,
                  WORDS("before a line #incident_angle"));
    check_refuses("pgii", "#incident_angle 1 2\n1 2 3\n", FF_ERR_FORMAT, 2, WORDS("before a line #format:"));
    check_refuses("pgii", "#incident_angle 10\n", FF_ERR_FORMAT, 1, WORDS("#incident_angle: found '10'", "phi"));
    check_refuses("pgii", "#incident_angle 190 0\n", FF_ERR_FORMAT, 1, WORDS("'190 0'", "0 to 180"));
    check_refuses("pgii", "#intheta -1\n", FF_ERR_FORMAT, 1, WORDS("'-1'", "0 to 180"));
    check_refuses("pgii", "#inphi north\n", FF_ERR_FORMAT, 1, WORDS("'north'", "phi in degrees"));
    check_refuses("pgii", "#format: theta\n", FF_ERR_FORMAT, 1, WORDS("'theta'", "theta phi and what"));
    check_refuses("pgii", "#format: phi theta BSDF\n", FF_ERR_FORMAT, 1, WORDS("'phi'", "theta phi"));
    check_refuses("pgii", "#format: theta phi volts\n", FF_ERR_FORMAT, 1, WORDS("'volts'", "BSDF, BRDF, DSF"));
    check_refuses("pgii", HEAD("BTDF") ROWS, FF_ERR_UNSUPPORTED, 5, WORDS("BTDF", "transmission"));
    check_refuses("pgii", HEAD("[uA]") ROWS, FF_ERR_UNSUPPORTED, 5, WORDS("in 'uA'", "not calibrated"));
    check_refuses("pgii", "#colorimetry: CIE-Lab\n", FF_ERR_FORMAT, 1, WORDS("'CIE-Lab'", "CIE-XYZ"));
    check_refuses("pgii", "#datapoints_in_file some\n", FF_ERR_FORMAT, 1, WORDS("'some'", "whole number"));
    check_refuses("pgii", HEAD("BSDF") "1 2\n", FF_ERR_FORMAT, 6, WORDS("found 2 numbers", "expected 3"));
    check_refuses("pgii", HEAD("BSDF") "1 2 3 4\n", FF_ERR_FORMAT, 6, WORDS("more than 3 numbers"));
    check_refuses("pgii", HEAD("BSDF") "1 2 x\n", FF_ERR_DATA, 6, WORDS("'x'", "finite number"));
    check_refuses("pgii", HEAD("BSDF") "-1 2 3\n", FF_ERR_DATA, 6, WORDS("theta -1", "0 to 180"));
    check_refuses("pgii", HEAD("BSDF") "95 2 3\n170 2 3\n", FF_ERR_UNSUPPORTED, 0,
                  WORDS("transmission only", "expected reflection"));
    /* a count that nothing is allocated for */
    ff_table t;
    if (check_reads("many points", "pgii",
                    "#datapoints_in_file 9007199254740992\n#incident_angle 0 0\n#format: theta phi BSDF\n1 2 3\n", &t))
        ff_table_clear(&t);
}

static int test_real(void)
{
    const char *path = check_data("pgii/golden_paper_partial.txt");
    if (!path) return 0;
    ff_table t;
    ff_error err = {0};
    ff_read_options o;
    ff_read_options_init(&o);
    ff_status status = ff_table_read_with_into(path, &o, &t, &err);
    FF_CHECK(status == FF_ERR_UNSUPPORTED && strstr(err.message, "uA") && err.hint == FF_HINT_SCALE, "%d %s, hint %d", status,
             err.message, (int)err.hint);
    o.scale = 2;
    if (!FF_CHECK(ff_table_read_with_into(path, &o, &t, &err) == FF_OK, "%s:%ld: %s", path, err.line, err.message)) return 1;
    size_t size, n = 0, negative = 0, brightest = 0;
    double worst = 0, largest = 0;
    char *text = ff_test_slurp(path, &size), *rest;
    for (char *line = strtok_r(text, "\n", &rest); line; line = strtok_r(NULL, "\n", &rest)) {
        double v[3], f;
        if (*line == '#' || sscanf(line, "%lf %lf %lf", v, v + 1, v + 2) != 3 || n >= t.n) continue;
        ff_table_values(&t, 0, n, 1, &f);
        const double expected = 2 * v[2] / cos(v[0] * check_pi / 180);
        worst = fmax(worst, fabs(f - expected) / (fabs(expected) + 1e-300));
        negative += v[2] < 0;
        if (v[2] > largest) largest = v[2], brightest = n;
        FF_CHECK(v[0] == t.angle[2][n] && v[1] == t.angle[3][n], "row %zu", n);
        n++;
    }
    free(text);
    /* near 90 degrees the cosine loses digits with the angle's own rounding */
    FF_CHECK(n == 49297 && t.n == n && t.n_negative == negative && worst < 1e-10, "%zu rows, %zu negative, off by %g", t.n,
             t.n_negative, worst);
    FF_CHECK(t.angle[0][0] == 26.8421 && t.angle[1][0] == 0 && strstr(t.note, "says 127039, the file has 49297"), "'%s'", t.note);
    double w[6]; /* the largest reading is within 3 degrees of the mirror direction */
    check_directions(&t, brightest, w);
    FF_CHECK(-w[0] * w[3] - w[1] * w[4] + w[2] * w[5] > cos(0.053), "the peak is at %g %g", t.angle[2][brightest],
             t.angle[3][brightest]);
    ff_table_clear(&t);
    return 1;
}

static void one_file_damaged(void)
{
    check_prefixes("pgii", HEAD("BSDF") ROWS, 3, 1);
    check_byte_order_mark("pgii", HEAD("BSDF") ROWS);
    check_flips("pgii", HEAD("DSF") ROWS);
}

static void measured(void)
{
    if (!test_real()) FF_SKIP("no real file in %s/pgii", check_data_dir());
}

FF_TEST_MAIN(FF_TEST(test_reading), FF_TEST(refusals), FF_TEST(one_file_damaged), FF_TEST(measured))
