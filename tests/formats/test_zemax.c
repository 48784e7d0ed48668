/* BSDF data interchange files, made here, and the measured ones where they are at hand. */
#include "check_text.h"
#include "data_formats/table/internal_table.h"

static const double pi = 3.14159265358979323846, degree = 3.14159265358979323846 / 180;

#define WORDS_OF_HEAD "Source Measured\nSymmetry PlaneSymmetrical\nSpectralContent Monochrome\nScatterType BRDF\n"
#define HEAD          WORDS_OF_HEAD "SampleRotation 1\n0\nAngleOfIncidence 2\n10 60\nScatterAzimuth 2\n0 180\nScatterRadial 3\n0 20 60\n\n"
#define BLOCKS        "TIS 0.1\n1 2 3\n4 5 6\nTIS 0.2\n7 8 9\n10 11 0\n"

/* ---- directions ------------------------------------------------------------------------------ */

static void cross(const double a[3], const double b[3], double out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

/* The specification in vectors: the plane of incidence has the normal x at rotation 0, the reflected ray goes over +y, the sample
 * turns by +rotation, azimuth 0 points from the reflected ray to the normal and grows counter-clockwise about it. */
static void by_vectors(double rotation, double incidence, double azimuth, double radial, double wi[3], double wo[3])
{
    const double over[2] = {sin(rotation), cos(rotation)}; /* +y as the turned sample sees it */
    const double s[3] = {sin(incidence) * over[0], sin(incidence) * over[1], cos(incidence)};
    double to_normal[3] = {-s[2] * s[0], -s[2] * s[1], 1 - s[2] * s[2]}, aside[3];
    const double length = sqrt(to_normal[0] * to_normal[0] + to_normal[1] * to_normal[1] + to_normal[2] * to_normal[2]);
    for (int k = 0; k < 3; k++) to_normal[k] /= length;
    cross(s, to_normal, aside);
    wi[0] = -s[0], wi[1] = -s[1], wi[2] = s[2];
    for (int k = 0; k < 3; k++) wo[k] = cos(radial) * s[k] + sin(radial) * (cos(azimuth) * to_normal[k] + sin(azimuth) * aside[k]);
}

static void test_directions(void)
{
    for (int k = 0; k < 2000; k++) {
        double q[4] = {360 * ff_test_uniform(), 1 + 88 * ff_test_uniform(), 360 * ff_test_uniform(), 179 * ff_test_uniform()};
        double angle[4], wi[3], wo[3], r[4], back[4];
        for (int j = 0; j < 4; j++) r[j] = q[j] * degree;
        by_vectors(r[0], r[1], r[2], r[3], wi, wo);
        ff_axes_angles(FF_AXES_SPECULAR, degree, q, angle);
        const double a[4] = {angle[0] * degree, angle[1] * degree, angle[2] * degree, angle[3] * degree};
        const double w[6] = {sin(a[0]) * cos(a[1]), sin(a[0]) * sin(a[1]), cos(a[0]),
                             sin(a[2]) * cos(a[3]), sin(a[2]) * sin(a[3]), cos(a[2])};
        for (int j = 0; j < 3; j++)
            FF_CHECK(fabs(w[j] - wi[j]) < 1e-12 && fabs(w[3 + j] - wo[j]) < 1e-12, "%g %g %g %g: component %d is %g %g, not %g %g",
                     q[0], q[1], q[2], q[3], j, w[j], w[3 + j], wi[j], wo[j]);
        FF_CHECK(angle[0] == q[1] && angle[1] == -90 - q[0], "incidence %g %g", angle[0], angle[1]);
        ff_axes_point(FF_AXES_SPECULAR, wi, wo, back);
        for (int j = 0; j < 4; j++) {
            double off = back[j] - r[j];
            if (j == 0 || j == 2) off -= 2 * pi * round(off / (2 * pi));
            FF_CHECK(fabs(off) < 1e-9 && back[j] > -pi && back[j] <= pi, "%g %g %g %g: axis %d is %g", q[0], q[1], q[2], q[3], j,
                     back[j] / degree);
        }
    }
    double back[4];
    ff_axes_point(FF_AXES_SPECULAR, (double[]){0, 0, 1}, (double[]){0, -sin(0.25), cos(0.25)}, back);
    FF_CHECK(back[0] == 0 && back[1] == 0 && fabs(back[2]) < 1e-12 && fabs(back[3] - 0.25) < 1e-12,
             "normal incidence: %g %g %g %g, expected rotation 0 and azimuth 0 on the side of the light", back[0], back[1], back[2],
             back[3]);
}

/* ---- reading --------------------------------------------------------------------------------- */

static void test_values(void)
{
    ff_table t;
    if (!check_reads("small", "zemax", "#comment\n" HEAD "Monochrome\nDataBegin\n" BLOCKS "DataEnd\n", &t)) return;
    static const double incidence[2] = {10, 60}, azimuth[2] = {0, 180}, radial[3] = {0, 20, 60};
    FF_CHECK(t.n == 12 && t.n_channels == 1 && t.isotropic == 1 && !t.weight && !t.sigma, "%zu x %zu, isotropic %d", t.n,
             t.n_channels, t.isotropic);
    FF_CHECK(t.axes.kind == FF_AXES_SPECULAR && t.axes.n[0] == 1 && t.axes.n[1] == 2 && t.axes.n[2] == 2 && t.axes.n[3] == 3,
             "axes");
    FF_CHECK(strcmp(t.channels[0].name, "f") == 0 && t.channels[0].scale == 1 && t.quantity == FF_BRDF, "channel");
    for (size_t i = 0; i < t.n; i++) {
        const double inc = incidence[i / 6], az = azimuth[i / 3 % 2], r = radial[i % 3];
        const double theta = inc + (az == 0 ? -r : r); /* in the plane, towards the normal and away */
        double f;
        ff_table_values(&t, 0, i, 1, &f);
        FF_CHECK(f == (i == 11 ? 0 : (double)i + 1), "value %zu is %g", i, f);
        FF_CHECK(fabs(t.angle[2][i] - fabs(theta)) < 1e-12, "sample %zu: theta_o %.17g, expected %g", i, t.angle[2][i], theta);
        FF_CHECK(fabs(cos((t.angle[3][i] - (theta < 0 ? -90 : 90)) * degree) - 1) < 1e-12 || theta == 0, "sample %zu: phi_o %g", i,
                 t.angle[3][i]);
        FF_CHECK(t.angle[0][i] == inc && t.angle[1][i] == -90, "sample %zu: light at %g %g", i, t.angle[0][i], t.angle[1][i]);
        FF_CHECK(t.valid[i] == (theta < 90), "sample %zu: theta_o %g, valid %d", i, theta, t.valid[i]);
    }
    FF_CHECK(t.n_invalid == 1 && t.n_negative == 0 && t.note[0] == '\0', "%zu invalid, note '%s'", t.n_invalid, t.note);
    ff_table_clear(&t);
}

static void variants(void)
{
    static const struct {
        const char *label, *text, *note;
        size_t n, n_channels, n_invalid, n_negative;
    } cases[] = {
        {"capitals, tabs, crlf",
         "SOURCE\tMeasured\r\nsymmetry\tplanesymmetrical\r\nSPECTRALCONTENT\tMONOCHROME\r\nscattertype\tbrdf\r\nsamplerotation\t1\r"
         "\n0\r\n"
         "angleofincidence\t1\r\n30\r\nscatterazimuth\t1\r\n0\r\nscatterradial\t2\r\n0\t5\r\n\r\nmonochrome\r\ndatabegin\r\n"
         "tis\t1e-3\r\n-1e-3\t2\r\ndataend\r\n",
         "", 2, 1, 0, 1},
        {"a byte-order mark, comments between, other order, no content line",
         "\xEF\xBB\xBF# x\nScatterRadial 2\n# y\n0 5\nScatterAzimuth 1\n0\nAngleOfIncidence 1 30\nSampleRotation 1 0\nModel #: 7\n"
         "ScatterType BSDF\nSpectralContent Monochrome\nSymmetry ASymmetrical\nDataBegin\nTIS 0.1\n# z\n1\n2\nDataEnd\n# end\n\n",
         "reflection is assumed", 2, 1, 0, 0},
        {"zeros above the horizon", HEAD "Monochrome\nDataBegin\nTIS 1\n1 2 0\n4 5 0\nTIS 1\n7 8 9\n10 11 0\nDataEnd\n",
         "2 values of 0 above the horizon", 12, 1, 3, 0},
        {"a value below the horizon", HEAD "Monochrome\nDataBegin\nTIS 1\n1 2 3\n4 5 6\nTIS 1\n7 8 9\n10 11 12\nDataEnd\n",
         "1 values other than 0 stand at or below the horizon", 12, 1, 1, 0},
        {"tristimulus",
         "Symmetry Asymmetrical\nSpectralContent XYZ\nScatterType BRDF\nSampleRotation 1\n0\nAngleOfIncidence "
         "1\n30\nScatterAzimuth 1\n0\n"
         "ScatterRadial 2\n0 5\nTristimulusX\nDataBegin\nTIS 1\n1 0\nDataEnd\nTristimulusY\nDataBegin\nTIS 1\n0 0\nDataEnd\n"
         "TristimulusZ\nDataBegin\nTIS 1\n5 0\nDataEnd\n",
         "1 values of 0", 2, 3, 1, 0},
        {"tristimulus with one begin and end",
         "Symmetry Asymmetrical\nSpectralContent XYZ\nScatterType BRDF\nSampleRotation 1\n0\nAngleOfIncidence "
         "1\n30\nScatterAzimuth 1\n0\n"
         "ScatterRadial 2\n0 5\nTristimulusX\nDataBegin\nTIS 1\n1 2\nTristimulusY\nTIS 1\n3 4\nTristimulusZ\nTIS 1\n5 6\nDataEnd",
         "", 2, 3, 0, 0},
    };
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        ff_table t;
        if (!check_reads(cases[k].label, "zemax", cases[k].text, &t)) continue;
        FF_CHECK(t.n == cases[k].n && t.n_channels == cases[k].n_channels, "%s: %zu x %zu", cases[k].label, t.n, t.n_channels);
        FF_CHECK(t.n_invalid == cases[k].n_invalid && t.n_negative == cases[k].n_negative, "%s: %zu invalid, %zu negative",
                 cases[k].label, t.n_invalid, t.n_negative);
        FF_CHECK(cases[k].note[0] ? strstr(t.note, cases[k].note) != NULL : t.note[0] == '\0', "%s: note '%s'", cases[k].label,
                 t.note);
        if (t.n_channels == 3)
            FF_CHECK(strcmp(t.channels[1].name, "Y") == 0 && t.value[4] == 5 && isnan(t.channels[0].wavelength_nm), "%s: channels",
                     cases[k].label);
        ff_table_clear(&t);
    }
    ff_table t;
    if (check_reads(
            "two rotations", "zemax",
            "Symmetry ASymmetrical4D\nSpectralContent Monochrome\nScatterType BRDF\nSampleRotation 2\n0 90\nAngleOfIncidence "
            "2\n10 20\n"
            "ScatterAzimuth 1\n0\nScatterRadial 1\n0\nDataBegin\nTIS 0\n1\nTIS 0\n2\nTIS 0\n3\nTIS 0\n4\nDataEnd\n",
            &t)) {
        FF_CHECK(!t.isotropic && t.n == 4, "isotropic %d", t.isotropic);
        for (size_t i = 0; i < 4; i++)
            FF_CHECK(t.value[i] == (double)i + 1 && t.angle[0][i] == (i % 2 ? 20 : 10) && t.angle[1][i] == (i / 2 ? -180 : -90),
                     "sample %zu: %g at %g %g", i, t.value[i], t.angle[0][i], t.angle[1][i]);
        ff_table_clear(&t);
    }
}

