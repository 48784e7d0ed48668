/* multiple_scattering [PATHS]: makes models/terms/multiple_scattering_table.h, the shape of the light that a Smith surface reflects
 * after two facets and more, from walks (simulate/walk). diffuse_multiple_scattering.c says what is expanded, and in what.
 *
 * Paths begin with the density cos(theta) / pi. Those that meet two facets and more then have pairs of directions of the density
 * (1 - a_i)(1 - a_o) T cos cos / (pi (1 - mean))^2 ..., so that a coefficient of T in polynomials that are orthonormal under
 * (1 - a) mu dmu is the mean of their products over such paths. The polynomials are written out in powers of mu. */
#include "ff_albedo.h"
#include "models/model_struct.h"
#include "simulate/walk/internal_walk.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { TERMS = 4, TURNING = 3, PAIRS = TURNING * (TURNING + 1) / 2, KINDS = 3, STARTS = 1000, NODES = 64, SEEN = 1 << 18 };
static const double alphas[] = {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.85, 1, 1.25, 1.5, 2, 2.8, 4};
enum { ALPHAS = sizeof alphas / sizeof alphas[0] };
/* Orthonormal polynomials, row k: coefficients of mu^0 ... */
typedef struct basis {
    double q[TERMS][TERMS];
} basis;

/* kinds: all orders from 2 on, order 2, order 3; normal equations of the cosine of the azimuth by symmetric products; and how many
 * paths, of order 4 and more, 5 and more. */
typedef struct sums {
    const basis *b;
    double mu;
    double sum[KINDS][TERMS][TERMS], gram[PAIRS][PAIRS], right[PAIRS], n, n4, n5;
    size_t n_seen;
    float seen[SEEN][3]; /* mu_i, mu_o and cos(phi) of some paths */
} sums;

static double power(double x, int n)
{
    return n ? x * power(x, n - 1) : 1;
}

static double at(const double *c, int n, double x)
{
    double sum = 0;
    for (int k = n - 1; k >= 0; k--) sum = sum * x + c[k];
    return sum;
}

/* Gram and Schmidt, twice, under the weights w of the nodes x. */
static void orthonormal(size_t n, const double *x, const double *w, double q[TERMS][TERMS])
{
    memset(q, 0, TERMS * sizeof *q);
    for (int k = 0; k < TERMS; k++) {
        q[k][k] = 1;
        for (int pass = 0; pass < 2; pass++)
            for (int j = 0; j < k; j++) {
                double dot = 0;
                for (size_t i = 0; i < n; i++) dot += w[i] * at(q[k], TERMS, x[i]) * at(q[j], TERMS, x[i]);
                for (int c = 0; c < TERMS; c++) q[k][c] -= dot * q[j][c];
            }
        double norm = 0;
        for (size_t i = 0; i < n; i++) norm += w[i] * power(at(q[k], TERMS, x[i]), 2);
        for (int c = 0; c < TERMS; c++) q[k][c] /= sqrt(norm);
    }
}

static void count(void *context, uint32_t order, const double r[3], const double *weight)
{
    sums *s = context;
    (void)weight;
    if (order < 2) return;
    const double side = hypot(r[0], r[1]), both = sqrt(1 - s->mu * s->mu) * side, turn = side > 0 ? r[0] / side : 0;
    double product[PAIRS];
    int t = 0;
    const size_t place = (size_t)s->n * 2654435761u % SEEN; /* of all directions in the end */
    s->seen[place][0] = (float)s->mu, s->seen[place][1] = (float)r[2], s->seen[place][2] = (float)turn;
    if (s->n_seen < SEEN) s->n_seen++;
    s->n++;
    s->n4 += order >= 4;
    s->n5 += order >= 5;
    for (int a = 0; a < TERMS; a++)
        for (int b = 0; b < TERMS; b++) {
            const double x = at(s->b->q[a], TERMS, s->mu) * at(s->b->q[b], TERMS, r[2]);
            s->sum[0][a][b] += x;
            if (order <= 3) s->sum[order - 1][a][b] += x;
        }
    for (int a = 0; a < TURNING; a++)
        for (int b = 0; b <= a; b++)
            product[t++] = both * (power(s->mu, a) * power(r[2], b) + (a == b ? 0 : power(s->mu, b) * power(r[2], a)));
    for (int a = 0; a < PAIRS; a++) {
        s->right[a] += product[a] * turn;
        for (int b = 0; b < PAIRS; b++) s->gram[a][b] += product[a] * product[b];
    }
}

