/* WINDOW and Radiance XML, made here: matrices over all bases, trees of known functions, and files that are wrong or hostile. */
#include "square.h"
#include "check_table.h"
#include <time.h>

static const double pi = 3.14159265358979323846;

/* ---- making files ---------------------------------------------------------------------------- */

typedef struct text {
    char *at;
    size_t n, room;
} text;

__attribute__((format(printf, 2, 3))) static void add(text *t, const char *fmt, ...)
{
    char piece[4096];
    va_list args;
    va_start(args, fmt);
    const int n = vsnprintf(piece, sizeof piece, fmt, args);
    va_end(args);
    if (n < 0 || (size_t)n >= sizeof piece) exit(1);
    if (t->n + (size_t)n + 1 > t->room) {
        t->room = 2 * (t->room + (size_t)n + 1);
        t->at = realloc(t->at, t->room);
        if (!t->at) exit(1);
    }
    memcpy(t->at + t->n, piece, (size_t)n + 1);
    t->n += (size_t)n;
}

static void start(text *t, const char *structure)
{
    t->n = 0;
    add(t,
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<!-- made by a test -->\n<WindowElement xmlns=\"http://windows.lbl.gov\">\n"
        "<WindowElementType>System</WindowElementType>\n<Optical>\n<Layer>\n<Material><Name>A &amp; B</Name></Material>\n"
        "<DataDefinition>\n<IncidentDataStructure>%s</IncidentDataStructure>\n",
        structure);
}

typedef struct ring {
    double lower, upper;
    int n;
} ring;

static void add_basis(text *t, const char *name, const ring *rings)
{
    add(t, "<AngleBasis>\n<AngleBasisName>%s</AngleBasisName>\n", name);
    for (; rings->n; rings++)
        add(t,
            "<AngleBasisBlock><nPhis>%d</nPhis><ThetaBounds><LowerTheta>%g</LowerTheta><UpperTheta>%g</UpperTheta></ThetaBounds>"
            "</AngleBasisBlock>\n",
            rings->n, rings->lower, rings->upper);
    add(t, "</AngleBasis>\n");
}

static void begin_data(text *t, const char *wavelength, const char *direction, const char *column, const char *row)
{
    add(t,
        "<WavelengthData><LayerNumber>System</LayerNumber>\n<Wavelength unit=\"Integral\">%s</Wavelength>\n<WavelengthDataBlock>\n"
        "<WavelengthDataDirection>%s</WavelengthDataDirection>\n",
        wavelength, direction);
    if (row)
        add(t, "<ColumnAngleBasis>%s</ColumnAngleBasis>\n<RowAngleBasis>%s</RowAngleBasis>\n", column, row);
    else
        add(t, "<AngleBasis>%s</AngleBasis>\n", column);
    add(t, "<ScatteringDataType>BTDF</ScatteringDataType>\n<ScatteringData>\n");
}

static void end_data(text *t)
{
    add(t, "</ScatteringData>\n</WavelengthDataBlock></WavelengthData>\n");
}

static void finish(text *t)
{
    add(t, "</Layer>\n</Optical>\n</WindowElement>\n");
}

/* One block of n values v0, v0 + 1, ... */
static void add_counted(text *t, const char *wavelength, const char *direction, const char *basis, int n, double v0)
{
    begin_data(t, wavelength, direction, basis, basis);
    for (int k = 0; k < n; k++) add(t, "%g\n", v0 + k);
    end_data(t);
}

static const char *put(const text *t)
{
    const char *path = ff_test_path("t.xml");
    ff_test_write(path, t->at, t->n);
    return path;
}

static int reads_part(const char *label, const text *t, const char *part, ff_table *table)
{
    char all[2048];
    ff_error err = {0};
    ff_read_options o;
    ff_read_options_init(&o);
    o.part = part;
    const ff_status status = ff_table_read_with_into(put(t), &o, table, &err);
    ff_error_format(&err, all, sizeof all);
    if (!FF_CHECK(status == FF_OK, "%s: %s", label, all)) return 0;
    return FF_CHECK(strcmp(table->format, "window") == 0, "%s: read as %s", label, table->format);
}

static int reads(const char *label, const text *t, ff_table *table)
{
    return reads_part(label, t, NULL, table);
}

static void fails_part(const char *label, const text *t, const char *part, ff_status code, const char *const *words)
{
    char all[2048];
    ff_error err = {0};
    ff_table table;
    ff_read_options o;
    ff_read_options_init(&o);
    o.part = part;
    o.format = "window";
    const ff_status status = ff_table_read_with_into(put(t), &o, &table, &err);
    ff_error_format(&err, all, sizeof all);
    FF_CHECK(status == code, "%s: status %d, expected %d: %s", label, status, code, all);
    for (; *words; words++) FF_CHECK(strstr(all, *words), "%s: no '%s' in: %s", label, *words, all);
    if (status == FF_OK) ff_table_clear(&table);
}

/* ---- directions, computed independently ------------------------------------------------------ */

static const ring full[] = {{0, 5, 1},    {5, 15, 8},   {15, 25, 16}, {25, 35, 20}, {35, 45, 24},
                            {45, 55, 24}, {55, 65, 24}, {65, 75, 16}, {75, 90, 12}, {0, 0, 0}};
static const ring half[] = {{0, 6.5, 1},      {6.5, 19.5, 8},   {19.5, 32.5, 12}, {32.5, 45.5, 16},
                            {45.5, 58.5, 20}, {58.5, 71.5, 12}, {71.5, 90, 8},    {0, 0, 0}};
static const ring quarter[] = {{0, 9, 1}, {9, 27, 8}, {27, 45, 12}, {45, 63, 12}, {63, 90, 8}, {0, 0, 0}};
static const ring coarse[] = {{0, 30, 1}, {30, 60, 2}, {60, 90, 3}, {0, 0, 0}};

static int count(const ring *r)
{
    int n = 0;
    for (; r->n; r++) n += r->n;
    return n;
}

/* Unit vector along the exit patch k, in the sheet's x and y; its solid angle. */
static double patch(const ring *r, int k, double v[3])
{
    double lower = r->lower;
    for (; k >= r->n; r++) k -= r->n;
    lower = r->lower;
    const double theta = r->n == 1 ? 0 : (lower + r->upper) / 2 * pi / 180, phi = 2 * pi * k / r->n;
    v[0] = sin(theta) * cos(phi);
    v[1] = sin(theta) * sin(phi);
    v[2] = cos(theta);
    return 2 * pi / r->n * (cos(lower * pi / 180) - cos(r->upper * pi / 180));
}

/* wi and wo of sample s. */
static void directions(const ff_table *t, size_t s, double wi[3], double wo[3])
{
    double *const planes[6] = {&wi[0], &wi[1], &wi[2], &wo[0], &wo[1], &wo[2]};
    ff_table_directions(t, s, 1, planes);
}

static int same(const double a[3], double x, double y, double z)
{
    return fabs(a[0] - x) < 1e-12 && fabs(a[1] - y) < 1e-12 && fabs(a[2] - z) < 1e-12;
}