static void refusals(void)
{
#define DATA "Monochrome\nDataBegin\n" BLOCKS "DataEnd\n"
#define AXES "SampleRotation 1\n0\nAngleOfIncidence 1\n30\nScatterAzimuth 1\n0\nScatterRadial 1\n0\nDataBegin\nTIS 1\n1\nDataEnd\n"
#define MONO "Symmetry PlaneSymmetrical\nSpectralContent Monochrome\n"
    check_refuses("zemax", "", FF_ERR_READ, 0, WORDS("end of the file", "expected DataBegin"));
    check_refuses("zemax", HEAD, FF_ERR_READ, 13, WORDS("end of the file", "expected DataBegin"));
    check_refuses("zemax", "SpectralContent Monochrome\nScatterType BRDF\n" AXES, FF_ERR_FORMAT, 11, WORDS("without Symmetry"));
    check_refuses("zemax", "Symmetry PlaneSymmetrical\nScatterType BRDF\n" AXES, FF_ERR_FORMAT, 11,
                  WORDS("without SpectralContent"));
    check_refuses("zemax", MONO AXES, FF_ERR_FORMAT, 11, WORDS("without ScatterType"));
    check_refuses("zemax", MONO "ScatterType BRDF\nDataBegin\n", FF_ERR_FORMAT, 4, WORDS("without SampleRotation"));
    check_refuses("zemax", MONO "ScatterType BTDF\n" AXES, FF_ERR_UNSUPPORTED, 12,
                  WORDS("BTDF, transmission", "only reflection is read"));
    check_refuses("zemax", MONO "ScatterType BXDF\n" AXES, FF_ERR_FORMAT, 3, WORDS("'BXDF'", "BRDF, BTDF or BSDF"));
    check_refuses("zemax", "Symmetry Round\n", FF_ERR_FORMAT, 1,
                  WORDS("'Round'", "PlaneSymmetrical, Asymmetrical or Asymmetrical4D"));
    check_refuses("zemax", "SpectralContent RGB\n", FF_ERR_FORMAT, 1, WORDS("'RGB'", "Monochrome or XYZ"));
    check_refuses("zemax", "SpectralContent", FF_ERR_READ, 1, WORDS("end of the file after SpectralContent"));
    check_refuses("zemax", "Symmetry Asymmetrical\nSymmetry Asymmetrical\n", FF_ERR_FORMAT, 2, WORDS("Symmetry twice"));
    check_refuses("zemax", "ScatterRadial 1\n0\nScatterRadial 1\n0\n", FF_ERR_FORMAT, 3, WORDS("ScatterRadial twice"));
    check_refuses("zemax", "ScatterRadial many\n", FF_ERR_FORMAT, 1, WORDS("'many'", "whole number from 1 to 1048576"));
    check_refuses("zemax", "ScatterRadial 0\n", FF_ERR_FORMAT, 1, WORDS("'0'", "whole number from 1"));
    check_refuses("zemax", "ScatterRadial -3\n", FF_ERR_FORMAT, 1, WORDS("'-3'", "whole number from 1"));
    check_refuses("zemax", "ScatterRadial 4000000000\n1", FF_ERR_FORMAT, 1, WORDS("'4000000000'", "whole number from 1"));
    check_refuses("zemax", "ScatterRadial 1000000\n0 1 2\n", FF_ERR_READ, 2, WORDS("after 3 angles", "expected 1000000"));
    check_refuses("zemax", "ScatterRadial 3\n0 5\nScatterAzimuth 1\n", FF_ERR_DATA, 3, WORDS("'ScatterAzimuth'", "angle 3 of 3"));
    check_refuses("zemax", "ScatterRadial 2\n0 5 10\n", FF_ERR_FORMAT, 2,
                  WORDS("'10'", "expected a keyword", "more angles than their count"));
    check_refuses("zemax", "ScatterRadial 2\n0 nan\n", FF_ERR_DATA, 2, WORDS("'nan'", "angle 2 of 2"));
    check_refuses("zemax", "ScatterRadial 2\n0\n200\n", FF_ERR_DATA, 3, WORDS("found 200", "from 0 to 180"));
    check_refuses("zemax", "ScatterRadial 2\n5 5\n", FF_ERR_DATA, 2, WORDS("found 5 after 5", "ascending"));
    check_refuses("zemax", "AngleOfIncidence 1\n95\n", FF_ERR_DATA, 2, WORDS("found 95", "from 0 to 90"));
    check_refuses("zemax", "SampleRotation 1\n-400\n", FF_ERR_DATA, 2, WORDS("found -400", "from -360 to 360"));
    check_refuses("zemax", HEAD "Monochrome\n" BLOCKS, FF_ERR_FORMAT, 15, WORDS("'TIS'", "expected DataBegin"));
    check_refuses("zemax", HEAD "Monochrome\nDataBegin\n1 2 3\n", FF_ERR_FORMAT, 16, WORDS("'1'", "expected TIS"));
    check_refuses("zemax", HEAD "Monochrome\nDataBegin\nTIS x\n", FF_ERR_DATA, 16, WORDS("'x'", "TIS"));
    check_refuses("zemax", HEAD "Monochrome\nDataBegin\nTIS 0.1\n1 2\n3 4 5\nTIS 0.2\n", FF_ERR_DATA, 19,
                  WORDS("'TIS'", "a row of 3 values"));
    check_refuses("zemax", HEAD "Monochrome\nDataBegin\nTIS 0.1\n1 2 3\n4 5 6 7\n", FF_ERR_FORMAT, 18,
                  WORDS("'7'", "expected TIS"));
    check_refuses("zemax", HEAD "Monochrome\nDataBegin\nTIS 0.1\n1 2 3\n4 5 inf\n", FF_ERR_DATA, 18,
                  WORDS("'inf'", "a row of 3 values"));
    check_refuses("zemax", HEAD "Monochrome\nDataBegin\nTIS 0.1\n1 2 3\n4 5 6\nDataEnd\n", FF_ERR_FORMAT, 19,
                  WORDS("'DataEnd'", "expected TIS"));
    check_refuses("zemax", HEAD "Monochrome\nDataBegin\n" BLOCKS, FF_ERR_READ, 21, WORDS("end of the file", "DataEnd"));
    check_refuses("zemax", HEAD DATA "more\n", FF_ERR_FORMAT, 23, WORDS("'more'", "the end of the file after DataEnd"));
    check_refuses("zemax", HEAD "TristimulusX\nDataBegin\n" BLOCKS "DataEnd\n", FF_ERR_FORMAT, 14,
                  WORDS("'TristimulusX'", "DataBegin"));
    check_refuses("zemax", HEAD "Monochrome\nDataBegin\nTIS 1\n0 0 0\n0 0 0\nTIS 1\n0 0 0\n0 0 0\nDataEnd\n", FF_ERR_DATA, 0,
                  WORDS("all of them marked as not measured"));
    char nul[] = HEAD DATA;
    nul[sizeof nul / 2] = '\0';
    const char *path = ff_test_path("nul.bsdf");
    ff_test_write(path, nul, sizeof nul - 1);
    check_fails("nul", path, "zemax", FF_ERR_FORMAT, 8, WORDS("NUL byte"));
}

