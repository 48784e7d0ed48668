/* Many wavelengths become few channels. */
#include "check_table.h"
#include "data_formats/analysis/spectral_struct.h"
#include "data_formats/analysis/internal_cie1931.h"

/* XYZ of linear sRGB, as IEC 61966-2-1 prints it. */
static const double xyz_of_rgb[3][3] = {{0.4124, 0.3576, 0.1805}, {0.2126, 0.7152, 0.0722}, {0.0193, 0.1192, 0.9505}};

/* n channels from `first` nm in steps; two samples, the second not measured. */
static ff_table spectrum(size_t n, double first, double step, int with_sigma)
{
    ff_table t;
    ff_error err = {0};
    if (ff_table_init(2, n, NULL, with_sigma, 1, &t, &err) != FF_OK) exit(1);
    for (size_t c = 0; c < n; c++) {
        snprintf(t.channels[c].name, sizeof t.channels[c].name, "%gnm", first + step * (double)c);
        t.channels[c].wavelength_nm = first + step * (double)c;
        if (with_sigma) t.sigma[c * 2] = t.sigma[c * 2 + 1] = 1;
    }
    t.valid[1] = 0;
    t.angle[0][0] = 0.25;
    t.weight[0] = 7;
    strcpy(t.format, "csv");
    strcpy(t.note, "as it was");
    return t;
}

static int reduces(const ff_table *t, const char *text, ff_table *out)
{
    ff_error err = {0};
    return FF_CHECK(ff_table_reduce_into(t, text, out, &err) == FF_OK, "%s: %s", text, err.message);
}

static double value(const ff_table *t, size_t c)
{
    double v;
    ff_table_values(t, c, 0, 1, &v);
    return v;
}

static void refuses(const ff_table *t, const char *text, ff_status code, const char *const *words)
{
    ff_table out;
    ff_error err = {0};
    memset(&out, 0x5A, sizeof out);
    ff_status status = ff_table_reduce_into(t, text, &out, &err);
    if (!FF_CHECK(status == code, "%s: %d %s", text, status, err.message)) {
        if (status == FF_OK) ff_table_clear(&out);
        return;
    }
    FF_CHECK(out.n == 0x5A5A5A5A5A5A5A5Au, "%s: the table was touched", text);
    for (; *words; words++) FF_CHECK(strstr(err.message, *words), "%s: no '%s' in: %s", text, *words, err.message);
}

/* ---- white ----------------------------------------------------------------------------------- */

static void constants(void)
{
    static const struct {
        size_t n;
        double first, step;
    } grids[] = {{95, 360, 5},      {31, 400, 10}, {471, 360, 1}, {3, 465, 80},
                 {16, 401.5, 19.7}, {2, 300, 700}, {6, 450, 120}, {700, 250, 1.3}};
    static const char *const kinds[] = {"srgb", "srgb:d65", "srgb:e"};
    for (size_t g = 0; g < sizeof grids / sizeof grids[0]; g++)
        for (int k = 0; k < 3; k++) {
            ff_table t = spectrum(grids[g].n, grids[g].first, grids[g].step, 0), out;
            for (size_t c = 0; c < t.n_channels; c++) {
                t.channels[c].scale = c % 2 ? 0.5 : 0.25;
                t.value[2 * c] = 0.3 / t.channels[c].scale;
                t.value[2 * c + 1] = NAN;
            }
            if (reduces(&t, kinds[k], &out)) {
                for (size_t c = 0; c < 3; c++)
                    FF_CHECK(fabs(value(&out, c) - 0.3) < 2e-15, "%s on grid %zu: channel %zu is %.17g", kinds[k], g, c,
                             value(&out, c));
                FF_CHECK(out.n_channels == 3 && strcmp(out.channels[0].name, "r") == 0 && strcmp(out.channels[2].name, "b") == 0 &&
                             isnan(out.channels[1].wavelength_nm),
                         "names");
                FF_CHECK(out.n == 2 && out.angle[0][0] == 0.25 && out.weight[0] == 7 && !out.valid[1] && out.value[1] == 0 &&
                             out.n_invalid == 1 && strncmp(out.note, "as it was", 9) == 0 && strcmp(out.format, "csv") == 0,
                         "the rest of the table: %s", out.note);
                ff_table_clear(&out);
            }
            ff_table_clear(&t);
        }
}

