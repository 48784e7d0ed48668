/* Which column is which: what the names say is brought together into one reading of the table, or a refusal with the option that
 * would read it. */
#define _GNU_SOURCE
#include "internal_csv_plan.h"
#include "base/internal_input.h"
#include "base/internal_number.h"
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

enum { NONE = -1 };

static void assume(ff_planner *p, const char *fmt, ...) __attribute__((format(printf, 2, 3)));
static void assume(ff_planner *p, const char *fmt, ...)
{
    va_list args;
    const size_t used = strlen(p->plan.notes), room = sizeof p->plan.notes - used;
    va_start(args, fmt);
    const int n = vsnprintf(p->plan.notes + used, room, fmt, args);
    va_end(args);
    if (n < 0 || (size_t)n + 2 > room)
        p->plan.notes[used] = '\0';
    else
        strcpy(p->plan.notes + used + n, "\n");
}

static const char *unit_text(ff_csv_unit unit)
{
    switch (unit) {
    case FF_CSV_RADIANS:
        return ":rad";
    case FF_CSV_NM:
        return ":nm";
    case FF_CSV_UM:
        return ":um";
    case FF_CSV_M:
        return ":m";
    case FF_CSV_PERCENT:
        return ":%";
    default:
        return "";
    }
}

static void put_number(FILE *out, double v)
{
    char text[FF_NUMBER_TEXT];
    fwrite(text, 1, ff_number_write(v, text), out);
}

static void put_separator(ff_planner *p)
{
    if (ftell(p->text) > 0) fputc(',', p->text);
}

static void put_column(ff_planner *p, const char *key, size_t k, const char *unit)
{
    put_separator(p);
    fprintf(p->text, "%s=#%zu%s", key, k + 1, unit);
    p->column[k].used = 1;
}

static void put_constant(ff_planner *p, const char *key, double v)
{
    put_separator(p);
    fprintf(p->text, "%s=", key);
    put_number(p->text, v);
}

static void put_setting(ff_planner *p, const char *key, ff_meaning meaning)
{
    const ff_plan_setting *s = &p->setting[meaning];
    put_separator(p);
    fprintf(p->text, "%s=@%s%s", key, s->name, unit_text(s->unit));
}

/* The option so far, ending what is written: for messages. */
static const char *so_far(ff_planner *p)
{
    return fflush(p->text) == 0 && p->plan.columns ? p->plan.columns : "";
}

/* ---- refusing ------------------------------------------------------------------------------------ */

static const char *list_names(const ff_planner *p, char out[FF_NAMES_LIST])
{
    size_t used = 0;
    out[0] = '\0';
    for (size_t k = 0; k < p->n; k++) {
        const size_t n = strlen(p->column[k].name);
        if (used + n + 8 > FF_NAMES_LIST) {
            strcpy(out + used, ", ...");
            break;
        }
        used = (size_t)(stpcpy(stpcpy(out + used, used ? ", " : ""), p->column[k].name) - out);
    }
    return out;
}

static ff_status refuse(ff_planner *p, const char *why, const char *say)
{
    char names[FF_NAMES_LIST];
    return ff_error_hint(p->err,
                         ff_error_set(p->err, FF_ERR_FORMAT, p->path, (long)(p->header_line ? p->header_line : p->look->first_row),
                                      -1, "found the columns %s; %s; say columns '%s'", list_names(p, names), why, say),
                         FF_HINT_SAY);
}

/* Azimuths are what goes beyond a right angle. */
static int is_wide(const ff_plan_column *c)
{
    return c->hi > 90.01 || c->lo < -90.01;
}