/* Every value of the matrix stands at the directions that it has in Radiance's frame, turned to the face. */
static void check_matrix(const char *label, const ff_table *t, const ring *in, const ring *out, int rows, int front,
                         const double *value)
{
    const int ni = count(in), no = count(out);
    const double x = front ? -1 : 1; /* the sheet seen from the front */
    if (!FF_CHECK(t->n == (size_t)(ni * no) && !t->isotropic && t->weight, "%s: %zu samples", label, t->n)) return;
    double sum = 0;
    for (int i = 0; i < ni; i++)
        for (int o = 0; o < no; o++) {
            const size_t s = (size_t)(rows ? i * no + o : o * ni + i);
            double vi[3], vo[3], wi[3], wo[3];
            const double omega = patch(in, i, vi) * patch(out, o, vo);
            directions(t, s, wi, wo);
            if (!FF_CHECK(same(wi, -x * vi[0], -vi[1], vi[2]) && same(wo, x * vo[0], vo[1], vo[2]), "%s: directions of %d, %d",
                          label, i, o))
                return;
            if (!FF_CHECK(t->value[s] == value[s], "%s: value %zu is %g, expected %g", label, s, t->value[s], value[s])) return;
            FF_CHECK(fabs(t->weight[s] - omega) < 1e-12 * omega, "%s: weight %zu: %g %g", label, s, t->weight[s], omega);
            sum += t->weight[s];
        }
    FF_CHECK(fabs(sum - 4 * pi * pi) < 1e-9, "%s: weights add to %.12g, expected (2 pi)^2", label, sum);
}

static void test_bases(void)
{
    static const struct {
        const char *label, *column, *row, *structure, *direction, *separator;
        const ring *in, *out;
        int defined; /* in the file */
    } cases[] = {
        {"full", "LBNL/Klems Full", "LBNL/Klems Full", "Columns", "Reflection Front", ", ", full, full, 1},
        {"full, unstated", "lbnl/klems full", "LBNL/Klems Full", "columns", "reflection back", "\t", full, full, 0},
        {"half", "LBNL/Klems Half", "LBNL/Klems Half", "Rows", "Reflection Back", "\r\n", half, half, 0},
        {"quarter", "LBNL/Klems Quarter", "LBNL/Klems Quarter", "Columns", "Reflection  Back ", ",\n", quarter, quarter, 0},
        {"full x quarter", "LBNL/Klems Full", "LBNL/Klems Quarter", "Columns", "Reflection Front", "\n", full, quarter, 0},
        {"quarter x full", "LBNL/Klems Quarter", "LBNL/Klems Full", "Columns", "Reflection Back", " \n ", quarter, full, 0},
        {"own", "my own", "my own", "Rows", "Reflection Front", " ,", coarse, coarse, 1},
        {"own x half", "my own", "LBNL/Klems Half", "Columns", "Reflection Front", " ", coarse, half, 1}};
    text t = {0};
    for (size_t c = 0; c < sizeof cases / sizeof cases[0]; c++) {
        const int n = count(cases[c].in) * count(cases[c].out);
        double *value = malloc((size_t)n * sizeof *value);
        if (!value) exit(1);
        start(&t, cases[c].structure);
        if (cases[c].defined) add_basis(&t, cases[c].column, cases[c].in);
        add(&t, "</DataDefinition>\n");
        begin_data(&t, "Visible", cases[c].direction, cases[c].column, cases[c].row);
        for (int k = 0; k < n; k++) {
            char number[40];
            value[k] = ldexp(ff_test_uniform() - 0.25, (int)(ff_test_random() % 20) - 10);
            snprintf(number, sizeof number, k % 3 ? "%.17g" : "%.9e", value[k]);
            value[k] = strtod(number, NULL);
            add(&t, "%s%s", number, cases[c].separator);
        }
        end_data(&t);
        finish(&t);
        ff_table table;
        if (reads(cases[c].label, &t, &table)) {
            check_matrix(cases[c].label, &table, cases[c].in, cases[c].out, !strcmp(cases[c].structure, "Rows"),
                         strstr(cases[c].direction, "Front") != NULL, value);
            FF_CHECK(table.n_channels == 1 && strcmp(table.channels[0].name, "Visible") == 0 && table.channels[0].scale == 1,
                     "%s: channel", cases[c].label);
            FF_CHECK(table.n_negative > 0 && table.n_invalid == 0 && strstr(table.note, "means over pairs of patches"),
                     "%s: note '%s'", cases[c].label, table.note);
            ff_table_clear(&table);
        }
        free(value);
    }
    free(t.at);
}

/* Two bases that differ, of which programs differ which is whose. */
static void rows_of_two_bases(void)
{
    text t = {0};
    start(&t, "Rows");
    add(&t, "</DataDefinition>\n");
    begin_data(&t, "Visible", "Reflection Back", "LBNL/Klems Full", "LBNL/Klems Quarter");
    end_data(&t);
    finish(&t);
    fails_part("rows of two bases", &t, NULL, FF_ERR_UNSUPPORTED, WORDS("different bases", "same basis"));
    free(t.at);
}

/* A mirror: the diagonal. */
static void test_mirror(void)
{
    static const char *const directions_of[] = {"Reflection Front", "Reflection Back"};
    text t = {0};
    for (int face = 0; face < 2; face++) {
        start(&t, "Columns");
        add(&t, "</DataDefinition>\n");
        begin_data(&t, "Visible", directions_of[face], "LBNL/Klems Quarter", "LBNL/Klems Quarter");
        for (int o = 0; o < 41; o++)
            for (int i = 0; i < 41; i++) add(&t, "%d ", i == o);
        end_data(&t);
        finish(&t);
        ff_table table;
        if (!reads(directions_of[face], &t, &table)) continue;
        int n = 0;
        for (size_t s = 0; s < table.n; s++) {
            double wi[3], wo[3];
            directions(&table, s, wi, wo);
            if (table.value[s] == 0) continue;
            n++;
            FF_CHECK(same(wo, -wi[0], -wi[1], wi[2]), "%s: sample %zu is not at the mirror direction", directions_of[face], s);
        }
        FF_CHECK(n == 41, "%d values of the mirror", n);
        ff_table_clear(&table);
    }
    free(t.at);
}

/* ---- parts and wavelengths ------------------------------------------------------------------- */

static void check_parts(const text *t, const char *part, double first, const char *names, const char *note)
{
    ff_table table;
    if (!reads_part(part ? part : "no part", t, part, &table)) return;
    char found[256] = "";
    for (size_t c = 0; c < table.n_channels; c++) {
        strcat(found, c ? " " : "");
        strcat(found, table.channels[c].name);
    }
    FF_CHECK(strcmp(found, names) == 0, "%s: channels '%s', expected '%s'", part ? part : "no part", found, names);
    FF_CHECK(table.value[0] == first, "%s: begins with %g, expected %g", part ? part : "no part", table.value[0], first);
    FF_CHECK(strstr(table.note, note), "%s: no '%s' in '%s'", part ? part : "no part", note, table.note);
    ff_table_clear(&table);
}

