/* CSV files of others, read through a mapping of their columns. */
#include "check_table.h"

static const double pi = 3.14159265358979323846;

static ff_status read_mapped(const char *text, size_t n, const char *columns, const char *part, int quantity, ff_table *t,
                             ff_error *err)
{
    const char *path = ff_test_path("other.dat");
    ff_test_write(path, text, n);
    ff_read_options o;
    ff_read_options_init(&o);
    o.columns = columns;
    o.part = part;
    o.quantity = quantity;
    return ff_table_read_with_into(path, &o, t, err);
}

static int reads(const char *label, const char *text, const char *columns, const char *part, ff_table *t)
{
    ff_error err = {0};
    char all[2048];
    ff_status status = read_mapped(text, strlen(text), columns, part, -1, t, &err);
    ff_error_format(&err, all, sizeof all);
    if (!FF_CHECK(status == FF_OK, "%s: %s", label, all)) return 0;
    return FF_CHECK(strcmp(t->format, "csv") == 0, "%s: read as %s", label, t->format);
}

static void refuses(const char *text, const char *columns, const char *part, ff_status code, long line, const char *const *words)
{
    ff_table t;
    ff_error err = {0};
    char all[FF_ERROR_PATH + FF_ERROR_MESSAGE + 64];
    memset(&t, 0x5A, sizeof t);
    ff_status status = read_mapped(text, strlen(text), columns, part, -1, &t, &err);
    ff_error_format(&err, all, sizeof all);
    if (!FF_CHECK(status == code && err.code == code, "'%s': status %d, expected %d: %s", columns, status, code, all)) {
        if (status == FF_OK) ff_table_clear(&t);
        return;
    }
    FF_CHECK(err.line == line && err.path[0], "'%s': line %ld, expected %ld: %s", columns, err.line, line, all);
    FF_CHECK(t.n == 0x5A5A5A5A5A5A5A5Au, "'%s': the table was touched", columns);
    for (; *words; words++) FF_CHECK(strstr(all, *words), "'%s': no '%s' in: %s", columns, *words, all);
}

static double value(const ff_table *t, size_t c, size_t i)
{
    double v;
    ff_table_values(t, c, i, 1, &v);
    return v;
}

/* ---- one table, written in many ways --------------------------------------------------------- */

#define PLAIN "theta_i=inc,phi_i=0,theta_o=em,phi_o=az,f=refl,sigma=dev"

