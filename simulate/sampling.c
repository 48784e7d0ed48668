/* Pairs of directions of the simulated instruments, in degrees with six decimals: what a file holds is what is evaluated. */
#include "simulate_struct.h"
#include "base/internal_number.h"
#include "internal_sampling.h"
#include <math.h>
#include <string.h>

#define PI 3.14159265358979323846
static const double theta_last = 85; /* instruments see no further */

/* ---- ranges ---------------------------------------------------------------------------------- */

static ff_status check_step(const ff_sampling *s, ff_error *err)
{
    if (s->step_deg >= 0.5 && s->step_deg <= 45) return FF_OK;
    return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "goniometer step %g degrees, expected 0.5 to 45", s->step_deg);
}

static ff_status check_fraction(const ff_sampling *s, ff_error *err)
{
    if (s->specular >= 0 && s->specular <= 1) return FF_OK;
    return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "scattered: fraction %g near the specular direction, expected 0 to 1",
                        s->specular);
}

/* All members, also those that another kind of sampling reads. */
static ff_status check_sampling(const ff_sampling *s, ff_error *err)
{
    if ((unsigned)s->kind > FF_SAMPLING_SCATTERED)
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "a sampling of number %d, expected 0 to %d", (int)s->kind,
                            (int)FF_SAMPLING_SCATTERED);
    const ff_status status = check_step(s, err);
    return status ? status : check_fraction(s, err);
}

/* ---- words ----------------------------------------------------------------------------------- */

/* A number after ':', or `otherwise` at the end of the text. NULL when neither is there. */
static const char *read_part(const char *text, double otherwise, double *value)
{
    *value = otherwise;
    if (*text == '\0') return text;
    return *text == ':' ? ff_number_read(text + 1, value) : NULL;
}

static ff_status parse_goniometer(const char *rest, ff_sampling *s, ff_error *err)
{
    rest = read_part(rest, 5, &s->step_deg);
    if (!rest || *rest)
        return ff_error_set(err, FF_ERR_SYNTAX, NULL, 0, -1, "expected goniometer or goniometer:STEP, STEP in degrees");
    return check_step(s, err);
}

static ff_status parse_scattered(const char *rest, ff_sampling *s, ff_error *err)
{
    double n = 0;
    rest = read_part(rest, 0, &n);
    if (rest) rest = read_part(rest, 0, &s->specular);
    if (!rest || *rest)
        return ff_error_set(err, FF_ERR_SYNTAX, NULL, 0, -1, "expected scattered:N or scattered:N:FRACTION, N pairs of directions");
    if (!(n >= 1 && n <= 1e9) || n != floor(n))
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "scattered: %g pairs, expected a whole number from 1 to 1e9", n);
    s->n = (size_t)n;
    return check_fraction(s, err);
}

ff_status ff_sampling_parse(const char *text, ff_sampling *out, ff_error *err)
{
    ff_sampling s = {FF_SAMPLING_MERL, 5, 1, 0};
    ff_status status = FF_OK;
    const size_t word = strcspn(text, ":");
    if (!strcmp(text, "merl")) {
        s.n = ff_grid_merl.n;
    } else if (word == 10 && !strncmp(text, "goniometer", word)) {
        s.kind = FF_SAMPLING_GONIOMETER;
        status = parse_goniometer(text + word, &s, err);
    } else if (word == 9 && !strncmp(text, "scattered", word)) {
        s.kind = FF_SAMPLING_SCATTERED;
        status = parse_scattered(text + word, &s, err);
    } else {
        status = ff_error_set(err, FF_ERR_UNKNOWN, NULL, 0, -1,
                              "unknown grid '%.40s'; known are merl, goniometer[:STEP], scattered:N[:FRACTION]", text);
    }
    if (status == FF_OK) *out = s;
    return status;
}

/* ---- goniometer ------------------------------------------------------------------------------ */

/* Values 0, step, ... up to last (less than last when open). */
static size_t steps(double step, double last, int open)
{
    const double n = last / step;
    const size_t whole = (size_t)floor(n + 1e-9);
    return open && (double)whole > n - 1e-9 ? whole : whole + 1;
}

/* At the pole every azimuth is the same direction: one of them is measured. An isotropic surface needs one phi_i and half a turn.
 */