static void test_prefixes(void)
{
    static const char text[] = "# c\n" HEAD DATA;
    const char *path = ff_test_path("prefix.bsdf");
    size_t whole = 0;
    for (size_t n = 0; n < sizeof text; n++) {
        ff_test_write(path, text, n);
        ff_table t;
        ff_error err = {0};
        if (ff_table_read_into(path, n % 2 ? "zemax" : NULL, &t, &err) == FF_OK) {
            whole++;
            FF_CHECK(t.n == 12 && n >= sizeof text - 2, "prefix %zu was read", n);
            ff_table_clear(&t);
        } else {
            FF_CHECK(strcmp(err.path, path) == 0 && err.message[0], "prefix %zu: no message", n);
        }
    }
    FF_CHECK(whole == 2, "%zu prefixes were read", whole); /* with and without the last end of line */
}

/* A file in which one bit is wrong is refused or gives a table that holds together. */
static void bit_flips(void)
{
    static const char text[] = HEAD DATA;
    const char *path = ff_test_path("flip.bsdf");
    char copy[sizeof text];
    for (size_t i = 0; i < 8 * (sizeof text - 1); i++) {
        memcpy(copy, text, sizeof text);
        copy[i / 8] = (char)(copy[i / 8] ^ 1 << i % 8);
        ff_test_write(path, copy, sizeof text - 1);
        ff_table t;
        ff_error err = {0};
        if (ff_table_read_into(path, "zemax", &t, &err) != FF_OK) continue;
        FF_CHECK(t.n == t.axes.n[0] * t.axes.n[1] * t.axes.n[2] * t.axes.n[3] && ff_table_check(&t, path, &err) == FF_OK,
                 "bit %zu: %s", i, err.message);
        ff_table_clear(&t);
    }
}