static void test_parts(void)
{
    text t = {0};
    start(&t, "Columns");
    add_basis(&t, "c", coarse);
    add(&t, "</DataDefinition>\n");
    add_counted(&t, "Visible", "Transmission Front", "c", 36, 100);
    add_counted(&t, "Solar", "Reflection Back", "c", 36, 200);
    add_counted(&t, "Visible", "Reflection Back", "c", 36, 300);
    add_counted(&t, "Solar", "Reflection Front", "c", 36, 400);
    add_counted(&t, "Visible", "Reflection Front", "c", 36, 500);
    add_counted(&t, "NIR", "Reflection Front", "c", 36, 600);
    finish(&t);
    check_parts(&t, NULL, 500, "Visible", "Reflection Back is there too");
    check_parts(&t, NULL, 500, "Visible",
                "of the wavelengths Solar, Visible, NIR, Visible is read: the part reflection-front:NAME");
    check_parts(&t, "reflection-front", 500, "Visible", "azimuths are mirrored");
    check_parts(&t, "reflection-back", 300, "Visible", "the part reflection-back:NAME reads another");
    check_parts(&t, "reflection-back:solar", 200, "Solar", "");
    check_parts(&t, "Reflection-Front:NIR", 600, "NIR", "");
    check_parts(&t, "reflection-front:all", 400, "Solar Visible NIR", "");
    fails_part("unknown", &t, "reflection-front:UV", FF_ERR_UNSUPPORTED, WORDS("Solar, Visible, NIR", "'UV' was asked for"));
    fails_part("transmission", &t, "transmission-front", FF_ERR_UNSUPPORTED, WORDS("'transmission-front'", "reflection-back"));
    fails_part("empty name", &t, "reflection-front:", FF_ERR_UNSUPPORTED, WORDS("'reflection-front:'"));

    /* no Visible: all that are on the same patches; wavelengths with a unit */
    start(&t, "Columns");
    add_basis(&t, "c", coarse);
    add(&t, "</DataDefinition>\n");
    add_counted(&t, "550", "Reflection Back", "c", 36, 1);
    add_counted(&t, "Solar", "Reflection Back", "LBNL/Klems Quarter", 41 * 41, 2);
    add_counted(&t, "NIR", "Reflection Back", "c", 36, 3);
    finish(&t);
    memcpy(strstr(t.at, "\"Integral\""), "'nm'      ", 10);
    check_parts(&t, NULL, 1, "550nm NIR", "of the wavelengths 550nm, Solar, NIR, 550nm and those on the same patches are read");
    check_parts(&t, "reflection-back:Solar", 2, "Solar", "");
    check_parts(&t, "reflection-back:550nm", 1, "550nm", "");
    fails_part("absent face", &t, "reflection-front", FF_ERR_UNSUPPORTED,
               WORDS("found Reflection Back alone", "reflection-front was asked"));
    ff_table table;
    if (reads("wavelength", &t, &table)) {
        FF_CHECK(table.channels[0].wavelength_nm == 550 && isnan(table.channels[1].wavelength_nm), "wavelengths %g %g",
                 table.channels[0].wavelength_nm, table.channels[1].wavelength_nm);
        ff_table_clear(&table);
    }

    /* the front first; a wavelength in micrometres */
    start(&t, "Columns");
    add_basis(&t, "c", coarse);
    add(&t, "</DataDefinition>\n");
    add_counted(&t, "0.55", "Reflection Front", "c", 36, 1);
    add_counted(&t, "Visible", "Reflection Back", "c", 36, 2);
    finish(&t);
    memcpy(strstr(t.at, "\"Integral\""), "\"micron\"  ", 10);
    check_parts(&t, NULL, 1, "550nm", "Reflection Back is there too");
    check_parts(&t, "reflection-back", 2, "Visible", "");

    start(&t, "Columns");
    add_basis(&t, "c", coarse);
    add(&t, "</DataDefinition>\n");
    add_counted(&t, "Visible", "Transmission Back", "c", 36, 1);
    finish(&t);
    fails_part("transmission alone", &t, NULL, FF_ERR_UNSUPPORTED,
               WORDS("found transmission alone", "Reflection Front or Reflection Back"));
    start(&t, "Columns");
    add(&t, "</DataDefinition>\n");
    finish(&t);
    fails_part("no data", &t, NULL, FF_ERR_FORMAT, WORDS("found no ScatteringData"));
    free(t.at);
}

/* ---- how XML may be written ------------------------------------------------------------------ */

/* The file of 36 values 1 .. 36 over the coarse basis, of this content and these first bytes. */
static void make_coarse(text *t, const char *content)
{
    start(t, "Columns");
    add_basis(t, "c", coarse);
    add(t, "</DataDefinition>\n");
    begin_data(t, "Visible", "Reflection Back", "c", "c");
    add(t, "%s", content);
    end_data(t);
    finish(t);
}

#define TWELVE "1 2 3 4 5 6 7 8 9 10 11 12\n"
#define REST   "25 26 27 28 29 30 31 32 33 34 35 36"

static void check_counted(const char *label, const text *t)
{
    ff_table table;
    if (!reads(label, t, &table)) return;
    for (size_t i = 0; i < table.n; i++)
        if (!FF_CHECK(table.value[i] == (double)(i + 1), "%s: value %zu is %g", label, i, table.value[i])) break;
    FF_CHECK(table.n == 36, "%s: %zu", label, table.n);
    ff_table_clear(&table);
}

static void writing_styles(void)
{
    static const char *const styles[][2] = {
        {"plain", TWELVE "13 14 15 16 17 18 19 20 21 22 23 24 " REST},
        {"commas", "1,2,3,4,5,6,7,8,9,10,11,12,\n 13 ,14, 15,16,17,18,19,20,21,22,23,24,25,26,27,28,29,30,31,32,33,34,35,36, \n"},
        {"comment, section, references", TWELVE "13 14<!-- here -->\n15 16 <![CDATA[17 18 1]]>9 2&#48; 2&#x31; 22 23 24&#10;" REST},
        {"exponents", "+1 2e0 .3e1 40E-1 5. 6.0 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 2.4e+1 " REST "\n"}};
    text t = {0}, u = {0};
    for (size_t k = 0; k < sizeof styles / sizeof styles[0]; k++) {
        make_coarse(&t, styles[k][1]);
        check_counted(styles[k][0], &t);
    }
    make_coarse(&t, styles[0][1]);
    u.n = 0;
    add(&u, "\xEF\xBB\xBF");
    add(&u, "%s", t.at);
    check_counted("byte-order mark", &u);
    u.n = 0;
    add(&u, "Recover using: genBSDF -recover /tmp/bsdf.1\n%s", t.at);
    check_counted("behind a line of genBSDF's", &u);
    /* UTF-16, both ways: what stands before the text is dropped */
    const char *body = strstr(t.at, "?>") + 3;
    for (int big = 0; big < 2; big++) {
        u.n = 0;
        add(&u, "%s", big ? "\xFE\xFF" : "\xFF\xFE");
        for (const char *p = body; *p; p++) {
            add(&u, "  ");
            u.at[u.n - 2 + (size_t)big] = *p;
            u.at[u.n - 1 - (size_t)big] = '\0';
        }
        check_counted(big ? "UTF-16 big-endian" : "UTF-16 little-endian", &u);
    }
    u.n = 0;
    add(&u, "<?xml version='1.0' encoding='ISO-8859-1'?>\n<!-- caf\xE9 -->%s", body);
    check_counted("Latin-1", &u);
    /* a prefix for the namespace */
    u.n = 0;
    for (const char *p = body; *p; p++) {
        const int tag = *p == '<' && p[1] != '!' && p[1] != '/';
        add(&u, "%c%s", *p, tag ? "w:" : "");
        if (*p == '<' && p[1] == '/') add(&u, "%c%s", *++p, "w:");
    }
    const char *xmlns = strstr(u.at, "xmlns=");
    const size_t at = (size_t)(xmlns - u.at);
    text v = {0};
    add(&v, "%.*sxmlns:w=%s", (int)at, u.at, xmlns + 6);
    check_counted("prefix", &v);
    free(t.at);
    free(u.at);
    free(v.at);
}