/* Gauss and Jordan; the equations are few and of full rank. */
static void solve(const sums *s, double *out)
{
    double a[PAIRS][PAIRS + 1];
    for (int i = 0; i < PAIRS; i++) {
        for (int j = 0; j < PAIRS; j++) a[i][j] = s->gram[i][j] + (i == j ? 1e-9 * s->n : 0);
        a[i][PAIRS] = s->right[i];
    }
    for (int k = 0; k < PAIRS; k++) {
        int pivot = k;
        for (int i = k; i < PAIRS; i++)
            if (fabs(a[i][k]) > fabs(a[pivot][k])) pivot = i;
        for (int j = 0; j <= PAIRS; j++) {
            const double x = a[k][j];
            a[k][j] = a[pivot][j];
            a[pivot][j] = x;
        }
        for (int i = 0; i < PAIRS; i++) {
            const double factor = i == k ? 0 : a[i][k] / a[k][k];
            for (int j = k; j <= PAIRS; j++) a[i][j] -= factor * a[k][j];
        }
    }
    for (int k = 0; k < PAIRS; k++) out[k] = a[k][PAIRS] / a[k][k];
}

/* The part of rho that brings A nearest to the azimuths of the paths in the mean square: the mean of A^2 is (1 + rho^2) / (1 -
 * rho^2), and that of A times what is there the mean of A over the paths. A mean cosine that comes of a narrow peak has too wide an
 * A. */
static double damped(const sums *s, const double *R)
{
    double best = 0, least_rest = INFINITY;
    for (double part = 0; part <= 1.001; part += 0.025) {
        double rest = 0;
        for (size_t k = 0; k < SEEN; k++) {
            const double x = s->seen[k][0], y = s->seen[k][1], c = s->seen[k][2];
            double rho = 0;
            for (int a = 0, t = 0; a < TURNING; a++)
                for (int b = 0; b <= a; b++, t++)
                    rho += R[t] * (power(x, a) * power(y, b) + (a == b ? 0 : power(x, b) * power(y, a)));
            rho = fmin(fmax(part * rho * sqrt((1 - x * x) * (1 - y * y)), -0.9), 0.9);
            rest += (1 + rho * rho) / (1 - rho * rho) - 2 * (1 - rho * rho) / (1 - 2 * rho * c + rho * rho);
        }
        if (rest >= least_rest) continue;
        least_rest = rest;
        best = part;
    }
    return best;
}

/* How much of the expansion is kept: powers, and the part of what is not constant, all of it where the sum is nowhere negative. */
typedef struct kept {
    int powers;
    double changing;
} kept;

/* Coefficients of mu_i^a mu_o^b, symmetric. Those of all orders keep their integral over mu_o to the bit: the mean of a polynomial
 * that is orthogonal to 1 is 0. */
static void expand(const sums *s, int kind, const kept *k, double out[TERMS][TERMS])
{
    memset(out, 0, TERMS * sizeof *out);
    for (int a = 0; a < k->powers; a++)
        for (int b = 0; b < k->powers; b++) {
            double c = 0.5 * (s->sum[kind][a][b] + s->sum[kind][b][a]) / s->n;
            if (kind == 0 && (a == 0 || b == 0)) c = a == b;
            if (a || b) c *= k->changing;
            for (int i = 0; i < TERMS; i++)
                for (int j = 0; j < TERMS; j++) out[i][j] += c * s->b->q[a][i] * s->b->q[b][j];
        }
}

/* The least value of what all orders have. */
static double least(const sums *s, const kept *k)
{
    enum { GRID = 64 };
    double c[TERMS][TERMS], low = INFINITY;
    expand(s, 0, k, c);
    for (int a = 0; a <= GRID; a++)
        for (int b = 0; b <= a; b++) {
            double sum = 0;
            for (int i = 0; i < TERMS; i++)
                for (int j = 0; j < TERMS; j++) sum += c[i][j] * power((double)a / GRID, i) * power((double)b / GRID, j);
            low = fmin(low, sum);
        }
    return low;
}

/* The largest part in [0, 1] that leaves nothing negative. */
static void shrink(const sums *s, kept *k)
{
    double lo = 0, hi = 1;
    k->changing = 1;
    if (least(s, k) >= 0) return;
    for (int i = 0; i < 12; i++) {
        k->changing = 0.5 * (lo + hi);
        if (least(s, k) >= 0)
            lo = k->changing;
        else
            hi = k->changing;
    }
    k->changing = lo;
}

/* How much of the variance of T about 1 an expansion has. */
static double explained(const sums *s, const kept *k)
{
    double sum = 0;
    for (int a = 1; a < k->powers; a++)
        for (int b = 1; b < k->powers; b++) sum += pow(0.5 * (s->sum[0][a][b] + s->sum[0][b][a]) / s->n, 2);
    return sum * k->changing * (2 - k->changing);
}

static kept choose(const sums *s, int most)
{
    kept best = {1, 1};
    double most_explained = 0;
    for (int n = 2; n <= most; n++) {
        kept k = {n, 1};
        shrink(s, &k);
        if (explained(s, &k) <= most_explained) continue;
        most_explained = explained(s, &k);
        best = k;
    }
    return best;
}

