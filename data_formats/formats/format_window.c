/* The BSDF of LBNL WINDOW and Radiance: XML with matrices over Klems' patches of the hemisphere, or tensor trees.
 *
 *     WindowElement / Optical / Layer
 *         DataDefinition
 *             IncidentDataStructure      Columns | Rows | TensorTree3 | TensorTree4
 *             AngleBasis ...             AngleBasisName; AngleBasisBlock ...: Theta, ThetaBounds (LowerTheta, UpperTheta), nPhis
 *         WavelengthData ...
 *             Wavelength                 "Visible", "Solar", "CIE-X", ...
 *             WavelengthDataBlock ...
 *                 WavelengthDataDirection  "Reflection Front", "Reflection Back", "Transmission ..."
 *                 ColumnAngleBasis, RowAngleBasis     names of bases; of a tree AngleBasis
 *                 ScatteringData         numbers in 1/sr without the cosine, separated by blanks or commas
 *
 * Columns: one column per incident patch, value[exit * n_incident + incident]; Rows: value[incident * n_exit + exit]. Patch k of a
 * ring of n is centred at the azimuth 360 k / n. ScatteringDataType says BTDF of reflection too and is not looked at.
 * A tree is a unit cube that nodes "{ 2^rank nodes }" halve along every axis (bit j of a branch's number is the half of axis j)
 * down to leaves "{ 2^(rank k) values }", grids whose last axis runs fastest. Axes of TensorTree4: the square of the incident, then
 * that of the exit direction, Shirley and Chiu's images of the disk. TensorTree3: (1 - sin theta_i) / 2, then the exit square.
 *
 * Directions. A patch (or a point of the disk) of incidence names where the light goes, one of exit likewise, in the x and y of the
 * sheet: patch k of exit is the mirror direction of patch k of incidence. So phi_o is the file's and phi_i the file's + 180
 * degrees. That is how Radiance (bsdf_m.c, bsdf_t.c) and WINDOW's engine read them. In Radiance both faces share x and y, which are
 * those seen from WINDOW's back (the room). Seen from the front, x points the other way: there phi_o = 180 - file, phi_i = -file.
 */
#define _GNU_SOURCE
#include "base/internal_input.h"
#include "base/internal_number.h"
#include "base/internal_tokens.h"
#include "data_formats/formats/window/internal_window.h"
#include "base/internal_xml.h"
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

enum { TEXT_MAX = 256, LIST_MAX = 240, BASES_MAX = 64, BLOCKS_MAX = 4096 };

/* ---- elements -------------------------------------------------------------------------------- */

enum element {
    OTHER,
    DOCUMENT,
    WINDOW,
    OPTICAL,
    LAYER,
    DEFINITION,
    STRUCTURE,
    BASIS,
    BASIS_NAME,
    BASIS_BLOCK,
    THETA,
    BOUNDS,
    LOWER,
    UPPER,
    N_PHIS,
    WAVELENGTH_DATA,
    WAVELENGTH,
    BLOCK,
    DIRECTION,
    COLUMN_BASIS,
    ROW_BASIS,
    TREE_BASIS,
    SCATTERING
};

/* Those that are looked at; has_text: what stands in it is wanted. */
static const struct {
    const char *name;
    unsigned char parent, is, has_text;
} elements[] = {
    {"WindowElement", DOCUMENT, WINDOW, 0},
    {"Optical", WINDOW, OPTICAL, 0},
    {"Layer", OPTICAL, LAYER, 0},
    {"DataDefinition", LAYER, DEFINITION, 0},
    {"IncidentDataStructure", DEFINITION, STRUCTURE, 1},
    {"AngleBasis", DEFINITION, BASIS, 0},
    {"AngleBasisName", BASIS, BASIS_NAME, 1},
    {"AngleBasisBlock", BASIS, BASIS_BLOCK, 0},
    {"Theta", BASIS_BLOCK, THETA, 1},
    {"ThetaBounds", BASIS_BLOCK, BOUNDS, 0},
    {"LowerTheta", BOUNDS, LOWER, 1},
    {"UpperTheta", BOUNDS, UPPER, 1},
    {"nPhis", BASIS_BLOCK, N_PHIS, 1},
    {"WavelengthData", LAYER, WAVELENGTH_DATA, 0},
    {"Wavelength", WAVELENGTH_DATA, WAVELENGTH, 1},
    {"WavelengthDataBlock", WAVELENGTH_DATA, BLOCK, 0},
    {"WavelengthDataDirection", BLOCK, DIRECTION, 1},
    {"ColumnAngleBasis", BLOCK, COLUMN_BASIS, 1},
    {"RowAngleBasis", BLOCK, ROW_BASIS, 1},
    {"AngleBasis", BLOCK, TREE_BASIS, 1},
    {"ScatteringData", BLOCK, SCATTERING, 0},
};
enum { N_ELEMENTS = sizeof elements / sizeof elements[0] };