/* Numbers of many lengths, across all borders of what is read at once. */
static void test_borders(void)
{
    const int n = 145 * 145;
    text t = {0};
    start(&t, "Columns");
    add(&t, "</DataDefinition>\n");
    begin_data(&t, "Visible", "Reflection Back", "LBNL/Klems Full", "LBNL/Klems Full");
    double *value = malloc((size_t)n * sizeof *value);
    if (!value) exit(1);
    for (int k = 0; k < n; k++) {
        char number[40];
        snprintf(number, sizeof number, "%.*f", (int)(ff_test_random() % 17), ff_test_uniform());
        value[k] = strtod(number, NULL);
        add(&t, "%s%s", number, k % 10 ? " " : "\n");
    }
    end_data(&t);
    finish(&t);
    ff_table table;
    if (reads("borders", &t, &table)) {
        check_matrix("borders", &table, full, full, 0, 0, value);
        ff_table_clear(&table);
    }
    free(value);
    free(t.at);
}

/* ---- tensor trees ---------------------------------------------------------------------------- */

static double known(const double *c, int rank)
{
    double f = 1;
    for (int k = 0; k < rank; k++) f += (k + 1) * c[k] + c[k] * c[(k + 1) % rank];
    return f;
}

/* A tree of the function's values at centres, divided at random; returns the leaves whose first coordinate is below `limit`. */
static int add_tree(text *t, int rank, const double *corner, double w, int levels, double limit)
{
    int n = 0;
    const int branches = 1 << rank, k = levels == 0 ? 0 : (int)(ff_test_random() % 2);
    double c[4];
    if (levels > 0 && (ff_test_random() % 3 || w == 1)) {
        add(t, "{");
        for (int b = 0; b < branches; b++) {
            for (int j = 0; j < rank; j++) c[j] = corner[j] + (b >> j & 1) * w / 2;
            n += add_tree(t, rank, c, w / 2, levels - 1, limit);
            add(t, b % 3 ? "\n" : ",");
        }
        add(t, "}");
        return n;
    }
    add(t, k ? "{ " : "{");
    for (int i = 0; i < 1 << rank * k; i++) {
        for (int j = 0; j < rank; j++) c[j] = corner[j] + (k ? ((i >> (rank - 1 - j) & 1) + 0.5) * w / 2 : w / 2);
        n += c[0] < limit;
        add(t, "%.12g%s", known(c, rank), i + 1 < 1 << rank * k ? i % 2 ? " " : ", " : "");
    }
    add(t, "}");
    return n;
}

static void check_tree(const char *label, const ff_table *t, int rank, int front, int leaves)
{
    const double x = front ? -1 : 1;
    double sum = 0;
    FF_CHECK(t->n == (size_t)leaves && t->isotropic == (rank == 3), "%s: %zu leaves, expected %d; isotropic %d", label, t->n,
             leaves, t->isotropic);
    for (size_t s = 0; s < t->n; s++) {
        double wi[3], wo[3], c[4];
        directions(t, s, wi, wo);
        if (rank == 3) {
            /* turned until the light comes from -x of the sheet */
            FF_CHECK(fabs(wi[1]) < 1e-12 && -x * wi[0] > 0, "%s: leaf %zu: light from %g %g", label, s, wi[0], wi[1]);
            c[0] = 0.5 - 0.5 * hypot(wi[0], wi[1]);
            square_of(x * wo[0], wo[1], &c[1], &c[2]);
        } else {
            square_of(-x * wi[0], -wi[1], &c[0], &c[1]);
            square_of(x * wo[0], wo[1], &c[2], &c[3]);
        }
        const double f = known(c, rank);
        if (!FF_CHECK(fabs(t->value[s] - f) < 1e-9, "%s: leaf %zu is %.12g, expected %.12g", label, s, t->value[s], f)) return;
        sum += t->weight[s];
    }
    FF_CHECK(fabs(sum - 4 * pi * pi) < 1e-9, "%s: weights add to %.12g, expected (2 pi)^2", label, sum);
}

static void begin_tree(text *t, int rank, const char *direction)
{
    start(t, rank == 3 ? "TensorTree3" : "TensorTree4");
    add(t, "</DataDefinition>\n");
    begin_data(t, "Visible", direction, "LBNL/Shirley-Chiu", NULL);
}

static void test_trees(void)
{
    static const double origin[4] = {0, 0, 0, 0};
    text t = {0};
    for (int k = 0; k < 12; k++) {
        char label[64];
        const int rank = 3 + k % 2, front = k / 2 % 2;
        snprintf(label, sizeof label, "tree %d, rank %d", k, rank);
        begin_tree(&t, rank, front ? "Reflection Front" : "Reflection Back");
        const int leaves = add_tree(&t, rank, origin, 1, 3, rank == 3 ? 0.5 : 1);
        end_data(&t);
        finish(&t);
        ff_table table;
        if (!reads(label, &t, &table)) continue;
        check_tree(label, &table, rank, front, leaves);
        ff_table_clear(&table);
    }
    /* one leaf: light from everywhere, and a cell of exit around the normal */
    for (int rank = 3; rank <= 4; rank++) {
        begin_tree(&t, rank, "Reflection Back");
        add(&t, "{ 0.25 }");
        end_data(&t);
        finish(&t);
        ff_table table;
        if (!reads("one leaf", &t, &table)) continue;
        FF_CHECK(table.n == 1 && table.value[0] == 0.25 && fabs(table.weight[0] - 4 * pi * pi) < 1e-12, "one leaf of rank %d",
                 rank);
        FF_CHECK(table.angle[2][0] == 0 && fabs(table.angle[0][0] - (rank == 3 ? 30 : 0)) < 1e-12, "one leaf of rank %d", rank);
        ff_table_clear(&table);
    }
    free(t.at);
}