static void layouts(void)
{
    static const struct {
        const char *label, *columns, *text, *note;
    } same[] = {
        {"commas", PLAIN, "id,inc,em,az,refl,dev\nx,10,20,180,1.5,0.1\ny,30,40,90,-2,0.2\n", ""},
        {"another order and text between", PLAIN, "refl,a b,dev,az,em,inc\n1.5,\"x, y\",.1,180,20,10\n-2,,0.2,90,40,30\n", ""},
        {"a comment as header", PLAIN, "# 'id', 'inc', 'em', 'az', 'refl', 'dev'\n0,10,20,180,1.5,0.1\n1,30,40,90,-2,0.2\n", ""},
        {"comments before", PLAIN, "# made, by: me\n#\n# id,inc,em,az,refl,dev\n0,10,20,180,1.5,0.1\n# stop\n1,30,40,90,-2,0.2\n",
         ""},
        {"semicolons", PLAIN, "id;inc;em;az;refl;dev\n0,5;10;20;180;1.5;0.1\n1;30;40;90;-2;0.2\n", ""},
        {"tabs", PLAIN, "id\tinc\tem\taz\trefl\tdev\n\t10\t20\t180\t1.5\t0.1\n1\t30\t40\t90\t-2\t0.2\n", ""},
        {"crlf, quotes, spaces", PLAIN, "\"inc\" , em,az,\"refl\",dev\r\n\"10\", 20 ,180,1.5,0.1\r\n\r\n 30,40,90,-2,0.2 \r\n", ""},
        {"a byte-order mark", PLAIN, "\xEF\xBB\xBFinc,em,az,refl,dev\n10,20,180,1.5,0.1\n30,40,90,-2,0.2\n", ""},
        {"lines before the header", PLAIN, "Instrument, X\nDate; today\n\ninc,em,az,refl,dev\n10,20,180,1.5,0.1\n30,40,90,-2,0.2\n",
         "2 lines before the header line 4 are passed over"},
        {"a line before that has one of the names", PLAIN, "inc,degrees\ninc,em,az,refl,dev\n10,20,180,1.5,0.1\n30,40,90,-2,0.2\n",
         "1 line before the header line 2 is passed over"},
        {"empty columns at the end", PLAIN, "inc,em,az,refl,dev\n10,20,180,1.5,0.1,,\n30,40,90,-2,0.2, \n", ""},
        {"by number", "theta_i=#1,phi_i=0,theta_o=#2,phi_o=#3,f=#5,sigma=#6",
         "a,a,,b,b,c\n10,20,180,-,1.5,0.1\n30,40,90,-,-2,0.2\n", ""},
        {"no header", "theta_i=#1,phi_i=0,theta_o=#2,phi_o=#3,f=#4,sigma=#5", "# hello\n10,20,180,1.5,0.1\n30,40,90,-2,0.2\n", ""},
        {"no header, semicolons", "theta_i=#1,phi_i=0,theta_o=#2,phi_o=#3,f=#4,sigma=#5", "10;20;180;1.5;0.1\n30;40;90;-2;0.2\n",
         ""},
        {"names in quotes", "theta_i=\"i, deg\",phi_i=0,theta_o=\"o=x\",phi_o=\"#3\",f=\"4\",sigma=\"a|b:rad\"",
         "\"i, deg\",o=x,#3,4,a|b:rad\n10,20,180,1.5,0.1\n30,40,90,-2,0.2\n", ""},
        {"either name", "theta_i=incidence|inc,phi_i=0,theta_o=em|e,phi_o=az,f=refl,sigma=dev",
         "inc,em,az,refl,dev\n10,20,180,1.5,0.1\n30,40,90,-2,0.2\n", ""},
        {"a name that is a number", "theta_i=inc,phi_i=0,theta_o=em,phi_o=az,f=550,sigma=dev",
         "inc,em,az,550,dev\n10,20,180,1.5,0.1\n30,40,90,-2,0.2\n", ""},
        {"a name with a colon", "theta_i=th:i,phi_i=0,theta_o=em:x:deg,phi_o=az,f=refl,sigma=dev",
         "th:i,em:x,az,refl,dev\n10,20,180,1.5,0.1\n30,40,90,-2,0.2\n", ""},
        {"our own names are found", "f=refl,sigma=dev",
         "theta_i,phi_i,theta_o,phi_o,refl,dev\n10,0,20,180,1.5,0.1\n30,0,40,90,-2,0.2\n", ""},
        {"spaces in the mapping", " theta_i = inc , phi_i = 0,theta_o=em,phi_o=az, f = refl ,sigma=dev",
         "inc,em,az,refl,dev\n10,20,180,1.5,0.1\n30,40,90,-2,0.2\n", ""},
        {"no end of line", PLAIN, "inc,em,az,refl,dev\n10,20,180,1.5,0.1\n30,40,90,-2,0.2", "the last line has no end-of-line"},
        {"units that change nothing", "theta_i=inc:deg,phi_i=0:deg,theta_o=em:deg,phi_o=az,f=refl,sigma=dev",
         "inc,em,az,refl,dev\n10,20,180,1.5,0.1\n30,40,90,-2,0.2\n", ""},
    };
    for (size_t k = 0; k < sizeof same / sizeof same[0]; k++) {
        ff_table t;
        if (!reads(same[k].label, same[k].text, same[k].columns, NULL, &t)) continue;
        FF_CHECK(t.n == 2 && t.n_channels == 1 && t.sigma && !t.weight, "%s: %zu x %zu", same[k].label, t.n, t.n_channels);
        FF_CHECK(t.angle[0][0] == 10 && t.angle[1][0] == 0 && t.angle[2][0] == 20 && t.angle[3][0] == 180 && t.angle[0][1] == 30 &&
                     t.angle[2][1] == 40 && t.angle[3][1] == 90,
                 "%s: angles", same[k].label);
        FF_CHECK(value(&t, 0, 0) == 1.5 && value(&t, 0, 1) == -2 && t.sigma[0] == 0.1 && t.sigma[1] == 0.2, "%s: values",
                 same[k].label);
        FF_CHECK(t.isotropic == 1 && t.n_negative == 1 && t.radians_per_unit == pi / 180 && strcmp(t.channels[0].name, "f") == 0,
                 "%s: description", same[k].label);
        FF_CHECK(same[k].note[0] ? strstr(t.note, same[k].note) != NULL : !t.note[0], "%s: note '%s'", same[k].label, t.note);
        ff_table_clear(&t);
    }
}

