/* FRED files, made here; real ones where they are. */
#include "check_text.h"

#define HEAD "type bsdf_data\nformat angles=deg bsdf=value scale=1\n"

static void expect(const char *label, const ff_table *t, size_t i, double theta_i, double phi_i, double theta_o, double phi_o,
                   double f)
{
    double v;
    ff_table_values(t, 0, i, 1, &v);
    FF_CHECK(fabs(t->angle[0][i] - theta_i) < 1e-15 && fabs(t->angle[1][i] - phi_i) < 1e-15 &&
                 fabs(t->angle[2][i] - theta_o) < 1e-15 && fabs(t->angle[3][i] - phi_o) < 1e-15,
             "%s %zu: %g %g -> %g %g", label, i, t->angle[0][i], t->angle[1][i], t->angle[2][i], t->angle[3][i]);
    FF_CHECK(fabs(v - f) <= 1e-15 * fabs(f), "%s %zu: %.17g, expected %.17g", label, i, v, f);
}

static void reading(void)
{
    ff_table t;
    if (check_reads("plain", "fred", HEAD "10\t0\n0\t0\t0.25\n5\t20\t-0.5\n30 0\n30 0 7\n", &t)) {
        FF_CHECK(t.n == 3 && t.n_channels == 1 && t.isotropic == 1 && t.n_negative == 1 && t.n_invalid == 0 && t.note[0] == '\0',
                 "%zu samples, '%s'", t.n, t.note);
        FF_CHECK(t.radians_per_unit == check_pi / 180 && strcmp(t.channels[0].name, "f") == 0, "unit, name");
        expect("plain", &t, 0, 10, 180, 0, 0, 0.25);
        expect("plain", &t, 1, 10, 180, 5, 20, -0.5);
        expect("plain", &t, 2, 30, 180, 30, 0, 7);
        double w[6]; /* the last one is the mirror reflection */
        check_directions(&t, 2, w);
        FF_CHECK(fabs(w[0] + w[3]) < 1e-15 && fabs(w[1] + w[4]) < 1e-15 && fabs(w[2] - w[5]) < 1e-15, "mirror reflection");
        ff_table_clear(&t);
    }
    if (check_reads("in the plane, scaled", "fred",
                    "\r\nTYPE  BSDF_DATA \r\nFormat bsdf=VALUE angles=DEG scale=0.5\r\n# words\r\n15 90\r\n-30 90 4\r\n\r\n", &t)) {
        expect("in the plane", &t, 0, 15, 270, -30, 90, 2);
        FF_CHECK(t.channels[0].scale == 0.5, "scale");
        ff_table_clear(&t);
    }
    if (check_reads("logarithms", "fred", "type bsdf_data\nformat angles=deg bsdf=log scale=2\n0 0\n0 0 -2\n10 0 0.5\n", &t)) {
        expect("logarithms", &t, 0, 0, 180, 0, 0, 0.02);
        expect("logarithms", &t, 1, 0, 180, 10, 0, 2 * sqrt(10));
        FF_CHECK(strstr(t.note, "decimal logarithms"), "'%s'", t.note);
        ff_table_clear(&t);
    }
    if (check_reads("cosines", "fred", "type bsdf_data\nformat angles=sin bsdf=value\n0.5 0\n0 0 1\n-0.3 0.4 2\n0 1 3\n", &t)) {
        expect("cosines", &t, 0, asin(0.5), 1.5 * check_pi, 0, 0, 1);
        expect("cosines", &t, 1, asin(0.5), 1.5 * check_pi, asin(0.5), atan2(-0.3, 0.4), 2);
        expect("cosines", &t, 2, asin(0.5), 1.5 * check_pi, check_pi / 2, 0, 3);
        FF_CHECK(t.radians_per_unit == 1 && strstr(t.note, "sin(phi) sin(theta)"), "'%s'", t.note);
        ff_table_clear(&t);
    }
    if (check_reads("transmission too", "fred", HEAD "10 0\n10 0 1\n170 0 2\n-95 0 3\n90 0 4\n", &t)) {
        FF_CHECK(t.n == 4 && t.n_invalid == 2 && t.valid[0] && !t.valid[1] && !t.valid[2] && t.valid[3] &&
                     strstr(t.note, "2 samples"),
                 "%zu invalid, '%s'", t.n_invalid, t.note);
        ff_table_clear(&t);
    }
    if (check_reads("what FRED itself does with it", "fred",
                    "type bsdf_data\nformat angles=deg bsdf=value scale=1 exclude=0.03 num=501\n15 0\n-80 0 2.6E-03\n", &t)) {
        expect("with settings of FRED's", &t, 0, 15, 180, -80, 0, 2.6e-3);
        ff_table_clear(&t);
    }
    if (check_reads("two azimuths", "fred", HEAD "10 0\n10 0 1\n10 90\n10 0 1\n", &t)) {
        FF_CHECK(t.isotropic == 0, "two azimuths of incidence");
        ff_table_clear(&t);
    }
}

