/* Residuals sample by sample, as CSV. */
#include "ff_report.h"
#include "internal_report.h"
#include <math.h>
#include <stdlib.h>

static void put_number(FILE *out, const char *before, double x)
{
    char text[FF_REPORT_NUMBER];
    fprintf(out, "%s%s", before, ff_report_number(x, text));
}

/* Azimuth in [0, 360), without the rounding that makes 360 of it. */
static double azimuth(double y, double x)
{
    const double phi = ff_report_degrees(atan2(y, x));
    return phi < 0 ? phi + 360 : phi;
}

static void put_angles(const double w[6], FILE *out)
{
    const double io = w[0] * w[3] + w[1] * w[4] + w[2] * w[5], length = sqrt(fmax(2 + 2 * io, 1e-300));
    put_number(out, "", ff_report_degrees(atan2(hypot(w[0], w[1]), w[2])));
    put_number(out, ",", azimuth(w[1], w[0]));
    put_number(out, ",", ff_report_degrees(atan2(hypot(w[3], w[4]), w[5])));
    put_number(out, ",", azimuth(w[4], w[3]));
    put_number(out, ",", ff_report_degrees(acos(fmin((w[2] + w[5]) / length, 1))));
    put_number(out, ",", ff_report_degrees(acos(fmin(0.5 * length, 1))));
}

/* Datum of channel c of the residuals: that channel, the one of its name, or the mean of all. */
static double datum(const ff_table *t, const ff_table *residuals, size_t c, size_t i)
{
    double value, sum = 0;
    const int named = ff_table_channel_find(t, residuals->channels[c].name);
    if (named >= 0) {
        ff_table_values(t, (size_t)named, i, 1, &value);
        return value;
    }
    for (size_t k = 0; k < t->n_channels; k++) {
        ff_table_values(t, k, i, 1, &value);
        sum += value / (double)t->n_channels;
    }
    return sum;
}

ff_status ff_report_residuals_csv(const ff_table *t, const ff_table *residuals, const char *title, FILE *out)
{
    double w[6], *const planes[6] = {w, w + 1, w + 2, w + 3, w + 4, w + 5};
    fprintf(out, "# %s\n# model - data, 1/sr; samples that were left out are not listed\n", title);
    fputs("theta_i,phi_i,theta_o,phi_o,theta_h,theta_d", out);
    for (size_t c = 0; c < residuals->n_channels; c++) {
        const char *name = residuals->channels[c].name;
        fprintf(out, ",f_%s,model_%s,residual_%s", name, name, name);
    }
    fputc('\n', out);
    for (size_t i = 0; i < t->n; i++) {
        if (!residuals->valid[i]) continue;
        ff_table_directions(t, i, 1, planes);
        put_angles(w, out);
        for (size_t c = 0; c < residuals->n_channels; c++) {
            const double y = datum(t, residuals, c, i), r = residuals->value[c * residuals->n + i];
            put_number(out, ",", y);
            put_number(out, ",", y + r);
            put_number(out, ",", r);
        }
        fputc('\n', out);
    }
    return FF_OK;
}
