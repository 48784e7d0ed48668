/* ALTA files, made here: every parametrisation against the coordinates' definitions; real ones where they are. */
#include "check_text.h"

#define HEAD "#DIM 4 1\n#PARAM_IN SPHERICAL_TL_PL_TV_PV\n#PARAM_OUT INV_STERADIAN\n"

/* ---- coordinates of a pair, from their definitions ------------------------------------------- */

static double dot(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double *a, const double *b, double *c)
{
    for (int k = 0; k < 3; k++) c[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

static void unit(double *a)
{
    const double n = sqrt(dot(a, a));
    for (int k = 0; k < 3; k++) a[k] /= n;
}

static double theta(const double *a)
{
    return acos(fmax(-1, fmin(1, a[2] / sqrt(dot(a, a)))));
}

static double phi(const double *a)
{
    return atan2(a[1], a[0]);
}

/* Half vector h, and V in its frame: turned back by phi_h about z, then by theta_h about y. */
static void half_difference(const double *l, const double *v, double *h, double *d)
{
    for (int k = 0; k < 3; k++) h[k] = l[k] + v[k];
    unit(h);
    const double c = cos(phi(h)), s = sin(phi(h)), ct = h[2], st = sin(theta(h));
    const double x = c * v[0] + s * v[1], y = c * v[1] - s * v[0];
    d[0] = ct * x - st * v[2], d[1] = y, d[2] = st * x + ct * v[2];
}

static void polar(double r, double a, double *x)
{
    x[0] = r * cos(a), x[1] = r * sin(a);
}

static void to_spherical(const double *l, const double *v, double *x)
{
    x[0] = theta(l), x[1] = phi(l), x[2] = theta(v), x[3] = phi(v);
}

static void to_tv_tl_dphi(const double *l, const double *v, double *x)
{
    x[0] = theta(v), x[1] = theta(l), x[2] = phi(l) - phi(v);
}

static void to_tl_tv_proj(const double *l, const double *v, double *x)
{
    x[0] = theta(l);
    polar(theta(v), phi(v) - phi(l), x + 1);
}

static void to_schlick(const double *l, const double *v, double *x)
{
    double k[3] = {v[0] - l[0], v[1] - l[1], v[2] + l[2]};
    x[0] = theta(l);
    polar(theta(k), phi(k) - phi(l), x + 1);
}

static void to_retro(const double *l, const double *v, double *x)
{
    const double n[3] = {0, 0, 1}, arc = acos(dot(l, v));
    double aside[3], up[3], to_v[3];
    cross(n, l, aside);
    unit(aside);
    cross(l, aside, up); /* from l towards the normal */
    for (int k = 0; k < 3; k++) to_v[k] = v[k] - dot(l, v) * l[k];
    unit(to_v);
    x[0] = theta(l);
    polar(arc, atan2(dot(to_v, aside), dot(to_v, up)), x + 1);
}

static void to_rusin(const double *l, const double *v, double *x)
{
    double h[3], d[3];
    half_difference(l, v, h, d);
    x[0] = theta(h), x[1] = phi(h), x[2] = theta(d), x[3] = phi(d);
}

static void to_rusin_isotropic(const double *l, const double *v, double *x)
{
    double all[4];
    to_rusin(l, v, all);
    x[0] = all[0], x[1] = all[2], x[2] = all[3];
}

static void to_rusin_vectors(const double *l, const double *v, double *x)
{
    half_difference(l, v, x, x + 3);
}

static void to_rusin_th_ph_td(const double *l, const double *v, double *x)
{
    to_rusin(l, v, x);
}

static void to_cosines(const double *l, const double *v, double *x)
{
    to_rusin_isotropic(l, v, x);
    x[0] = cos(x[0]), x[1] = cos(x[1]);
}

static void to_stereographic(const double *l, const double *v, double *x)
{
    for (int k = 0; k < 2; k++) x[k] = v[k] / (1 + v[2]), x[2 + k] = l[k] / (1 + l[2]);
}

static void half_back(const double *l, const double *v, double *h, double *b)
{
    for (int k = 0; k < 3; k++) h[k] = (l[k] + v[k]) / 2, b[k] = (l[k] - v[k]) / 2;
}

static void to_stark(const double *l, const double *v, double *x)
{
    double h[3], b[3];
    half_back(l, v, h, b);
    x[0] = hypot(h[0], h[1]), x[1] = sqrt(dot(b, b)), x[2] = phi(b) - phi(h);
}

static void to_neumann(const double *l, const double *v, double *x)
{
    double h[3], b[3];
    half_back(l, v, h, b);
    x[0] = hypot(h[0], h[1]), x[1] = hypot(b[0], b[1]), x[2] = phi(b) - phi(h);
}

static void to_cartesian(const double *l, const double *v, double *x)
{
    memcpy(x, v, 3 * sizeof *x);
    memcpy(x + 3, l, 3 * sizeof *x);
}

enum { ALL, ROTATED, SOME }; /* what the coordinates tell: the pair; the pair but for a rotation; themselves */
static const struct {
    const char *name;
    int n, tells;
    void (*make)(const double *l, const double *v, double *x);
} coordinates[] = {{"SPHERICAL_TL_PL_TV_PV", 4, ALL, to_spherical},
                   {"ISOTROPIC_TV_TL_DPHI", 3, ROTATED, to_tv_tl_dphi},
                   {"ISOTROPIC_TL_TV_PROJ_DPHI", 3, ROTATED, to_tl_tv_proj},
                   {"SCHLICK_TL_TK_PROJ_DPHI", 3, ROTATED, to_schlick},
                   {"RETRO_TL_TVL_PROJ_DPHI", 3, ROTATED, to_retro},
                   {"RUSIN_TH_PH_TD_PD", 4, ALL, to_rusin},
                   {"RUSIN_TH_TD_PD", 3, ROTATED, to_rusin_isotropic},
                   {"RUSIN_VH_VD", 6, ALL, to_rusin_vectors},
                   {"STEREOGRAPHIC", 4, ALL, to_stereographic},
                   {"STARK_3D", 3, ROTATED, to_stark},
                   {"NEUMANN_3D", 3, ROTATED, to_neumann},
                   {"CARTESIAN", 6, ALL, to_cartesian},
                   {"RUSIN_TH_PH_TD", 3, SOME, to_rusin_th_ph_td},
                   {"RUSIN_TH_TD", 2, SOME, to_rusin_isotropic},
                   {"COS_TH_TD", 2, SOME, to_cosines},
                   {"STARK_2D", 2, SOME, to_stark},
                   {"NEUMANN_2D", 2, SOME, to_neumann}};

static void random_direction(double *a)
{
    const double z = 0.02 + 0.97 * ff_test_uniform(), r = sqrt(1 - z * z), p = 2 * check_pi * ff_test_uniform();
    a[0] = r * cos(p), a[1] = r * sin(p), a[2] = z;
}

static void compare_pair(const char *name, int tells, const double *l, const double *v, const double *w)
{
    double error = 0;
    for (int k = 0; k < 3 && tells == ALL; k++) error = fmax(error, fmax(fabs(l[k] - w[k]), fabs(v[k] - w[3 + k])));
    double one[3], other[3];
    cross(l, v, one);
    cross(w, w + 3, other);
    if (tells == ROTATED) /* polar angles, the angle between, and the sense of rotation from one to the other */
        error = fmax(fmax(fabs(l[2] - w[2]), fabs(v[2] - w[5])), fmax(fabs(dot(l, v) - dot(w, w + 3)), fabs(one[2] - other[2])));
    FF_CHECK(error < 2e-8, "%s: off by %g at %g %g %g, %g %g %g", name, error, l[0], l[1], l[2], v[0], v[1], v[2]);
}

static void parametrisations(void)
{
    enum { N = 300 };
    static double pair[N][6], x[N][6];
    static char text[N * 200];
    for (size_t k = 0; k < sizeof coordinates / sizeof coordinates[0]; k++) {
        const char *name = coordinates[k].name;
        const int n = coordinates[k].n, tells = coordinates[k].tells;
        size_t used = (size_t)sprintf(text, "#PARAM_IN  %s\n#DIM\t%d 1\n#PARAM_OUT INV_STERADIAN\n", name, n);
        for (int i = 0; i < N; i++) {
            random_direction(pair[i]);
            random_direction(pair[i] + 3);
            double all[6];
            coordinates[k].make(pair[i], pair[i] + 3, all);
            memcpy(x[i], all, sizeof all);
            for (int j = 0; j < n; j++) used += (size_t)sprintf(text + used, "%.17g ", x[i][j]);
            used += (size_t)sprintf(text + used, "\t%d\n", i);
        }
        ff_table t;
        if (!check_reads(name, "alta", text, &t)) continue;
        FF_CHECK(t.n == N && t.isotropic == (tells == ROTATED || n == 2) && t.n_invalid == 0, "%s: %zu, isotropic %d, %zu invalid",
                 name, t.n, t.isotropic, t.n_invalid);
        FF_CHECK(tells == SOME ? strstr(t.note, "90 degrees are taken") != NULL : !t.note[0], "%s: '%s'", name, t.note);
        for (size_t i = 0; i < N && i < t.n; i++) {
            double w[6], back[6];
            check_directions(&t, i, w);
            compare_pair(name, tells, pair[i], pair[i] + 3, w);
            coordinates[k].make(w, w + 3, back);
            for (int j = 0; j < n && tells == SOME; j++)
                FF_CHECK(fabs(back[j] - x[i][j]) < 1e-7, "%s: coordinate %d is %g, expected %g", name, j, back[j], x[i][j]);
            if (tells == SOME) FF_CHECK(fabs(w[2] - w[5]) < 1e-12, "%s: polar angles %g %g", name, theta(w), theta(w + 3));
            FF_CHECK(t.value[i] == (double)i, "%s: value %g", name, t.value[i]);
        }
        ff_table_clear(&t);
    }
}

/* What the text says about retro-reflection and mirror reflection, in numbers without a second formula. */
static void known_pairs(void)
{
    static const struct {
        const char *name, *x;
        double l[3], v[3];
    } known[] = {
        {"ISOTROPIC_TL_TV_PROJ_DPHI",
         "0.5 0.5 0",
         {0.479425538604203, 0, 0.877582561890373},
         {0.479425538604203, 0, 0.877582561890373}},
        {"ISOTROPIC_TL_TV_PROJ_DPHI",
         "0.5 -0.5 0",
         {0.479425538604203, 0, 0.877582561890373},
         {-0.479425538604203, 0, 0.877582561890373}},
        {"ISOTROPIC_TL_TV_PROJ_DPHI", "0.5 0 0", {0.479425538604203, 0, 0.877582561890373}, {0, 0, 1}},
        {"RETRO_TL_TVL_PROJ_DPHI",
         "0.5 1 0",
         {0.479425538604203, 0, 0.877582561890373},
         {-0.479425538604203, 0, 0.877582561890373}},
        {"RETRO_TL_TVL_PROJ_DPHI", "0.5 0 0", {0.479425538604203, 0, 0.877582561890373}, {0.479425538604203, 0, 0.877582561890373}},
        {"SCHLICK_TL_TK_PROJ_DPHI",
         "0.5 0 0",
         {0.479425538604203, 0, 0.877582561890373},
         {0.479425538604203, 0, 0.877582561890373}},
        {"CARTESIAN", "0 0 1 0.6 0 0.8", {0.6, 0, 0.8}, {0, 0, 1}},
        {"SPHERICAL_TL_PL_TV_PV",
         "-0.5 0 0.5 0",
         {-0.479425538604203, 0, 0.877582561890373},
         {0.479425538604203, 0, 0.877582561890373}}};
    for (size_t k = 0; k < sizeof known / sizeof known[0]; k++) {
        char text[200];
        int n = 1;
        for (const char *p = known[k].x; *p; p++) n += *p == ' ';
        sprintf(text, "#DIM %d 1\n#PARAM_IN %s\n#PARAM_OUT INV_STERADIAN\n%s 1\n", n, known[k].name, known[k].x);
        ff_table t;
        if (!check_reads(known[k].name, "alta", text, &t)) continue;
        double w[6];
        check_directions(&t, 0, w);
        for (int j = 0; j < 3; j++)
            FF_CHECK(fabs(w[j] - known[k].l[j]) < 1e-14 && fabs(w[3 + j] - known[k].v[j]) < 1e-14, "%s %s: %g %g %g, %g %g %g",
                     known[k].name, known[k].x, w[0], w[1], w[2], w[3], w[4], w[5]);
        ff_table_clear(&t);
    }
}

/* ---- values ---------------------------------------------------------------------------------- */

static void test_values(void)
{
    static const struct {
        const char *out;
        int asked, quantity;
        double factor; /* of the value at theta_v = pi/3 */
        const char *note;
    } cases[] = {{"#PARAM_OUT INV_STERADIAN\n", -1, FF_BRDF, 1, ""},
                 {"#PARAM_OUT INV_STERADIAN_COSINE_FACTOR\n", -1, FF_BRDF_COS, 2, ""},
                 {"#PARAM_OUT INV_STERADIAN_COSINE_FACTOR\n", FF_BRDF, FF_BRDF, 1, ""},
                 {"", -1, FF_BRDF, 1, "there is no #PARAM_OUT"},
                 {"#PARAM_OUT UNKNOWN_OUTPUT\n", -1, FF_BRDF, 1, "there is no #PARAM_OUT"},
                 {"", FF_BRDF_COS, FF_BRDF_COS, 2, ""},
                 {"#PARAM_OUT ENERGY\n", FF_REFLECTANCE_FACTOR, FF_REFLECTANCE_FACTOR, 0.318309886183791, ""}};
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        char text[300];
        sprintf(text,
                "#SAMPLE \"x\"\n#DIM 4 1\n# PARAM_IN COS_TH is a comment\n#PARAM_IN SPHERICAL_TL_PL_TV_PV\n%s0.25 0 "
                "1.0471975511965976 2 -3\n",
                cases[k].out);
        ff_read_options o;
        ff_read_options_init(&o);
        o.quantity = cases[k].asked;
        ff_table t;
        if (!check_reads_with(text, "alta", text, &o, &t)) continue;
        double v;
        ff_table_values(&t, 0, 0, 1, &v);
        FF_CHECK(fabs(v / (-3 * cases[k].factor) - 1) < 1e-14 && t.quantity == (ff_quantity)cases[k].quantity && t.n_negative == 1,
                 "case %zu: %g", k, v);
        FF_CHECK(cases[k].note[0] ? strstr(t.note, cases[k].note) != NULL : !t.note[0], "case %zu: '%s'", k, t.note);
        FF_CHECK(t.angle[0][0] == 0.25 && t.angle[3][0] == 2, "case %zu: angles", k);
        ff_table_clear(&t);
    }
    ff_table t;
    /* at 90 degrees nothing can be divided by the cosine */
    if (check_reads("grazing", "alta",
                    "#DIM 4 1\n#PARAM_IN SPHERICAL_TL_PL_TV_PV\n#PARAM_OUT INV_STERADIAN_COSINE_FACTOR\n0 0 1.5707963267948966 0 "
                    "1\n0 0 1 0 1\n",
                    &t)) {
        FF_CHECK(t.n == 2 && t.n_invalid == 1 && !t.valid[0], "%zu invalid", t.n_invalid);
        ff_table_clear(&t);
    }
    if (check_reads("no pair", "alta", "#DIM 2 1\n#PARAM_IN STARK_2D\n#PARAM_OUT INV_STERADIAN\n0.8 0.8 1\n0.5 0.5 2\n", &t)) {
        FF_CHECK(t.n_invalid == 1 && !t.valid[0] && strstr(t.note, "1 samples have coordinates of no pair"), "'%s'", t.note);
        ff_table_clear(&t);
    }
    if (check_reads("no pair", "alta", "#DIM 3 1\n#PARAM_IN NEUMANN_3D\n#PARAM_OUT INV_STERADIAN\n0.8 0.8 0 1\n0.5 0.5 0 2\n",
                    &t)) {
        FF_CHECK(t.n_invalid == 1 && !t.valid[0], "'%s'", t.note);
        ff_table_clear(&t);
    }
    static const struct {
        const char *header, *names[3];
    } colours[] = {{"#PARAM_OUT RGB_COLOR\n", {"r", "g", "b"}},
                   {"#PARAM_OUT XYZ_COLOR\n", {"X", "Y", "Z"}},
                   {"#PARAM_OUT INV_STERADIAN\n", {"c0", "c1", "c2"}},
                   {"#PARAM_OUT INV_STERADIAN\n#CHANNELS 465nm, b c,d\n", {"465nm", "b c", "d"}}};
    for (size_t k = 0; k < sizeof colours / sizeof colours[0]; k++) {
        char text[200];
        sprintf(text, "#DIM 4 3\n#PARAM_IN SPHERICAL_TL_PL_TV_PV\n%s0 0 0 0 1 2 3\n# PARAM_IN none\n#DIM none\n1 0 0 0 4 5 6\n",
                colours[k].header);
        if (!check_reads(text, "alta", text, &t)) continue;
        for (size_t c = 0; c < 3; c++)
            FF_CHECK(strcmp(t.channels[c].name, colours[k].names[c]) == 0 && t.value[2 * c + 1] == (double)c + 4, "channel '%s'",
                     t.channels[c].name);
        FF_CHECK(k != 3 || t.channels[0].wavelength_nm == 465, "wavelength");
        ff_table_clear(&t);
    }
}

static void test_intervals(void)
{
    static const struct {
        const char *text;
        size_t n_channels;
        double sigma[2]; /* of the first sample; 0 = none */
        const char *note;
    } cases[] = {{"#DIM 4 1\n#VS 0\n0 0 0 0 5\n", 1, {0, 0}, ""},
                 {"#DIM 4 1\n#VS 1\n0 0 0 0 5 0.25\n", 1, {0.25, 0}, "half the width"},
                 {"#DIM 4 1\n#VS 2\n0 0 0 0 5 4.5 5.25\n", 1, {0.375, 0}, "half the width"},
                 {"#DIM 4 2\n#VS 1\n0 0 0 0 5 6 0.25 0.5\n", 2, {0.25, 0.5}, "half the width"},
                 {"#DIM 4 2\n#VS 1\n0 0 0 0 5 6 0.25\n", 2, {0, 0}, "not of every value"},
                 {"#DIM 4 2\n#VS 2\n0 0 0 0 5 6 4 6\n", 2, {0, 0}, "not of every value"},
                 {"#DIM 4 2\n#VS 2\n0 0 0 0 5 6 4 6 5 7\n", 2, {0, 0}, "in an order that ALTA does not define"},
                 {"#DIM 4 1\n#VS 1\n0 0 0 0 5 0.25\n0 0 0 0 5 0\n", 1, {0, 0}, "sample 1 has none of a width"},
                 {"#DIM 4 1\n#VS 2\n0 0 0 0 5 6 4\n", 1, {0, 0}, "sample 0 has none of a width"}};
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        char text[300];
        sprintf(text, "#PARAM_IN SPHERICAL_TL_PL_TV_PV\n#PARAM_OUT INV_STERADIAN\n%s", cases[k].text);
        ff_table t;
        if (!check_reads(text, "alta", text, &t)) continue;
        FF_CHECK(t.n_channels == cases[k].n_channels && !t.sigma == !cases[k].sigma[0] && t.value[0] == 5, "%s: sigma %p", text,
                 (void *)t.sigma);
        for (size_t c = 0; c < t.n_channels && t.sigma; c++)
            FF_CHECK(t.sigma[c * t.n] == cases[k].sigma[c], "%s: %g", text, t.sigma[c * t.n]);
        FF_CHECK(cases[k].note[0] ? strstr(t.note, cases[k].note) != NULL : !t.note[0], "%s: '%s'", text, t.note);
        ff_table_clear(&t);
    }
}