/* ---- published chromaticities ---------------------------------------------------------------- */

static void chromaticity(const ff_table *rgb, double xy[2], double *luminance)
{
    double v[3], xyz[3], sum = 0;
    for (size_t c = 0; c < 3; c++) v[c] = value(rgb, c);
    for (int i = 0; i < 3; i++) xyz[i] = xyz_of_rgb[i][0] * v[0] + xyz_of_rgb[i][1] * v[1] + xyz_of_rgb[i][2] * v[2];
    for (int i = 0; i < 3; i++) sum += xyz[i];
    xy[0] = xyz[0] / sum;
    xy[1] = xyz[1] / sum;
    *luminance = xyz[1];
}

/* Chromaticities of the spectrum locus (CIE 15, table of the 1931 observer). What reflects one node of 5 nm only has that of its
 * wavelength, under any illuminant. */
static void test_locus(void)
{
    static const struct {
        int nm;
        double x, y;
    } locus[] = {{450, 0.1566, 0.0177}, {480, 0.0913, 0.1327}, {500, 0.0082, 0.5384}, {520, 0.0743, 0.8338},
                 {550, 0.3016, 0.6923}, {580, 0.5125, 0.4866}, {600, 0.6270, 0.3725}, {650, 0.7260, 0.2740}};
    for (size_t k = 0; k < sizeof locus / sizeof locus[0]; k++) {
        ff_table t = spectrum(95, 360, 5, 0), out;
        double xy[2], y;
        t.value[2 * ((locus[k].nm - 360) / 5)] = 100;
        if (reduces(&t, "srgb", &out)) {
            chromaticity(&out, xy, &y);
            FF_CHECK(fabs(xy[0] - locus[k].x) < 4e-4 && fabs(xy[1] - locus[k].y) < 4e-4, "%d nm: %.4f %.4f, expected %.4f %.4f",
                     locus[k].nm, xy[0], xy[1], locus[k].x, locus[k].y);
            FF_CHECK(out.n_negative == (size_t)(value(&out, 0) < 0 || value(&out, 1) < 0 || value(&out, 2) < 0), "negatives");
            ff_table_clear(&out);
        }
        ff_table_clear(&t);
    }
}