static void units_and_channels(void)
{
    ff_table t;
    if (reads("radians", "inc,p,em,az,v\n0.5,0.25,1,3,2\n", "theta_i=inc:rad,phi_i=p:rad,theta_o=em:rad,phi_o=az:rad,f=v", NULL,
              &t)) {
        FF_CHECK(t.radians_per_unit == 1 && t.angle[0][0] == 0.5 && t.angle[1][0] == 0.25 && t.angle[3][0] == 3, "radians stay");
        ff_table_clear(&t);
    }
    /* the second of these failed while a constant without unit made the table one of degrees */
    if (reads("radians and 0", "inc,em,az,v\n0.5,1,3,2\n", "theta_i=inc:rad,phi_i=0,theta_o=em:rad,phi_o=az:rad,f=v", NULL, &t)) {
        FF_CHECK(t.radians_per_unit == 1 && t.angle[0][0] == 0.5 && t.angle[1][0] == 0, "radians stay beside a constant");
        ff_table_clear(&t);
    }
    if (reads("radians and 180", "inc,em,v\n0.5,1,2\n", "theta_i=inc:rad,phi_i=0,theta_o=em:rad,phi_o=180:deg,f=v", NULL, &t)) {
        FF_CHECK(t.radians_per_unit == pi / 180 && fabs(t.angle[0][0] - 0.5 * 180 / pi) < 1e-12 && t.angle[3][0] == 180,
                 "mixed: %g %g", t.angle[0][0], t.angle[3][0]);
        ff_table_clear(&t);
    }
    if (reads("channels", "inc,em,az,blue,red,db,dr,w\n10,20,30,2,4,5,10,0.25\n11,20,30,-3,4,5,10,0.5\n",
              "theta_i=inc,phi_i=7,theta_o=em,phi_o=az,f_465nm=blue:%,sigma_r=dr:%,f_r=red,sigma_465nm=db:%,weight=w", NULL, &t)) {
        FF_CHECK(t.n_channels == 2 && strcmp(t.channels[0].name, "465nm") == 0 && t.channels[0].wavelength_nm == 465 &&
                     strcmp(t.channels[1].name, "r") == 0,
                 "names");
        FF_CHECK(fabs(value(&t, 0, 0) - 0.02) < 1e-17 && value(&t, 1, 0) == 4 && t.weight[1] == 0.5 && t.angle[1][1] == 7,
                 "values");
        FF_CHECK(fabs(t.sigma[0] - 0.001) < 1e-17 && fabs(t.sigma[2] - 0.4) < 1e-16 && fabs(t.sigma[1] - 0.0015) < 1e-17,
                 "%g %g %g", t.sigma[0], t.sigma[2], t.sigma[1]);
        ff_table_clear(&t);
    }
    if (reads("constants", "inc,v\n10,2\n20,3\n", "theta_i=inc,phi_i=0,theta_o=inc,phi_o=0,f=v,sigma=0.5,wavelength=532.25", NULL,
              &t)) {
        FF_CHECK(t.n == 2 && t.angle[2][1] == 20 && t.sigma[1] == 0.5 && strcmp(t.channels[0].name, "532.25nm") == 0 &&
                     t.channels[0].wavelength_nm == 532.25,
                 "retro-reflection: one column for both thetas; '%s'", t.channels[0].name);
        ff_table_clear(&t);
    }
    if (reads("not measured", "inc,em,az,a,b\n10,20,30,,1\n10,20,30,1,2\n", "theta_i=inc,phi_i=0,theta_o=em,phi_o=az,f_a=a,f_b=b",
              NULL, &t)) {
        FF_CHECK(!t.valid[0] && t.valid[1] && t.n_invalid == 1 && value(&t, 0, 0) == 0 && value(&t, 1, 0) == 1, "empty cells");
        ff_table_clear(&t);
    }
}

static void quantities(void)
{
    static const char text[] = "inc,em,az,v,s\n10,60,30,1,0.5\n10,90,30,1,0.5\n";
    static const char columns[] = "theta_i=inc,phi_i=0,theta_o=em,phi_o=az,f=v,sigma=s";
    ff_table t;
    ff_error err = {0};
    if (FF_CHECK(read_mapped(text, strlen(text), columns, NULL, FF_BRDF_COS, &t, &err) == FF_OK, "%s", err.message)) {
        FF_CHECK(fabs(value(&t, 0, 0) - 2) < 1e-14 && fabs(t.sigma[0] - 1) < 1e-14 && !t.valid[1] && t.quantity == FF_BRDF_COS,
                 "cosine");
        ff_table_clear(&t);
    }
    if (FF_CHECK(read_mapped(text, strlen(text), columns, NULL, FF_REFLECTANCE_FACTOR, &t, &err) == FF_OK, "%s", err.message)) {
        FF_CHECK(fabs(value(&t, 0, 1) - 1 / pi) < 1e-16 && t.valid[1], "reflectance factor");
        ff_table_clear(&t);
    }
    /* files of our own are taken by their word, others by nobody's */
    if (reads("ours",
              "# facetfit-csv: 1\n# quantity: reflectance-factor\n# angles: radians\n# isotropic: "
              "yes\ntheta_i,phi_i,theta_o,phi_o,f_r,f_g\n0.5,0,1,0,1,2\n0.5,1,1,0,1,2\n",
              "f=f_g", NULL, &t)) {
        FF_CHECK(t.n_channels == 1 && fabs(value(&t, 0, 0) - 2 / pi) < 1e-16 && t.radians_per_unit == 1 && t.angle[2][0] == 1 &&
                     t.isotropic == 1,
                 "%g", value(&t, 0, 0));
        ff_table_clear(&t);
    }
    if (reads("not ours", "# quantity: radiance\n# angles: gon\ntheta_i,phi_i,theta_o,phi_o,v\n0.5,0,1,0,1\n", "f=v", NULL, &t)) {
        FF_CHECK(value(&t, 0, 0) == 1 && t.radians_per_unit == pi / 180, "%g", value(&t, 0, 0));
        ff_table_clear(&t);
    }
    /* the program's own reader takes the option too */
    ff_read_options o;
    ff_read_options_init(&o);
    o.quantity = FF_BRDF_COS;
    const char *path = ff_test_path("own.csv");
    static const char own[] = "# quantity: reflectance-factor\ntheta_i,phi_i,theta_o,phi_o,f\n0,0,60,0,1\n";
    ff_test_write(path, own, sizeof own - 1);
    if (FF_CHECK(ff_table_read_with_into(path, &o, &t, &err) == FF_OK, "%s", err.message)) {
        FF_CHECK(fabs(value(&t, 0, 0) - 2) < 1e-14 && t.quantity == FF_BRDF_COS, "%g", value(&t, 0, 0));
        ff_table_clear(&t);
    }
    o.part = "532nm";
    FF_CHECK(ff_table_read_with_into(path, &o, &t, &err) == FF_ERR_UNSUPPORTED && strstr(err.message, "'part'"), "%s", err.message);
}

