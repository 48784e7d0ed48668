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

static ff_status check_once(ff_planner *p)
{
    char why[160 + FF_PLAN_NAME];
    for (size_t k = 0; k < p->n; k++) {
        const ff_named *one = &p->column[k].named;
        if (one->meaning == FF_MEANS_NOTHING || one->meaning >= FF_MEANS_VALUE || !isnan(one->number)) continue;
        for (size_t j = 0; j < k; j++) {
            if (p->column[j].named.meaning != one->meaning || !isnan(p->column[j].named.number)) continue;
            char say[256];
            ff_plan_guess(p, say, sizeof say);
            snprintf(why, sizeof why, "columns %zu and %zu mean the same", j + 1, k + 1);
            return ff_plan_refuse(p, why, say);
        }
    }
    return FF_OK;
}

static int is_named(const ff_planner *p, ff_meaning meaning)
{
    return ff_plan_find(p, meaning) != FF_PLAN_NONE || p->setting[meaning].count > 0;
}

/* A polar angle of no side is that of the side that nothing else names. */
static void settle_sides(ff_planner *p, int wide_over_theta_i)
{
    const long open = ff_plan_find(p, FF_MEANS_THETA);
    double degrees;
    const int i = ff_name_incidence(p->path, &degrees) || is_named(p, FF_MEANS_THETA_I) || is_named(p, FF_MEANS_ELEVATION_I) ||
                  wide_over_theta_i;
    const int o = is_named(p, FF_MEANS_THETA_O) || is_named(p, FF_MEANS_ELEVATION_O);
    if (open != FF_PLAN_NONE && !o)
        p->column[open].named.meaning = FF_MEANS_THETA_O;
    else if (open != FF_PLAN_NONE && !i)
        p->column[open].named.meaning = FF_MEANS_THETA_I;
    const long between = ff_plan_find(p, FF_MEANS_PHI_D);
    if (between != FF_PLAN_NONE && ff_plan_find(p, FF_MEANS_THETA_H) == FF_PLAN_NONE)
        p->column[between].named.meaning = FF_MEANS_PHI;
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
    ff_plan_assume(p, "columns that are named by numbers are taken for wavelengths in nm");
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
    ff_plan_put_separator(p);
    fprintf(p->text, "f@%s=", key_of(over));
    for (size_t k = 0; k < w->n; k++) {
        if (k) fputc(':', p->text);
        ff_plan_put_number(p->text, p->column[w->first + k].named.number);
        p->column[w->first + k].used = 1;
    }
    fprintf(p->text, "@#%zu%s", w->first + 1, ff_plan_unit_text(w->unit));
    ff_plan_assume(p, "%zu columns are one a value of %s", w->n, key_of(over));
}

/* ---- angles ------------------------------------------------------------------------------------------- */

static void put_angle(ff_planner *p, const char *key, size_t k, int elevation)
{
    const ff_csv_unit unit = p->column[k].named.unit;
    ff_plan_put_column(p, key, k, elevation ? unit == FF_CSV_RADIANS ? ":elevation-rad" : ":elevation" : ff_plan_unit_text(unit));
}

/* 1 when something gives the angle, and then it is written. */
static int put_polar(ff_planner *p, const char *key, ff_meaning theta, ff_meaning elevation)
{
    const long k = ff_plan_find(p, theta), e = ff_plan_find(p, elevation);
    if (k != FF_PLAN_NONE)
        put_angle(p, key, (size_t)k, 0);
    else if (e != FF_PLAN_NONE)
        put_angle(p, key, (size_t)e, 1);
    else if (p->setting[theta].count)
        ff_plan_put_setting(p, key, theta);
    else
        return 0;
    if (k == FF_PLAN_NONE && e != FF_PLAN_NONE) ff_plan_assume(p, "%s is an elevation above the surface", key);
    return 1;
}

/* Columns that nothing is known of and that hold numbers, from the k-th on; FF_PLAN_NONE. */
static long next_unknown(const ff_planner *p, long k)
{
    for (k++; k < (long)p->n; k++)
        if (!p->column[k].used && p->column[k].named.meaning == FF_MEANS_NOTHING && isfinite(p->column[k].lo)) return k;
    return FF_PLAN_NONE;
}