/* ---- cells ----------------------------------------------------------------------------------- */

/* A table of a layout with f = 1/pi where it is above the horizon. */
static int lambert(int isotropic, const char *grid, ff_table *t)
{
    ff_table data;
    ff_error err = {0};
    if (!FF_CHECK(ff_table_init(3, 1, NULL, 0, 0, &data, &err) == FF_OK, "%s", err.message)) return 0;
    for (size_t i = 0; i < 3; i++) data.angle[0][i] = 0.1 + 0.5 * (double)i, data.angle[1][i] = (double)i;
    data.isotropic = isotropic;
    ff_status status = ff_format_find("zemax")->layout(&data, grid, t, &err);
    ff_table_clear(&data);
    if (!FF_CHECK(status == FF_OK, "%s", err.message)) return 0;
    for (size_t i = 0; i < t->n; i++) {
        t->value[i] = 1 / pi;
        t->valid[i] = t->angle[2][i] < 90 - 1e-6;
    }
    return 1;
}

static void test_cells(void)
{
    static const struct {
        int isotropic;
        const char *grid;
        double radial_end; /* of the last cell */
        double sphere;     /* of all incidences and rotations */
    } cases[] = {{1, NULL, 175, 4 * pi * pi},
                 {0, "rotation:30", 175, 4 * pi * pi},
                 {1, "azimuth:0/20/40/60/80/100/120/140/160/180,radial:0/10/30,incidence:0/45", 40, 4 * pi * pi},
                 {0, "rotation:0/45/90,azimuth:0/40/80/120/160/200/240/280/320,radial:2", 175, pi * pi}};
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        ff_table t;
        if (!lambert(cases[k].isotropic, cases[k].grid, &t)) continue;
        double sum = 0;
        for (size_t i = 0; i < t.n && t.weight; i++) sum += t.weight[i];
        const double expected = cases[k].sphere * (1 - cos(cases[k].radial_end * degree));
        FF_CHECK(t.weight && fabs(sum / expected - 1) < 1e-12, "case %zu: the cells are %.12g sr^2, expected %.12g", k, sum,
                 expected);
        ff_table_clear(&t);
    }
    /* TIS of a white Lambert surface is 1 */
    ff_table t;
    if (!lambert(1, "incidence:0/30/60,azimuth:5,radial:2", &t)) return;
    for (size_t i = 0; i < t.n; i++)
        if (!t.valid[i]) t.value[i] = 77; /* what nobody measured, and no file held, is written as 0 */
    const char *path = ff_test_path("white.zemax.bsdf");
    ff_error err = {0};
    FF_CHECK(ff_table_write(path, NULL, &t, &err) == FF_OK, "%s", err.message);
    size_t n;
    char *text = ff_test_slurp(path, &n), *at = text;
    int blocks = 0;
    for (; (at = strstr(at, "TIS\t")); blocks++) {
        const double tis = strtod(at += 4, NULL);
        FF_CHECK(fabs(tis - 1) < 0.01, "TIS of white is %g", tis);
    }
    FF_CHECK(blocks == 3 && strstr(text, "Symmetry\tPlaneSymmetrical\n"), "%d blocks", blocks);
    FF_CHECK(!strstr(text, "\t77"), "a number below the horizon");
    free(text);
    ff_table_clear(&t);
}