/* The first columns in the order that most tables have, for those whose names say nothing. */
static void guess(const ff_planner *p, char *out, size_t size)
{
    static const char *const usual[6] = {"",
                                         "",
                                         "theta_i=20,phi_i=0,theta_o=#1,phi_o=180,f=#2",
                                         "theta_i=#1,phi_i=0,theta_o=#2,phi_o=180,f=#3",
                                         "theta_i=#1,phi_i=0,theta_o=#2,phi_o=#3,f=#4",
                                         "theta_i=#1,phi_i=#2,theta_o=#3,phi_o=#4,f=#5"};
    static const char *const usual_radians[6] = {"",
                                                 "",
                                                 "theta_i=20,phi_i=0,theta_o=#1:rad,phi_o=180,f=#2",
                                                 "theta_i=#1:rad,phi_i=0,theta_o=#2:rad,phi_o=180,f=#3",
                                                 "theta_i=#1:rad,phi_i=0,theta_o=#2:rad,phi_o=#3:rad,f=#4",
                                                 "theta_i=#1:rad,phi_i=#2:rad,theta_o=#3:rad,phi_o=#4:rad,f=#5"};
    size_t n = p->n;
    double largest = 0;
    for (size_t k = 0; k + 1 < n; k++) largest = fmax(largest, fmax(fabs(p->column[k].lo), fabs(p->column[k].hi)));
    const int radians = largest <= 6.2832;
    if (n > 5) n = 5;
    if (n == 5 && is_wide(&p->column[2]) && !is_wide(&p->column[1])) {
        snprintf(out, size, "theta_i=#1,theta_o=#2,phi_i=#3,phi_o=#4,f=#5");
        return;
    }
    snprintf(out, size, "%s", radians ? usual_radians[n] : usual[n]);
}

static ff_status refuse_unnamed(ff_planner *p)
{
    char say[256];
    guess(p, say, sizeof say);
    return ff_error_hint(
        p->err,
        ff_error_set(p->err, FF_ERR_FORMAT, p->path, (long)p->look->first_row, -1,
                     "found %zu columns and no line of names above them that says which angle is which, expected one as "
                     "theta_i,phi_i,theta_o,phi_o,f; if they are in this order, say columns '%s'",
                     p->n, say),
        FF_HINT_SAY);
}

/* ---- looking for columns ----------------------------------------------------------------------------- */

/* The column of a meaning, without a number in its name; NONE. */
static long find(const ff_planner *p, ff_meaning meaning)
{
    for (size_t k = 0; k < p->n; k++)
        if (p->column[k].named.meaning == meaning && isnan(p->column[k].named.number) && isfinite(p->column[k].lo)) return (long)k;
    return NONE;
}

static ff_status check_once(ff_planner *p)
{
    char why[160 + FF_PLAN_NAME];
    for (size_t k = 0; k < p->n; k++) {
        const ff_named *one = &p->column[k].named;
        if (one->meaning == FF_MEANS_NOTHING || one->meaning >= FF_MEANS_VALUE || !isnan(one->number)) continue;
        for (size_t j = 0; j < k; j++) {
            if (p->column[j].named.meaning != one->meaning || !isnan(p->column[j].named.number)) continue;
            char say[256];
            guess(p, say, sizeof say);
            snprintf(why, sizeof why, "columns %zu and %zu mean the same", j + 1, k + 1);
            return refuse(p, why, say);
        }
    }
    return FF_OK;
}

static int is_named(const ff_planner *p, ff_meaning meaning)
{
    return find(p, meaning) != NONE || p->setting[meaning].count > 0;
}

/* A polar angle of no side is that of the side that nothing else names. */
static void settle_sides(ff_planner *p, int wide_over_theta_i)
{
    const long open = find(p, FF_MEANS_THETA);
    double degrees;
    const int i = ff_name_incidence(p->path, &degrees) || is_named(p, FF_MEANS_THETA_I) || is_named(p, FF_MEANS_ELEVATION_I) ||
                  wide_over_theta_i;
    const int o = is_named(p, FF_MEANS_THETA_O) || is_named(p, FF_MEANS_ELEVATION_O);
    if (open != NONE && !o)
        p->column[open].named.meaning = FF_MEANS_THETA_O;
    else if (open != NONE && !i)
        p->column[open].named.meaning = FF_MEANS_THETA_I;
    const long between = find(p, FF_MEANS_PHI_D);
    if (between != NONE && find(p, FF_MEANS_THETA_H) == NONE) p->column[between].named.meaning = FF_MEANS_PHI;
}