/* ---- errors ---------------------------------------------------------------------------------- */

static void refusals(void)
{
    check_refuses("alta", "", FF_ERR_READ, 0, WORDS("no rows"));
    check_refuses("alta", HEAD, FF_ERR_READ, 3, WORDS("no rows of numbers"));
    check_refuses("alta", "#PARAM_IN SPHERICAL_TL_PL_TV_PV\n0 0 0 0 1\n", FF_ERR_FORMAT, 2, WORDS("before a line #DIM"));
    check_refuses("alta", "#DIM 4 1\n0 0 0 0 1\n", FF_ERR_FORMAT, 2, WORDS("before a line #PARAM_IN"));
    check_refuses("alta", "#DIM 4\n", FF_ERR_FORMAT, 1, WORDS("#DIM: found '4'", "two whole numbers"));
    check_refuses("alta", "#DIM four 1\n", FF_ERR_FORMAT, 1, WORDS("'four 1'"));
    check_refuses("alta", "#DIM 4 0\n", FF_ERR_FORMAT, 1, WORDS("'4 0'", "1 to 4096 values"));
    check_refuses("alta", "#DIM 4 1000000000\n", FF_ERR_FORMAT, 1, WORDS("1 to 4096 values"));
    check_refuses("alta", "#DIM 99999999999999999999999999999999999999999999999999999 1\n", FF_ERR_FORMAT, 1,
                  WORDS("two whole numbers"));
    check_refuses("alta", "#PARAM_IN SIDEWAYS\n", FF_ERR_FORMAT, 1, WORDS("'SIDEWAYS'", "SPHERICAL_TL_PL_TV_PV"));
    static const char *const open[] = {"RUSIN_VH",       "COS_TH",  "SCHLICK_TK_PK", "SCHLICK_VK",      "SCHLICK_VH",
                                       "COS_TK",         "COS_TLV", "COS_TLR",       "ISOTROPIC_TV_TL", "ISOTROPIC_TV_PROJ_DPHI",
                                       "ISOTROPIC_TD_PD"};
    for (size_t k = 0; k < sizeof open / sizeof open[0]; k++) {
        char text[64];
        sprintf(text, "#DIM 1 1\n#PARAM_IN %s\n", open[k]);
        check_refuses("alta", text, FF_ERR_UNSUPPORTED, 2, WORDS(open[k], "which tells", "determine two directions"));
    }
    check_refuses("alta", "#PARAM_OUT LUMINANCE\n", FF_ERR_FORMAT, 1, WORDS("'LUMINANCE'", "INV_STERADIAN_COSINE_FACTOR"));
    check_refuses("alta", "#PARAM_OUT ENERGY\n", FF_ERR_UNSUPPORTED, 1, WORDS("ENERGY"));
    check_refuses("alta", "#VS 3\n", FF_ERR_FORMAT, 1, WORDS("'3'", "0, 1 or 2"));
    check_refuses("alta", "#ISOTROPIC yes\n", FF_ERR_FORMAT, 1, WORDS("'yes'", "0 or 1"));
    check_refuses("alta", "#FORMAT binary\n", FF_ERR_UNSUPPORTED, 1, WORDS("'binary'", "data2data"));
    check_refuses("alta", HEAD "#CHANNELS a,b\n0 0 0 0 1\n", FF_ERR_FORMAT, 5, WORDS("found 2 names", "expected 1"));
    check_refuses("alta", HEAD "#CHANNELS a,a\n", FF_ERR_FORMAT, 4, WORDS("'a' twice"));
    check_refuses("alta", "#DIM 3 1\n#PARAM_IN SPHERICAL_TL_PL_TV_PV\n0 0 0 1\n", FF_ERR_FORMAT, 3,
                  WORDS("found 3 coordinates", "expected 4"));
    check_refuses("alta", HEAD "0 0 0 1\n", FF_ERR_FORMAT, 4, WORDS("found 4 numbers", "expected 4 coordinates, 1 values"));
    check_refuses("alta", HEAD "#VS 1\n0 0 0 0 1\n", FF_ERR_FORMAT, 5, WORDS("found 5 numbers", "expected 6", "intervals"));
    check_refuses("alta", HEAD "#VS 2\n0 0 0 0 1 2\n", FF_ERR_FORMAT, 5, WORDS("found 6 numbers", "2 per value"));
    check_refuses("alta", HEAD "0 0 0 0 1\n0 0 0 1\n", FF_ERR_FORMAT, 5,
                  WORDS("found 4 numbers", "expected 5 as in the first row"));
    check_refuses("alta", HEAD "0 0 0 0 1\n0 0 0 0 1 2\n", FF_ERR_FORMAT, 5, WORDS("more than 5 numbers"));
    check_refuses("alta", HEAD "0 0 0 0 nan\n", FF_ERR_DATA, 4, WORDS("'nan'", "finite number"));
    check_refuses("alta", HEAD "0 0 0 0 1\n0 0 0 0 1e999\n", FF_ERR_DATA, 5, WORDS("'1e999'", "finite number"));
    check_refuses("alta", HEAD "45 0 0 0 1\n", FF_ERR_DATA, 4, WORDS("45, 0", "theta_l, phi_l", "degrees?"));
    check_refuses("alta", "#DIM 3 1\n#PARAM_IN ISOTROPIC_TL_TV_PROJ_DPHI\n0 3 3 1\n", FF_ERR_DATA, 3, WORDS("radians", "degrees?"));
    check_refuses("alta", "#DIM 2 1\n#PARAM_IN COS_TH_TD\n0.5 1.5 1\n", FF_ERR_DATA, 3, WORDS("0.5, 1.5", "two cosines"));
    check_refuses("alta", "#DIM 2 1\n#PARAM_IN STARK_2D\n-0.5 0.5 1\n", FF_ERR_DATA, 3, WORDS("-0.5, 0.5", "two lengths"));
    check_refuses("alta", "#DIM 6 1\n#PARAM_IN CARTESIAN\n0 0 2 0 0 1 1\n", FF_ERR_DATA, 3, WORDS("two unit vectors"));
    check_refuses("alta", "#DIM 6 1\n#PARAM_IN RUSIN_VH_VD\n0 0 1 0 0 0 1\n", FF_ERR_DATA, 3, WORDS("two unit vectors"));
    check_refuses("alta", "#DIM 2 1\n#PARAM_IN STARK_2D\n0.9 0.9 1\n", FF_ERR_DATA, 0, WORDS("all of them"));
}