/* ---- writing --------------------------------------------------------------------------------- */

static char *written(const ff_table *t, const char *name)
{
    const char *path = ff_test_path(name);
    ff_error err = {0};
    size_t n;
    if (!FF_CHECK(ff_table_write(path, "zemax", t, &err) == FF_OK, "%s: %s", name, err.message)) return calloc(1, 1);
    return ff_test_slurp(path, &n);
}

static void round_trip(void)
{
    ff_table t, back;
    ff_error err = {0};
    if (!check_reads("source", "zemax",
                     HEAD "Monochrome\nDataBegin\nTIS 0.1\n0.1 -2e-3 0\n1e300 5 6\nTIS 0.2\n7 8 9\n10 11 12.5\nDataEnd\n", &t))
        return;
    for (size_t i = 0; i < t.n; i++)
        if (t.valid[i] && i != 1) t.value[i] = ldexp(1 + ff_test_uniform(), (int)(ff_test_random() % 60) - 40);
    char *text = written(&t, "round.zemax.bsdf");
    FF_CHECK(strstr(text, "TIS\t0.1\n") && strstr(text, "TIS\t0.2\n") && strstr(text, "\t12.5\nDataEnd\n"),
             "TIS and the number below the horizon: %s", text);
    free(text);
    const char *path = ff_test_path("round.zemax.bsdf");
    if (FF_CHECK(ff_table_read_into(path, NULL, &back, &err) == FF_OK, "%s", err.message)) {
        check_same_tables("round trip", &t, &back);
        check_same_angles("round trip", &t, &back);
        FF_CHECK(check_same_bits(t.value, back.value, t.n), "stored values");
        for (int k = 0; k < 4; k++) FF_CHECK(check_same_bits(t.axes.node[k], back.axes.node[k], t.axes.n[k]), "axis %d", k);
        ff_table_clear(&back);
    }
    ff_read_options o;
    ff_read_options_init(&o);
    o.scale = 2;
    if (FF_CHECK(ff_table_read_with_into(path, &o, &back, &err) == FF_OK, "%s", err.message)) {
        text = written(&back, "scaled.zemax.bsdf");
        FF_CHECK(strstr(text, "TIS\t0.2\n") && strstr(text, "TIS\t0.4\n") && strstr(text, "\t25\nDataEnd\n"), "scaled: %s", text);
        free(text);
        ff_table_clear(&back);
    }
    /* measured once more below the horizon, or not at all: as 0 */
    t.valid[0] = 0;
    text = written(&t, "less.zemax.bsdf");
    FF_CHECK(strstr(text, "TIS\t0.1\n0\t-0.002\t"), "unmeasured: %s", text);
    free(text);
    ff_table_clear(&t);
    FF_CHECK(check_leftovers() == 0, "%d unfinished files", check_leftovers());
}