/* ---- values ------------------------------------------------------------------------------------------- */

static int is_value(const ff_plan_column *c)
{
    return c->named.meaning == FF_MEANS_VALUE && isfinite(c->lo);
}

static int has_color_partner(const ff_planner *p)
{
    int green = 0, blue = 0;
    for (size_t k = 0; k < p->n; k++) {
        green |= !strcasecmp(p->column[k].name, "g");
        blue |= !strcasecmp(p->column[k].name, "b");
    }
    return green && blue;
}

/* Only the highest rank of values counts; R beside G and B is red. */
static void choose_values(ff_planner *p)
{
    int most = FF_RANK_NONE;
    for (size_t k = 0; k < p->n; k++) {
        ff_named *one = &p->column[k].named;
        if (!strcasecmp(p->column[k].name, "r") && has_color_partner(p)) {
            one->rank = FF_RANK_PLAIN;
            one->quantity = FF_BRDF;
            strcpy(one->channel, p->column[k].name);
        }
        if (is_value(&p->column[k]) && one->rank > most) most = one->rank;
    }
    for (size_t k = 0; k < p->n; k++)
        if (is_value(&p->column[k]) && p->column[k].named.rank < most) p->column[k].named.meaning = FF_MEANS_NOTHING;
}

static int is_angle_number(const ff_named *one)
{
    return !isnan(one->number) &&
           (one->number_unit == FF_CSV_PLAIN || one->number_unit == FF_CSV_DEGREES || one->number_unit == FF_CSV_RADIANS);
}

static int is_wavelength_number(const ff_named *one)
{
    return !isnan(one->number) && (one->number_unit == FF_CSV_NM || one->number_unit == FF_CSV_UM || one->number_unit == FF_CSV_M);
}

/* Columns named by plain numbers that are too large for angles are wavelengths in nm. */
static void settle_numbers(ff_planner *p)
{
    double least = INFINITY;
    size_t n = 0;
    for (size_t k = 0; k < p->n; k++) {
        const ff_named *one = &p->column[k].named;
        if (isnan(one->number) || one->number_unit != FF_CSV_PLAIN) continue;
        least = fmin(least, one->number);
        n++;
    }
    if (n == 0 || !(least >= 181)) return;
    for (size_t k = 0; k < p->n; k++)
        if (!isnan(p->column[k].named.number)) p->column[k].named.number_unit = FF_CSV_NM;
    assume(p, "columns that are named by numbers are taken for wavelengths in nm");
}

/* Columns of values at angles: how many, the first, and 1 when they stand side by side in one unit. */
typedef struct wide {
    size_t n, first;
    int fine;
    ff_csv_unit unit;
    ff_meaning says; /* the angle that their names say */
} wide;

static wide find_wide(const ff_planner *p)
{
    wide w = {.fine = 1, .says = FF_MEANS_NOTHING};
    for (size_t k = 0; k < p->n; k++) {
        const ff_named *one = &p->column[k].named;
        const int angle = one->meaning >= FF_MEANS_THETA_I && one->meaning <= FF_MEANS_PHI;
        if (!is_angle_number(one) || !(one->meaning == FF_MEANS_VALUE || one->meaning == FF_MEANS_NUMBER || angle)) continue;
        if (w.n == 0) w.first = k, w.unit = one->number_unit;
        if (w.first + w.n != k || one->number_unit != w.unit) w.fine = 0;
        if (angle) w.says = one->meaning;
        w.n++;
    }
    return w;
}

/* "theta_o\phi_o" above the first column: the angle down, and the one across. */
static int split_corner(ff_planner *p, ff_meaning *across)
{
    for (size_t k = 0; k < p->n; k++) {
        char down[FF_PLAN_NAME];
        ff_named a, b;
        strcpy(down, p->column[k].name);
        char *slash = strpbrk(down, "\\/|");
        if (!slash || !slash[1]) continue;
        *slash = '\0';
        ff_name_meaning(down, &a);
        ff_name_meaning(slash + 1, &b);
        if (a.meaning == FF_MEANS_NOTHING || a.meaning >= FF_MEANS_VALUE || b.meaning == FF_MEANS_NOTHING ||
            b.meaning >= FF_MEANS_VALUE)
            continue;
        p->column[k].named = a;
        *across = b.meaning;
        return 1;
    }
    return 0;
}