static unsigned char element_of(const char *name, unsigned char parent)
{
    for (size_t k = 0; k < N_ELEMENTS; k++)
        if (elements[k].parent == parent && strcmp(elements[k].name, name) == 0) return elements[k].is;
    return OTHER;
}

static int has_text(unsigned char element)
{
    for (size_t k = 0; k < N_ELEMENTS; k++)
        if (elements[k].is == element) return elements[k].has_text;
    return 0;
}

/* ---- what is read ---------------------------------------------------------------------------- */

enum structure { NO_STRUCTURE, COLUMNS, ROWS, TREE_3, TREE_4 };
enum face { FRONT, BACK, N_FACES, TRANSMISSION, NO_FACE };
static const char *const face_name[N_FACES] = {"Reflection Front", "Reflection Back"};
static const char *const part_name[N_FACES] = {"reflection-front", "reflection-back"};

/* One ScatteringData that is kept. */
typedef struct block {
    int face;
    char name[FF_CHANNEL_NAME];
    double wavelength_nm;
    size_t incident, exit; /* bases */
    ff_scattering data;
} block;

/* Which wavelengths are wanted. */
enum wanted { VISIBLE_OR_ALL, ALL, NAMED };

typedef struct window {
    ff_xml xml;
    unsigned char stack[FF_XML_DEPTH + 2]; /* elements that are open; stack[0] = DOCUMENT */
    char text[TEXT_MAX];
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
    block *blocks; /* [n_blocks] */
    size_t n_blocks;
    size_t left_out;               /* trees beside the one that is kept */
    int seen[NO_FACE];             /* blocks of each direction */
    char names[N_FACES][LIST_MAX]; /* their wavelengths */
} window;

__attribute__((format(printf, 3, 4))) static ff_status fail(const window *w, ff_status code, const char *fmt, ...)
{
    char message[FF_ERROR_MESSAGE];
    va_list args;
    va_start(args, fmt);
    vsnprintf(message, sizeof message, fmt, args);
    va_end(args);
    return ff_error_set(w->xml.err, code, w->xml.path, w->xml.parser ? ff_xml_line(&w->xml) : 0, -1, "%s", message);
}

static const char *quoted(const char *text, char out[FF_QUOTE])
{
    return ff_quote(text, strlen(text), out);
}

/* ---- bases ----------------------------------------------------------------------------------- */

static ff_status new_basis(window *w)
{
    if (w->n_bases == BASES_MAX) return fail(w, FF_ERR_FORMAT, "found more than %d elements AngleBasis, expected fewer", BASES_MAX);
    ff_window_basis *b = calloc(1, sizeof *b);
    ff_window_basis **larger = b ? realloc(w->bases, (w->n_bases + 1) * sizeof *larger) : NULL;
    if (!larger) {
        free(b);
        return fail(w, FF_ERR_MEMORY, "no memory for a basis");
    }
    w->bases = larger;
    w->bases[w->n_bases++] = b;
    return FF_OK;
}

static ff_window_basis *last_basis(const window *w)
{
    return w->bases[w->n_bases - 1];
}

/* Index among the first n, SIZE_MAX when there is none of that name. */
static size_t find_basis(const window *w, const char *name, size_t n)
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

static ff_status end_basis(window *w)
{
    char found[FF_QUOTE];
    ff_window_basis *b = last_basis(w);
    if (b->name[0] == '\0') return fail(w, FF_ERR_FORMAT, "found an AngleBasis without a name, expected AngleBasisName in it");
    if (b->n_rings == 0 && !ff_window_standard_basis(b))
        return fail(w, FF_ERR_FORMAT, "found the basis %s without an AngleBasisBlock, expected its rings of patches",
                    quoted(b->name, found));
    const size_t before = find_basis(w, b->name, w->n_bases - 1);
    if (before == SIZE_MAX) return FF_OK;
    if (!same_rings(w->bases[before], b))
        return fail(w, FF_ERR_FORMAT, "found two bases %s that differ, expected one", quoted(b->name, found));
    free(b);
    w->n_bases--;
    return FF_OK;
}