/* What reflects like S_X / S_D65 looks under D65 as the illuminant X: A (Planck at 2856 K, CIE 15: 0.44758, 0.40745) and E. */
static void illuminants(void)
{
    double xy[2], y;
    for (int illuminant = 0; illuminant < 2; illuminant++) {
        ff_table t = spectrum(95, 360, 5, 0), out;
        for (int k = 0; k < 95; k++) {
            const double nm = 360 + 5 * k;
            const double a = 100 * pow(560 / nm, 5) * (exp(1.435e7 / (2848 * 560.0)) - 1) / (exp(1.435e7 / (2848 * nm)) - 1);
            t.value[2 * k] = (illuminant ? 100 : a) / ff_cie_d65[k];
        }
        if (reduces(&t, "srgb:d65", &out)) {
            chromaticity(&out, xy, &y);
            if (illuminant)
                FF_CHECK(fabs(xy[0] - 1. / 3) < 3e-4 && fabs(xy[1] - 1. / 3) < 3e-4, "E: %.5f %.5f", xy[0], xy[1]);
            else
                FF_CHECK(fabs(xy[0] - 0.44758) < 3e-4 && fabs(xy[1] - 0.40745) < 3e-4, "A: %.5f %.5f", xy[0], xy[1]);
            ff_table_clear(&out);
        }
        /* under E, Bradford's adaptation of E to D65 makes of A what is computed here step by step */
        if (!illuminant && reduces(&t, "srgb:e", &out)) {
            static const double b[3][3] = {{0.8951, 0.2664, -0.1614}, {-0.7502, 1.7135, 0.0367}, {0.0389, -0.0685, 1.0296}};
            static const double back[3][3] = {
                {0.9869929, -0.1470543, 0.1599627}, {0.4323053, 0.5183603, 0.0492912}, {-0.0085287, 0.0400428, 0.9684867}};
            static const double rgb[3][3] = {{3.2406, -1.5372, -0.4986}, {-0.9689, 1.8758, 0.0415}, {0.0557, -0.2040, 1.0570}};
            static const double d65[3] = {0.9505, 1, 1.0891};
            double xyz[3] = {0, 0, 0}, white = 0, cone[3], adapted[3], expected;
            for (int k = 0; k < 95; k++) white += ff_cie1931[k][1];
            for (int k = 0; k < 95; k++)
                for (int c = 0; c < 3; c++) xyz[c] += ff_cie1931[k][c] * t.value[2 * k] / white;
            for (int i = 0; i < 3; i++) {
                double to = 0, from = b[i][0] + b[i][1] + b[i][2];
                cone[i] = 0;
                for (int j = 0; j < 3; j++) cone[i] += b[i][j] * xyz[j], to += b[i][j] * d65[j];
                cone[i] *= to / from;
            }
            for (int i = 0; i < 3; i++) adapted[i] = back[i][0] * cone[0] + back[i][1] * cone[1] + back[i][2] * cone[2];
            for (int i = 0; i < 3; i++) {
                expected = rgb[i][0] * adapted[0] + rgb[i][1] * adapted[1] + rgb[i][2] * adapted[2];
                FF_CHECK(fabs(value(&out, (size_t)i) - expected) < 2e-3, "E, channel %d: %.5f, expected %.5f", i,
                         value(&out, (size_t)i), expected);
            }
            ff_table_clear(&out);
        }
        ff_table_clear(&t);
    }
    double sum[3] = {0, 0, 0}, white[3] = {0, 0, 0};
    for (int k = 0; k < FF_CIE_N; k++)
        for (int c = 0; c < 3; c++) sum[c] += ff_cie1931[k][c], white[c] += ff_cie1931[k][c] * ff_cie_d65[k];
    FF_CHECK(fabs(sum[0] / sum[1] - 1) < 4e-4 && fabs(sum[2] / sum[1] - 1) < 4e-4, "E: %g %g", sum[0] / sum[1], sum[2] / sum[1]);
    FF_CHECK(fabs(white[0] / white[1] - 0.9505) < 1e-4 && fabs(white[2] / white[1] - 1.0889) < 2e-4, "D65: %g %g",
             white[0] / white[1], white[2] / white[1]);
    FF_CHECK(ff_cie_d65[(560 - 360) / 5] == 100 && ff_cie1931[(555 - 360) / 5][1] == 1, "peaks");
}

/* Smooth spectra on coarse grids, against the same at 1 nm. */
static double smooth(int kind, double nm)
{
    if (kind == 0) return 0.05 + 0.6 / (1 + exp(-(nm - 580) / 15));                   /* a red of an edge 60 nm wide */
    if (kind == 1) return 0.1 + 0.4 * exp(-(nm - 530) * (nm - 530) / (2 * 30 * 30.)); /* a green                    */
    return 0.3 + 0.2 * sin(nm / 40);
}

static void accuracy(void)
{
    static const struct {
        size_t n;
        double first, step, at_most;
    } grids[] = {{81, 380, 5, 6e-4}, {31, 400, 10, 1.2e-3}, {16, 400, 20, 8e-3}};
    for (size_t g = 0; g < 3; g++) {
        double worst = 0;
        for (int kind = 0; kind < 3; kind++) {
            ff_table fine = spectrum(471, 360, 1, 0), coarse = spectrum(grids[g].n, grids[g].first, grids[g].step, 0), a, b;
            for (size_t c = 0; c < fine.n_channels; c++) fine.value[2 * c] = smooth(kind, fine.channels[c].wavelength_nm);
            for (size_t c = 0; c < coarse.n_channels; c++) coarse.value[2 * c] = smooth(kind, coarse.channels[c].wavelength_nm);
            if (reduces(&fine, "srgb", &a) && reduces(&coarse, "srgb", &b)) {
                for (size_t c = 0; c < 3; c++) worst = fmax(worst, fabs(value(&a, c) - value(&b, c)));
                ff_table_clear(&a);
                ff_table_clear(&b);
            }
            ff_table_clear(&fine);
            ff_table_clear(&coarse);
        }
        printf("%zu channels of %g nm: within %.1e of 1 nm\n", grids[g].n, grids[g].step, worst);
        FF_CHECK(worst < grids[g].at_most, "%g nm: off by %g", grids[g].step, worst);
    }
}