static void test_tristimulus(void)
{
    ff_table t, back;
    ff_error err = {0};
    if (!lambert(0, "rotation:0/90,azimuth:90,radial:0/30", &t)) return;
    ff_table_clear(&t);
    const size_t n[4] = {2, 1, 3, 2};
    static const double rotation[] = {0, 0.5}, incidence[] = {0.25}, azimuth[] = {0, 1, 2}, radial[] = {0, 0.5};
    const double *const node[4] = {rotation, incidence, azimuth, radial};
    if (!FF_CHECK(ff_table_init_axes(FF_AXES_SPECULAR, n, node, 1, 3, 0, &t, &err) == FF_OK, "%s", err.message)) return;
    for (size_t i = 0; i < 3 * t.n; i++) t.value[i] = ff_test_uniform() + 0.5;
    ff_status status = ff_table_write(ff_test_path("rgb.zemax.bsdf"), NULL, &t, &err);
    FF_CHECK(status == FF_ERR_UNSUPPORTED && strstr(err.message, "X, Y and Z") && strstr(err.message, "one file per channel"),
             "%d %s", status, err.message);
    for (int c = 0; c < 3; c++) snprintf(t.channels[c].name, FF_CHANNEL_NAME, "%c", "XYZ"[c]);
    const char *path = ff_test_path("xyz.zemax.bsdf");
    FF_CHECK(ff_table_write(path, NULL, &t, &err) == FF_OK, "%s", err.message);
    if (FF_CHECK(ff_table_read_into(path, NULL, &back, &err) == FF_OK, "%s", err.message)) {
        check_same_tables("tristimulus", &t, &back);
        FF_CHECK(fabs(back.axes.node[0][1] - 0.5 / degree) < 1e-12 && back.radians_per_unit == degree, "radians became degrees");
        ff_table_clear(&back);
    }
    ff_table_clear(&t);
}

static void refuses_writing(const char *label, const ff_table *t, const char *word)
{
    ff_error err = {0};
    ff_status status = ff_table_write(ff_test_path("no.zemax.bsdf"), "zemax", t, &err);
    FF_CHECK(status == FF_ERR_UNSUPPORTED && strstr(err.message, word), "%s: %d %s", label, status, err.message);
}

static void unwritable(void)
{
    ff_table t;
    ff_error err = {0};
    if (!FF_CHECK(ff_table_init(2, 1, NULL, 0, 0, &t, &err) == FF_OK, "%s", err.message)) return;
    refuses_writing("scattered", &t, "resample");
    ff_table_clear(&t);
    if (!lambert(1, NULL, &t)) return;
    t.sigma = calloc(t.n, sizeof *t.sigma);
    for (size_t i = 0; i < t.n; i++) t.sigma[i] = 1;
    refuses_writing("sigma", &t, "standard deviations");
    free(t.sigma);
    t.sigma = NULL;
    t.value[0] = NAN;
    ff_status status = ff_table_write(ff_test_path("no.zemax.bsdf"), "zemax", &t, &err);
    FF_CHECK(status == FF_ERR_DATA && strstr(err.message, "sample 0"), "%d %s", status, err.message);
    ff_table_clear(&t);
    FF_CHECK(check_leftovers() == 0, "%d unfinished files", check_leftovers());
    FF_CHECK(ff_format_for_writing("a.zemax.bsdf") == ff_format_find("zemax"), "extension");
}

/* ---- layout ---------------------------------------------------------------------------------- */

static void refuses_grid(const ff_table *t, const char *grid, ff_status code, const char *word)
{
    ff_table out;
    ff_error err = {0};
    ff_status status = ff_format_find("zemax")->layout(t, grid, &out, &err);
    FF_CHECK(status == code && strstr(err.message, word), "grid '%s': %d %s", grid, status, err.message);
    if (status == FF_OK) ff_table_clear(&out);
}