static const char *key_of(ff_meaning m)
{
    switch (m) {
    case FF_MEANS_THETA_I:
        return "theta_i";
    case FF_MEANS_THETA_O:
    case FF_MEANS_THETA:
        return "theta_o";
    case FF_MEANS_PHI_I:
        return "phi_i";
    default:
        return "phi_o";
    }
}

static void put_wide(ff_planner *p, const wide *w, ff_meaning over)
{
    put_separator(p);
    fprintf(p->text, "f@%s=", key_of(over));
    for (size_t k = 0; k < w->n; k++) {
        if (k) fputc(':', p->text);
        put_number(p->text, p->column[w->first + k].named.number);
        p->column[w->first + k].used = 1;
    }
    fprintf(p->text, "@#%zu%s", w->first + 1, unit_text(w->unit));
    assume(p, "%zu columns are one a value of %s", w->n, key_of(over));
}

/* ---- angles ------------------------------------------------------------------------------------------- */

static void put_angle(ff_planner *p, const char *key, size_t k, int elevation)
{
    const ff_csv_unit unit = p->column[k].named.unit;
    put_column(p, key, k, elevation ? unit == FF_CSV_RADIANS ? ":elevation-rad" : ":elevation" : unit_text(unit));
}

/* 1 when something gives the angle, and then it is written. */
static int put_polar(ff_planner *p, const char *key, ff_meaning theta, ff_meaning elevation)
{
    const long k = find(p, theta), e = find(p, elevation);
    if (k != NONE)
        put_angle(p, key, (size_t)k, 0);
    else if (e != NONE)
        put_angle(p, key, (size_t)e, 1);
    else if (p->setting[theta].count)
        put_setting(p, key, theta);
    else
        return 0;
    if (k == NONE && e != NONE) assume(p, "%s is an elevation above the surface", key);
    return 1;
}

/* Columns that nothing is known of and that hold numbers, from the k-th on; NONE. */
static long next_unknown(const ff_planner *p, long k)
{
    for (k++; k < (long)p->n; k++)
        if (!p->column[k].used && p->column[k].named.meaning == FF_MEANS_NOTHING && isfinite(p->column[k].lo)) return k;
    return NONE;
}

static long last_unknown(const ff_planner *p)
{
    long last = NONE;
    for (long k = next_unknown(p, NONE); k != NONE; k = next_unknown(p, k)) last = k;
    return last;
}

static long first_value(const ff_planner *p)
{
    for (size_t k = 0; k < p->n; k++)
        if (is_value(&p->column[k])) return (long)k;
    return NONE;
}

/* What is missing of the polar angles: the first column that nothing is known of may be it, the last one the values. */
static ff_status refuse_polar(ff_planner *p, const char *key)
{
    char why[128], say[640];
    const int is_i = strcmp(key, "theta_i") == 0;
    const long o = find(p, FF_MEANS_THETA_O),
               phi_known = find(p, FF_MEANS_PHI_O) != NONE ? find(p, FF_MEANS_PHI_O) : find(p, FF_MEANS_PHI);
    long value = first_value(p), free = next_unknown(p, NONE), phi = phi_known;
    if (value == NONE) value = last_unknown(p);
    if (free == value) free = NONE;
    if (phi == NONE && free != NONE) phi = next_unknown(p, free);
    if (phi == value) phi = NONE;
    if ((is_i && o == NONE) || value == NONE) {
        guess(p, say, sizeof say);
    } else {
        const char *made = so_far(p);
        size_t used = (size_t)snprintf(say, sizeof say, "%.200s%s", made, *made ? "," : "");
        used += (size_t)(free != NONE ? snprintf(say + used, sizeof say - used, "%s=#%ld", key, free + 1)
                                      : snprintf(say + used, sizeof say - used, "%s=20", key));
        if (is_i)
            used += (size_t)snprintf(say + used, sizeof say - used, ",theta_o=#%ld%s", o + 1, unit_text(p->column[o].named.unit));
        used += (size_t)(phi == NONE ? snprintf(say + used, sizeof say - used, ",phi_i=0,phi_o=180")
                                     : snprintf(say + used, sizeof say - used, ",phi_i=0,phi_o=#%ld%s", phi + 1,
                                                unit_text(p->column[phi].named.unit)));
        snprintf(say + used, sizeof say - used, ",f=#%ld%s", value + 1, unit_text(p->column[value].named.unit));
    }
    snprintf(why, sizeof why, "none of them is %s%s", key, free == NONE ? ", here as if it were 20 degrees everywhere" : "");
    return refuse(p, why, say);
}