static ff_status end_basis_block(window *w)
{
    ff_window_ring *r = &w->ring;
    if (isnan(r->lower) || isnan(r->upper) || r->n_phi == 0)
        return fail(w, FF_ERR_FORMAT, "found an AngleBasisBlock without %s, expected LowerTheta, UpperTheta and nPhis",
                    isnan(r->lower)   ? "LowerTheta"
                    : isnan(r->upper) ? "UpperTheta"
                                      : "nPhis");
    if (isnan(r->theta)) r->theta = r->n_phi == 1 && r->lower == 0 ? 0 : (r->lower + r->upper) / 2;
    return ff_window_add_ring(last_basis(w), r, w->xml.path, ff_xml_line(&w->xml), w->xml.err);
}

static ff_status read_angle(window *w, const char *what, double *angle)
{
    char found[FF_QUOTE];
    const char *end = ff_number_read(w->text, angle);
    if (end && *end == '\0' && *angle >= 0 && *angle <= 90) return FF_OK;
    return fail(w, FF_ERR_DATA, "%s: found %s, expected degrees from 0 to 90", what, quoted(w->text, found));
}

static ff_status read_n_phis(window *w)
{
    char found[FF_QUOTE];
    uint64_t n;
    if (!ff_whole_number(w->text, FF_WINDOW_PATCHES, &n) || n == 0)
        return fail(w, FF_ERR_DATA, "nPhis: found %s, expected a whole number from 1 to %d", quoted(w->text, found),
                    FF_WINDOW_PATCHES);
    w->ring.n_phi = (size_t)n;
    return FF_OK;
}

/* A basis that a block names: one of the file's, or one that everybody knows. */
static ff_status use_basis(window *w, size_t *out)
{
    char found[FF_QUOTE], names[LIST_MAX];
    *out = find_basis(w, w->text, w->n_bases);
    if (*out != SIZE_MAX) return FF_OK;
    if (strlen(w->text) < FF_WINDOW_NAME) {
        ff_status status = new_basis(w);
        if (status != FF_OK) return status;
        strcpy(last_basis(w)->name, w->text);
        *out = w->n_bases - 1;
        if (ff_window_standard_basis(last_basis(w))) return FF_OK;
        free(last_basis(w));
        w->n_bases--;
    }
    size_t used = 0;
    names[0] = '\0';
    for (size_t k = 0; k < w->n_bases && used < sizeof names; k++)
        used += (size_t)snprintf(names + used, sizeof names - used, ", %s", quoted(w->bases[k]->name, (char[FF_QUOTE]){0}));
    return fail(w, FF_ERR_FORMAT,
                "found the basis %s, expected LBNL/Klems Full, Half or Quarter, or one that an AngleBasis defines%s",
                quoted(w->text, found), names);
}

/* ---- the choice among blocks ----------------------------------------------------------------- */

static void drop_block(window *w, size_t k)
{
    ff_scattering_free(&w->blocks[k].data);
    memmove(w->blocks + k, w->blocks + k + 1, (w->n_blocks - k - 1) * sizeof *w->blocks);
    w->n_blocks--;
}

static int is_visible(const char *name)
{
    return strcasecmp(name, "Visible") == 0;
}

/* CIE-u and CIE-v of a tree are chromaticities. */
static int is_reflectance(const window *w)
{
    return w->structure < TREE_3 || (strcasecmp(w->wavelength, "CIE-u") != 0 && strcasecmp(w->wavelength, "CIE-v") != 0);
}

/* Whether the block that opens may be of use; blocks that it replaces go. */
static int is_wanted(window *w)
{
    if (w->face >= N_FACES || !is_reflectance(w) || (w->part != NO_FACE && w->face != w->part)) return 0;
    if (w->wanted == NAMED && strcasecmp(w->wavelength, w->asked) != 0) return 0;
    for (size_t k = 0; k < w->n_blocks; k++) {
        const block *b = &w->blocks[k];
        if (w->part == NO_FACE && w->face == BACK && b->face == FRONT) return 0;
        if (w->wanted == VISIBLE_OR_ALL && b->face == w->face && is_visible(b->name) && !is_visible(w->wavelength)) return 0;
    }
    for (size_t k = w->n_blocks; k-- > 0;) {
        const block *b = &w->blocks[k];
        const int other_face = b->face != w->face && w->face == FRONT;
        const int less = w->wanted == VISIBLE_OR_ALL && b->face == w->face && is_visible(w->wavelength) && !is_visible(b->name);
        if (!other_face && !less) continue;
        drop_block(w, k);
        w->left_out = 0;
    }
    if (w->structure < TREE_3 || w->n_blocks == 0 || strcasecmp(w->blocks[0].name, w->wavelength) == 0) return 1;
    w->left_out++; /* every tree has directions of its own */
    return 0;
}