/* ---- writing --------------------------------------------------------------------------------- */

static void round_trip(const char *label, const ff_table *t)
{
    ff_table back;
    ff_error err = {0};
    const char *path = ff_test_path("round.alta");
    if (!FF_CHECK(ff_table_write(path, NULL, t, &err) == FF_OK, "%s: %s", label, err.message)) return;
    if (!FF_CHECK(ff_table_read_into(path, NULL, &back, &err) == FF_OK, "%s: %ld: %s", label, err.line, err.message)) return;
    check_same_tables(label, t, &back);
    if (t->radians_per_unit == 1) check_same_angles(label, t, &back);
    for (size_t c = 0; c < t->n_channels; c++)
        FF_CHECK(isnan(t->channels[c].wavelength_nm) ? isnan(back.channels[c].wavelength_nm)
                                                     : t->channels[c].wavelength_nm == back.channels[c].wavelength_nm,
                 "%s: wavelength %zu", label, c);
    ff_table_clear(&back);
}

static void test_round_trip(void)
{
    static const char *const names[][3] = {{"f"}, {"r", "g", "b"}, {"X", "Y", "Z"}, {"465.5nm", "a b"}, {"c0"}};
    static const size_t n_channels[] = {1, 3, 3, 2, 1};
    ff_error err = {0};
    for (size_t k = 0; k < sizeof names / sizeof names[0]; k++)
        for (int with_sigma = 0; with_sigma < 2; with_sigma++) {
            ff_table t;
            if (!FF_CHECK(ff_table_init(500, n_channels[k], NULL, with_sigma, 0, &t, &err) == FF_OK, "%s", err.message)) return;
            for (size_t i = 0; i < t.n; i++)
                for (int j = 0; j < 4; j++) t.angle[j][i] = ff_test_uniform() * (j % 2 ? 6.28 : 1.57);
            for (size_t i = 0; i < t.n * t.n_channels; i++) {
                t.value[i] = ldexp(ff_test_uniform() - 0.125, (int)(ff_test_random() % 40) - 30);
                if (with_sigma) t.sigma[i] = ldexp(ff_test_uniform() + 1e-9, (int)(ff_test_random() % 40) - 30);
            }
            for (size_t c = 0; c < t.n_channels; c++) {
                strcpy(t.channels[c].name, names[k][c]);
                if (c == 0 && k == 3) t.channels[c].wavelength_nm = 465.5;
            }
            t.isotropic = (int)k % 2;
            for (size_t i = 0; i < t.n; i++) {
                int any = 0;
                for (size_t c = 0; c < t.n_channels; c++) any |= t.value[c * t.n + i] < 0;
                t.n_negative += (size_t)any;
            }
            round_trip(names[k][0], &t);
            ff_table_clear(&t);
        }
    ff_table t, back;
    if (!FF_CHECK(ff_table_init(3, 1, NULL, 0, 0, &t, &err) == FF_OK, "%s", err.message)) return;
    t.radians_per_unit = check_pi / 180;
    t.angle[0][0] = 60;
    t.valid[1] = 0;
    t.value[2] = 7;
    const char *path = ff_test_path("degrees.alta");
    FF_CHECK(ff_table_write(path, NULL, &t, &err) == FF_OK, "%s", err.message);
    if (FF_CHECK(ff_table_read_into(path, NULL, &back, &err) == FF_OK, "%s", err.message)) {
        FF_CHECK(back.n == 2 && back.value[1] == 7 && fabs(back.angle[0][0] - check_pi / 3) < 1e-15,
                 "what was not measured is left out");
        ff_table_clear(&back);
    }
    static const char *const bad[] = {"", "a,b", "a\"", " a", "a ", "a\n"};
    for (size_t k = 0; k < sizeof bad / sizeof bad[0]; k++) {
        strcpy(t.channels[0].name, bad[k]);
        ff_status status = ff_table_write(path, NULL, &t, &err);
        FF_CHECK(status == FF_ERR_UNSUPPORTED && strstr(err.message, "expected a name"), "'%s': %d %s", bad[k], status,
                 err.message);
    }
    ff_table_clear(&t);
    FF_CHECK(check_leftovers() == 0, "%d unfinished files", check_leftovers());
}