static void test_phase(void)
{
    static const char columns[] = "theta_i=i,phi_i=0,theta_o=o,phi_o=az,f=v,phase=g";
    ff_table t;
    if (reads("azimuth 0 at the light", "i,o,az,g,v\n30,40,0,10,1\n30,40,180,70,1\n30,0,90,30,1\n", columns, NULL, &t)) {
        FF_CHECK(t.angle[3][0] == 0 && t.angle[3][1] == 180 && !t.note[0], "%g %s", t.angle[3][0], t.note);
        ff_table_clear(&t);
    }
    if (reads("azimuth 0 at the mirror", "i,o,az,g,v\n30,40,0,70,1\n30,40,180,10,1\n", columns, NULL, &t)) {
        FF_CHECK(t.angle[3][0] == 180 && t.angle[3][1] == 360 && strstr(t.note, "180 degrees are added"), "%g %s", t.angle[3][0],
                 t.note);
        ff_table_clear(&t);
    }
    if (reads("neither", "i,o,az,g,v\n30,40,0,70,1\n30,40,0,10,1\n", columns, NULL, &t)) {
        FF_CHECK(t.angle[3][0] == 0 && strstr(t.note, "up to 60 degrees"), "%s", t.note);
        ff_table_clear(&t);
    }
}

/* ---- wavelengths ----------------------------------------------------------------------------- */

#define LONG "theta_i=i,phi_i=0,theta_o=o,phi_o=a,f=v,sigma=s,wavelength=l:um"

static void test_complete(void)
{
    static const char text[] =
        "l,i,o,a,v,s\n0.65,10,20,30,3,.3\n0.65,11,21,31,6,.6\n0.45,11,21,31,4,.4\n0.45,10,20,30,1,.1\n0.5325,10,20,30,2,.2\n"
        "0.5325,11,21,31,,.5\n";
    ff_table t;
    if (!reads("complete", text, LONG, NULL, &t)) return;
    FF_CHECK(t.n == 2 && t.n_channels == 3 && strcmp(t.channels[0].name, "450nm") == 0 &&
                 strcmp(t.channels[1].name, "532.5nm") == 0 && t.channels[2].wavelength_nm == 650,
             "%zu x %zu %s %s", t.n, t.n_channels, t.channels[0].name, t.channels[1].name);
    size_t a = t.angle[0][0] == 10 ? 0 : 1;
    FF_CHECK(t.angle[0][a] == 10 && t.angle[3][a] == 30 && t.angle[0][1 - a] == 11 && t.angle[2][1 - a] == 21, "angles");
    FF_CHECK(value(&t, 0, a) == 1 && value(&t, 1, a) == 2 && value(&t, 2, a) == 3 && value(&t, 0, 1 - a) == 4 &&
                 value(&t, 2, 1 - a) == 6,
             "values");
    FF_CHECK(t.sigma[a] == .1 && t.sigma[2 + a] == .2 && t.sigma[4 + a] == .3, "sigmas");
    FF_CHECK(t.valid[a] && !t.valid[1 - a] && t.n_invalid == 1 && !t.note[0], "validity, note '%s'", t.note);
    ff_table_clear(&t);
    if (!reads("part", text, LONG, "650nm", &t)) return;
    FF_CHECK(t.n == 2 && t.n_channels == 1 && value(&t, 0, 0) == 3 && value(&t, 0, 1) == 6 && t.n_invalid == 0, "one of three");
    FF_CHECK(strstr(t.note, "read are the rows of 650nm") && strstr(t.note, "450nm, 532.5nm"), "note '%s'", t.note);
    ff_table_clear(&t);
    if (!reads("parts", text, LONG, " 650 , 450 nm", &t)) return;
    FF_CHECK(t.n == 2 && t.n_channels == 2 && t.channels[0].wavelength_nm == 450 && t.channels[1].wavelength_nm == 650,
             "two of three");
    ff_table_clear(&t);
    refuses(text, LONG, "500nm", FF_ERR_UNKNOWN, 0, WORDS("'500nm'", "450nm, 532.5nm, 650nm"));
    refuses(text, LONG, "450nm,", FF_ERR_UNKNOWN, 0, WORDS("''", "450nm"));
    refuses(text, LONG, "450x", FF_ERR_UNKNOWN, 0, WORDS("'450x'", "450nm"));
    refuses(text, "theta_i=i,phi_i=0,theta_o=o,phi_o=a,f=v", "450nm", FF_ERR_UNSUPPORTED, 0, WORDS("'part'", "wavelength"));
}