static long last_unknown(const ff_planner *p)
{
    long last = FF_PLAN_NONE;
    for (long k = next_unknown(p, FF_PLAN_NONE); k != FF_PLAN_NONE; k = next_unknown(p, k)) last = k;
    return last;
}

static long first_value(const ff_planner *p)
{
    for (size_t k = 0; k < p->n; k++)
        if (is_value(&p->column[k])) return (long)k;
    return FF_PLAN_NONE;
}

/* What is missing of the polar angles: the first column that nothing is known of may be it, the last one the values. */
static ff_status refuse_polar(ff_planner *p, const char *key)
{
    char why[192 + FF_PLAN_NAME], say[640];
    const int is_i = strcmp(key, "theta_i") == 0;
    const long o = ff_plan_find(p, FF_MEANS_THETA_O), phi_known = ff_plan_find(p, FF_MEANS_PHI_O) != FF_PLAN_NONE
                                                                      ? ff_plan_find(p, FF_MEANS_PHI_O)
                                                                      : ff_plan_find(p, FF_MEANS_PHI);
    long value = first_value(p), free = next_unknown(p, FF_PLAN_NONE), phi = phi_known;
    if (value == FF_PLAN_NONE) value = last_unknown(p);
    if (free == value) free = FF_PLAN_NONE;
    if (phi == FF_PLAN_NONE && free != FF_PLAN_NONE) phi = next_unknown(p, free);
    if (phi == value) phi = FF_PLAN_NONE;
    if ((is_i && o == FF_PLAN_NONE) || value == FF_PLAN_NONE) {
        ff_plan_guess(p, say, sizeof say);
    } else {
        const char *made = ff_plan_so_far(p);
        size_t used = (size_t)snprintf(say, sizeof say, "%.200s%s", made, *made ? "," : "");
        used += (size_t)(free != FF_PLAN_NONE ? snprintf(say + used, sizeof say - used, "%s=#%ld%s", key, free + 1,
                                                         p->column[free].named.is_elevation ? ":elevation" : "")
                                              : snprintf(say + used, sizeof say - used, "%s=20", key));
        if (is_i)
            used += (size_t)snprintf(say + used, sizeof say - used, ",theta_o=#%ld%s", o + 1,
                                     ff_plan_unit_text(p->column[o].named.unit));
        used += (size_t)(phi == FF_PLAN_NONE ? snprintf(say + used, sizeof say - used, ",phi_i=0,phi_o=180")
                                             : snprintf(say + used, sizeof say - used, ",phi_i=0,phi_o=#%ld%s", phi + 1,
                                                        ff_plan_unit_text(p->column[phi].named.unit)));
        snprintf(say + used, sizeof say - used, ",f=#%ld%s", value + 1, ff_plan_unit_text(p->column[value].named.unit));
    }
    if (free == FF_PLAN_NONE)
        snprintf(why, sizeof why, "none of them is %s, here as if it were 20 degrees everywhere", key);
    else
        snprintf(why, sizeof why, "none of them is %s: '%s' is %s", key, p->column[free].name,
                 p->column[free].named.is_elevation ? "an elevation of what is not known" : "not known");
    return ff_plan_refuse(p, why, say);
}