/* ---- real files ------------------------------------------------------------------------------ */

typedef struct tape_row {
    double theta_l, x, y, value;
} tape_row;

/* Stored value next to theta_v, dphi (|y|: the tapes are symmetric) for light at theta_l. */
static double near_to(const tape_row *rows, size_t n, double theta_l, double theta_v, double dphi, double *distance)
{
    double found = NAN;
    *distance = 1e9;
    for (size_t i = 0; i < n; i++) {
        if (fabs(rows[i].theta_l - theta_l) > 1e-6) continue;
        const double d = hypot(rows[i].x - theta_v * cos(dphi), fabs(rows[i].y) - theta_v * sin(dphi));
        if (d < *distance) *distance = d, found = rows[i].value;
    }
    return found;
}

/* The stored values obey reciprocity after division by cos(theta_v): the median of g(a -> b) / g(b -> a) is cos b / cos a. */
static void check_reciprocity(const char *path, const tape_row *rows, size_t n, double a, double b)
{
    double ratio[32];
    int found = 0;
    for (int k = 20; k <= 160; k += 10) {
        const double dphi = k * check_pi / 180;
        double d[2];
        const double there = near_to(rows, n, a, b, dphi, d), back = near_to(rows, n, b, a, dphi, d + 1);
        if (fmax(d[0], d[1]) > 0.05) continue;
        ratio[found] = there / back;
        for (int m = found++; m > 0 && ratio[m - 1] > ratio[m]; m--) {
            const double swap = ratio[m];
            ratio[m] = ratio[m - 1], ratio[m - 1] = swap;
        }
    }
    FF_CHECK(found > 8 && fabs(ratio[found / 2] / (cos(b) / cos(a)) - 1) < 0.12, "%s, %g and %g: %g, the cosines give %g", path, a,
             b, ratio[found / 2], cos(b) / cos(a));
}