static ff_status put_azimuths(ff_planner *p, const wide *w, ff_meaning over)
{
    const long i = find(p, FF_MEANS_PHI_I);
    long o = find(p, FF_MEANS_PHI_O);
    const int across = w->n && (over == FF_MEANS_PHI_O || over == FF_MEANS_PHI);
    if (o == NONE) o = find(p, FF_MEANS_PHI);
    if (i != NONE)
        put_angle(p, "phi_i", (size_t)i, 0);
    else if (p->setting[FF_MEANS_PHI_I].count)
        put_setting(p, "phi_i", FF_MEANS_PHI_I);
    else if (over != FF_MEANS_PHI_I)
        put_constant(p, "phi_i", 0);
    if (o != NONE) {
        put_angle(p, "phi_o", (size_t)o, 0);
        if (i == NONE) assume(p, "the only azimuth is taken as counted from that of the light: phi_i is 0");
    } else if (across) {
        return FF_OK;
    } else if (p->setting[FF_MEANS_PHI_O].count || p->setting[FF_MEANS_PHI].count) {
        put_setting(p, "phi_o", p->setting[FF_MEANS_PHI_O].count ? FF_MEANS_PHI_O : FF_MEANS_PHI);
    } else if (i != NONE) {
        const long value = first_value(p) != NONE ? first_value(p) : last_unknown(p);
        char say[512];
        snprintf(say, sizeof say, "%.300s,phi_o=180,f=#%ld", so_far(p), value + 1);
        return refuse(p, "none of them is phi_o, here as if it were 180 degrees everywhere", say);
    } else {
        put_constant(p, "phi_o", 180);
        fputs(":deg", p->text);
        p->plan.scan = 1;
        assume(p, "there is no azimuth: a scan in the plane of incidence, positive angles on the side of the mirror direction");
    }
    return FF_OK;
}

/* ---- values into the option ------------------------------------------------------------------------------ */

static void put_name(FILE *out, const char *name)
{
    for (; *name; name++) fputc(strchr(",:|#=\"@", *name) ? '_' : *name, out);
}

static void put_sigma_of(ff_planner *p, const char *channel, size_t n_values)
{
    for (size_t k = 0; k < p->n; k++) {
        const ff_plan_column *c = &p->column[k];
        if (c->named.meaning != FF_MEANS_SIGMA || c->used || !isfinite(c->lo)) continue;
        if (strcmp(c->named.channel, channel) != 0 && !(n_values == 1 && !*c->named.channel)) continue;
        put_separator(p);
        fputs(*channel ? "sigma_" : "sigma", p->text);
        put_name(p->text, channel);
        fprintf(p->text, "=#%zu%s", k + 1, unit_text(c->named.unit));
        p->column[k].used = 1;
        return;
    }
}

/* The name of a channel: of its wavelength, of what else its name says, or "" of f. */
static void channel_of(const ff_planner *p, size_t k, char out[FF_CHANNEL_NAME])
{
    const ff_named *one = &p->column[k].named;
    strcpy(out, one->channel);
    if (is_wavelength_number(one))
        ff_csv_wavelength_name(one->number * (one->number_unit == FF_CSV_UM ? 1e3 : one->number_unit == FF_CSV_M ? 1e9 : 1), out);
}

