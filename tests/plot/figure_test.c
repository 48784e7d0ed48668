/* Parts of figures by themselves: ticks, widths of text, numbers, colours. */
#include "ff_test.h"
#include "report/plot/internal_sheet.h"

static const ff_tick *find(const ff_ticks *t, const char *label)
{
    for (size_t k = 0; k < t->n; k++)
        if (!strcmp(t->tick[k].label, label)) return &t->tick[k];
    return NULL;
}

/* Labels never meet, ticks lie inside, whatever the range. */
static void ticks_of_any_range(void)
{
    for (int k = 0; k < 3000; k++) {
        const ff_scale scale = (ff_scale)(k % 3);
        const double size = 3 + 20 * ff_test_uniform(), length = 40 + 600 * ff_test_uniform(),
                     at = pow(10, 16 * ff_test_uniform() - 8);
        const double lo = scale == FF_SCALE_LOG ? at : (ff_test_uniform() - 0.5) * at,
                     hi = scale == FF_SCALE_LOG ? lo * pow(10, 0.02 + 12 * ff_test_uniform())
                                                : lo + at * pow(10, 4 * ff_test_uniform() - 3);
        const int stacked = (k / 3) % 2;
        ff_ticks t;
        double end = -INFINITY;
        ff_ticks_make(scale, lo, hi, length, size, stacked, &t);
        for (size_t i = 0; i < t.n; i++) {
            const double place = ff_scale_place(scale, lo, hi, t.tick[i].at) * length,
                         half = stacked ? 0.47 * size : ff_text_points(t.tick[i].label, size) / 2;
            FF_CHECK(place > -1e-3 * length && place < 1.001 * length, "tick %s at %g of %g", t.tick[i].label, place, length);
            if (!t.tick[i].label[0]) continue;
            FF_CHECK(place - half > end, "%s meets its neighbour, from %g to %g", t.tick[i].label, lo, hi);
            end = place + half;
        }
    }
}

static void ticks_that_people_like(void)
{
    ff_ticks t;
    ff_ticks_make(FF_SCALE_ANGLE, -90, 90, 200, 8, 0, &t);
    FF_CHECK(t.n == 7 && find(&t, "−90") && find(&t, "30"), "%zu ticks of angles, the second %s", t.n, t.tick[1].label);
    ff_ticks_make(FF_SCALE_LINEAR, 0, 1, 150, 8, 1, &t);
    FF_CHECK(t.n == 6 && find(&t, "0.2") && find(&t, "1.0"), "%zu ticks from 0 to 1", t.n);
    ff_ticks_make(FF_SCALE_LOG, 1e-6, 1, 150, 8, 1, &t);
    FF_CHECK(find(&t, "10^{−6}") && find(&t, "10^{0}"), "powers of ten");
    ff_ticks_make(FF_SCALE_LOG, 0.01, 20, 150, 8, 1, &t);
    FF_CHECK(find(&t, "0.01") && find(&t, "10") && !find(&t, "20"), "plain numbers where they are short");
    ff_ticks_make(FF_SCALE_LOG, 2, 7, 150, 8, 1, &t);
    FF_CHECK(find(&t, "2") && find(&t, "5"), "less than a decade");
    ff_ticks_make(FF_SCALE_LINEAR, 0, 3e6, 150, 8, 1, &t);
    FF_CHECK(t.power == 6 && find(&t, "2.0") && find(&t, "0.0"), "large numbers: power %d", t.power);
    ff_ticks_make(FF_SCALE_LINEAR, 0.00404, 0.00421, 150, 8, 1, &t);
    FF_CHECK(t.power == -3 && find(&t, "4.100"), "small numbers with many digits: power %d, %s", t.power, t.tick[0].label);
    ff_ticks_make(FF_SCALE_LINEAR, 0, 0.0052, 150, 8, 1, &t);
    FF_CHECK(t.power == 0 && find(&t, "0.001"), "small numbers with few: power %d, %s", t.power, t.tick[1].label);
    ff_ticks_make(FF_SCALE_LINEAR, 0.2493, 0.2512, 150, 8, 0, &t);
    FF_CHECK(t.power == 0 && find(&t, "0.2500"), "digits that no power takes away: power %d, %s", t.power, t.tick[1].label);
    ff_ticks_make(FF_SCALE_LINEAR, 1, 1, 100, 8, 0, &t);
    FF_CHECK(t.n == 0, "an empty range has no ticks");
    ff_ticks_make(FF_SCALE_LINEAR, NAN, 1, 100, 8, 0, &t);
    FF_CHECK(t.n == 0, "nor has one that is none");
}