static void test_layout(void)
{
    const ff_format *f = ff_format_find("zemax");
    ff_table data, t;
    ff_error err = {0};
    if (!FF_CHECK(ff_table_init(400, 1, NULL, 0, 0, &data, &err) == FF_OK, "%s", err.message)) return;
    data.radians_per_unit = degree;
    data.isotropic = 1;
    strcpy(data.channels[0].name, "650nm");
    for (size_t i = 0; i < data.n; i++) data.angle[0][i] = 5 + 20 * (double)(i % 4), data.angle[1][i] = 0;
    data.angle[0][7] = 33, data.valid[7] = 0; /* what was not measured has no say */
    if (FF_CHECK(f->layout(&data, NULL, &t, &err) == FF_OK, "%s", err.message)) {
        FF_CHECK(t.axes.n[0] == 1 && t.axes.n[1] == 4 && t.axes.n[2] == 19 && t.isotropic == 1 &&
                     strcmp(t.channels[0].name, "650nm") == 0,
                 "%zu x %zu x %zu", t.axes.n[0], t.axes.n[1], t.axes.n[2]);
        for (size_t k = 0; k < 4; k++) FF_CHECK(t.axes.node[1][k] == 5 + 20 * (double)k, "incidence %g", t.axes.node[1][k]);
        FF_CHECK(t.axes.node[2][18] == 180 && t.axes.node[3][0] == 0 && t.axes.node[3][1] == 0.5, "azimuth and radial");
        FF_CHECK(t.axes.node[3][t.axes.n[3] - 1] == 170 && t.n_invalid == 0 && t.valid[t.n - 1], "the last radial angle");
        ff_table again;
        if (FF_CHECK(f->layout(&t, NULL, &again, &err) == FF_OK, "%s", err.message)) {
            check_same_angles("a layout's own", &t, &again);
            ff_table_clear(&again);
        }
        ff_table_clear(&t);
    }
    if (FF_CHECK(f->layout(&data, "radial:0/2/5,azimuth:45,incidence:30", &t, &err) == FF_OK, "%s", err.message)) {
        FF_CHECK(t.axes.n[3] == 3 && t.axes.n[2] == 5 && t.axes.n[1] == 3 && t.axes.node[1][2] == 60 && t.axes.node[3][2] == 5,
                 "own grid");
        ff_table_clear(&t);
    }
    for (size_t i = 0; i < data.n; i++) data.angle[0][i] = 0.2 * (double)i, data.angle[1][i] = 90 * (double)(i % 4) - 90;
    data.isotropic = 0;
    if (FF_CHECK(f->layout(&data, NULL, &t, &err) == FF_OK, "%s", err.message)) {
        FF_CHECK(t.axes.n[0] == 5 && t.axes.node[0][1] == 90 && t.axes.node[0][4] == 360 && t.isotropic == 0, "%zu rotations",
                 t.axes.n[0]);
        FF_CHECK(t.axes.n[1] == 16 && t.axes.node[1][15] == 75 && t.axes.n[2] == 37, "%zu incidences, %zu azimuths", t.axes.n[1],
                 t.axes.n[2]);
        ff_table_clear(&t);
    }
    for (size_t i = 0; i < data.n; i++) data.angle[0][i] = i % 2 ? 20 : -20, data.angle[1][i] = -90;
    if (FF_CHECK(f->layout(&data, NULL, &t, &err) == FF_OK, "%s", err.message)) {
        FF_CHECK(t.axes.n[1] == 1 && t.axes.node[1][0] == 20 && t.axes.n[0] == 3 && t.axes.node[0][1] == 180, "a negative theta_i");
        ff_table_clear(&t);
    }
    refuses_grid(&data, "", FF_ERR_SYNTAX, "azimuth:10");
    refuses_grid(&data, "angle:10", FF_ERR_SYNTAX, "'angle:10'");
    refuses_grid(&data, "azimuth", FF_ERR_SYNTAX, "'azimuth'");
    refuses_grid(&data, "azimuth:", FF_ERR_SYNTAX, "'azimuth:'");
    refuses_grid(&data, "azimuth:10,", FF_ERR_SYNTAX, "found ''");
    refuses_grid(&data, "azimuth:10,azimuth:20", FF_ERR_SYNTAX, "'azimuth:20'");
    refuses_grid(&data, "azimuth:1x", FF_ERR_SYNTAX, "'azimuth:1x'");
    refuses_grid(&data, "radial:0/5/5", FF_ERR_RANGE, "ascending");
    refuses_grid(&data, "radial:0/190", FF_ERR_RANGE, "190");
    refuses_grid(&data, "incidence:0/90", FF_ERR_RANGE, "89.9");
    refuses_grid(&data, "azimuth:-5", FF_ERR_RANGE, "-5");
    refuses_grid(&data, "azimuth:0.001", FF_ERR_RANGE, "0.01");
    refuses_grid(&data, "azimuth:0.01,radial:0.01,incidence:0.01", FF_ERR_RANGE, "larger steps");
    data.isotropic = 1;
    refuses_grid(&data, "azimuth:0/90/270", FF_ERR_RANGE, "270");
    ff_table_clear(&data);
    if (!FF_CHECK(ff_table_init(2, 2, NULL, 0, 0, &data, &err) == FF_OK, "%s", err.message)) return;
    refuses_grid(&data, NULL, FF_ERR_UNSUPPORTED, "2 channels");
    ff_table_clear(&data);
}

/* ---- measured files -------------------------------------------------------------------------- */

static const char *data_dir(void)
{
    const char *set = getenv("FACETFIT_DATA");
    return set ? set : FF_SOURCE_DIR "/../shared/data";
}

/* The numbers after DataBegin, read with the C library as a second source: their count and sum without those of TIS. */
static size_t second_source(const char *path, double *sum, double *last)
{
    size_t n, count = 0;
    char *text = ff_test_slurp(path, &n), *at = strstr(text, "DataBegin");
    *sum = *last = 0;
    for (char *word = at ? strtok(at + 9, " \t\r\n") : NULL; word; word = strtok(NULL, " \t\r\n")) {
        if (strcmp(word, "TIS") == 0) {
            strtok(NULL, " \t\r\n");
        } else if (strcmp(word, "DataEnd") != 0) {
            *last = strtod(word, NULL);
            *sum += *last;
            count++;
        }
    }
    free(text);
    return count;
}

/* Everything stored below the horizon is 0: with azimuth 0 away from the normal it would not be. */
static void check_horizon(const char *name, const ff_table *t)
{
    size_t below = 0, other_way = 0;
    for (size_t i = 0; i < t->n; i++) {
        const double *const *node = (const double *const *)t->axes.node;
        const size_t *n = t->axes.n;
        const double inc = node[1][i / n[3] / n[2] % n[1]] * degree, az = node[2][i / n[3] % n[2]] * degree,
                     r = node[3][i % n[3]] * degree;
        const double z = cos(inc) * cos(r) + sin(inc) * sin(r) * cos(az), other = cos(inc) * cos(r) - sin(inc) * sin(r) * cos(az);
        below += z < -1e-9 && t->value[i] != 0;
        other_way += other < -1e-9 && t->value[i] != 0;
        FF_CHECK((t->angle[2][i] > 90) == (z < 0) || fabs(z) < 1e-9, "%s: sample %zu: theta_o %g, z %g", name, i, t->angle[2][i],
                 z);
    }
    FF_CHECK(below == 0 && other_way > t->n / 50, "%s: %zu values below the horizon, %zu if azimuth 0 were away from the normal",
             name, below, other_way);
}