static void note_seen(window *w)
{
    w->seen[w->face]++;
    if (w->face >= N_FACES) return;
    char *list = w->names[w->face];
    const size_t used = strlen(list);
    if (used + strlen(w->wavelength) + 3 < LIST_MAX) sprintf(list + used, "%s%s", used ? ", " : "", w->wavelength);
}

static ff_status check_bases(const window *w, const block *b)
{
    if (w->structure >= TREE_3)
        return w->tree_basis
                   ? FF_OK
                   : fail(w, FF_ERR_FORMAT, "found ScatteringData of a tree before its AngleBasis, expected LBNL/Shirley-Chiu");
    if (b->incident == SIZE_MAX || b->exit == SIZE_MAX)
        return fail(w, FF_ERR_FORMAT, "found ScatteringData without a %s before it, expected both bases",
                    w->column == SIZE_MAX ? "ColumnAngleBasis" : "RowAngleBasis");
    if (w->structure == ROWS && b->incident != b->exit)
        return fail(
            w, FF_ERR_UNSUPPORTED,
            "found different bases of columns and rows with incident directions in rows, of which programs differ which is whose; "
            "expected the same basis");
    return FF_OK;
}

static long line_of_data(void *xml)
{
    return ff_xml_line(xml);
}

static ff_status open_data(window *w, block *b)
{
    *b = (block){.face = w->face, .wavelength_nm = ff_wavelength_of(w->wavelength)};
    strcpy(b->name, w->wavelength);
    b->incident = w->structure == ROWS ? w->row : w->column;
    b->exit = w->structure == ROWS ? w->column : w->row;
    const ff_status status = check_bases(w, b);
    if (status != FF_OK) return status;
    b->data = (ff_scattering){.path = w->xml.path, .err = w->xml.err, .buffer = w->buffer, .line = line_of_data, .user = &w->xml};
    b->data.mirrored = w->face == FRONT;
    b->data.rank = w->structure == TREE_3 ? 3 : w->structure == TREE_4 ? 4 : 0;
    b->data.leaves.width = ff_rows_width(1, 0, 1);
    if (b->data.rank) return FF_OK;
    const size_t n_incident = w->bases[b->incident]->n, n_exit = w->bases[b->exit]->n;
    b->data.expected = (uint64_t)n_incident * n_exit;
    snprintf(b->data.what, sizeof b->data.what, "%zu x %zu (one per pair of patches)", n_incident, n_exit);
    return FF_OK;
}

static ff_status start_scattering(window *w)
{
    if (w->structure == NO_STRUCTURE)
        return fail(w, FF_ERR_FORMAT,
                    "found ScatteringData before IncidentDataStructure, expected it in DataDefinition before the data");
    if (w->face == NO_FACE || w->wavelength[0] == '\0')
        return fail(w, FF_ERR_FORMAT, "found ScatteringData before %s, expected it behind",
                    w->face == NO_FACE ? "WavelengthDataDirection" : "Wavelength");
    if (w->has_data) return fail(w, FF_ERR_FORMAT, "found a second ScatteringData in one WavelengthDataBlock, expected one");
    w->has_data = 1;
    note_seen(w);
    if (!is_wanted(w)) return FF_OK;
    for (size_t k = 0; k < w->n_blocks; k++)
        if (w->blocks[k].face == w->face && strcasecmp(w->blocks[k].name, w->wavelength) == 0)
            return fail(w, FF_ERR_FORMAT, "found %s of '%s' twice, expected it once", face_name[w->face], w->wavelength);
    if (w->n_blocks == BLOCKS_MAX) return fail(w, FF_ERR_FORMAT, "found more than %d wavelengths, expected fewer", BLOCKS_MAX);
    block *larger = realloc(w->blocks, (w->n_blocks + 1) * sizeof *larger);
    if (!larger) return fail(w, FF_ERR_MEMORY, "no memory for another block");
    w->blocks = larger;
    const ff_status status = open_data(w, &w->blocks[w->n_blocks]);
    if (status != FF_OK) return status;
    w->n_blocks++;
    w->reading = 1;
    return FF_OK;
}