/* The power that the numbers leave out stands with the unit. */
static void texts_of_axes(void)
{
    static const struct {
        const char *label, *unit;
        int power;
        const char *text;
    } cases[] = {{"f", "sr^{−1}", 0, "f (sr^{−1})"},
                 {"f", "sr^{−1}", -4, "f (10^{−4} sr^{−1})"},
                 {"objective", "1", 6, "objective (10^{6})"},
                 {"", "1", -5, "(10^{−5})"},
                 {"", "", 0, ""},
                 {"D", "", 0, "D"}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        ff_axis a = {.scale = FF_SCALE_LINEAR};
        char text[FF_AXIS_TEXT];
        ff_axis_say(&a, cases[k].label, cases[k].unit, FF_SCALE_LINEAR, 0, 1);
        ff_axis_text(&a, &(ff_ticks){.power = cases[k].power}, text, sizeof text);
        FF_CHECK(!strcmp(text, cases[k].text), "'%s', expected '%s'", text, cases[k].text);
    }
}

/* What both fonts lack is drawn with something that they have, or is known to be drawn otherwise. */
static void glyphs(void)
{
    static const struct {
        uint32_t code;
        unsigned char latin, symbol;
        int level;
        double width;
    } cases[] = {{'A', 'A', 0, 0, 667},          {0xe9, 0xe9, 0, 0, 556},         {0x2192, 0, 0xae, 0, 987}, /* é, an arrow      */
                 {0x2079, '9', 0, 1, 0.7 * 556}, {0x2082, '2', 0, -1, 0.7 * 556}, {0x207b, '-', 0, 1, 0.7 * 333},
                 {0x010d, 'c', 0, 0, 500},       {0x0142, 'l', 0, 0, 222},        {0x0161, 0x9a, 0, 0, 500}, /* č, ł, š          */
                 {0x2248, 0, 0xbb, 0, 549},      {0x03b8, 0, 0x71, 0, 521},       {0x03ac, 0, 0x61, 0, 631},
                 {0x2009, ' ', 0, 0, 278},       {0x4e2d, 0, 0, 0, 1000},         {0x1f600, 0, 0, 0, 1000}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        const ff_glyph g = ff_glyph_of(cases[k].code);
        FF_CHECK(g.latin == cases[k].latin && g.symbol == cases[k].symbol && g.level == cases[k].level, "U+%04X: %d, %d, %d",
                 (unsigned)cases[k].code, g.latin, g.symbol, g.level);
        FF_CHECK_CLOSE(g.width, cases[k].width, 1e-12, 0);
    }
    for (uint32_t code = 0x20; code < 0x180; code++)
        if (code < 0x7f || code >= 0xa0) FF_CHECK(ff_glyph_of(code).latin, "U+%04X is not drawn", (unsigned)code);
    for (uint32_t code = 0x391; code < 0x3ca; code++) {
        const ff_glyph g = ff_glyph_of(code);
        FF_CHECK(g.symbol || code == 0x3a2, "U+%04X is not drawn", (unsigned)code);
    }
}

/* By Adobe's table: H 722, e 556, l 222, v 500, t 278, i 222, c 500, a 556; theta 521 of Symbol. */
static void widths(void)
{
    FF_CHECK_CLOSE(ff_text_points("Helvetica", 10), 0.01 * (722 + 556 + 222 + 500 + 556 + 278 + 222 + 500 + 556), 1e-12, 0);
    FF_CHECK_CLOSE(ff_text_points("θ_{i}", 10), 0.01 * (521 + FF_RUN_SIZE * 222), 1e-12, 0);
    FF_CHECK_CLOSE(ff_text_points("10^{−3}", 10), 0.01 * (2 * 556 + FF_RUN_SIZE * (584 + 556)), 1e-12, 0);
    FF_CHECK_CLOSE(ff_text_points("", 10), 0, 0, 0);
    char out[64];
    FF_CHECK(!strcmp(ff_text_fit("abc", 10, 100, out, sizeof out), "abc"), "what fits stays");
    for (double room = 0; room < 60; room += 0.7) {
        ff_text_fit("smith θ_{i} correlated", 10, room, out, sizeof out);
        FF_CHECK(ff_text_points(out, 10) <= room, "'%s' in %g points", out, room);
        const char *open = strrchr(out, '{'), *close = strrchr(out, '}');
        FF_CHECK(!open || (close && close > open), "a subscript is cut: '%s'", out);
    }
}

static void numbers(void)
{
    static const struct {
        double x;
        const char *text;
    } cases[] = {{0, "0"},          {1, "1"},        {-1.5, "-1.5"}, {0.004, "0"}, {-0.004, "0"},
                 {12.345, "12.35"}, {99.999, "100"}, {0.05, "0.05"}, {NAN, "0"},   {1e300, "1000000000"}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        char text[FF_POINT];
        const size_t n = ff_point_text(cases[k].x, text);
        FF_CHECK(!strcmp(text, cases[k].text) && n == strlen(text), "%g is written '%s'", cases[k].x, text);
    }
}

static double lightness(uint32_t c)
{
    return 0.2126 * pow((c >> 16 & 255) / 255.0, 2.2) + 0.7152 * pow((c >> 8 & 255) / 255.0, 2.2) +
           0.0722 * pow((c & 255) / 255.0, 2.2);
}