/* Weights of exit cells against the integral of dx dy / cos theta, where nothing grazes. */
static void tree_weights(void)
{
    enum { M = 8, FINE = 200 };
    text t = {0};
    begin_tree(&t, 3, "Reflection Back");
    add(&t, "{");
    for (int i = 0; i < M * M * M; i++) add(&t, "%d ", i);
    add(&t, "}");
    end_data(&t);
    finish(&t);
    ff_table table;
    if (reads("weights", &t, &table)) {
        for (int o = 0; o < M * M; o++) {
            double sum = 0;
            const int row = o / M, column = o % M;
            if (row == 0 || row == M - 1 || column == 0 || column == M - 1) continue;
            for (int i = 0; i < FINE * FINE; i++) {
                const double a = 2 * (row + (i / FINE + 0.5) / FINE) / M - 1, b = 2 * (column + (i % FINE + 0.5) / FINE) / M - 1;
                const double r = fmax(fabs(a), fabs(b));
                sum += pi / sqrt(1 - r * r) / (M * M) / (FINE * FINE);
            }
            const double ring_omega = 2 * pi * sqrt(1 - 0.75 * 0.75); /* sin theta_i from 3/4 to 1 */
            FF_CHECK(fabs(table.weight[o] / ring_omega - sum) < 1e-5 * sum, "cell %d: %g, expected %g", o,
                     table.weight[o] / ring_omega, sum);
        }
        FF_CHECK(table.n == M * M * M / 2, "%zu cells, half of them mean nothing", table.n);
        ff_table_clear(&table);
    }
    free(t.at);
}

/* A mirror as a tree of rank 4 and of rank 3: the peak of each incidence lies at the mirror direction. */
static void tree_mirror(void)
{
    enum { M = 4 };
    text t = {0};
    for (int rank = 3; rank <= 4; rank++)
        for (int front = 0; front < 2; front++) {
            begin_tree(&t, rank, front ? "Reflection Front" : "Reflection Back");
            add(&t, "{");
            for (int i = 0; i < (rank == 4 ? M * M * M * M : M * M * M); i++) {
                /* rank 3: the light's (1 - sin theta) / 2 = x means the exit point (1 - x, 1/2), between two cells */
                const int first = i / (M * M), exit = i % (M * M);
                add(&t, "%d ",
                    rank == 4 ? first == exit : exit / M == M - 1 - first && (exit % M == M / 2 || exit % M == M / 2 - 1));
            }
            add(&t, "}");
            end_data(&t);
            finish(&t);
            ff_table table;
            if (!reads("mirror", &t, &table)) continue;
            double sum[2] = {0, 0};
            for (size_t s = 0; s < table.n; s++) {
                double wi[3], wo[3];
                directions(&table, s, wi, wo);
                if (table.value[s] == 0) continue;
                if (rank == 4) FF_CHECK(same(wo, -wi[0], -wi[1], wi[2]), "tree mirror: leaf %zu", s);
                if (rank == 3) FF_CHECK(wo[0] * wi[0] < 0 && fabs(wo[2] - wi[2]) < 1e-9, "tree mirror: leaf %zu", s);
                sum[0] += table.value[s];
                sum[1] += wo[1];
            }
            FF_CHECK(sum[0] == (rank == 4 ? M * M : M) && fabs(sum[1]) < 1e-12, "tree mirror: %g peaks", sum[0]);
            ff_table_clear(&table);
        }
    free(t.at);
}

static void tree_channels(void)
{
    text t = {0};
    begin_tree(&t, 4, "Reflection Back");
    t.n -= strlen(strstr(t.at, "<WavelengthData>"));
    static const char *const names[] = {"CIE-u", "Solar", "Visible", "CIE-v"};
    for (int k = 0; k < 4; k++) {
        begin_data(&t, names[k], "Reflection Back", "LBNL/Shirley-Chiu", NULL);
        add(&t, "{ %d }", k);
        end_data(&t);
    }
    finish(&t);
    check_parts(&t, NULL, 2, "Visible", "of the wavelengths CIE-u, Solar, Visible, CIE-v, Visible is read");
    check_parts(&t, "reflection-back:Solar", 1, "Solar", "");
    check_parts(&t, "reflection-back:all", 1, "Solar", "Solar is read: the others are on other directions");
    fails_part("chromaticity", &t, "reflection-back:CIE-u", FF_ERR_UNSUPPORTED, WORDS("'CIE-u' was asked for"));
    free(t.at);
}

/* ---- what is wrong --------------------------------------------------------------------------- */

/* A file that differs in one place from a good one. */
static void refuses_change(const char *from, const char *to, ff_status code, const char *const *words)
{
    text good = {0}, bad = {0};
    make_coarse(&good, TWELVE "13 14 15 16 17 18 19 20 21 22 23 24\n" REST);
    const char *at = strstr(good.at, from);
    if (FF_CHECK(at, "'%s' is not in the file", from)) {
        add(&bad, "%.*s", (int)(at - good.at), good.at);
        add(&bad, "%s%s", to, at + strlen(from));
        fails_part(to, &bad, NULL, code, words);
    }
    free(good.at);
    free(bad.at);
}