/* Beyond its ends a spectrum is as at its ends: the same, written out. */
static void test_ends(void)
{
    ff_table shorter = spectrum(51, 420, 5, 0), whole = spectrum(95, 360, 5, 0), a, b;
    for (size_t c = 0; c < 51; c++) shorter.value[2 * c] = 0.01 * (double)c;
    for (size_t c = 0; c < 95; c++) whole.value[2 * c] = 0.01 * fmax(0, fmin(50, (double)c - 12));
    if (reduces(&shorter, "srgb", &a) && reduces(&whole, "srgb", &b)) {
        for (size_t c = 0; c < 3; c++)
            FF_CHECK(fabs(value(&a, c) - value(&b, c)) < 1e-14, "%zu: %g %g", c, value(&a, c), value(&b, c));
        ff_table_clear(&a);
        ff_table_clear(&b);
    }
    ff_table_clear(&shorter);
    ff_table_clear(&whole);
}

static void coverage(void)
{
    ff_table t = spectrum(6, 450, 120, 0), out; /* 450 to 1050 nm */
    if (reduces(&t, "srgb", &out)) {
        /* of Z under D65 the table has 42 % below 450 nm */
        double below = 0, all = 0;
        for (int k = 0; k < FF_CIE_N; k++) {
            all += ff_cie1931[k][2] * ff_cie_d65[k];
            if (360 + 5 * k < 450) below += ff_cie1931[k][2] * ff_cie_d65[k];
        }
        char expected[64];
        snprintf(expected, sizeof expected, "%.1f %% of Z", 100 * below / all);
        FF_CHECK(strstr(out.note, expected) && strstr(out.note, "beyond 450 to 1050 nm") && strstr(out.note, "up to 120 nm apart"),
                 "'%s' in '%s'", expected, out.note);
        ff_table_clear(&out);
    }
    ff_table_clear(&t);
    t = spectrum(31, 400, 10, 0);
    if (reduces(&t, "srgb", &out)) {
        FF_CHECK(strstr(out.note, "beyond 400 to 700 nm") && !strstr(out.note, "apart"), "'%s'", out.note);
        ff_table_clear(&out);
    }
    ff_table_clear(&t);
    t = spectrum(95, 360, 5, 0);
    if (reduces(&t, "srgb", &out)) {
        FF_CHECK(strcmp(out.note, "as it was") == 0, "'%s'", out.note);
        ff_table_clear(&out);
    }
    ff_table_clear(&t);
    t = spectrum(20, 600, 10, 0);
    refuses(&t, "srgb", FF_ERR_UNSUPPORTED, WORDS("600 to 790 nm", "at least 50 %"));
    ff_table_clear(&t);
    t = spectrum(1, 550, 10, 0);
    refuses(&t, "srgb", FF_ERR_UNSUPPORTED, WORDS("550 to 550 nm"));
    ff_table_clear(&t);
}

/* ---- bands ----------------------------------------------------------------------------------- */