static ff_status end_scattering(window *w)
{
    if (!w->reading) return FF_OK;
    w->reading = 0;
    return ff_scattering_end(&w->blocks[w->n_blocks - 1].data);
}

/* ---- elements with text ---------------------------------------------------------------------- */

/* Drops blanks at both ends, makes those within one space. */
static void tidy(window *w)
{
    size_t n = 0;
    for (size_t i = 0; i < w->n_text; i++) {
        const char c = w->text[i];
        const int blank = c == ' ' || c == '\t' || c == '\n' || c == '\r';
        if (!blank)
            w->text[n++] = c;
        else if (n > 0 && w->text[n - 1] != ' ')
            w->text[n++] = ' ';
    }
    if (n > 0 && w->text[n - 1] == ' ') n--;
    w->text[n] = '\0';
    w->n_text = n;
}

static ff_status read_structure(window *w)
{
    static const char *const known[] = {NULL, "Columns", "Rows", "TensorTree3", "TensorTree4"};
    char found[FF_QUOTE];
    for (int k = COLUMNS; k <= TREE_4; k++) {
        if (strcasecmp(w->text, known[k]) != 0) continue;
        if (w->structure != NO_STRUCTURE && w->structure != k)
            return fail(w, FF_ERR_FORMAT, "found IncidentDataStructure %s and %s, expected one", known[w->structure], known[k]);
        w->structure = k;
        return FF_OK;
    }
    return fail(w, FF_ERR_UNSUPPORTED, "IncidentDataStructure: found %s, expected Columns, Rows, TensorTree3 or TensorTree4",
                quoted(w->text, found));
}

static ff_status read_direction(window *w)
{
    char found[FF_QUOTE];
    for (int k = 0; k < N_FACES; k++)
        if (strcasecmp(w->text, face_name[k]) == 0) w->face = k;
    if (strncasecmp(w->text, "Transmission", 12) == 0) w->face = TRANSMISSION;
    if (w->face != NO_FACE) return FF_OK;
    return fail(w, FF_ERR_FORMAT, "WavelengthDataDirection: found %s, expected Reflection or Transmission, Front or Back",
                quoted(w->text, found));
}

static ff_status read_name(window *w, const char *what, char *out, size_t size)
{
    char found[FF_QUOTE];
    int plain = w->n_text > 0 && w->n_text < size;
    for (size_t i = 0; i < w->n_text; i++) plain &= (unsigned char)w->text[i] >= 0x20 && w->text[i] != 0x7F;
    if (!plain)
        return fail(w, FF_ERR_FORMAT, "%s: found %s, expected a name of 1 to %zu bytes", what, quoted(w->text, found), size - 1);
    strcpy(out, w->text);
    return FF_OK;
}

/* A name, or a number of the element's unit: "550nm". */
static ff_status read_wavelength(window *w)
{
    const ff_status status = read_name(w, "Wavelength", w->wavelength, FF_CHANNEL_NAME);
    if (status != FF_OK || isnan(w->per_nm)) return status;
    double number;
    const char *end = ff_number_read(w->wavelength, &number);
    if (end && *end == '\0' && number > 0 && isfinite(number * w->per_nm))
        snprintf(w->wavelength, FF_CHANNEL_NAME, "%.6gnm", number * w->per_nm);
    return FF_OK;
}

static ff_status read_tree_basis(window *w)
{
    char found[FF_QUOTE];
    if (w->structure < TREE_3) return FF_OK;
    w->tree_basis = strcasecmp(w->text, "LBNL/Shirley-Chiu") == 0;
    if (w->tree_basis) return FF_OK;
    return fail(w, FF_ERR_UNSUPPORTED, "AngleBasis: found %s, expected LBNL/Shirley-Chiu", quoted(w->text, found));
}

