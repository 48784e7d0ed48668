/* The elements of a WINDOW file that divide the hemisphere into patches. */
#include "internal_window_file.h"
#include "base/internal_number.h"
#include "base/internal_tokens.h"
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

enum { BASES_MAX = 64 };

ff_status ff_window_fails(const ff_window_file *w, ff_status code, const char *fmt, ...)
{
    char message[FF_ERROR_MESSAGE];
    va_list args;
    va_start(args, fmt);
    vsnprintf(message, sizeof message, fmt, args);
    va_end(args);
    return ff_error_set(w->xml.err, code, w->xml.path, w->xml.parser ? ff_xml_line(&w->xml) : 0, -1, "%s", message);
}

ff_status ff_window_new_basis(ff_window_file *w)
{
    if (w->n_bases == BASES_MAX)
        return ff_window_fails(w, FF_ERR_FORMAT, "found more than %d elements AngleBasis, expected fewer", BASES_MAX);
    ff_window_basis *b = calloc(1, sizeof *b);
    ff_window_basis **larger = b ? realloc(w->bases, (w->n_bases + 1) * sizeof *larger) : NULL;
    if (!larger) {
        free(b);
        return ff_window_fails(w, FF_ERR_MEMORY, "no memory for a basis");
    }
    w->bases = larger;
    w->bases[w->n_bases++] = b;
    return FF_OK;
}

ff_window_basis *ff_window_last_basis(const ff_window_file *w)
{
    return w->bases[w->n_bases - 1];
}

/* Index among the first n, SIZE_MAX when there is none of that name. */
static size_t find_basis(const ff_window_file *w, const char *name, size_t n)
{
    for (size_t k = 0; k < n; k++)
        if (strcasecmp(w->bases[k]->name, name) == 0) return k;
    return SIZE_MAX;
}

static int same_rings(const ff_window_basis *a, const ff_window_basis *b)
{
    if (a->n_rings != b->n_rings) return 0;
    for (size_t j = 0; j < a->n_rings; j++)
        if (a->ring[j].theta != b->ring[j].theta || a->ring[j].upper != b->ring[j].upper || a->ring[j].n_phi != b->ring[j].n_phi)
            return 0;
    return 1;
}

ff_status ff_window_end_basis(ff_window_file *w)
{
    char found[FF_QUOTE];
    ff_window_basis *b = ff_window_last_basis(w);
    if (b->name[0] == '\0')
        return ff_window_fails(w, FF_ERR_FORMAT, "found an AngleBasis without a name, expected AngleBasisName in it");
    if (b->n_rings == 0 && !ff_window_standard_basis(b))
        return ff_window_fails(w, FF_ERR_FORMAT, "found the basis %s without an AngleBasisBlock, expected its rings of patches",
                               ff_window_quoted(b->name, found));
    const size_t before = find_basis(w, b->name, w->n_bases - 1);
    if (before == SIZE_MAX) return FF_OK;
    if (!same_rings(w->bases[before], b))
        return ff_window_fails(w, FF_ERR_FORMAT, "found two bases %s that differ, expected one", ff_window_quoted(b->name, found));
    free(b);
    w->n_bases--;
    return FF_OK;
}

ff_status ff_window_end_basis_block(ff_window_file *w)
{
    ff_window_ring *r = &w->ring;
    if (isnan(r->lower) || isnan(r->upper) || r->n_phi == 0)
        return ff_window_fails(w, FF_ERR_FORMAT, "found an AngleBasisBlock without %s, expected LowerTheta, UpperTheta and nPhis",
                               isnan(r->lower)   ? "LowerTheta"
                               : isnan(r->upper) ? "UpperTheta"
                                                 : "nPhis");
    if (isnan(r->theta)) r->theta = r->n_phi == 1 && r->lower == 0 ? 0 : (r->lower + r->upper) / 2;
    return ff_window_add_ring(ff_window_last_basis(w), r, w->xml.path, ff_xml_line(&w->xml), w->xml.err);
}

ff_status ff_window_read_angle(ff_window_file *w, const char *what, double *angle)
{
    char found[FF_QUOTE];
    const char *end = ff_number_read(w->text, angle);
    if (end && *end == '\0' && *angle >= 0 && *angle <= 90) return FF_OK;
    return ff_window_fails(w, FF_ERR_DATA, "%s: found %s, expected degrees from 0 to 90", what, ff_window_quoted(w->text, found));
}

ff_status ff_window_read_n_phis(ff_window_file *w)
{
    char found[FF_QUOTE];
    uint64_t n;
    if (!ff_whole_number(w->text, FF_WINDOW_PATCHES, &n) || n == 0)
        return ff_window_fails(w, FF_ERR_DATA, "nPhis: found %s, expected a whole number from 1 to %d",
                               ff_window_quoted(w->text, found), FF_WINDOW_PATCHES);
    w->ring.n_phi = (size_t)n;
    return FF_OK;
}

ff_status ff_window_use_basis(ff_window_file *w, size_t *out)
{
    char found[FF_QUOTE], names[FF_WINDOW_LIST];
    *out = find_basis(w, w->text, w->n_bases);
    if (*out != SIZE_MAX) return FF_OK;
    if (strlen(w->text) < FF_WINDOW_NAME) {
        ff_status status = ff_window_new_basis(w);
        if (status != FF_OK) return status;
        strcpy(ff_window_last_basis(w)->name, w->text);
        *out = w->n_bases - 1;
        if (ff_window_standard_basis(ff_window_last_basis(w))) return FF_OK;
        free(ff_window_last_basis(w));
        w->n_bases--;
    }
    size_t used = 0;
    names[0] = '\0';
    for (size_t k = 0; k < w->n_bases && used < sizeof names; k++)
        used +=
            (size_t)snprintf(names + used, sizeof names - used, ", %s", ff_window_quoted(w->bases[k]->name, (char[FF_QUOTE]){0}));
    return ff_window_fails(w, FF_ERR_FORMAT,
                           "found the basis %s, expected LBNL/Klems Full, Half or Quarter, or one that an AngleBasis defines%s",
                           ff_window_quoted(w->text, found), names);
}