static void refusals(void)
{
    refuses_change("36</S", "</S", FF_ERR_FORMAT, WORDS("found 35 numbers", "expected 6 x 6 (one per pair of patches)"));
    refuses_change("36</S", "36 37</S", FF_ERR_FORMAT, WORDS(":27: ", "found more numbers", "expected 6 x 6"));
    refuses_change("1 2 3", "1 nan 3", FF_ERR_DATA, WORDS(":25: ", "value 2", "'nan'", "finite number"));
    refuses_change("25 26", "25 inf", FF_ERR_DATA, WORDS(":27: ", "value 26", "'inf'"));
    refuses_change("25 26", "25 1e999", FF_ERR_DATA, WORDS("value 26", "'1e999'"));
    refuses_change("25 26", "25 2x6", FF_ERR_DATA, WORDS("value 26", "'2x6'"));
    refuses_change("25 26", "25 , , 26", FF_ERR_DATA, WORDS("value 26", "','"));
    refuses_change("1 2 3", ", 1 2 3", FF_ERR_DATA, WORDS("value 1", "','"));
    refuses_change("25 26", "25 {26}", FF_ERR_DATA, WORDS("'{26}'"));
    refuses_change("Columns", "Diagonals", FF_ERR_UNSUPPORTED, WORDS("'Diagonals'", "Columns, Rows"));
    refuses_change("<IncidentDataStructure>Columns</IncidentDataStructure>", "", FF_ERR_FORMAT,
                   WORDS("before IncidentDataStructure"));
    refuses_change("<ColumnAngleBasis>c</ColumnAngleBasis>", "", FF_ERR_FORMAT, WORDS("without a ColumnAngleBasis"));
    refuses_change("<RowAngleBasis>c</RowAngleBasis>", "", FF_ERR_FORMAT, WORDS("without a RowAngleBasis"));
    refuses_change("<ColumnAngleBasis>c<", "<ColumnAngleBasis>d<", FF_ERR_FORMAT,
                   WORDS("the basis 'd'", "LBNL/Klems Full", ", 'c'"));
    refuses_change("<AngleBasisName>c</AngleBasisName>", "", FF_ERR_FORMAT, WORDS("AngleBasis without a name"));
    refuses_change("Reflection Back", "Reflection Sideways", FF_ERR_FORMAT, WORDS("'Reflection Sideways'"));
    refuses_change("Visible", " \n ", FF_ERR_FORMAT, WORDS("Wavelength", "a name"));
    refuses_change("<WavelengthDataDirection>Reflection Back</WavelengthDataDirection>", "", FF_ERR_FORMAT,
                   WORDS("before WavelengthDataDirection"));
    refuses_change("<nPhis>2", "<nPhis>1", FF_ERR_UNSUPPORTED, WORDS("all around", "theta 30 to 60"));
    refuses_change("<nPhis>2", "<nPhis>0", FF_ERR_DATA, WORDS("nPhis", "'0'"));
    refuses_change("<nPhis>2", "<nPhis>-2", FF_ERR_DATA, WORDS("nPhis", "'-2'"));
    refuses_change("<nPhis>2", "<nPhis>1000000000", FF_ERR_DATA, WORDS("nPhis", "'1000000000'"));
    refuses_change("<nPhis>2", "<nPhis>1048575", FF_ERR_DATA, WORDS("more than 1048576 patches"));
    refuses_change("<nPhis>2</nPhis>", "", FF_ERR_FORMAT, WORDS("without nPhis"));
    refuses_change("<nPhis>2", "<nPhis>1000000", FF_ERR_FORMAT, WORDS("found 36 numbers", "expected 1000004 x 1000004"));
    refuses_change("<UpperTheta>60", "<UpperTheta>20", FF_ERR_DATA, WORDS("from theta 30 to 20"));
    refuses_change("<UpperTheta>60", "<UpperTheta>x", FF_ERR_DATA, WORDS("UpperTheta", "'x'"));
    refuses_change("<UpperTheta>90", "<UpperTheta>91", FF_ERR_DATA, WORDS("'91'", "degrees from 0 to 90"));
    refuses_change("<LowerTheta>60", "<LowerTheta>61", FF_ERR_DATA, WORDS("from theta 61 to 90", "begin at 60"));
    refuses_change("<nPhis>2", "<Theta>70</Theta><nPhis>2", FF_ERR_DATA, WORDS("theta 70", "bounds 30 and 60"));
    refuses_change("WindowElement ", "Scene ", FF_ERR_FORMAT, WORDS("'Scene'", "expected WindowElement"));
    refuses_change("</Layer>", "</Optical>", FF_ERR_FORMAT, WORDS("mismatched tag"));
    refuses_change("</WindowElement>", "</WindowElement><more/>", FF_ERR_FORMAT, WORDS("junk after document element"));
    refuses_change("UTF-8", "EBCDIC", FF_ERR_FORMAT, WORDS("encoding"));
    refuses_change("<ScatteringDataType>", "<ScatteringData/><ScatteringDataType>", FF_ERR_FORMAT, WORDS("found 0 numbers"));
    refuses_change("</ScatteringData>", "</ScatteringData><ScatteringData>1</ScatteringData>", FF_ERR_FORMAT,
                   WORDS("a second ScatteringData"));
    refuses_change("<AngleBasis>", "<AngleBasis><AngleBasisName>e</AngleBasisName></AngleBasis><AngleBasis>", FF_ERR_FORMAT,
                   WORDS("'e' without an AngleBasisBlock"));
    refuses_change("A &amp; B", "A &bomb; B", FF_ERR_FORMAT, WORDS("undefined entity"));

    text t = {0};
    start(&t, "Columns");
    add_basis(&t, "c", coarse);
    add_basis(&t, "c", quarter);
    finish(&t);
    fails_part("two bases", &t, NULL, FF_ERR_FORMAT, WORDS("two bases 'c' that differ"));
    start(&t, "Columns");
    add_basis(&t, "c", coarse);
    add_basis(&t, "c", coarse);
    add(&t, "</DataDefinition>");
    add_counted(&t, "Visible", "Reflection Back", "c", 36, 1);
    add_counted(&t, "visible", "Reflection Back", "c", 36, 1);
    finish(&t);
    fails_part("twice", &t, NULL, FF_ERR_FORMAT, WORDS("Reflection Back of 'visible' twice"));
    start(&t, "Columns");
    add(&t, "</DataDefinition><WavelengthData><Wavelength>");
    for (int k = 0; k < 300; k++) add(&t, "x");
    add(&t, "</Wavelength></WavelengthData>");
    finish(&t);
    fails_part("long text", &t, NULL, FF_ERR_FORMAT, WORDS("a text of more than 255 bytes"));
    start(&t, "Columns");
    add(&t, "</DataDefinition><WavelengthData><WavelengthDataBlock></WavelengthDataBlock></WavelengthData>");
    finish(&t);
    fails_part("no data in a block", &t, NULL, FF_ERR_FORMAT, WORDS("WavelengthDataBlock without ScatteringData"));
    free(t.at);
}

static void wrong_trees(void)
{
    static const struct {
        int rank;
        const char *tree;
        ff_status code;
        const char *words[3];
    } cases[] = {
        {4, "", FF_ERR_FORMAT, {"end of ScatteringData within its tree", "'{'"}},
        {4, "{ 1", FF_ERR_FORMAT, {"end of ScatteringData within its tree", "'}'"}},
        {4, "{ }", FF_ERR_FORMAT, {"a node of 0 branches", "16 branches"}},
        {3, "{ 1 2 }", FF_ERR_FORMAT, {"2 values in a leaf", "a power of 8"}},
        {4, "{ 1 2 3 4 5 6 7 8 }", FF_ERR_FORMAT, {"8 values in a leaf", "a power of 16"}},
        {3, "{ {1}{2}{3} }", FF_ERR_FORMAT, {"a node of 3 branches", "8 branches"}},
        {3, "{ {1}{2}{3}{4}{5}{6}{7}{8}{9} }", FF_ERR_FORMAT, {"'{' after all branches"}},
        {3, "{ {1}{2} 3 }", FF_ERR_FORMAT, {"the number 3 among the branches"}},
        {3, "{ 3 {1} }", FF_ERR_FORMAT, {"'{' among the values of a leaf"}},
        {3, "{ 1 } { 2 }", FF_ERR_FORMAT, {"'{' after the tree", "nothing more"}},
        {3, "{ 1 } 2", FF_ERR_FORMAT, {"the number 2 outside of the tree"}},
        {3, "{ 1 } }", FF_ERR_FORMAT, {"'}' without a '{'", "nothing more"}},
        {3, "1", FF_ERR_FORMAT, {"the number 1 outside of the tree"}},
        {3, "{ x }", FF_ERR_DATA, {"'x'"}},
        {3, "{ , 1 }", FF_ERR_DATA, {"','"}},
        {3, "{ 1,, }", FF_ERR_DATA, {"','"}},
    };
    text t = {0};
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        begin_tree(&t, cases[k].rank, "Reflection Back");
        add(&t, "%s", cases[k].tree);
        end_data(&t);
        finish(&t);
        fails_part(cases[k].tree, &t, NULL, cases[k].code, cases[k].words);
    }
    begin_tree(&t, 3, "Reflection Back");
    for (int k = 0; k < 100000; k++) add(&t, "{");
    fails_part("deep tree", &t, NULL, FF_ERR_FORMAT, WORDS("more than 20 levels"));
    start(&t, "TensorTree4");
    add(&t, "</DataDefinition>");
    begin_data(&t, "Visible", "Reflection Back", "LBNL/Klems Full", NULL);
    fails_part("basis of a tree", &t, NULL, FF_ERR_UNSUPPORTED, WORDS("'LBNL/Klems Full'", "LBNL/Shirley-Chiu"));
    start(&t, "TensorTree4");
    add(&t, "</DataDefinition><WavelengthData><Wavelength>Visible</"
            "Wavelength><WavelengthDataBlock><WavelengthDataDirection>Reflection Back"
            "</WavelengthDataDirection><ScatteringData>");
    fails_part("no basis of a tree", &t, NULL, FF_ERR_FORMAT, WORDS("before its AngleBasis"));
    free(t.at);
}