static ff_status end_text(window *w, unsigned char element)
{
    tidy(w);
    switch (element) {
    case STRUCTURE:
        return read_structure(w);
    case BASIS_NAME:
        return read_name(w, "AngleBasisName", last_basis(w)->name, FF_WINDOW_NAME);
    case THETA:
        return read_angle(w, "Theta", &w->ring.theta);
    case LOWER:
        return read_angle(w, "LowerTheta", &w->ring.lower);
    case UPPER:
        return read_angle(w, "UpperTheta", &w->ring.upper);
    case N_PHIS:
        return read_n_phis(w);
    case WAVELENGTH:
        return read_wavelength(w);
    case DIRECTION:
        return read_direction(w);
    case COLUMN_BASIS:
        return use_basis(w, &w->column);
    case ROW_BASIS:
        return use_basis(w, &w->row);
    case TREE_BASIS:
        return read_tree_basis(w);
    default:
        return FF_OK;
    }
}

/* ---- what the XML calls ---------------------------------------------------------------------- */

static void set_unit(window *w, const char *const *attributes)
{
    const char *unit = ff_xml_attribute(attributes, "unit");
    w->per_nm = NAN;
    if (unit && (strncasecmp(unit, "nano", 4) == 0 || strcasecmp(unit, "nm") == 0)) w->per_nm = 1;
    if (unit && (strncasecmp(unit, "micro", 5) == 0 || strcasecmp(unit, "um") == 0)) w->per_nm = 1000;
}

static ff_status on_start(void *user, const char *name, const char *const *attributes)
{
    window *w = user;
    char found[FF_QUOTE];
    const unsigned depth = w->xml.depth;
    const unsigned char element = element_of(name, w->stack[depth - 1]);
    if (depth == 1 && element != WINDOW)
        return fail(w, FF_ERR_FORMAT, "found the element %s, expected WindowElement", quoted(name, found));
    w->stack[depth] = element;
    ff_xml_want_text(&w->xml, has_text(element));
    if (has_text(element)) w->n_text = 0;
    switch (element) {
    case BASIS:
        return new_basis(w);
    case BASIS_BLOCK:
        w->ring = (ff_window_ring){NAN, NAN, NAN, 0};
        return FF_OK;
    case WAVELENGTH_DATA:
        w->wavelength[0] = '\0';
        return FF_OK;
    case WAVELENGTH:
        set_unit(w, attributes);
        return FF_OK;
    case BLOCK:
        w->face = NO_FACE;
        w->column = w->row = SIZE_MAX;
        w->tree_basis = w->has_data = 0;
        return FF_OK;
    case SCATTERING: {
        const ff_status status = start_scattering(w);
        ff_xml_want_text(&w->xml, w->reading);
        return status;
    }
    default:
        return FF_OK;
    }
}

static ff_status on_end(void *user)
{
    window *w = user;
    const unsigned depth = w->xml.depth; /* of the parent */
    const unsigned char element = w->stack[depth + 1];
    ff_xml_want_text(&w->xml, w->stack[depth] == SCATTERING ? w->reading : has_text(w->stack[depth]));
    if (has_text(element)) return end_text(w, element);
    if (element == BASIS) return end_basis(w);
    if (element == BASIS_BLOCK) return end_basis_block(w);
    if (element == SCATTERING) return end_scattering(w);
    if (element == BLOCK && !w->has_data)
        return fail(w, FF_ERR_FORMAT, "found a WavelengthDataBlock without ScatteringData, expected its numbers");
    return FF_OK;
}

static ff_status on_text(void *user, const char *text, size_t n)
{
    window *w = user;
    if (w->reading) return ff_scattering_text(&w->blocks[w->n_blocks - 1].data, text, n);
    if (w->n_text + n >= TEXT_MAX)
        return fail(w, FF_ERR_FORMAT, "found a text of more than %d bytes, expected a name or a number", TEXT_MAX - 1);
    memcpy(w->text + w->n_text, text, n);
    w->n_text += n;
    return FF_OK;
}

/* ---- the table ------------------------------------------------------------------------------- */

static ff_status nothing_wanted(const window *w)
{
    const int any = w->seen[FRONT] + w->seen[BACK];
    if (any == 0 && w->seen[TRANSMISSION])
        return fail(w, FF_ERR_UNSUPPORTED, "found transmission alone, expected a block Reflection Front or Reflection Back");
    if (any == 0) return fail(w, FF_ERR_FORMAT, "found no ScatteringData, expected a block Reflection Front or Reflection Back");
    if (w->part != NO_FACE && w->seen[w->part] == 0)
        return fail(w, FF_ERR_UNSUPPORTED, "found %s alone, but %s was asked for", face_name[!w->part], part_name[w->part]);
    const int face = w->part != NO_FACE ? w->part : w->seen[FRONT] ? FRONT : BACK;
    if (w->wanted == NAMED)
        return fail(w, FF_ERR_UNSUPPORTED, "found the wavelengths %s of %s, but '%s' was asked for", w->names[face],
                    face_name[face], w->asked);
    return fail(w, FF_ERR_UNSUPPORTED, "found chromaticities alone (%s), expected a reflectance", w->names[face]);
}

