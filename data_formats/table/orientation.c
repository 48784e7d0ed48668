/* How the azimuths of a file are counted: from which side, in which sense. */
#include "internal_table.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

static const char *const azimuth_names[3] = {"", "mirror", "light"};
static const char *const phi_names[4] = {"", "clockwise", "clockwise-in", "clockwise-out"};

const char *ff_azimuth_name(int azimuth)
{
    return azimuth >= 0 && azimuth < 3 ? azimuth_names[azimuth] : NULL;
}

const char *ff_phi_sense_name(int phi)
{
    return phi >= 0 && phi < 4 ? phi_names[phi] : NULL;
}

const char *ff_angles_name(int angles)
{
    static const char *const names[6] = {"", "degrees", "radians", "elevation", "elevation-in", "elevation-out"};
    return angles >= 0 && angles < 6 ? names[angles] : NULL;
}

int ff_table_has_radian_azimuths(const ff_table *t)
{
    double polar = 0;
    int any = 0;
    if (t->grid || t->radians_per_unit == 1 || t->n < 3) return 0;
    for (size_t i = 0; i < t->n; i++) {
        polar = fmax(polar, fmax(fabs(t->angle[0][i]), fabs(t->angle[2][i])));
        if (polar > pi / 2 + 1e-4) return 0;
        for (int k = 1; k < 4; k += 2) {
            const double phi = fabs(t->angle[k][i]), rights = phi / (pi / 2);
            if (phi > 2 * pi + 1e-3) return 0;
            any |= rights > 0.5 && fabs(rights - rint(rights)) < 1e-3;
        }
    }
    return any && polar > 0;
}

/* Angle planes in place of a grid, whose directions are those of its parametrisation. */
static ff_status make_angles(ff_table *t, ff_error *err)
{
    for (int k = 0; k < 4; k++) {
        t->angle[k] = malloc(t->n * sizeof *t->angle[k]);
        if (!t->angle[k]) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for the angles of %zu samples", t->n);
    }
    ff_table_angles(t, 1, 0, t->n, t->angle);
    t->radians_per_unit = 1;
    t->grid = NULL;
    return FF_OK;
}

/* What belongs to the directions as they were: axes, cells, and what writes the same file again. */
static void forget_structure(ff_table *t)
{
    for (int k = 0; k < 4; k++) {
        free(t->axes.node[k]);
        t->axes.node[k] = NULL;
        t->axes.n[k] = 0;
    }
    t->axes.kind = FF_AXES_NONE;
    if (t->kept && t->kept_free) t->kept_free(t->kept);
    t->kept = NULL;
    t->kept_free = NULL;
    t->kept_share = NULL;
    t->kept_incidence = NULL;
    t->kept_around = NULL;
    if (t->cells) t->cells->release(t->cells);
    t->cells = NULL;
}

static void negate(double *angle, size_t n)
{
    for (size_t i = 0; i < n; i++) angle[i] = angle[i] == 0 ? 0 : -angle[i];
}

/* What was measured from the surface, from its normal. */
static void take_elevations(ff_table *t, int angles)
{
    const double right = t->radians_per_unit == 1 ? pi / 2 : pi / 2 / t->radians_per_unit;
    for (size_t i = 0; i < t->n && angles != FF_ANGLES_ELEVATION_OUT; i++) t->angle[0][i] = right - t->angle[0][i];
    for (size_t i = 0; i < t->n && angles != FF_ANGLES_ELEVATION_IN; i++) t->angle[2][i] = right - t->angle[2][i];
    ff_table_note(t, "polar angles%s are elevations above the surface, as asked",
                  angles == FF_ANGLES_ELEVATION      ? ""
                  : angles == FF_ANGLES_ELEVATION_IN ? " of the light"
                                                     : " of the detector");
}

/* A table of the other unit; what reads a CSV has taken the option already. */
static int is_other_unit(const ff_table *t, int angles)
{
    return (angles == FF_ANGLES_DEGREES && t->radians_per_unit == 1) || (angles == FF_ANGLES_RADIANS && t->radians_per_unit != 1);
}

ff_status ff_table_orient(ff_table *t, const ff_read_options *o, ff_error *err)
{
    const int azimuth = o->azimuth, phi = o->phi, elevations = o->angles >= FF_ANGLES_ELEVATION;
    const int from_mirror = azimuth == FF_AZIMUTH_AS_FORMAT ? t->azimuth_from_mirror : azimuth == FF_AZIMUTH_MIRROR;
    const int turns = from_mirror != t->azimuth_from_mirror;
    const int other_unit = !t->grid && is_other_unit(t, o->angles);
    if (!turns && phi == FF_PHI_AS_FORMAT && !elevations && !other_unit) return FF_OK;
    if (t->grid) {
        const ff_status status = make_angles(t, err);
        if (status != FF_OK) return status;
    }
    forget_structure(t);
    if (other_unit) {
        t->radians_per_unit = o->angles == FF_ANGLES_RADIANS ? 1 : pi / 180;
        ff_table_note(t, "angles are read as %s, as asked, where the file says that they are in %s", ff_angles_name(o->angles),
                      ff_angles_name(o->angles == FF_ANGLES_RADIANS ? FF_ANGLES_DEGREES : FF_ANGLES_RADIANS));
    }
    if (elevations) take_elevations(t, o->angles);
    if (phi == FF_PHI_CLOCKWISE || phi == FF_PHI_CLOCKWISE_IN) negate(t->angle[1], t->n);
    if (phi == FF_PHI_CLOCKWISE || phi == FF_PHI_CLOCKWISE_OUT) negate(t->angle[3], t->n);
    const double half = pi / t->radians_per_unit;
    for (size_t i = 0; i < t->n && turns; i++) t->angle[3][i] += t->radians_per_unit == 1 ? half : 180;
    t->azimuth_from_mirror = from_mirror;
    if (turns) ff_table_note(t, "azimuth 0 is the side of the %s, as asked", from_mirror ? "mirror direction" : "light");
    if (phi)
        ff_table_note(t, "azimuths%s are counted clockwise, as asked",
                      phi == FF_PHI_CLOCKWISE      ? ""
                      : phi == FF_PHI_CLOCKWISE_IN ? " of the light"
                                                   : " of the detector");
    return FF_OK;
}