static int is_channel(const ff_plan_column *c)
{
    return isfinite(c->lo) && !c->used &&
           (c->named.meaning == FF_MEANS_VALUE || (c->named.meaning == FF_MEANS_NUMBER && is_wavelength_number(&c->named)));
}

/* A standard deviation of all channels, or of none. */
static int has_all_sigmas(const ff_planner *p, size_t n_values)
{
    size_t found = 0;
    for (size_t k = 0; k < p->n; k++) {
        if (p->column[k].named.meaning != FF_MEANS_SIGMA || !isfinite(p->column[k].lo)) continue;
        if (n_values == 1) return 1;
        for (size_t j = 0; j < p->n; j++) {
            char name[FF_CHANNEL_NAME], own[FF_CHANNEL_NAME];
            if (p->column[j].named.meaning == FF_MEANS_SIGMA || !(p->column[j].used || is_channel(&p->column[j]))) continue;
            channel_of(p, j, name);
            channel_of(p, k, own);
            found += is_value(&p->column[j]) && strcmp(name, own) == 0;
        }
    }
    return found == n_values;
}

static ff_status refuse_values(ff_planner *p)
{
    char say[512];
    snprintf(say, sizeof say, "%.380s", so_far(p));
    for (size_t k = 0; k < p->n; k++) {
        const size_t used = strlen(say);
        if (p->column[k].used || p->column[k].named.meaning != FF_MEANS_NOTHING || !isfinite(p->column[k].lo)) continue;
        snprintf(say + used, sizeof say - used, ",f=#%zu", k + 1);
        return refuse(p, "none of them is known to be the BRDF", say);
    }
    return refuse(p, "none of them is the BRDF", "theta_i=#1,phi_i=0,theta_o=#2,phi_o=180,f=#3");
}

/* A single stranger beside columns that are all known is the value. */
static void adopt_stranger(ff_planner *p)
{
    long only = NONE;
    size_t n = 0;
    for (size_t k = 0; k < p->n; k++) {
        if (is_channel(&p->column[k])) return;
        if (p->column[k].used || p->column[k].named.meaning != FF_MEANS_NOTHING || !isfinite(p->column[k].lo)) continue;
        only = (long)k;
        n++;
    }
    if (n != 1) return;
    p->column[only].named.meaning = FF_MEANS_VALUE;
    p->column[only].named.rank = FF_RANK_PLAIN;
    assume(p, "column '%s' is taken for the values, since all others are known", p->column[only].name);
}

static ff_status put_values(ff_planner *p)
{
    size_t n_values = 0;
    adopt_stranger(p);
    for (size_t k = 0; k < p->n; k++) n_values += is_channel(&p->column[k]) != 0;
    if (n_values == 0) return refuse_values(p);
    const int sigmas = has_all_sigmas(p, n_values);
    const ff_plan_setting *lambda = &p->setting[FF_MEANS_WAVELENGTH];
    for (size_t k = 0; k < p->n; k++) {
        char channel[FF_CHANNEL_NAME];
        const ff_named *one = &p->column[k].named;
        if (!is_channel(&p->column[k])) continue;
        channel_of(p, k, channel);
        if (n_values == 1 && !*channel && lambda->count == 1 && lambda->value > 0)
            ff_csv_wavelength_name(lambda->value * (lambda->unit == FF_CSV_UM ? 1e3 : lambda->unit == FF_CSV_M ? 1e9 : 1), channel);
        p->plan.quantity = one->quantity;
        put_separator(p);
        fputs(*channel ? "f_" : "f", p->text);
        put_name(p->text, channel);
        fprintf(p->text, "=#%zu%s", k + 1, unit_text(one->unit));
        p->column[k].used = 1;
        if (one->rank == FF_RANK_REFLECTANCE && one->unit != FF_CSV_PERCENT)
            assume(p, "'%s' is taken for the BRDF in 1/sr: say quantity reflectance-factor if it is pi times that",
                   p->column[k].name);
        if (one->rank == FF_RANK_COUNTS)
            assume(p,
                   "'%s' is what a detector gave, proportional to the BRDF at best: say quantity brdf-cos if its power was not "
                   "divided by "
                   "the cosine",
                   p->column[k].name);
        if (sigmas) put_sigma_of(p, channel, n_values);
    }
    return FF_OK;
}