/* Channels of one table share their directions: those of the first. */
static size_t drop_others(window *w)
{
    size_t dropped = w->left_out;
    for (size_t k = w->n_blocks; k-- > 1;) {
        const block *b = &w->blocks[k], *first = &w->blocks[0];
        if (b->incident == first->incident && b->exit == first->exit) continue;
        drop_block(w, k);
        dropped++;
    }
    return dropped;
}

static void fill_directions(const window *w, ff_table *t, double *const incident[3], double *const exit[3])
{
    const block *b = &w->blocks[0];
    const size_t n_incident = w->bases[b->incident]->n, n_exit = w->bases[b->exit]->n;
    for (size_t i = 0; i < n_incident; i++)
        incident[1][i] = fmod(b->face == FRONT ? 360 - incident[1][i] : incident[1][i] + 180, 360);
    for (size_t o = 0; o < n_exit && b->face == FRONT; o++) exit[1][o] = fmod(540 - exit[1][o], 360);
    for (size_t s = 0; s < t->n; s++) {
        const size_t i = w->structure == ROWS ? s / n_exit : s % n_incident, o = w->structure == ROWS ? s % n_exit : s / n_incident;
        t->angle[0][s] = incident[0][i];
        t->angle[1][s] = incident[1][i];
        t->angle[2][s] = exit[0][o];
        t->angle[3][s] = exit[1][o];
        t->weight[s] = incident[2][i] * exit[2][o];
    }
}

static ff_status matrix_directions(const window *w, ff_table *t)
{
    const ff_window_basis *bi = w->bases[w->blocks[0].incident], *bo = w->bases[w->blocks[0].exit];
    double *planes = malloc(3 * (bi->n + bo->n) * sizeof *planes);
    if (!planes) return fail(w, FF_ERR_MEMORY, "no memory for the patches");
    double *const incident[3] = {planes, planes + bi->n, planes + 2 * bi->n};
    double *const exit[3] = {planes + 3 * bi->n, planes + 3 * bi->n + bo->n, planes + 3 * bi->n + 2 * bo->n};
    ff_window_patches(bi, incident[0], incident[1], incident[2]);
    ff_window_patches(bo, exit[0], exit[1], exit[2]);
    fill_directions(w, t, incident, exit);
    free(planes);
    return FF_OK;
}

static ff_status matrix_to_table(window *w, ff_table *t)
{
    ff_status status = ff_table_new(w->blocks[0].data.n, w->n_blocks, NULL, 0, 1, t, w->xml.err);
    if (status != FF_OK) return status;
    for (size_t c = 0; c < w->n_blocks; c++) {
        memcpy(t->value + c * t->n, w->blocks[c].data.value, t->n * sizeof *t->value);
        ff_scattering_free(&w->blocks[c].data);
    }
    status = matrix_directions(w, t);
    if (status != FF_OK) ff_table_free(t);
    return status;
}

static void describe(const window *w, size_t dropped, ff_table *t)
{
    const block *first = &w->blocks[0];
    strcpy(t->format, "window");
    t->radians_per_unit = 3.14159265358979323846 / 180;
    t->isotropic = w->structure == TREE_3;
    for (size_t c = 0; c < t->n_channels; c++) {
        strcpy(t->channels[c].name, w->blocks[c].name);
        t->channels[c].wavelength_nm = w->blocks[c].wavelength_nm;
    }
    ff_table_note(t, "values are means over %s; they stand at the centres",
                  w->structure < TREE_3 ? "pairs of patches" : "cells of the tree");
    if (w->part == NO_FACE && w->seen[FRONT] && w->seen[BACK])
        ff_table_note(t, "Reflection Front is read, Reflection Back is there too: the part reflection-back reads it");
    if (first->face == FRONT && !t->isotropic)
        ff_table_note(
            t, "x and y of the file are taken as those seen from the back, as Radiance does: azimuths are mirrored for the front");
    const char *names = w->names[first->face], *more = w->n_blocks > 1 ? " and those on the same patches are" : " is";
    if (dropped)
        ff_table_note(t, "of the wavelengths %s, %s%s read: the others are on other directions", names, first->name, more);
    else if (w->wanted == VISIBLE_OR_ALL && (size_t)w->seen[first->face] > w->n_blocks)
        ff_table_note(t, "of the wavelengths %s, %s is read: the part %s:NAME reads another%s", names, first->name,
                      part_name[first->face], w->structure < TREE_3 ? ", :all reads all" : "");
}