static void incomplete(void)
{
    ff_table t;
    if (reads("one pair lacks a wavelength", "l,i,o,a,v,s\n.4,1,1,1,1,1\n.5,1,1,1,2,1\n.4,2,2,2,3,1\n.5,2,2,2,4,1\n.4,3,3,3,5,1\n",
              LONG, NULL, &t)) {
        FF_CHECK(t.n == 2 && t.n_channels == 2 && value(&t, 1, 1) == 4 &&
                     strstr(t.note, "1 of 3 samples lack one of the 2 wavelengths"),
                 "%zu, note '%s'", t.n, t.note);
        ff_table_clear(&t);
    }
    static const char random[] =
        "l,i,o,a,v,s\n.4,1,1,1,1,1\n.4,2,1,1,2,1\n.5,3,1,1,3,1\n.5,4,1,1,4,1\n.5,5,1,1,5,1\n.6,1,1,1,6,1\n";
    if (reads("other directions at each wavelength", random, LONG, NULL, &t)) {
        FF_CHECK(t.n == 3 && t.n_channels == 1 && t.channels[0].wavelength_nm == 500 && value(&t, 0, 2) == 5, "%zu x %zu", t.n,
                 t.n_channels);
        FF_CHECK(strstr(t.note, "500nm alone is read, without 400nm, 600nm; the option 'part' chooses others"), "note '%s'",
                 t.note);
        ff_table_clear(&t);
    }
    if (reads("a choice that has a pair", random, LONG, "400nm,600nm", &t)) {
        FF_CHECK(t.n == 1 && t.n_channels == 2 && value(&t, 0, 0) == 1 && value(&t, 1, 0) == 6, "%zu x %zu", t.n, t.n_channels);
        ff_table_clear(&t);
    }
    refuses(random, LONG, "400nm,500nm", FF_ERR_DATA, 0, WORDS("no pair of directions", "400nm, 500nm", "single wavelength"));
    if (reads("measured twice",
              "l,i,o,a,v,s\n.4,1,1,1,1,1\n.4,1,1,1,2,1\n.4,1,1,1,3,1\n.5,1,1,1,4,1\n.5,1,1,1,5,1\n.5,-0,1,1,9,1\n.4,0,1,1,8,1\n",
              LONG, NULL, &t)) {
        FF_CHECK(t.n == 3 && value(&t, 0, 0) == 1 && value(&t, 1, 0) == 4 && value(&t, 0, 1) == 2 && value(&t, 1, 1) == 5 &&
                     value(&t, 0, 2) == 8 && value(&t, 1, 2) == 9,
                 "%zu: %g %g", t.n, value(&t, 0, 0), value(&t, 1, 0));
        FF_CHECK(strstr(t.note, "1 of 4 samples"), "note '%s'", t.note);
        ff_table_clear(&t);
    }
}