/* ---- hostile files --------------------------------------------------------------------------- */

static void test_hostile(void)
{
    text t = {0};
    const clock_t began = clock();
    add(&t, "<?xml version='1.0'?>\n<!DOCTYPE WindowElement [\n<!ENTITY a \"ha\">\n");
    for (char c = 'b'; c < 'z'; c++)
        add(&t, "<!ENTITY %c \"&%c;&%c;&%c;&%c;&%c;&%c;\">\n", c, c - 1, c - 1, c - 1, c - 1, c - 1, c - 1);
    add(&t, "]>\n<WindowElement>&y;</WindowElement>\n");
    fails_part("entity bomb", &t, NULL, FF_ERR_FORMAT, WORDS(":3: ", "the entity 'a'", "refused"));
    t.n = 0;
    add(&t, "<!DOCTYPE WindowElement [\n<!ENTITY a SYSTEM \"/etc/passwd\">\n]>\n<WindowElement>&a;</WindowElement>\n");
    fails_part("external entity", &t, NULL, FF_ERR_FORMAT, WORDS(":2: ", "the entity 'a'", "refused"));
    t.n = 0;
    add(&t, "<!DOCTYPE WindowElement [\n<!ENTITY %% a SYSTEM \"http://example.org/x.dtd\">\n%%a;]>\n<WindowElement/>\n");
    fails_part("parameter entity", &t, NULL, FF_ERR_FORMAT, WORDS(":2: ", "the entity 'a'", "refused"));
    t.n = 0;
    add(&t, "<!DOCTYPE WindowElement SYSTEM \"http://example.org/x.dtd\">\n<WindowElement/>\n");
    fails_part("external definition", &t, NULL, FF_ERR_FORMAT, WORDS(":1: ", "another document", "refused"));
    t.n = 0;
    add(&t, "<WindowElement>");
    for (int k = 0; k < 100000; k++) add(&t, "<a>");
    fails_part("deep elements", &t, NULL, FF_ERR_FORMAT, WORDS("deeper than 64"));
    t.n = 0;
    add(&t, "<WindowElement ");
    for (int k = 0; k < 600000; k++) add(&t, "aaaaaaaa");
    fails_part("endless tag", &t, NULL, FF_ERR_FORMAT, WORDS("more than 1048576 bytes"));
    make_coarse(&t, "1 2 ");
    t.n = (size_t)(strstr(t.at, "1 2 ") - t.at);
    for (int k = 0; k < 20000; k++) add(&t, "11");
    fails_part("endless number", &t, NULL, FF_ERR_DATA, WORDS("value 1", "'1111", "..."));
    FF_CHECK((double)(clock() - began) / CLOCKS_PER_SEC < 20, "hostile files took %g s",
             (double)(clock() - began) / CLOCKS_PER_SEC);
    free(t.at);
}

static void check_well_formed(const char *label, const ff_table *t)
{
    for (size_t s = 0; s < t->n; s++) {
        double wi[3], wo[3];
        directions(t, s, wi, wo);
        const double all = wi[0] + wi[1] + wi[2] + wo[0] + wo[1] + wo[2] + t->weight[s] + t->value[s];
        if (!FF_CHECK(isfinite(all) && wi[2] >= -1e-12 && wo[2] >= -1e-12, "%s: sample %zu", label, s)) return;
    }
}

static void try_bytes(const char *label, const char *bytes, size_t n, int may_be_read, int *whole)
{
    const char *path = ff_test_path("cut.xml");
    ff_error err = {0};
    ff_table table;
    ff_test_write(path, bytes, n);
    if (ff_table_read_into(path, "window", &table, &err) == FF_OK) {
        (*whole)++;
        FF_CHECK(may_be_read, "%s: was read", label);
        check_well_formed(label, &table);
        ff_table_clear(&table);
    } else {
        FF_CHECK(err.message[0] && strcmp(err.path, path) == 0, "%s: no message", label);
    }
}

static void test_damaged(void)
{
    text t[2] = {{0}, {0}};
    make_coarse(&t[0], TWELVE "13 14 15 16 17 18 19 20 21 22 23 24\n" REST);
    begin_tree(&t[1], 3, "Reflection Front");
    add(&t[1], "{ {1}{2}{3}{4 5 6 7 8 9 10 11}{12}{13}{14}{15} }");
    end_data(&t[1]);
    finish(&t[1]);
    for (int k = 0; k < 2; k++) {
        char label[64];
        int whole = 0, flipped = 0;
        for (size_t n = 0; n <= t[k].n; n++) {
            snprintf(label, sizeof label, "prefix %zu", n);
            try_bytes(label, t[k].at, n, n + 1 >= t[k].n, &whole);
        }
        FF_CHECK(whole == 2, "%d prefixes were read, expected the file with and without its last end of line", whole);
        for (size_t n = 0; n < 2 * t[k].n && n < 4096; n++) { /* two bits of each byte, others in the other file */
            const int bit = (int)((n + n / 8 + (n & 1 ? 4 : 0) + (size_t)(2 * k)) % 8);
            snprintf(label, sizeof label, "bit %d of byte %zu", bit, n / 2);
            t[k].at[n / 2] = (char)(t[k].at[n / 2] ^ 1 << bit);
            try_bytes(label, t[k].at, t[k].n, 1, &flipped);
            t[k].at[n / 2] = (char)(t[k].at[n / 2] ^ 1 << bit);
        }
        FF_CHECK(flipped > 100, "%d damaged files were read", flipped); /* in comments, names, digits */
        free(t[k].at);
    }
}

static void detection(void)
{
    static const struct {
        const char *head;
        int found;
    } cases[] = {{"<?xml version='1.0'?>\n<WindowElement>", 1},
                 {"\xEF\xBB\xBF  \n<!-- x --><w:WindowElement>", 1},
                 {"<WindowElement", 1},
                 {"Recover using: genBSDF -recover /tmp/b\n<?xml version='1.0'?>\n<WindowElement>", 1},
                 {"Recover using: genBSDF <WindowElement", 0},
                 {"<?xml version='1.0'?><scene>", 0},
                 {"WindowElement,a,b\n1,2,3\n", 0},
                 {"<WWindowElement>", 1},
                 {"", 0},
                 {"<", 0}};
    const ff_format *f = ff_format_find("window");
    if (!FF_CHECK(f, "no format 'window'")) return;
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        const char *path = ff_test_path("head");
        const ff_format *found = NULL;
        ff_error err = {0};
        ff_test_write(path, cases[k].head, strlen(cases[k].head));
        ff_status status = ff_format_detect(path, &found, &err);
        FF_CHECK((status == FF_OK && found == f) == cases[k].found, "%s: %s %s", cases[k].head, found ? found->name : "none",
                 err.message);
    }
    FF_CHECK(f->write && f->layout && f->reads == FF_READS_PART, "window is read in parts, and written");
}