static int test_real(void)
{
    static const char *const names[] = {"alta/retro-3M-jaune.dat", "alta/retro-gray-tape.dat"};
    static const size_t n_samples[] = {7397, 7405};
    int n_files = 0;
    for (size_t k = 0; k < 2; k++) {
        const char *path = check_data(names[k]);
        ff_table t;
        ff_error err = {0};
        if (!path) continue;
        n_files++;
        if (!FF_CHECK(ff_table_read_into(path, NULL, &t, &err) == FF_OK, "%s:%ld: %s", path, err.line, err.message)) continue;
        FF_CHECK(strcmp(t.format, "alta") == 0 && t.n == n_samples[k] && t.isotropic && t.n_negative == 0, "%s: %zu samples", path,
                 t.n);
        FF_CHECK(t.quantity == (k ? FF_BRDF : FF_BRDF_COS) && !strstr(t.note, "PARAM_OUT") == !k, "%s: '%s'", path, t.note);
        size_t size, n = 0, invalid = 0, brightest = 0;
        char *text = ff_test_slurp(path, &size), *rest;
        tape_row *rows = malloc(t.n * sizeof *rows);
        if (!rows) exit(1);
        double worst = 0;
        for (char *line = strtok_r(text, "\n", &rest); line; line = strtok_r(NULL, "\n", &rest)) {
            tape_row r;
            if (*line == '#' || sscanf(line, "%lf %lf %lf %lf", &r.theta_l, &r.x, &r.y, &r.value) != 4 || n >= t.n) continue;
            rows[n] = r;
            double v, w[6];
            const double theta_v = hypot(r.x, r.y);
            ff_table_values(&t, 0, n, 1, &v);
            check_directions(&t, n, w);
            invalid += !t.valid[n];
            worst = fmax(worst, fabs(acos(w[2]) - r.theta_l) + fabs(acos(w[5]) - theta_v));
            if (theta_v > 0)
                worst = fmax(worst, fabs(w[3] / sin(theta_v) - r.x / theta_v) + fabs(w[4] / sin(theta_v) - r.y / theta_v));
            if (t.valid[n]) worst = fmax(worst, fabs(v / (r.value / (k ? 1 : cos(theta_v))) - 1) * cos(theta_v));
            if (t.valid[n] && theta_v < 1.2 && t.value[n] > t.value[brightest]) brightest = n;
            n++;
        }
        FF_CHECK(n == t.n && worst < 1e-7 && invalid == (k ? 0 : 86), "%s: %zu rows, %zu invalid, off by %g", path, n, invalid,
                 worst);
        if (k == 1) { /* the gray tape's largest value is the retro-reflected one */
            double w[6];
            check_directions(&t, brightest, w);
            FF_CHECK(dot(w, w + 3) > cos(1e-6), "the peak is at %g %g", t.angle[2][brightest], t.angle[3][brightest]);
        }
        check_reciprocity(path, rows, n, check_pi / 12, check_pi / 3);
        check_reciprocity(path, rows, n, check_pi / 6, check_pi / 3);
        free(rows);
        free(text);
        if (t.n_invalid == 0) round_trip(path, &t);
        ff_table_clear(&t);
    }
    return n_files;
}

static void one_file_damaged(void)
{
    static const char text[] = HEAD "#VS 0\n#ISOTROPIC 0\n#CHANNELS a\n0.5 0 0.25 3 1.5\n1 0.1 1.25 2 6.5\n";
    check_prefixes("alta", text, 2, 1);
    check_byte_order_mark("alta", text);
    check_flips("alta", text);
    check_flips("alta", "#DIM 3 2\n#PARAM_IN RETRO_TL_TVL_PROJ_DPHI\n#VS 1\n0.5 0.25 3e-1 1.5 2 .1 .2\n");
}

static void measured(void)
{
    if (!test_real()) FF_SKIP("no real files in %s/alta", check_data_dir());
}

FF_TEST_MAIN(FF_TEST(parametrisations), FF_TEST(known_pairs), FF_TEST(test_values), FF_TEST(test_intervals), FF_TEST(refusals),
             FF_TEST(test_round_trip), FF_TEST(one_file_damaged), FF_TEST(measured))
