/* The blocks of a WINDOW file that were kept, as a table. */
#include "internal_window_file.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

const char *const ff_window_face_name[FF_WINDOW_FACES] = {"Reflection Front", "Reflection Back"};
const char *const ff_window_part_name[FF_WINDOW_FACES] = {"reflection-front", "reflection-back"};

void ff_window_drop_block(ff_window_file *w, size_t k)
{
    ff_scattering_free(&w->blocks[k].data);
    memmove(w->blocks + k, w->blocks + k + 1, (w->n_blocks - k - 1) * sizeof *w->blocks);
    w->n_blocks--;
}

static ff_status nothing_wanted(const ff_window_file *w)
{
    const int any = w->seen[FF_WINDOW_FRONT] + w->seen[FF_WINDOW_BACK];
    if (any == 0 && w->seen[FF_WINDOW_TRANSMISSION])
        return ff_window_fails(w, FF_ERR_UNSUPPORTED,
                               "found transmission alone, expected a block Reflection Front or Reflection Back");
    if (any == 0)
        return ff_window_fails(w, FF_ERR_FORMAT, "found no ScatteringData, expected a block Reflection Front or Reflection Back");
    if (w->part != FF_WINDOW_NO_FACE && w->seen[w->part] == 0)
        return ff_window_fails(w, FF_ERR_UNSUPPORTED, "found %s alone, but %s was asked for", ff_window_face_name[!w->part],
                               ff_window_part_name[w->part]);
    const int face = w->part != FF_WINDOW_NO_FACE ? w->part : w->seen[FF_WINDOW_FRONT] ? FF_WINDOW_FRONT : FF_WINDOW_BACK;
    if (w->wanted == FF_WINDOW_NAMED)
        return ff_window_fails(w, FF_ERR_UNSUPPORTED, "found the wavelengths %s of %s, but '%s' was asked for", w->names[face],
                               ff_window_face_name[face], w->asked);
    return ff_window_fails(w, FF_ERR_UNSUPPORTED, "found chromaticities alone (%s), expected a reflectance", w->names[face]);
}

/* Channels of one table share their directions: those of the first. */
static size_t drop_others(ff_window_file *w)
{
    size_t dropped = w->left_out;
    for (size_t k = w->n_blocks; k-- > 1;) {
        const ff_window_block *b = &w->blocks[k], *first = &w->blocks[0];
        if (b->incident == first->incident && b->exit == first->exit) continue;
        ff_window_drop_block(w, k);
        dropped++;
    }
    return dropped;
}

static void fill_directions(const ff_window_file *w, ff_table *t, double *const incident[3], double *const exit[3])
{
    const ff_window_block *b = &w->blocks[0];
    const size_t n_incident = w->bases[b->incident]->n, n_exit = w->bases[b->exit]->n;
    for (size_t i = 0; i < n_incident; i++)
        incident[1][i] = fmod(b->face == FF_WINDOW_FRONT ? 360 - incident[1][i] : incident[1][i] + 180, 360);
    for (size_t o = 0; o < n_exit && b->face == FF_WINDOW_FRONT; o++) exit[1][o] = fmod(540 - exit[1][o], 360);
    for (size_t i = 0; i < n_incident; i++)
        for (size_t o = 0; o < n_exit; o++) {
            const size_t s = w->structure == FF_WINDOW_ROWS ? i * n_exit + o : o * n_incident + i;
            t->angle[0][s] = incident[0][i];
            t->angle[1][s] = incident[1][i];
            t->angle[2][s] = exit[0][o];
            t->angle[3][s] = exit[1][o];
            t->weight[s] = incident[2][i] * exit[2][o];
        }
}

static ff_status matrix_directions(const ff_window_file *w, ff_table *t)
{
    const ff_window_basis *bi = w->bases[w->blocks[0].incident], *bo = w->bases[w->blocks[0].exit];
    double *planes = malloc(3 * (bi->n + bo->n) * sizeof *planes);
    if (!planes) return ff_window_fails(w, FF_ERR_MEMORY, "no memory for the patches");
    double *const incident[3] = {planes, planes + bi->n, planes + 2 * bi->n};
    double *const exit[3] = {planes + 3 * bi->n, planes + 3 * bi->n + bo->n, planes + 3 * bi->n + 2 * bo->n};
    ff_window_patches(bi, incident[0], incident[1], incident[2]);
    ff_window_patches(bo, exit[0], exit[1], exit[2]);
    fill_directions(w, t, incident, exit);
    free(planes);
    return FF_OK;
}