static ff_csv_unit wavelength_unit(ff_planner *p, size_t k)
{
    const ff_plan_column *c = &p->column[k];
    if (c->named.unit != FF_CSV_PLAIN) return c->named.unit;
    return c->hi > 100 ? FF_CSV_NM : c->lo > 0.05 ? FF_CSV_UM : FF_CSV_M;
}

/* ---- all of it --------------------------------------------------------------------------------------------- */

/* Angles without a unit that are all small may be radians: wrong by 57 times is worse than a question. */
static ff_status check_units(ff_planner *p)
{
    double polar = 0;
    size_t without = 0;
    for (size_t k = 0; k < p->n; k++) {
        const ff_plan_column *c = &p->column[k];
        const ff_meaning m = c->named.meaning;
        if (!c->used || m == FF_MEANS_NOTHING || m >= FF_MEANS_WI_X || !isnan(c->named.number)) continue;
        if (c->named.unit != FF_CSV_PLAIN) return FF_OK;
        without++;
        if (m == FF_MEANS_PHI_I || m == FF_MEANS_PHI_O || m == FF_MEANS_PHI || m == FF_MEANS_PHI_H || m == FF_MEANS_PHI_D) continue;
        polar = fmax(polar, fmax(fabs(c->lo), fabs(c->hi)));
    }
    if (without == 0 || p->angles == FF_ANGLES_DEGREES || p->angles == FF_ANGLES_RADIANS) return FF_OK;
    if (polar > p->small || polar == 0) {
        assume(p, "angles without a unit are taken to be degrees");
        return FF_OK;
    }
    char names[FF_NAMES_LIST];
    return ff_error_hint(
        p->err,
        ff_error_set(p->err, FF_ERR_FORMAT, p->path, (long)p->header_line, -1,
                     "found the columns %s; their polar angles have no unit and are all below 1.571: if they are not in degrees "
                     "(which angles degrees insists on), say angles radians",
                     list_names(p, names)),
        FF_HINT_SAY);
}

static void name_strangers(ff_planner *p)
{
    char names[FF_NAMES_LIST] = "";
    size_t used = 0, n = 0;
    for (size_t k = 0; k < p->n; k++) {
        if (p->column[k].used || !*p->column[k].name || !isfinite(p->column[k].lo)) continue;
        const size_t length = strlen(p->column[k].name);
        n++;
        if (used + length + 12 > sizeof names) continue;
        used = (size_t)(stpcpy(stpcpy(stpcpy(stpcpy(names + used, used ? ", " : ""), "'"), p->column[k].name), "'") - names);
    }
    if (n)
        assume(p, "not read %s %s: the option 'columns' takes a channel as f_NAME=#NUMBER",
               n == 1 ? "is the column" : "are the columns", names);
}

static ff_status put_half_difference(ff_planner *p)
{
    static const struct {
        const char *key;
        ff_meaning meaning;
    } all[] = {{"theta_h", FF_MEANS_THETA_H}, {"phi_h", FF_MEANS_PHI_H}, {"theta_d", FF_MEANS_THETA_D}, {"phi_d", FF_MEANS_PHI_D}};
    for (size_t k = 0; k < 4; k++) {
        long c = find(p, all[k].meaning);
        if (c == NONE && all[k].meaning == FF_MEANS_PHI_D) c = find(p, FF_MEANS_PHI);
        if (c != NONE)
            put_angle(p, all[k].key, (size_t)c, 0);
        else if (all[k].meaning == FF_MEANS_PHI_H)
            put_constant(p, "phi_h", 0);
        else
            return refuse(p, "half and difference angles are theta_h, theta_d and phi_d",
                          "theta_h=#1,phi_h=0,theta_d=#2,phi_d=#3,f=#4");
    }
    return FF_OK;
}