static void refusals(void)
{
    check_refuses("fred", "", FF_ERR_READ, 0, WORDS("end of the file", "'type bsdf_data'"));
    check_refuses("fred", "type bsdf\n", FF_ERR_FORMAT, 1, WORDS("'type bsdf'", "expected 'type bsdf_data'"));
    check_refuses("fred", "type bsdf_data 2\n", FF_ERR_FORMAT, 1, WORDS("'type bsdf_data 2'"));
    check_refuses("fred", "type bsdf_data\n", FF_ERR_READ, 1, WORDS("end of the file", "expected 'format"));
    check_refuses("fred", "type bsdf_data\n10 0\n", FF_ERR_FORMAT, 2, WORDS("'10'", "expected 'format"));
    check_refuses("fred", "type bsdf_data\nformat bsdf=value\n", FF_ERR_FORMAT, 2, WORDS("no 'angles='"));
    check_refuses("fred", "type bsdf_data\nformat angles=deg\n", FF_ERR_FORMAT, 2, WORDS("no 'bsdf='"));
    check_refuses("fred", "type bsdf_data\nformat angles=rad\n", FF_ERR_FORMAT, 2, WORDS("'rad'", "angles=sin"));
    check_refuses("fred", "type bsdf_data\nformat bsdf=ln\n", FF_ERR_FORMAT, 2, WORDS("'ln'", "bsdf=log"));
    check_refuses("fred", "type bsdf_data\nformat scale=0\n", FF_ERR_FORMAT, 2, WORDS("'0'", "> 0"));
    check_refuses("fred", "type bsdf_data\nformat scale=1x\n", FF_ERR_FORMAT, 2, WORDS("'1x'", "> 0"));
    check_refuses("fred", "type bsdf_data\nformat num=many\n", FF_ERR_FORMAT, 2, WORDS("'many'", "a number"));
    check_refuses("fred", "type bsdf_data\nformat colour=red\n", FF_ERR_FORMAT, 2, WORDS("'colour'", "angles="));
    check_refuses("fred", "type bsdf_data\nformat angles = deg\n", FF_ERR_FORMAT, 2, WORDS("'angles'", "without spaces"));
    check_refuses("fred", HEAD, FF_ERR_READ, 2, WORDS("end of the file", "specular direction"));
    check_refuses("fred", HEAD "1 2 3\n", FF_ERR_FORMAT, 3, WORDS("three numbers", "specular direction before it"));
    check_refuses("fred", HEAD "10 0\n1 2 3\n30 0\n", FF_ERR_READ, 5, WORDS("end of the file", "direction of line 5"));
    check_refuses("fred", HEAD "10 0\n1\n", FF_ERR_FORMAT, 4, WORDS("one number", "2 of a specular"));
    check_refuses("fred", HEAD "10 0\n1 2 3 4\n", FF_ERR_FORMAT, 4, WORDS("more than 3 numbers"));
    check_refuses("fred", HEAD "10 0\n1 2 inf\n", FF_ERR_DATA, 4, WORDS("'inf'", "finite number"));
    check_refuses("fred", HEAD "95 0\n1 2 3\n", FF_ERR_DATA, 3, WORDS("polar angle 95 of the specular direction", "90 degrees"));
    check_refuses("fred", HEAD "10 0\n-181 2 3\n", FF_ERR_DATA, 4, WORDS("polar angle -181", "180 degrees"));
    check_refuses("fred", HEAD "10 0\n95 2 3\n180 0 1\n", FF_ERR_UNSUPPORTED, 0, WORDS("transmission only", "expected reflection"));
    check_refuses("fred", "type bsdf_data\nformat angles=sin bsdf=value\n0 0\n0.8 0.7 1\n", FF_ERR_DATA, 4,
                  WORDS("0.8 0.7", "direction cosines"));
    check_refuses("fred", "type bsdf_data\nformat angles=deg bsdf=log\n0 0\n0 0 400\n", FF_ERR_DATA, 4,
                  WORDS("logarithm 400", "less than 1e308"));
    check_refuses("fred", "type bsdf_data\nformat angles=deg bsdf=value scale=10\n0 0\n0 0 1e308\n", FF_ERR_DATA, 4,
                  WORDS("value 1e+308", "less than 1e308"));
}

/* The laboratory's Zemax file has this coating's values at the specular direction: first azimuth row, first radial column. */
static size_t zemax_at_specular(const char *path, double *at, size_t most)
{
    size_t n, found = 0;
    char *text = ff_test_slurp(path, &n), *p = strstr(text, "DataBegin");
    while (p && found < most && (p = strstr(p, "TIS"))) {
        p += strcspn(p, "\n");
        at[found++] = strtod(p, &p);
    }
    free(text);
    return found;
}