/* All pairs of many wavelengths, in random order, against the formula that made them. */
static void test_many(void)
{
    enum { PAIRS = 400, NM = 31, ROWS = PAIRS * NM };
    static int order[ROWS];
    char *text = malloc(ROWS * 80 + 100), *at = text + sprintf(text, "a,v,i,nm,o,w\n");
    for (int k = 0; k < ROWS; k++) order[k] = k;
    for (int k = ROWS - 1; k > 0; k--) {
        int j = (int)(ff_test_random() % (uint64_t)(k + 1)), swap = order[k];
        order[k] = order[j];
        order[j] = swap;
    }
    for (int k = 0; k < ROWS; k++) {
        int p = order[k] / NM, l = order[k] % NM;
        at += sprintf(at, "%d,%d,%d,%d,%d,%d\n", p % 7, 1000 * p + l, p / 7, 400 + 10 * l, p / 49, p);
    }
    ff_table t;
    if (reads("many", text, "theta_i=i,phi_i=0,theta_o=o,phi_o=a,f=v,weight=w,wavelength=nm", NULL, &t)) {
        FF_CHECK(t.n == PAIRS && t.n_channels == NM && !t.sigma && t.weight, "%zu x %zu", t.n, t.n_channels);
        for (size_t i = 0; i < t.n; i++) {
            int p = (int)(t.angle[0][i] * 7 + t.angle[3][i]);
            FF_CHECK(t.weight[i] == p, "weight of %d", p);
            for (size_t c = 0; c < t.n_channels; c++)
                FF_CHECK(value(&t, c, i) == 1000 * p + (int)c && t.channels[c].wavelength_nm == 400 + 10 * (int)c,
                         "pair %d channel %zu", p, c);
        }
        ff_table_clear(&t);
    }
    /* more wavelengths than anybody measures */
    at = text + sprintf(text, "i,v,nm\n");
    for (int k = 0; k < 4200; k++) at += sprintf(at, "1,2,%d\n", 400 + k);
    refuses(text, "theta_i=i,phi_i=0,theta_o=i,phi_o=0,f=v,wavelength=nm", NULL, FF_ERR_DATA, 0,
            WORDS("more than 4096", "is that column"));
    /* one pair, again and again, and as many samples as rows */
    at = text + sprintf(text, "i,v,nm\n");
    for (int k = 0; k < 20000; k++) at += sprintf(at, "1,%d,%d\n", k, 400 + k % 2);
    if (reads("again and again", text, "theta_i=i,phi_i=0,theta_o=i,phi_o=0,f=v,wavelength=nm", NULL, &t)) {
        FF_CHECK(t.n == 10000 && value(&t, 0, 777) == 1554 && value(&t, 1, 777) == 1555, "%zu", t.n);
        ff_table_clear(&t);
    }
    free(text);
}

/* ---- what is refused ------------------------------------------------------------------------- */

static void bad_mappings(void)
{
    static const char text[] = "i,o,a,v,s,v\n1,2,3,4,5,6\n";
#define A "theta_i=i,phi_i=0,theta_o=o,phi_o=a,"
    refuses(text, A "brdf=v", NULL, FF_ERR_UNKNOWN, 0, WORDS("'brdf'", "f_NAME", "wavelength"));
    refuses(text, A "f_=v", NULL, FF_ERR_UNKNOWN, 0, WORDS("'f_'"));
    refuses(text, A "weights=v", NULL, FF_ERR_UNKNOWN, 0, WORDS("'weights'"));
    refuses(text, A "weight_x=v", NULL, FF_ERR_UNKNOWN, 0, WORDS("'weight_x'"));
    refuses(text, "", NULL, FF_ERR_SYNTAX, 0, WORDS("''", "key=column"));
    refuses(text, A "f", NULL, FF_ERR_SYNTAX, 0, WORDS("'f'", "key=column"));
    refuses(text, A "f=", NULL, FF_ERR_SYNTAX, 0, WORDS("'f'", "the name of a column"));
    refuses(text, A, NULL, FF_ERR_SYNTAX, 0, WORDS("''", "key=column"));
    refuses(text, A "f=v,f=s", NULL, FF_ERR_SYNTAX, 0, WORDS("'f'", "only once"));
    refuses(text, A "f=v,f_f=s", NULL, FF_ERR_SYNTAX, 0, WORDS("'f_f'", "only once"));
    refuses(text, A "phi_i=a,f=s", NULL, FF_ERR_SYNTAX, 0, WORDS("'phi_i'", "only once"));
    refuses(text, A "f=s,sigma=s", NULL, FF_ERR_SYNTAX, 0, WORDS("f and sigma", "same column"));
    refuses(text, A "f=#0", NULL, FF_ERR_SYNTAX, 0, WORDS("'#0'", "from 1"));
    refuses(text, A "f=#x", NULL, FF_ERR_SYNTAX, 0, WORDS("'#x'"));
    refuses(text, A "f=\"v", NULL, FF_ERR_SYNTAX, 0, WORDS("ends in a quote"));
    refuses(text, A "f=\"v\"x", NULL, FF_ERR_SYNTAX, 0, WORDS("nothing but ':'"));
    refuses(text, A "f=s:rad", NULL, FF_ERR_SYNTAX, 0, WORDS("'f'", "a unit of its own"));
    refuses(text, A "f=s,wavelength=v:deg", NULL, FF_ERR_SYNTAX, 0, WORDS("'wavelength'", "a unit of its own"));
    refuses(text, A "f=s,sigma=1:%", NULL, FF_ERR_SYNTAX, 0, WORDS("a constant in %"));
    refuses(text, A "f=s,phase=1", NULL, FF_ERR_SYNTAX, 0, WORDS("a constant phase"));
    refuses(text, A "sigma=s", NULL, FF_ERR_SYNTAX, 0, WORDS("no f", "f=column"));
    refuses(text, A "f_a=s,f_b=a,sigma_a=#4", NULL, FF_ERR_SYNTAX, 0, WORDS("some sigmas", "each channel"));
    refuses(text, A "f_a=s,sigma_b=#4", NULL, FF_ERR_SYNTAX, 0, WORDS("sigma_b", "a channel that is there"));
    refuses(text, A "f_a=s,f_b=#4,wavelength=#6", NULL, FF_ERR_SYNTAX, 0, WORDS("several channels", "one column of values"));
    refuses(text, A "f=v", NULL, FF_ERR_FORMAT, 1, WORDS("'v' twice", "f=#4"));
    refuses(text, A "f=x", NULL, FF_ERR_FORMAT, 1, WORDS("i, o, a, v, s, v", "'x'", "for f"));
    refuses(text, "theta_i=i,theta_o=o,phi_o=a,f=s", NULL, FF_ERR_FORMAT, 1, WORDS("i, o, a, v, s, v", "'phi_i'", "phi_i=0"));
    refuses("theta_i=#1\n", "theta_i=#1,phi_i=0,theta_o=#2,phi_o=#3,f=#9", NULL, FF_ERR_FORMAT, 1,
            WORDS("found 1 columns", "column 2"));
    refuses("", A "f=v", NULL, FF_ERR_READ, 0, WORDS("end of the file", "header"));
    refuses("# i,o,a,s\n", A "f=s", NULL, FF_ERR_DATA, 1, WORDS("no rows"));
    /* of a file without its header the line that comes nearest is told */
    refuses("# x\n# i,o,a,v\n1,2,3,4\n", A "f=w", NULL, FF_ERR_FORMAT, 2, WORDS("i, o, a, v", "'w'"));
    char *keys = malloc(5000 * 10 + 100), *at = keys;
    for (int k = 0; k < 5000; k++) at += sprintf(at, "f_%d=v,", k);
    refuses(text, keys, NULL, FF_ERR_SYNTAX, 0, WORDS("5001 keys", "at most 4096"));
    at = keys + sprintf(keys, A "f_");
    memset(at, 'x', 70);
    strcpy(at + 70, "=s");
    refuses(text, keys, NULL, FF_ERR_SYNTAX, 0, WORDS("at most 63 bytes"));
    free(keys);
}