static ff_status put_vectors(ff_planner *p)
{
    static const char *const key[6] = {"wi_x", "wi_y", "wi_z", "wo_x", "wo_y", "wo_z"};
    for (int k = 0; k < 6; k++) {
        const long c = find(p, (ff_meaning)(FF_MEANS_WI_X + k));
        if (c == NONE)
            return refuse(p, "of the directions as vectors one component is missing",
                          "wi_x=#1,wi_y=#2,wi_z=#3,wo_x=#4,wo_y=#5,wo_z=#6,f=#7");
        put_column(p, key[k], (size_t)c, "");
    }
    return FF_OK;
}

/* The angle that values side by side differ in, where neither their names nor a corner say it: what nothing else gives. */
static ff_meaning missing_angle(const ff_planner *p)
{
    if (!is_named(p, FF_MEANS_THETA_I) && !is_named(p, FF_MEANS_ELEVATION_I)) return FF_MEANS_THETA_I;
    if (!is_named(p, FF_MEANS_THETA_O) && !is_named(p, FF_MEANS_ELEVATION_O)) return FF_MEANS_THETA_O;
    return FF_MEANS_PHI_O;
}

/* One file an incidence: its name says which. */
static int put_name_of_file(ff_planner *p)
{
    double degrees;
    if (!ff_name_incidence(p->path, &degrees)) return 0;
    put_separator(p);
    fputs("theta_i=", p->text);
    put_number(p->text, degrees);
    fputs(":deg", p->text);
    assume(p, "theta_i is %g degrees by the name of the file", degrees);
    return 1;
}

static ff_status put_directions(ff_planner *p, const wide *w, ff_meaning over)
{
    if (find(p, FF_MEANS_THETA_H) != NONE && find(p, FF_MEANS_THETA_D) != NONE) return put_half_difference(p);
    if (find(p, FF_MEANS_WI_X) != NONE && find(p, FF_MEANS_WO_X) != NONE) return put_vectors(p);
    if (!(w->n && over == FF_MEANS_THETA_I) && !put_polar(p, "theta_i", FF_MEANS_THETA_I, FF_MEANS_ELEVATION_I) &&
        !put_name_of_file(p))
        return refuse_polar(p, "theta_i");
    if (!(w->n && over == FF_MEANS_THETA_O) && !put_polar(p, "theta_o", FF_MEANS_THETA_O, FF_MEANS_ELEVATION_O))
        return refuse_polar(p, "theta_o");
    return put_azimuths(p, w, over);
}

ff_status ff_plan_assign(ff_planner *p)
{
    ff_meaning over = FF_MEANS_NOTHING;
    if (!p->header_line) return refuse_unnamed(p);
    const int corner = split_corner(p, &over);
    choose_values(p);
    settle_numbers(p);
    ff_status status = check_once(p);
    if (status != FF_OK) return status;
    wide w = find_wide(p);
    if (w.n && over == FF_MEANS_NOTHING) over = w.says;
    settle_sides(p, w.n > 0 && (over == FF_MEANS_THETA_I || (over == FF_MEANS_NOTHING && !is_named(p, FF_MEANS_THETA_I))));
    if (w.n && over == FF_MEANS_NOTHING) over = missing_angle(p);
    if ((w.n && !w.fine) || (corner && !w.n))
        return refuse(p, "values at angles do not stand side by side in one unit",
                      "theta_o=#1,f@theta_i=20:40:60,phi_i=0,phi_o=180");
    status = put_directions(p, &w, over);
    if (status != FF_OK) return status;
    const long phase = find(p, FF_MEANS_PHASE), weight = find(p, FF_MEANS_WEIGHT), lambda = find(p, FF_MEANS_WAVELENGTH);
    if (phase != NONE) put_angle(p, "phase", (size_t)phase, 0);
    if (weight != NONE && w.n == 0) put_column(p, "weight", (size_t)weight, "");
    if (w.n) {
        put_wide(p, &w, over);
        p->plan.quantity = p->column[w.first].named.quantity;
    } else {
        if (lambda != NONE) put_column(p, "wavelength", (size_t)lambda, unit_text(wavelength_unit(p, (size_t)lambda)));
        status = put_values(p);
    }
    if (status == FF_OK) status = check_units(p);
    name_strangers(p);
    return status;
}