static ff_status matrix_to_table(ff_window_file *w, ff_table *t)
{
    ff_status status = ff_table_init(w->blocks[0].data.n, w->n_blocks, NULL, 0, 1, t, w->xml.err);
    if (status != FF_OK) return status;
    for (size_t c = 0; c < w->n_blocks; c++) {
        memcpy(t->value + c * t->n, w->blocks[c].data.value, t->n * sizeof *t->value);
        ff_scattering_free(&w->blocks[c].data);
    }
    status = matrix_directions(w, t);
    const ff_window_block *b = &w->blocks[0];
    if (status == FF_OK) {
        t->cells = ff_window_matrix_cells(w->bases[b->incident], w->bases[b->exit], w->structure == FF_WINDOW_ROWS,
                                          b->face == FF_WINDOW_FRONT);
        if (!t->cells) status = ff_window_fails(w, FF_ERR_MEMORY, "no memory for the patches");
    }
    if (status != FF_OK) ff_table_clear(t);
    return status;
}

static ff_status tree_to_table(ff_window_file *w, ff_table *t)
{
    ff_scattering *data = &w->blocks[0].data;
    const ff_status status = ff_rows_to_table(&data->leaves, 1, 0, 1, t, w->xml.err);
    if (status != FF_OK) return status;
    t->cells = ff_window_tree_cells(data->rank, data->mirrored, t->n, data->place);
    data->place = NULL;
    if (t->cells) return FF_OK;
    ff_table_clear(t);
    return ff_window_fails(w, FF_ERR_MEMORY, "no memory for the cells of the tree");
}

static void describe(const ff_window_file *w, size_t dropped, ff_table *t)
{
    const ff_window_block *first = &w->blocks[0];
    strcpy(t->format, "window");
    t->radians_per_unit = 3.14159265358979323846 / 180;
    t->isotropic = w->structure == FF_WINDOW_TREE_3;
    for (size_t c = 0; c < t->n_channels; c++) {
        strcpy(t->channels[c].name, w->blocks[c].name);
        t->channels[c].wavelength_nm = w->blocks[c].wavelength_nm;
    }
    ff_table_note(t, "values are means over %s; they stand at the centres",
                  w->structure < FF_WINDOW_TREE_3 ? "pairs of patches" : "cells of the tree");
    if (w->part == FF_WINDOW_NO_FACE && w->seen[FF_WINDOW_FRONT] && w->seen[FF_WINDOW_BACK])
        ff_table_note(t, "Reflection Front is read, Reflection Back is there too: the part reflection-back reads it");
    if (first->face == FF_WINDOW_FRONT && !t->isotropic)
        ff_table_note(
            t, "x and y of the file are taken as those seen from the back, as Radiance does: azimuths are mirrored for the front");
    const char *names = w->names[first->face], *more = w->n_blocks > 1 ? " and those on the same patches are" : " is";
    if (dropped)
        ff_table_note(t, "of the wavelengths %s, %s%s read: the others are on other directions", names, first->name, more);
    else if (w->wanted == FF_WINDOW_VISIBLE_OR_ALL && (size_t)w->seen[first->face] > w->n_blocks)
        ff_table_note(t, "of the wavelengths %s, %s is read: the part %s:NAME reads another%s", names, first->name,
                      ff_window_part_name[first->face], w->structure < FF_WINDOW_TREE_3 ? ", :all reads all" : "");
}

ff_status ff_window_to_table(ff_window_file *w, ff_table *out)
{
    if (w->n_blocks == 0) return nothing_wanted(w);
    const size_t dropped = drop_others(w);
    ff_table t;
    const ff_status status = w->structure < FF_WINDOW_TREE_3 ? matrix_to_table(w, &t) : tree_to_table(w, &t);
    if (status != FF_OK) return status;
    describe(w, dropped, &t);
    return ff_table_hand_out(&t, w->xml.path, out, w->xml.err);
}