static void bad_rows(void)
{
#define H "x,i,o,a,v,s,l\n"
#define C "theta_i=i,phi_i=0,theta_o=o,phi_o=a,f=v,sigma=s,wavelength=l"
    refuses(H "x,1,2,3,no,5,6\n", C, NULL, FF_ERR_DATA, 2,
            WORDS("column 5", "'f'", "'no'", "finite number", "leave the cell empty"));
    refuses(H "x,inf,2,3,4,5,6\n", C, NULL, FF_ERR_DATA, 2, WORDS("column 2", "'theta_i'", "'inf'"));
    refuses(H "x,1,1e999,3,4,5,6\n", C, NULL, FF_ERR_DATA, 2, WORDS("column 3", "'1e999'"));
    refuses(H "x,1,2,3 4,4,5,6\n", C, NULL, FF_ERR_DATA, 2, WORDS("'3 4'"));
    refuses(H "x,1,,3,4,5,6\n", C, NULL, FF_ERR_DATA, 2, WORDS("'theta_o'", "an empty cell"));
    refuses(H "x,1,2,3,4,5,\n", C, NULL, FF_ERR_DATA, 2, WORDS("'wavelength'", "an empty cell"));
    refuses(H "x,1,2,3,4,5,0\n", C, NULL, FF_ERR_DATA, 2, WORDS("wavelength: found 0", "> 0"));
    refuses(H "x,1,2,3,4,0,6\n", C, NULL, FF_ERR_DATA, 2, WORDS("sigma: found 0", "> 0"));
    refuses(H "x,1,2,3,4,,6\n", C, NULL, FF_ERR_DATA, 2, WORDS("sigma: found an empty cell", "> 0"));
    refuses(H "x,1,2,3,4,5,6\nx,1,200,3,4,5,6\n", C, NULL, FF_ERR_DATA, 3, WORDS("theta_o: found 200", "degrees from -180 to 180"));
    refuses(H "x,1,2,3,4,5\n", C, NULL, FF_ERR_FORMAT, 2, WORDS("found 6 cells", "expected 7"));
    refuses(H "x,1\n", C, NULL, FF_ERR_FORMAT, 2, WORDS("found 2 cells", "expected 7"));
    refuses(H "x,1,2,3,4,5,6,7\n", C, NULL, FF_ERR_FORMAT, 2, WORDS("found 8 cells", "expected 7"));
    refuses("i,o,a,v,x\n1,2,3,4\n", "theta_i=i,phi_i=0,theta_o=o,phi_o=a,f=v", NULL, FF_ERR_FORMAT, 2,
            WORDS("found 4 cells", "expected 5"));
    refuses("i;o;a;v\n1;2;3;4,5\n1;2.5;3;4.5\n", "theta_i=i,phi_i=0,theta_o=o,phi_o=a,f=v", NULL, FF_ERR_DATA, 2,
            WORDS("'4,5'", "a decimal point and not a comma", "say dialect decimal=comma"));
    refuses("i,o,a,v,w\n1,2,3,4,-1\n", "theta_i=i,phi_i=0,theta_o=o,phi_o=a,f=v,weight=w", NULL, FF_ERR_DATA, 2,
            WORDS("weight: found -1"));
    refuses("i,o,a,v\n1,2,3,4\n", "theta_i=i:rad,phi_i=0,theta_o=o,phi_o=a,f=v,sigma=-1", NULL, FF_ERR_DATA, 2,
            WORDS("a constant: found -1"));
    refuses("i,o,a,v\n10,2,3,4\n", "theta_i=i:rad,phi_i=0,theta_o=o:rad,phi_o=a:rad,f=v", NULL, FF_ERR_DATA, 2,
            WORDS("radians from -pi"));
    refuses("i,o,a,v\n10,2,3,\n", "theta_i=i,phi_i=0,theta_o=o,phi_o=a,f=v", NULL, FF_ERR_DATA, 0,
            WORDS("at least one measurement"));
}