static ff_status put_azimuths(ff_planner *p, const wide *w, ff_meaning over)
{
    const long i = ff_plan_find(p, FF_MEANS_PHI_I);
    long o = ff_plan_find(p, FF_MEANS_PHI_O);
    const int across = w->n && (over == FF_MEANS_PHI_O || over == FF_MEANS_PHI);
    if (o == FF_PLAN_NONE) o = ff_plan_find(p, FF_MEANS_PHI);
    if (i != FF_PLAN_NONE)
        put_angle(p, "phi_i", (size_t)i, 0);
    else if (p->setting[FF_MEANS_PHI_I].count)
        ff_plan_put_setting(p, "phi_i", FF_MEANS_PHI_I);
    else if (over != FF_MEANS_PHI_I)
        ff_plan_put_constant(p, "phi_i", 0);
    if (o != FF_PLAN_NONE) {
        put_angle(p, "phi_o", (size_t)o, 0);
        if (i == FF_PLAN_NONE) ff_plan_assume(p, "the only azimuth is taken as counted from that of the light: phi_i is 0");
    } else if (across) {
        return FF_OK;
    } else if (p->setting[FF_MEANS_PHI_O].count || p->setting[FF_MEANS_PHI].count) {
        ff_plan_put_setting(p, "phi_o", p->setting[FF_MEANS_PHI_O].count ? FF_MEANS_PHI_O : FF_MEANS_PHI);
    } else if (i != FF_PLAN_NONE) {
        const long value = first_value(p) != FF_PLAN_NONE ? first_value(p) : last_unknown(p);
        char say[512];
        snprintf(say, sizeof say, "%.300s,phi_o=180,f=#%ld", ff_plan_so_far(p), value + 1);
        return ff_plan_refuse(p, "none of them is phi_o, here as if it were 180 degrees everywhere", say);
    } else {
        ff_plan_put_constant(p, "phi_o", 180);
        fputs(":deg", p->text);
        p->plan.scan = 1;
        ff_plan_assume(
            p, "there is no azimuth: a scan in the plane of incidence, positive angles on the side of the mirror direction");
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
        ff_plan_put_separator(p);
        fputs(*channel ? "sigma_" : "sigma", p->text);
        put_name(p->text, channel);
        fprintf(p->text, "=#%zu%s", k + 1, ff_plan_unit_text(c->named.unit));
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
    snprintf(say, sizeof say, "%.380s", ff_plan_so_far(p));
    for (size_t k = 0; k < p->n; k++) {
        const size_t used = strlen(say);
        if (p->column[k].used || p->column[k].named.meaning != FF_MEANS_NOTHING || !isfinite(p->column[k].lo)) continue;
        snprintf(say + used, sizeof say - used, ",f=#%zu", k + 1);
        return ff_plan_refuse(p, "none of them is known to be the BRDF", say);
    }
    return ff_plan_refuse(p, "none of them is the BRDF", "theta_i=#1,phi_i=0,theta_o=#2,phi_o=180,f=#3");
}

/* A single stranger beside columns that are all known is the value. */
static void adopt_stranger(ff_planner *p)
{
    long only = FF_PLAN_NONE;
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
    ff_plan_assume(p, "column '%s' is taken for the values, since all others are known", p->column[only].name);
}

/* What the name of the values was taken to say of them, unless the file says it in our words. */
static void say_quantity(ff_planner *p, const ff_plan_column *c)
{
    const char *in_percent = c->named.unit == FF_CSV_PERCENT ? ", in per cent" : "";
    if (p->head.quantity_is_said)
        return;
    else if (c->named.quantity == FF_REFLECTANCE_FACTOR)
        ff_plan_assume(p, "'%s' is taken for pi times the BRDF, reflectance-factor%s: say quantity brdf if it is not", c->name,
                       in_percent);
    else if (c->named.quantity == FF_BRDF_COS)
        ff_plan_assume(p, "'%s' is taken for the BRDF times cos(theta_o), brdf-cos%s: say quantity brdf if it is not", c->name,
                       in_percent);
    else if (c->named.rank == FF_RANK_REFLECTANCE)
        ff_plan_assume(p, "'%s' is taken for the BRDF in 1/sr%s: say quantity reflectance-factor if it is pi times that", c->name,
                       in_percent);
    else if (c->named.rank == FF_RANK_COUNTS)
        ff_plan_assume(p,
                       "'%s' is what a detector gave, proportional to the BRDF at best: say quantity brdf-cos if its power was not "
                       "divided by the cosine",
                       c->name);
    else if (*in_percent)
        ff_plan_assume(p, "'%s' is taken for the BRDF in 1/sr%s", c->name, in_percent);
}

static ff_status put_values(ff_planner *p)
{
    size_t n_values = 0, said = 0;
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
        p->plan.says_quantity |= one->quantity != FF_BRDF || ff_csv_names_brdf(p->column[k].name);
        ff_plan_put_separator(p);
        fputs(*channel ? "f_" : "f", p->text);
        put_name(p->text, channel);
        fprintf(p->text, "=#%zu%s", k + 1, ff_plan_unit_text(one->unit));
        p->column[k].used = 1;
        if (said++ == 0) say_quantity(p, &p->column[k]);
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
        ff_plan_assume(p, "angles without a unit are taken to be degrees");
        return FF_OK;
    }
    char names[FF_NAMES_LIST];
    return ff_error_hint(
        p->err,
        ff_error_set(p->err, FF_ERR_FORMAT, p->path, (long)p->header_line, -1,
                     "found the columns %s; their polar angles have no unit and are all below 1.571: if they are not in degrees "
                     "(which angles degrees insists on), say angles radians",
                     ff_plan_list_names(p, names)),
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
        ff_plan_assume(p, "not read %s %s: the option 'columns' takes a channel as f_NAME=#NUMBER",
                       n == 1 ? "is the column" : "are the columns", names);
}

static ff_status put_half_difference(ff_planner *p)
{
    static const struct {
        const char *key;
        ff_meaning meaning;
    } all[] = {{"theta_h", FF_MEANS_THETA_H}, {"phi_h", FF_MEANS_PHI_H}, {"theta_d", FF_MEANS_THETA_D}, {"phi_d", FF_MEANS_PHI_D}};
    for (size_t k = 0; k < 4; k++) {
        long c = ff_plan_find(p, all[k].meaning);
        if (c == FF_PLAN_NONE && all[k].meaning == FF_MEANS_PHI_D) c = ff_plan_find(p, FF_MEANS_PHI);
        if (c != FF_PLAN_NONE)
            put_angle(p, all[k].key, (size_t)c, 0);
        else if (all[k].meaning == FF_MEANS_PHI_H)
            ff_plan_put_constant(p, "phi_h", 0);
        else
            return ff_plan_refuse(p, "half and difference angles are theta_h, theta_d and phi_d",
                                  "theta_h=#1,phi_h=0,theta_d=#2,phi_d=#3,f=#4");
    }
    return FF_OK;
}

static ff_status put_vectors(ff_planner *p)
{
    static const char *const key[6] = {"wi_x", "wi_y", "wi_z", "wo_x", "wo_y", "wo_z"};
    for (int k = 0; k < 6; k++) {
        const long c = ff_plan_find(p, (ff_meaning)(FF_MEANS_WI_X + k));
        if (c == FF_PLAN_NONE)
            return ff_plan_refuse(p, "of the directions as vectors one component is missing",
                                  "wi_x=#1,wi_y=#2,wi_z=#3,wo_x=#4,wo_y=#5,wo_z=#6,f=#7");
        ff_plan_put_column(p, key[k], (size_t)c, "");
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
    ff_plan_put_separator(p);
    fputs("theta_i=", p->text);
    ff_plan_put_number(p->text, degrees);
    fputs(":deg", p->text);
    ff_plan_assume(p, "theta_i is %g degrees by the name of the file", degrees);
    return 1;
}

static ff_status put_directions(ff_planner *p, const wide *w, ff_meaning over)
{
    if (ff_plan_find(p, FF_MEANS_THETA_H) != FF_PLAN_NONE && ff_plan_find(p, FF_MEANS_THETA_D) != FF_PLAN_NONE)
        return put_half_difference(p);
    if (ff_plan_find(p, FF_MEANS_WI_X) != FF_PLAN_NONE && ff_plan_find(p, FF_MEANS_WO_X) != FF_PLAN_NONE) return put_vectors(p);
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
    if (!p->header_line) return ff_plan_refuse_unnamed(p);
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
        return ff_plan_refuse(p, "values at angles do not stand side by side in one unit",
                              "theta_o=#1,f@theta_i=20:40:60,phi_i=0,phi_o=180");
    status = put_directions(p, &w, over);
    if (status != FF_OK) return status;
    const long phase = ff_plan_find(p, FF_MEANS_PHASE), weight = ff_plan_find(p, FF_MEANS_WEIGHT),
               lambda = ff_plan_find(p, FF_MEANS_WAVELENGTH);
    if (phase != FF_PLAN_NONE) put_angle(p, "phase", (size_t)phase, 0);
    if (weight != FF_PLAN_NONE && w.n == 0) ff_plan_put_column(p, "weight", (size_t)weight, "");
    if (w.n) {
        put_wide(p, &w, over);
        p->plan.quantity = p->column[w.first].named.quantity;
    } else {
        if (lambda != FF_PLAN_NONE)
            ff_plan_put_column(p, "wavelength", (size_t)lambda, ff_plan_unit_text(wavelength_unit(p, (size_t)lambda)));
        status = put_values(p);
    }
    if (status == FF_OK) status = check_units(p);
    name_strangers(p);
    return status;
}