static void test_bands(void)
{
    static const double nm[5] = {600, 400, 500, 450, 700}; /* in any order */
    static const double f[5] = {5, 1, 4, 3, -1};
    ff_table t = spectrum(5, 0, 1, 1), out;
    for (size_t c = 0; c < 5; c++) {
        t.channels[c].wavelength_nm = nm[c];
        t.channels[c].scale = 2;
        t.value[2 * c] = f[c] / 2;
        t.sigma[2 * c] = 0.1 * (double)(c + 1) / 2;
    }
    if (reduces(&t, "bands:blue=400-500,mid=425-525,low=300-420,up=650-700,all=400-700", &out)) {
        /* by hand: trapezoids 400-450 100, 450-500 175; 425 is 2, 525 is 4.25 */
        FF_CHECK(fabs(value(&out, 0) - 275 / 100.) < 1e-14, "blue %g", value(&out, 0));
        FF_CHECK(fabs(value(&out, 1) - (62.5 + 175 + 25 * 4.125) / 100) < 1e-14, "mid %g", value(&out, 1));
        FF_CHECK(fabs(value(&out, 2) - 1.4) < 1e-14, "low, 400 to 420 alone: %g", value(&out, 2));
        FF_CHECK(fabs(value(&out, 3) - 0.5) < 1e-14, "up %g", value(&out, 3));
        FF_CHECK(fabs(value(&out, 4) - (275 + 450 + 200) / 300.) < 1e-14, "all %g", value(&out, 4));
        /* weights of blue: 400 25, 450 50, 500 25 of 100; sigmas .2 .4 .3 */
        FF_CHECK(fabs(out.sigma[0] - sqrt(.05 * .05 + .2 * .2 + .075 * .075)) < 1e-15, "sigma %g", out.sigma[0]);
        FF_CHECK(strstr(out.note, "band 'low', 300 to 420 nm: the mean is over 400 to 420 nm") && !strstr(out.note, "blue"), "'%s'",
                 out.note);
        FF_CHECK(strcmp(out.channels[3].name, "up") == 0 && out.n_channels == 5 && out.sigma[1] == 0, "names");
        ff_table_clear(&out);
    }
    refuses(&t, "bands:ir=800-900", FF_ERR_UNSUPPORTED, WORDS("'ir'", "800 to 900", "400 to 700 nm"));
    refuses(&t, "bands:ir=700-900", FF_ERR_UNSUPPORTED, WORDS("'ir'"));
    refuses(&t, "bands:x=500-400", FF_ERR_RANGE, WORDS("'x'", "500 to 400"));
    refuses(&t, "bands:x=400-500,x=500-600", FF_ERR_SYNTAX, WORDS("'x=500-600'", "once"));
    static const char *const wrong[] = {"bands:",           "bands:x",        "bands:x=",         "bands:x=4",      "bands:x=400-",
                                        "bands:x=400-500x", "bands:=400-500", "bands:x=400-500,", "bands:x=nan-500"};
    for (size_t k = 0; k < sizeof wrong / sizeof wrong[0]; k++) refuses(&t, wrong[k], FF_ERR_SYNTAX, WORDS("bands NAME=A-B"));
    char longer[300] = "bands:";
    memset(longer + 6, 'x', 200);
    strcpy(longer + 206, "=1-2");
    refuses(&t, longer, FF_ERR_SYNTAX, WORDS("bands NAME=A-B"));
    ff_table_clear(&t);
    t = spectrum(1, 550, 1, 0);
    t.value[0] = 3;
    if (reduces(&t, "bands:x=500-600", &out)) {
        FF_CHECK(value(&out, 0) == 3, "%g", value(&out, 0));
        ff_table_clear(&out);
    }
    refuses(&t, "bands:x=560-600", FF_ERR_UNSUPPORTED, WORDS("560 to 600"));
    ff_table_clear(&t);
}

/* ---- channels, mean, and what is wrong --------------------------------------------------------- */