static ff_status to_table(window *w, ff_table *out)
{
    if (w->n_blocks == 0) return nothing_wanted(w);
    const size_t dropped = drop_others(w);
    ff_table t;
    ff_status status =
        w->structure < TREE_3 ? matrix_to_table(w, &t) : ff_rows_to_table(&w->blocks[0].data.leaves, 1, 0, 1, &t, w->xml.err);
    if (status != FF_OK) return status;
    describe(w, dropped, &t);
    return ff_table_hand_out(&t, w->xml.path, out, w->xml.err);
}

/* ---- the format ------------------------------------------------------------------------------ */

/* "reflection-front", "reflection-back", either with ":all" or ":NAME" of a wavelength. */
static ff_status read_part(window *w, const char *part)
{
    char found[FF_QUOTE];
    w->part = NO_FACE;
    w->wanted = VISIBLE_OR_ALL;
    if (!part) return FF_OK;
    const size_t n = strcspn(part, ":");
    for (int k = 0; k < N_FACES; k++)
        if (n == strlen(part_name[k]) && strncasecmp(part, part_name[k], n) == 0) w->part = k;
    const char *name = part[n] == ':' ? part + n + 1 : NULL;
    if (w->part == NO_FACE || (name && (name[0] == '\0' || strlen(name) >= sizeof w->asked)))
        return fail(w, FF_ERR_UNSUPPORTED,
                    "found the part %s, expected reflection-front or reflection-back, or one of them with :all or the name of a "
                    "wavelength, as in reflection-front:Solar",
                    quoted(part, found));
    if (name) {
        w->wanted = strcasecmp(name, "all") == 0 ? ALL : NAMED;
        strcpy(w->asked, name);
    }
    return FF_OK;
}

static ff_status read_window(const char *path, const ff_read_options *o, ff_table *out, ff_error *err)
{
    static const ff_xml_calls calls = {on_start, on_end, on_text};
    window *w = calloc(1, sizeof *w);
    if (!w) return ff_error_set(err, FF_ERR_MEMORY, path, 0, -1, "no memory for a reader");
    w->xml = (ff_xml){.path = path, .err = err, .calls = &calls, .user = w};
    w->stack[0] = DOCUMENT;
    ff_status status = read_part(w, o->part);
    if (status == FF_OK) status = ff_xml_read(&w->xml);
    if (status == FF_OK) status = to_table(w, out);
    while (w->n_blocks > 0) drop_block(w, w->n_blocks - 1);
    free(w->blocks);
    while (w->n_bases > 0) free(w->bases[--w->n_bases]);
    free(w->bases);
    free(w);
    return status;
}

/* UTF-16 becomes readable without its NUL bytes. */
static int probe(const unsigned char *head, size_t n, int64_t file_size)
{
    static const char name[] = "WindowElement";
    (void)file_size;
    const int utf16 = n > 1 && ((head[0] == 0xFF && head[1] == 0xFE) || (head[0] == 0xFE && head[1] == 0xFF));
    const size_t step = utf16 ? 2 : 1;
    size_t at = utf16 ? 2 + (head[0] == 0xFE) : 0;
    while (at < n && (head[at] == ' ' || head[at] == '\t' || head[at] == '\r' || head[at] == '\n')) at += step;
    if (at >= n || head[at] != '<') return 0;
    for (size_t same = 0; at < n; at += step) {
        same = head[at] == (unsigned char)name[same] ? same + 1 : head[at] == 'W';
        if (name[same] == '\0') return 95;
    }
    return 0;
}

const ff_format ff_format_window = {
    .name = "window",
    .title = "LBNL WINDOW and Radiance BSDF XML: Klems matrices, tensor trees",
    .extensions = ".xml",
    .source = "LBNL WINDOW BSDF-v1.4.xsd; Radiance bsdf_m.c, bsdf_t.c; Klems 1994; Ward 2011 (tensor trees)",
    .probe = probe,
    .reads = FF_READS_PART,
    .read = read_window,
};