static int test_real(void)
{
    static const char *const names[] = {"fred/AnoBlackEC1onAlum.txt", "fred/AnoBlackNiTEonSteel_fullAz.txt"};
    static const size_t n_samples[] = {1144, 2175};
    int n_files = 0;
    for (size_t k = 0; k < 2; k++) {
        const char *path = check_data(names[k]);
        ff_table t;
        ff_error err = {0};
        if (!path) continue;
        n_files++;
        size_t size, n_rows = 0;
        double sum = 0, mine = 0;
        char *text = ff_test_slurp(path, &size), *rest;
        for (char *line = strtok_r(text, "\n", &rest); line; line = strtok_r(NULL, "\n", &rest)) {
            double v[3];
            if (sscanf(line, "%lf %lf %lf", v, v + 1, v + 2) == 3) n_rows++, sum += v[2];
        }
        free(text);
        if (!FF_CHECK(ff_table_read_into(path, NULL, &t, &err) == FF_OK, "%s:%ld: %s", path, err.line, err.message)) continue;
        for (size_t i = 0; i < t.n; i++) mine += t.value[i];
        FF_CHECK(strcmp(t.format, "fred") == 0 && t.n == n_rows && t.n == n_samples[k] && mine == sum && t.isotropic == 1 &&
                     !t.note[0],
                 "%s: %zu samples, sum %.17g, expected %zu, %.17g; '%s'", path, t.n, mine, n_rows, sum, t.note);
        static const double incidence[4] = {10, 30, 50, 70};
        double brightest[4] = {0}, phi[4] = {-1, -1, -1, -1}, at_specular[4] = {0}, zemax[4];
        for (size_t i = 0; i < t.n; i++)
            for (int j = 0; j < 4; j++) {
                if (t.angle[0][i] != incidence[j]) continue;
                if (t.value[i] > brightest[j]) brightest[j] = t.value[i], phi[j] = t.angle[3][i];
                if (t.angle[2][i] == incidence[j] && t.angle[3][i] == 0) at_specular[j] = t.value[i];
            }
        for (int j = 0; j < 4; j++) /* to the 10 degrees of the scan */
            FF_CHECK(phi[j] == 0 || phi[j] == 10, "%s: at %g the largest value is at azimuth %g", path, incidence[j], phi[j]);
        const char *other = k == 0 ? check_data("zemax/AnoBlackEC1onAlum.bsdf") : NULL;
        if (other && FF_CHECK(zemax_at_specular(other, zemax, 4) == 4, "%s: incidences", other))
            for (int j = 0; j < 4; j++)
                FF_CHECK(fabs(at_specular[j] / zemax[j] - 1) < 0.05, "at %g: %g, Zemax %g", incidence[j], at_specular[j], zemax[j]);
        ff_table_clear(&t);
    }
    return n_files;
}

static void one_file_damaged(void)
{
    static const char text[] = HEAD "10\t0\n5\t20\t0.25\n30\t0\n30\t5\t7\n";
    check_prefixes("fred", text, 2, 1);
    check_byte_order_mark("fred", text);
    check_flips("fred", text);
}

static void measured(void)
{
    if (!test_real()) FF_SKIP("no real files in %s/fred", check_data_dir());
}

/* Interleaved incidences are sorted; what was not measured has no row. */
static void written(void)
{
    ff_table t, again;
    ff_error err = {0};
    if (!check_reads("written", "csv", "theta_i,phi_i,theta_o,phi_o,f\n10,0,20,180,1\n30,0,20,90,2\n10,0,40,0,\n10,0,50,10,-3\n",
                     &t))
        return;
    const char *path = ff_test_path("written.fred");
    if (FF_CHECK(ff_table_write(path, NULL, &t, &err) == FF_OK && ff_table_read_into(path, NULL, &again, &err) == FF_OK, "%s",
                 err.message)) {
        FF_CHECK(!strcmp(again.format, "fred") && again.n == 3 && again.angle[0][0] == 10 && again.angle[0][2] == 30, "%zu samples",
                 again.n);
        FF_CHECK(again.value[0] == 1 && again.value[1] == -3 && again.value[2] == 2, "%g %g %g", again.value[0], again.value[1],
                 again.value[2]);
        FF_CHECK(fabs(remainder(again.angle[3][1] - again.angle[1][1] - 10, 360)) < 1e-9, "%g %g", again.angle[1][1],
                 again.angle[3][1]);
        ff_table_clear(&again);
    }
    ff_table_clear(&t);
}

FF_TEST_MAIN(FF_TEST(written), FF_TEST(reading), FF_TEST(refusals), FF_TEST(one_file_damaged), FF_TEST(measured))