static void test_channels(void)
{
    ff_table t = spectrum(4, 400, 100, 1), out;
    for (size_t c = 0; c < 4; c++) {
        t.value[2 * c] = 0.1 * (double)(c + 1);
        t.channels[c].scale = 1.15 / 1500;
        t.sigma[2 * c] = (double)(c + 3);
    }
    if (reduces(&t, "channels:600nm,400nm", &out)) {
        FF_CHECK(out.n_channels == 2 && check_same_bits(&out.value[0], &t.value[4], 1) &&
                     check_same_bits(&out.value[2], &t.value[0], 1) && out.channels[0].scale == 1.15 / 1500 &&
                     out.channels[0].wavelength_nm == 600 && out.sigma[0] == 5,
                 "picked");
        ff_table_clear(&out);
    }
    if (reduces(&t, "mean", &out)) {
        FF_CHECK(out.n_channels == 1 && fabs(value(&out, 0) - 0.25 * 1.15 / 1500) < 1e-19, "mean %g", value(&out, 0));
        FF_CHECK(fabs(out.sigma[0] - 1.15 / 1500 * sqrt(9. + 16 + 25 + 36) / 4) < 1e-17, "sigma %g", out.sigma[0]);
        ff_table_clear(&out);
    }
    refuses(&t, "channels:600nm,x", FF_ERR_UNKNOWN, WORDS("'x'", "'400nm' to '700nm'"));
    refuses(&t, "channels:", FF_ERR_UNKNOWN, WORDS("''"));
    refuses(&t, "channels:600nm,600nm", FF_ERR_SYNTAX, WORDS("once"));
    refuses(&t, "rgb", FF_ERR_SYNTAX, WORDS("'rgb'", "srgb:d65", "bands:"));
    refuses(&t, "", FF_ERR_SYNTAX, WORDS("''", "mean"));
    refuses(&t, "srgb:a", FF_ERR_SYNTAX, WORDS("'srgb:a'"));
    t.channels[2].wavelength_nm = 500;
    refuses(&t, "srgb", FF_ERR_UNSUPPORTED, WORDS("'500nm' and '600nm'", "of one wavelength"));
    t.channels[2].wavelength_nm = NAN;
    refuses(&t, "bands:x=400-500", FF_ERR_UNSUPPORTED, WORDS("'600nm' without a wavelength"));
    t.valid[0] = 0;
    refuses(&t, "mean", FF_ERR_DATA, WORDS("at least one measurement"));
    ff_table_clear(&t);
}

static void note_free(void *kept)
{
    *(int *)kept += 1;
}

static void structures(void)
{
    ff_table t, out;
    ff_error err = {0};
    int freed = 0;
    if (ff_table_init(ff_grid_merl.n, 2, &ff_grid_merl, 0, 0, &t, &err) != FF_OK) exit(1);
    for (size_t i = 0; i < t.n; i++) t.value[i] = 1, t.value[t.n + i] = 2, t.valid[i] = i % 3 != 0;
    t.kept = &freed;
    t.kept_free = note_free;
    if (reduces(&t, "mean", &out)) {
        FF_CHECK(out.grid == &ff_grid_merl && !out.angle[0] && !out.kept && out.isotropic == 1 && out.value[1] == 1.5 &&
                     out.value[0] == 0 && out.n_invalid == t.n / 3,
                 "a grid");
        ff_table_clear(&out);
    }
    FF_CHECK(freed == 0, "kept was freed");
    ff_table_clear(&t);
    if (ff_table_init(6, 2, NULL, 0, 0, &t, &err) != FF_OK) exit(1);
    t.axes.kind = FF_AXES_INCIDENT_EXIT;
    for (int k = 0; k < 4; k++) {
        t.axes.n[k] = k == 0 ? 2 : k == 2 ? 3 : 1;
        t.axes.node[k] = calloc(3, sizeof(double));
        t.axes.node[k][0] = k;
    }
    if (reduces(&t, "channels:c1", &out)) {
        FF_CHECK(out.axes.kind == FF_AXES_INCIDENT_EXIT && out.axes.n[2] == 3 && out.axes.node[3][0] == 3 &&
                     out.axes.node[3] != t.axes.node[3],
                 "axes");
        ff_table_clear(&out);
    }
    ff_table_clear(&t);
}

FF_TEST_MAIN(FF_TEST(constants), FF_TEST(test_locus), FF_TEST(illuminants), FF_TEST(accuracy), FF_TEST(test_ends),
             FF_TEST(coverage), FF_TEST(test_bands), FF_TEST(test_channels), FF_TEST(structures))