/* ---- real files ------------------------------------------------------------------------------ */

/* Numbers of the k-th ScatteringData (from 0), read with the C library. */
static size_t second_source(const char *xml, int k, double *value, size_t most)
{
    const char *p = xml;
    for (; k >= 0 && p; k--) {
        p = strstr(p, "<ScatteringData>");
        if (p) p += 16;
    }
    size_t n = 0;
    while (p && n < most) {
        char *end;
        value[n] = strtod(p, &end);
        if (end == p) break;
        n++;
        for (p = end; *p == ','; p++) {
        }
    }
    return n;
}

/* The fabric shines at grazing incidence: of the patches at theta = 82.5 the brightest is that of the mirror direction. */
static void check_lobe(const char *name, const ff_table *t)
{
    for (size_t i = 133; i < 145; i++) {
        size_t best = i + 145 * 133;
        for (size_t o = 133; o < 145; o++)
            if (t->value[i + 145 * o] > t->value[best]) best = i + 145 * o;
        double wi[3], wo[3];
        directions(t, best, wi, wo);
        FF_CHECK(same(wo, -wi[0], -wi[1], wi[2]), "%s: the lobe of patch %zu is not at the mirror direction", name, i);
    }
}

static void test_real_file(const char *name, const char *part, int block, double least, double most)
{
    const char *set = getenv("FACETFIT_DATA");
    char path[700], all[2048];
    snprintf(path, sizeof path, "%s/klems/%s", set ? set : FF_SOURCE_DIR "/../shared/data", name);
    if (access(path, R_OK) != 0) FF_SKIP("there is no %s", path);
    ff_read_options o;
    ff_read_options_init(&o);
    o.part = part;
    ff_error err = {0};
    ff_table t;
    const ff_status status = ff_table_read_with_into(path, &o, &t, &err);
    ff_error_format(&err, all, sizeof all);
    if (!FF_CHECK(status == FF_OK, "%s", all)) return;
    size_t size;
    char *xml = ff_test_slurp(path, &size);
    double *value = calloc(145 * 145, sizeof *value);
    if (!value) exit(1);
    FF_CHECK(second_source(xml, block, value, 145 * 145) == 145 * 145, "%s: second source", name);
    check_matrix(name, &t, full, full, 0, !part || strstr(part, "front"), value);
    /* directional albedo of each incidence, by the weights */
    for (int i = 0; i < 145; i++) {
        double albedo = 0, unused[3];
        const double omega_i = patch(full, i, unused);
        for (size_t k = (size_t)i; k < t.n; k += 145) albedo += t.value[k] * cos(t.angle[2][k] * pi / 180) * t.weight[k] / omega_i;
        FF_CHECK(albedo > least && albedo < most, "%s: albedo of patch %d is %g", name, i, albedo);
    }
    if (part && strcmp(part, "reflection-back") == 0) check_lobe(name, &t);
    free(value);
    free(xml);
    ff_table_clear(&t);
}

static void measured(void)
{
    test_real_file("2011-SA1.XML", NULL, 2, 0.45, 0.7);
    test_real_file("2011-SA1.XML", "reflection-back:Solar", 7, 0.45, 0.7);
    test_real_file("frads_klems_aniso_high.xml", "reflection-back", 2, 0.2, 0.45);
    test_real_file("frads_klems_aniso_high.xml", "reflection-front", 3, 0.35, 0.7);
}

/* ---- writing --------------------------------------------------------------------------------- */

/* f = 1/pi (1 + cos theta_i cos theta_o) / 2 on the layout: what is read back are the means over patches. */
static void written(void)
{
    static const double bound[] = {0, 5, 15, 25, 35, 45, 55, 65, 75, 90};
    ff_table like, t, again;
    ff_error err = {0};
    const double pi = acos(-1);
    const ff_format *window = ff_format_find("window");
    if (!FF_CHECK(ff_table_init(1, 1, NULL, 0, 0, &like, &err) == FF_OK && window->layout(&like, NULL, &t, &err) == FF_OK, "%s",
                  err.message))
        return;
    FF_CHECK(t.n == 145 * 145 * 15 && window->layout(&like, "finer", &again, &err) == FF_ERR_SYNTAX, "%zu directions", t.n);
    for (size_t i = 0; i < t.n; i++) t.value[i] = (1 + cos(pi / 180 * t.angle[0][i]) * cos(pi / 180 * t.angle[2][i])) / (2 * pi);
    const char *path = ff_test_path("klems.xml");
    if (FF_CHECK(ff_table_write(path, "window", &t, &err) == FF_OK && ff_table_read_into(path, NULL, &again, &err) == FF_OK, "%s",
                 err.message)) {
        double sum = 0, off = 0;
        FF_CHECK(again.n == 145 * 145 && again.n_invalid == 0, "%zu samples", again.n);
        for (size_t i = 0; i < again.n; i++) {
            const double theta_i = pi / 180 * again.angle[0][i], theta_o = pi / 180 * again.angle[2][i];
            size_t ring = 0;
            while (ring < 8 && again.angle[2][i] > bound[ring + 1]) ring++;
            const double a = cos(pi / 180 * bound[ring]), b = cos(pi / 180 * bound[ring + 1]);
            const double mean = 2.0 / 3 * (a * a * a - b * b * b) / (a * a - b * b); /* of cos theta_o, weighted by itself */
            off = fmax(off, fabs(again.value[i] / ((1 + cos(theta_i) * mean) / (2 * pi)) - 1));
            if (theta_i == 0) sum += again.value[i] * again.weight[i] * cos(theta_o);
        }
        FF_CHECK(off < 0.002, "a patch is off by %g", off); /* fifteen points for an integral */
        double all = 0;
        for (size_t i = 0; i < again.n; i++)
            if (again.angle[0][i] == 0) all += again.weight[i] * cos(pi / 180 * again.angle[2][i]);
        FF_CHECK(fabs(sum / all - (1 + 2.0 / 3) / (2 * pi)) < 0.005 / pi, "mean at normal incidence %g, expected %g", sum / all,
                 (1 + 2.0 / 3) / (2 * pi));
        ff_table_clear(&again);
    }
    memset(t.valid, 0, 15);
    FF_CHECK(ff_table_write(ff_test_path("gap.xml"), "window", &t, &err) == FF_ERR_UNSUPPORTED &&
                 strstr(err.message, "1 have no sample") && access(ff_test_path("gap.xml"), F_OK) != 0,
             "%s", err.message);
    ff_table_clear(&t);
    ff_table_clear(&like);
}

FF_TEST_MAIN(FF_TEST(written), FF_TEST(detection), FF_TEST(test_bases), FF_TEST(rows_of_two_bases), FF_TEST(test_mirror),
             FF_TEST(test_parts), FF_TEST(writing_styles), FF_TEST(test_borders), FF_TEST(test_trees), FF_TEST(tree_weights),
             FF_TEST(tree_mirror), FF_TEST(tree_channels), FF_TEST(refusals), FF_TEST(wrong_trees), FF_TEST(test_hostile),
             FF_TEST(test_damaged), FF_TEST(measured))