static void prefixes_and_damage(void)
{
    static const char text[] =
        "# made 'here'\n# 'n', 'i', 'o', 'a', 'v', 's', 'l'\n0, 1.00, 20.5, 3, 4, 0.5, 450\n\"x\", 1.00, 20.5, 3, 4, 0.5, 550\n";
    static const char columns[] = "theta_i=i,phi_i=0,theta_o=o,phi_o=a,f=v,sigma=s:%,wavelength=l";
    static const char bytes[] = ",\n\r\"#;-e.0\x00\xFF:'\t f";
    for (size_t n = 0; n < sizeof text; n++) {
        ff_table t;
        ff_error err = {0};
        ff_status status = read_mapped(text, n, columns, NULL, -1, &t, &err);
        if (status == FF_OK) {
            FF_CHECK(n > 70 && (text[n - 1] == '\n' || strstr(t.note, "cut")), "prefix %zu: note '%s'", n, t.note);
            ff_table_clear(&t);
        } else {
            FF_CHECK(err.message[0] && err.path[0], "prefix %zu: no message", n);
        }
    }
    size_t fine = 0;
    for (int k = 0; k < 4000; k++) {
        char copy[sizeof text];
        memcpy(copy, text, sizeof text);
        for (int j = 0; j <= k % 4; j++) copy[ff_test_random() % (sizeof text - 1)] = bytes[ff_test_random() % (sizeof bytes - 1)];
        if (k % 3 == 0) copy[ff_test_random() % (sizeof text - 1)] ^= (char)(1 << ff_test_random() % 8);
        ff_table t;
        ff_error err = {0};
        if (read_mapped(copy, sizeof text - 1, columns, NULL, -1, &t, &err) == FF_OK) {
            fine++;
            for (size_t i = 0; i < t.n; i++) FF_CHECK(isfinite(t.value[i]) && isfinite(t.angle[2][i]), "damaged %d: not finite", k);
            ff_table_clear(&t);
        } else {
            FF_CHECK(err.message[0] && err.path[0], "damaged %d: no message", k);
        }
    }
    FF_CHECK(fine > 100, "%zu of the damaged files were read", fine);
    /* and damaged mappings */
    for (int k = 0; k < 4000; k++) {
        char copy[sizeof columns];
        memcpy(copy, columns, sizeof columns);
        for (int j = 0; j <= k % 4; j++) copy[ff_test_random() % (sizeof columns - 1)] = ",=#:%|\" 0a"[ff_test_random() % 10];
        ff_table t;
        ff_error err = {0};
        if (read_mapped(text, sizeof text - 1, copy, NULL, -1, &t, &err) == FF_OK)
            ff_table_clear(&t);
        else
            FF_CHECK(err.message[0], "mapping '%s': no message", copy);
    }
}

static void format_given(void)
{
    const char *path = ff_test_path("given.dat");
    ff_test_write(path, "i,o,a,v\n1,2,3,4\n", 16);
    ff_read_options o;
    ff_read_options_init(&o);
    o.columns = "theta_i=i,phi_i=0,theta_o=o,phi_o=a,f=v";
    o.format = "astm";
    ff_table t;
    ff_error err = {0};
    FF_CHECK(ff_table_read_with_into(path, &o, &t, &err) == FF_ERR_UNSUPPORTED && strstr(err.message, "'columns'"), "%s",
             err.message);
    check_fails("without a mapping", path, "csv", FF_ERR_FORMAT, 1,
                WORDS("theta_o", "say columns 'theta_i=#1,theta_o=#2,phi_i=0,phi_o=#3,f=#4'", "i, o, a, v"));
}

FF_TEST_MAIN(FF_TEST(layouts), FF_TEST(units_and_channels), FF_TEST(quantities), FF_TEST(test_phase), FF_TEST(test_complete),
             FF_TEST(incomplete), FF_TEST(test_many), FF_TEST(bad_mappings), FF_TEST(bad_rows), FF_TEST(prefixes_and_damage),
             FF_TEST(format_given))