static void test_measured(const char *name, size_t n, size_t n_invalid, int isotropic, int has_weights)
{
    char path[700];
    snprintf(path, sizeof path, "%s/zemax/%s", data_dir(), name);
    ff_table t, back;
    ff_error err = {0};
    double expected, expected_last, sum = 0;
    if (!FF_CHECK(ff_table_read_into(path, NULL, &t, &err) == FF_OK, "%s:%ld: %s", path, err.line, err.message)) return;
    const size_t count = second_source(path, &expected, &expected_last);
    for (size_t i = 0; i < t.n; i++) sum += t.value[i];
    FF_CHECK(t.n == n && t.n == count && t.n_channels == 1 && strcmp(t.format, "zemax") == 0, "%s: %zu samples, %zu numbers", name,
             t.n, count);
    FF_CHECK(sum == expected && t.value[t.n - 1] == expected_last, "%s: sum %.17g, expected %.17g", name, sum, expected);
    FF_CHECK(t.n_invalid == n_invalid && t.isotropic == isotropic && !t.weight == !has_weights,
             "%s: %zu invalid, isotropic %d, weights %d", name, t.n_invalid, t.isotropic, t.weight != NULL);
    check_horizon(name, &t);
    const char *copy = ff_test_path("copy.zemax.bsdf");
    FF_CHECK(ff_table_write(copy, NULL, &t, &err) == FF_OK, "%s: %s", name, err.message);
    if (FF_CHECK(ff_table_read_into(copy, NULL, &back, &err) == FF_OK, "%s: %s", name, err.message)) {
        check_same_tables(name, &t, &back);
        check_same_angles(name, &t, &back);
        FF_CHECK(check_same_bits(t.value, back.value, t.n) && strcmp(t.note, back.note) == 0, "%s: the copy differs", name);
        ff_table_clear(&back);
    }
    ff_table_clear(&t);
}

/* The same coating in absolute angles (FRED text: incidence, then theta, phi, value with the mirror direction at phi 0): samples in
 * the plane of incidence agree with those at the same angles. */
static void test_against_fred(void)
{
    char path[700], line[256];
    ff_table t;
    ff_error err = {0};
    snprintf(path, sizeof path, "%s/zemax/AnoBlackEC1onAlum.bsdf", data_dir());
    if (!FF_CHECK(ff_table_read_into(path, NULL, &t, &err) == FF_OK, "%s", err.message)) return;
    snprintf(path, sizeof path, "%s/fred/AnoBlackEC1onAlum.txt", data_dir());
    FILE *f = fopen(path, "r");
    double incidence = -1, squares = 0;
    int pairs = 0;
    while (f && fgets(line, sizeof line, f)) {
        double theta, phi, value;
        const int n = sscanf(line, "%lf %lf %lf", &theta, &phi, &value);
        if (n == 2) incidence = theta;
        if (n != 3 || (phi != 0 && phi != 180)) continue;
        for (size_t i = 0; i < t.n; i++) {
            const double side = cos((t.angle[3][i] - 90 - phi) * degree);
            if (t.angle[0][i] != incidence || !t.valid[i] || fabs(t.angle[2][i] - theta) > 1e-6) continue;
            if (theta > 0 && side < 1 - 1e-9) continue;
            const double log_ratio = log(t.value[i] / value);
            squares += log_ratio * log_ratio;
            pairs++;
            break;
        }
    }
    if (f) fclose(f);
    FF_CHECK(pairs > 40 && sqrt(squares / pairs) < 0.1, "%d pairs in the plane of incidence differ by %.3g rms", pairs,
             sqrt(squares / pairs));
    ff_table_clear(&t);
}

static void byte_order_marks(void)
{
    check_byte_order_mark("zemax", HEAD "Monochrome\nDataBegin\n" BLOCKS "DataEnd\n");
}

static void measured(void)
{
    char path[700];
    snprintf(path, sizeof path, "%s/zemax/IMX455.bsdf", data_dir());
    if (access(path, R_OK) != 0) FF_SKIP("there is no %s", path);
    test_measured("AnoBlackEC1onAlum.bsdf", 912, 193, 1, 1);
    test_measured("IMX455.bsdf", 114996, 58793, 0, 1);
    test_measured("ValidationTest_of_BRDF_via_MagicBlack.bsdf", 912, 193, 1, 1);
    test_measured("aeroglaze_legacy.bsdf", 1288, 640, 1, 0);
    test_against_fred();
}

FF_TEST_MAIN(FF_TEST(test_directions), FF_TEST(test_values), FF_TEST(variants), FF_TEST(refusals), FF_TEST(test_prefixes),
             FF_TEST(byte_order_marks), FF_TEST(bit_flips), FF_TEST(test_cells), FF_TEST(round_trip), FF_TEST(test_tristimulus),
             FF_TEST(unwritable), FF_TEST(test_layout), FF_TEST(measured))