static void fail(const ff_error *err)
{
    fprintf(stderr, "%s\n", err->message);
    exit(1);
}

static void make(const char *ndf, double alpha, uint64_t paths)
{
    ff_model m;
    ff_error err = {0};
    ff_walk *walk;
    ff_walk_options o;
    double shape[FF_MAX_SHAPE], channel[FF_MAX_CHANNEL_PARAMS], x[NODES], w[NODES], sum = 0;
    char text[80];
    static basis b;
    static sums s;
    s = (sums){.b = &b};
    snprintf(text, sizeof text, "%s/smith-height-correlated/none", ndf);
    if (ff_model_parse(text, &m, &err)) fail(&err);
    ff_model_defaults(&m, 1, shape, channel);
    snprintf(text, sizeof text, "alpha=%.17g", alpha);
    if (ff_model_set(&m, 1, text, shape, channel, &err)) fail(&err);
    for (int i = 0; i < NODES; i++) { /* mu = y^2: 1 - a is steep near the horizon */
        const double y = (i + 0.5) / NODES, mu = y * y, wo[3] = {sqrt(1 - mu * mu), 0, mu};
        ff_integral a;
        if (ff_albedo_directional(&m, FF_ISA_BEST, 1, shape, channel, wo, &a, &err)) fail(&err);
        x[i] = mu;
        sum += w[i] = (1 - a.value) * mu * 2 * y;
    }
    for (int i = 0; i < NODES; i++) w[i] /= sum;
    orthonormal(NODES, x, w, b.q);
    ff_walk_options_init(&o);
    o.paths = paths / STARTS;
    o.seed = 20;
    if (ff_walk_new(&m, 1, shape, channel, &o, &walk, &err)) fail(&err);
    ff_walk_lanes *lanes = ff_walk_lanes_new(1, 1);
    for (int k = 0; k < STARTS && lanes; k++) {
        s.mu = sqrt((k + 0.5) / STARTS);
        const double wi[3] = {sqrt(1 - s.mu * s.mu), 0, s.mu};
        const ff_dirs dirs = {&wi[0], &wi[1], &wi[2], NULL, NULL, NULL};
        const ff_walk_item item = {
            .n_pairs = 1, .n_paths = o.paths, .w = &dirs, .number = (uint64_t)k, .leaves = count, .context = &s};
        walk->run(&walk->setting, &item, lanes);
    }
    free(lanes);
    ff_walk_free(walk);
    const kept keep = choose(&s, alpha <= 0.1 ? 1 : TERMS); /* at the first node the shape is that of Kulla and Conty */
    fprintf(stderr, "%s %g: %d powers, %.3f of what changes\n", ndf, alpha, keep.powers, keep.changing);
    printf("    {%.9g, /* alpha = %g, %.0f paths */\n", s.n4 > 0 ? s.n5 / s.n4 : 0, alpha, s.n);
    for (int kind = 0; kind < KINDS; kind++) {
        double c[TERMS][TERMS];
        expand(&s, kind, &keep, c);
        printf("    ");
        for (int i = 0; i < TERMS; i++)
            for (int j = 0; j <= i; j++) printf(" %.9g,", c[i][j]);
        printf("\n");
    }
    double rho[PAIRS];
    solve(&s, rho);
    const double part = alpha <= 0.1 ? 0 : damped(&s, rho);
    fprintf(stderr, "%s %g: %.3f of what turns\n", ndf, alpha, part);
    for (int k = 0; k < PAIRS; k++) rho[k] *= part;
    printf("    ");
    for (int k = 0; k < PAIRS; k++) printf(" %.9g,", rho[k]);
    printf("\n");
    printf("    },\n");
    fflush(stdout);
}

int main(int argc, char **argv)
{
    static const char *const ndfs[] = {"beckmann", "ggx"};
    const uint64_t paths = argc > 1 ? strtoull(argv[1], NULL, 10) : 20000000;
    printf("/* Made by bench/multiple_scattering %llu: the coefficients that diffuse_multiple_scattering.c describes. */\n",
           (unsigned long long)paths);
    printf("enum { FF_SCATTERING_NODES = %d };\nstatic const double node[FF_SCATTERING_NODES] = {", (int)ALPHAS);
    for (int k = 0; k < ALPHAS; k++) printf("%s%g", k ? ", " : "", alphas[k]);
    printf("};\n");
    for (int k = 0; k < 2; k++) {
        printf("static const double of_%s[FF_SCATTERING_NODES][FF_SCATTERING_TERMS] = {\n", ndfs[k]);
        for (int a = 0; a < ALPHAS; a++) make(ndfs[k], alphas[a], paths);
        printf("};\n");
    }
    return 0;
}