/* Read in grey, a map rises all the way, and the diverging one to both sides alike. */
static void colours(void)
{
    for (int k = 0; k < 100; k++)
        FF_CHECK(lightness(ff_colour_of(FF_MAP_VIRIDIS, k / 100.0)) < lightness(ff_colour_of(FF_MAP_VIRIDIS, (k + 1) / 100.0)),
                 "viridis at %d", k);
    for (int k = 0; k < 50; k++) {
        FF_CHECK(lightness(ff_colour_of(FF_MAP_DIVERGING, k / 100.0)) < lightness(ff_colour_of(FF_MAP_DIVERGING, (k + 1) / 100.0)),
                 "below at %d", k);
        FF_CHECK(lightness(ff_colour_of(FF_MAP_DIVERGING, 1 - k / 100.0)) <
                     lightness(ff_colour_of(FF_MAP_DIVERGING, 1 - (k + 1) / 100.0)),
                 "above at %d", k);
    }
    FF_CHECK(ff_colour_of(FF_MAP_VIRIDIS, 0) == 0x440154 && ff_colour_of(FF_MAP_VIRIDIS, 1) == 0xfde725, "ends of viridis");
    FF_CHECK(ff_colour_of(FF_MAP_DIVERGING, 0.5) == 0xf7f7f7 &&
                 ff_colour_of(FF_MAP_VIRIDIS, NAN) != ff_colour_of(FF_MAP_VIRIDIS, 0),
             "middle, none");
    for (size_t a = 0; a < 20; a++)
        for (size_t b = a + 1; b < 20; b++) {
            const ff_style p = ff_style_at(a), q = ff_style_at(b);
            FF_CHECK(p.colour != q.colour || p.dash != q.dash, "styles %zu and %zu are the same", a, b);
        }
}

static void plain_text(void)
{
    char out[32];
    FF_CHECK(!strcmp(ff_figure_plain("a_{b}^{c}\n\xff", out, sizeof out), "a {b} {c}??"), "'%s'", out);
    ff_figure_plain("0123456789012345678901234567890123456789", out, sizeof out);
    FF_CHECK(strlen(out) < sizeof out, "cut");
    FF_CHECK(ff_figure_form_find("a.svg") == FF_FIGURE_SVG && ff_figure_form_find("b/a.PDF") == FF_FIGURE_PDF &&
                 ff_figure_form_find("a.csv.x") == -1 && ff_figure_form_find("csv") == -1 && ff_figure_form_find("a.") == -1,
             "forms by extension");
}

/* A figure of every kind of series and panel is written, in both forms; one without room is refused. */
static void drawn(void)
{
    ff_figure fig;
    ff_error err = {0};
    ff_figure_init(&fig);
    fig.columns = 2;
    for (int kind = 0; kind < 3; kind++) {
        ff_panel *p = ff_figure_panel(&fig, "panel");
        p->kind = (ff_panel_kind)kind;
        ff_axis_say(&p->x, "x", "degrees", FF_SCALE_ANGLE, 0, 90);
        ff_axis_say(&p->y, "y", "1", kind == 0 ? FF_SCALE_LOG : FF_SCALE_LINEAR, kind ? 0 : NAN, NAN);
        for (int s = 0; s < FF_SERIES_IMAGE; s++) {
            ff_series *v = ff_panel_series(&fig, p, (ff_series_kind)s, "series", ff_style_at((size_t)s), 5,
                                           FF_WITH_X_ERRORS | FF_WITH_Y_ERRORS);
            for (size_t i = 0; i < 5; i++)
                v->x[i] = 10 * (double)i, v->y[i] = (double)i, v->low[i] = (double)i - 1, v->high[i] = (double)i + 1;
        }
        ff_panel_rule_x(&fig, p, "rule", ff_style_at(3), 30);
    }
    const char *path = ff_test_path("a.svg");
    for (int form = 0; form < FF_FIGURE_FORMS; form++) {
        FILE *f = fopen(path, "wb");
        FF_CHECK(ff_figure_write(&fig, (ff_figure_form)form, f, &err) == FF_OK, "%s", err.message);
        FF_CHECK(ftell(f) > 500, "%s is empty", ff_figure_form_name(form));
        fclose(f);
    }
    FILE *f = fopen(path, "wb");
    fig.width = 30;
    FF_CHECK(ff_figure_write(&fig, FF_FIGURE_SVG, f, &err) == FF_ERR_RANGE && strstr(err.message, "no room"), "%s", err.message);
    fig.width = 400, fig.height = 20;
    FF_CHECK(ff_figure_write(&fig, FF_FIGURE_SVG, f, &err) == FF_ERR_RANGE, "a height without room");
    fclose(f);
    ff_figure_clear(&fig);
}

FF_TEST_MAIN(FF_TEST(ticks_of_any_range), FF_TEST(ticks_that_people_like), FF_TEST(texts_of_axes), FF_TEST(glyphs), FF_TEST(widths),
             FF_TEST(numbers), FF_TEST(colours), FF_TEST(plain_text), FF_TEST(drawn))