static size_t goniometer(double step, int isotropic, double *const angle[4])
{
    const size_t n_to = steps(step, theta_last, 0), n_po = isotropic ? steps(step, 180, 0) : steps(step, 360, 1);
    size_t n = 0;
    for (int ti = 0; ti <= 75; ti += 15)
        for (int pi = 0; pi < (isotropic || ti == 0 ? 45 : 180); pi += 45)
            for (size_t to = 0; to < n_to; to++)
                for (size_t po = 0; po < (to == 0 ? 1 : n_po); po++, n++) {
                    if (!angle) continue;
                    angle[0][n] = ti;
                    angle[1][n] = pi;
                    angle[2][n] = (double)to * step;
                    angle[3][n] = (double)po * step;
                }
    return n;
}

/* ---- scattered ------------------------------------------------------------------------------- */

/* Six decimals of a degree: identical whatever the last bit of the mathematical library. */
static double rounded(double degrees)
{
    return round(degrees * 1e6) / 1e6;
}

static double theta_uniform(double u)
{
    return acos(1 - u * (1 - cos(theta_last * PI / 180))) * 180 / PI;
}

/* wo = wi mirrored at a half vector near the normal; 0 when it would leave the instrument's range. */
static int mirror(double theta_i, double phi_i, double u_slope, double u_phi, double *theta_o, double *phi_o)
{
    const double slope = 0.002 * pow(500, u_slope), turn = 2 * PI * u_phi, hz = 1 / sqrt(1 + slope * slope);
    const double h[3] = {slope * hz * cos(turn), slope * hz * sin(turn), hz};
    const double t = theta_i * PI / 180, p = phi_i * PI / 180, i[3] = {sin(t) * cos(p), sin(t) * sin(p), cos(t)};
    const double ih = i[0] * h[0] + i[1] * h[1] + i[2] * h[2];
    const double o[3] = {2 * ih * h[0] - i[0], 2 * ih * h[1] - i[1], 2 * ih * h[2] - i[2]};
    *theta_o = acos(fmin(1, o[2])) * 180 / PI;
    *phi_o = fmod(atan2(o[1], o[0]) * 180 / PI + 360, 360);
    return ih > 0 && *theta_o <= theta_last;
}

/* Directions draw from streams of their own, above those of the channels. */
static const uint32_t stream_uniform = 0x80000000u, stream_mirror = 0x80000001u;
enum { TRIES = 64 };

static void scattered(const ff_sampling *s, uint64_t seed, double *const angle[4])
{
    for (size_t n = 0; n < s->n; n++) {
        double u[5], to, po;
        for (uint64_t j = 0; j < 5; j++) u[j] = ff_random_uniform(seed, stream_uniform, 5 * n + j);
        const double ti = rounded(theta_uniform(u[0])), pi = rounded(360 * u[1]);
        to = theta_uniform(u[2]);
        po = 360 * u[3];
        for (uint64_t j = 0; u[4] < s->specular && j < TRIES; j++) {
            const uint64_t at = 2 * (TRIES * n + j);
            double mto, mpo;
            if (!mirror(ti, pi, ff_random_uniform(seed, stream_mirror, at), ff_random_uniform(seed, stream_mirror, at + 1), &mto,
                        &mpo))
                continue;
            to = mto;
            po = mpo;
            break;
        }
        angle[0][n] = ti;
        angle[1][n] = pi;
        angle[2][n] = rounded(to);
        angle[3][n] = rounded(po);
    }
}

ff_status ff_sampling_table(const ff_sampling *s, uint64_t seed, int isotropic, size_t n_channels, int sigma, ff_table *out,
                            ff_error *err)
{
    const ff_status legal = check_sampling(s, err);
    if (legal) return legal;
    const size_t n = s->kind == FF_SAMPLING_MERL        ? ff_grid_merl.n
                     : s->kind == FF_SAMPLING_SCATTERED ? s->n
                                                        : goniometer(s->step_deg, isotropic, NULL);
    const ff_grid *grid = s->kind == FF_SAMPLING_MERL ? &ff_grid_merl : NULL;
    const ff_status status = ff_table_init(n, n_channels, grid, sigma, 0, out, err);
    if (status != FF_OK) return status;
    out->radians_per_unit = PI / 180;
    out->isotropic = grid ? grid->isotropic : s->kind == FF_SAMPLING_GONIOMETER && isotropic;
    if (s->kind == FF_SAMPLING_GONIOMETER) goniometer(s->step_deg, isotropic, out->angle);
    if (s->kind == FF_SAMPLING_SCATTERED) scattered(s, seed, out->angle);
    return FF_OK;
}
