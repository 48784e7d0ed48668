/* A WINDOW file on its way to a table: what has been read of it so far. Files are read by format_window.c. */
#ifndef FF_INTERNAL_WINDOW_FILE_H
#define FF_INTERNAL_WINDOW_FILE_H
#include "base/internal_input.h"
#include "base/internal_xml.h"
#include "internal_window.h"
#include <string.h>

enum { FF_WINDOW_TEXT = 256, FF_WINDOW_LIST = 240 };

enum ff_window_structure { FF_WINDOW_NO_STRUCTURE, FF_WINDOW_COLUMNS, FF_WINDOW_ROWS, FF_WINDOW_TREE_3, FF_WINDOW_TREE_4 };
enum ff_window_face { FF_WINDOW_FRONT, FF_WINDOW_BACK, FF_WINDOW_FACES, FF_WINDOW_TRANSMISSION, FF_WINDOW_NO_FACE };
extern const char *const ff_window_face_name[FF_WINDOW_FACES]; /* "Reflection Front", as files have it */
extern const char *const ff_window_part_name[FF_WINDOW_FACES]; /* "reflection-front", as people ask for it */

/* One ScatteringData that is kept. */
typedef struct ff_window_block {
    int face;
    char name[FF_CHANNEL_NAME];
    double wavelength_nm;
    size_t incident, exit; /* bases */
    ff_scattering data;
} ff_window_block;

/* Which wavelengths are wanted. */
enum ff_window_wanted { FF_WINDOW_VISIBLE_OR_ALL, FF_WINDOW_ALL, FF_WINDOW_NAMED };

typedef struct ff_window_file {
    ff_xml xml;
    unsigned char stack[FF_XML_DEPTH + 2]; /* elements that are open; stack[0] = DOCUMENT */
    char text[FF_WINDOW_TEXT];
    size_t n_text;
    int structure;
    ff_window_basis **bases; /* [n_bases] */
    size_t n_bases;
    ff_window_ring ring; /* the block that is open */
    /* the WavelengthData and WavelengthDataBlock that are open */
    char wavelength[FF_CHANNEL_NAME];
    double per_nm; /* nm of the wavelength's unit; NaN: it is no length */
    int face, has_data;
    size_t column, row; /* bases, SIZE_MAX = not stated */
    int tree_basis;
    int reading; /* the ScatteringData that is open goes to the last block */
    char buffer[FF_SCATTERING_BUFFER];
    /* the choice */
    int part, wanted;
    char asked[FF_CHANNEL_NAME];
    ff_window_block *blocks; /* [n_blocks] */
    size_t n_blocks;
    size_t left_out;                             /* trees beside the one that is kept */
    int seen[FF_WINDOW_NO_FACE];                 /* blocks of each direction */
    char names[FF_WINDOW_FACES][FF_WINDOW_LIST]; /* their wavelengths */
} ff_window_file;

/* An error about what stands at the present place of the file. */
__attribute__((format(printf, 3, 4))) ff_status ff_window_fails(const ff_window_file *w, ff_status code, const char *fmt, ...);

static inline const char *ff_window_quoted(const char *text, char out[FF_QUOTE])
{
    return ff_quote(text, strlen(text), out);
}

/* ---- window_bases.c: elements about the division of the hemisphere --------------------------- */

/* AngleBasis begins (its name and rings go to the last basis) and ends; FF_ERR_FORMAT, FF_ERR_MEMORY. */
ff_status ff_window_new_basis(ff_window_file *w);
ff_window_basis *ff_window_last_basis(const ff_window_file *w);
ff_status ff_window_end_basis(ff_window_file *w);
/* AngleBasisBlock ends: w->ring goes to the last basis. */
ff_status ff_window_end_basis_block(ff_window_file *w);
/* The text of Theta, LowerTheta, UpperTheta (`what`), and of nPhis. */
ff_status ff_window_read_angle(ff_window_file *w, const char *what, double *angle);
ff_status ff_window_read_n_phis(ff_window_file *w);
/* The basis that the text names: one of the file's, or one that everybody knows. */
ff_status ff_window_use_basis(ff_window_file *w, size_t *out);

/* ---- window_table.c: the blocks that were kept become a table --------------------------------- */

void ff_window_drop_block(ff_window_file *w, size_t k);
/* FF_ERR_UNSUPPORTED, FF_ERR_FORMAT when nothing was kept; FF_ERR_DATA, FF_ERR_MEMORY. */
ff_status ff_window_to_table(ff_window_file *w, ff_table *out);
#endif
