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
#include "data_formats/formats/window/internal_window_file.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

enum { BLOCKS_MAX = 4096 };

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

/* ---- the choice among blocks ----------------------------------------------------------------- */

static int is_visible(const char *name)
{
    return strcasecmp(name, "Visible") == 0;
}

/* CIE-u and CIE-v of a tree are chromaticities. */
static int is_reflectance(const ff_window_file *w)
{
    return w->structure < FF_WINDOW_TREE_3 || (strcasecmp(w->wavelength, "CIE-u") != 0 && strcasecmp(w->wavelength, "CIE-v") != 0);
}

/* Whether the block that opens may be of use; blocks that it replaces go. */
static int is_wanted(ff_window_file *w)
{
    if (w->face >= FF_WINDOW_FACES || !is_reflectance(w) || (w->part != FF_WINDOW_NO_FACE && w->face != w->part)) return 0;
    if (w->wanted == FF_WINDOW_NAMED && strcasecmp(w->wavelength, w->asked) != 0) return 0;
    for (size_t k = 0; k < w->n_blocks; k++) {
        const ff_window_block *b = &w->blocks[k];
        if (w->part == FF_WINDOW_NO_FACE && w->face == FF_WINDOW_BACK && b->face == FF_WINDOW_FRONT) return 0;
        if (w->wanted == FF_WINDOW_VISIBLE_OR_ALL && b->face == w->face && is_visible(b->name) && !is_visible(w->wavelength))
            return 0;
    }
    for (size_t k = w->n_blocks; k-- > 0;) {
        const ff_window_block *b = &w->blocks[k];
        const int other_face = b->face != w->face && w->face == FF_WINDOW_FRONT;
        const int less =
            w->wanted == FF_WINDOW_VISIBLE_OR_ALL && b->face == w->face && is_visible(w->wavelength) && !is_visible(b->name);
        if (!other_face && !less) continue;
        ff_window_drop_block(w, k);
        w->left_out = 0;
    }
    if (w->structure < FF_WINDOW_TREE_3 || w->n_blocks == 0 || strcasecmp(w->blocks[0].name, w->wavelength) == 0) return 1;
    w->left_out++; /* every tree has directions of its own */
    return 0;
}

static void note_seen(ff_window_file *w)
{
    w->seen[w->face]++;
    if (w->face >= FF_WINDOW_FACES) return;
    char *list = w->names[w->face];
    const size_t used = strlen(list);
    if (used + strlen(w->wavelength) + 3 < FF_WINDOW_LIST) sprintf(list + used, "%s%s", used ? ", " : "", w->wavelength);
}

static ff_status check_bases(const ff_window_file *w, const ff_window_block *b)
{
    if (w->structure >= FF_WINDOW_TREE_3)
        return w->tree_basis ? FF_OK
                             : ff_window_fails(w, FF_ERR_FORMAT,
                                               "found ScatteringData of a tree before its AngleBasis, expected LBNL/Shirley-Chiu");
    if (b->incident == SIZE_MAX || b->exit == SIZE_MAX)
        return ff_window_fails(w, FF_ERR_FORMAT, "found ScatteringData without a %s before it, expected both bases",
                               w->column == SIZE_MAX ? "ColumnAngleBasis" : "RowAngleBasis");
    if (w->structure == FF_WINDOW_ROWS && b->incident != b->exit)
        return ff_window_fails(
            w, FF_ERR_UNSUPPORTED,
            "found different bases of columns and rows with incident directions in rows, of which programs differ which is whose; "
            "expected the same basis");
    return FF_OK;
}

static long line_of_data(void *xml)
{
    return ff_xml_line(xml);
}

static ff_status open_data(ff_window_file *w, ff_window_block *b)
{
    *b = (ff_window_block){.face = w->face, .wavelength_nm = ff_wavelength_of(w->wavelength)};
    strcpy(b->name, w->wavelength);
    b->incident = w->structure == FF_WINDOW_ROWS ? w->row : w->column;
    b->exit = w->structure == FF_WINDOW_ROWS ? w->column : w->row;
    const ff_status status = check_bases(w, b);
    if (status != FF_OK) return status;
    b->data = (ff_scattering){.path = w->xml.path, .err = w->xml.err, .buffer = w->buffer, .line = line_of_data, .user = &w->xml};
    b->data.mirrored = w->face == FF_WINDOW_FRONT;
    b->data.rank = w->structure == FF_WINDOW_TREE_3 ? 3 : w->structure == FF_WINDOW_TREE_4 ? 4 : 0;
    b->data.leaves.width = ff_rows_width(1, 0, 1);
    if (b->data.rank) return FF_OK;
    const size_t n_incident = w->bases[b->incident]->n, n_exit = w->bases[b->exit]->n;
    b->data.expected = (uint64_t)n_incident * n_exit;
    snprintf(b->data.what, sizeof b->data.what, "%zu x %zu (one per pair of patches)", n_incident, n_exit);
    return FF_OK;
}

static ff_status start_scattering(ff_window_file *w)
{
    if (w->structure == FF_WINDOW_NO_STRUCTURE)
        return ff_window_fails(w, FF_ERR_FORMAT,
                               "found ScatteringData before IncidentDataStructure, expected it in DataDefinition before the data");
    if (w->face == FF_WINDOW_NO_FACE || w->wavelength[0] == '\0')
        return ff_window_fails(w, FF_ERR_FORMAT, "found ScatteringData before %s, expected it behind",
                               w->face == FF_WINDOW_NO_FACE ? "WavelengthDataDirection" : "Wavelength");
    if (w->has_data)
        return ff_window_fails(w, FF_ERR_FORMAT, "found a second ScatteringData in one WavelengthDataBlock, expected one");
    w->has_data = 1;
    note_seen(w);
    if (!is_wanted(w)) return FF_OK;
    for (size_t k = 0; k < w->n_blocks; k++)
        if (w->blocks[k].face == w->face && strcasecmp(w->blocks[k].name, w->wavelength) == 0)
            return ff_window_fails(w, FF_ERR_FORMAT, "found %s of '%s' twice, expected it once", ff_window_face_name[w->face],
                                   w->wavelength);
    if (w->n_blocks == BLOCKS_MAX)
        return ff_window_fails(w, FF_ERR_FORMAT, "found more than %d wavelengths, expected fewer", BLOCKS_MAX);
    ff_window_block *larger = realloc(w->blocks, (w->n_blocks + 1) * sizeof *larger);
    if (!larger) return ff_window_fails(w, FF_ERR_MEMORY, "no memory for another block");
    w->blocks = larger;
    const ff_status status = open_data(w, &w->blocks[w->n_blocks]);
    if (status != FF_OK) return status;
    w->n_blocks++;
    w->reading = 1;
    return FF_OK;
}

static ff_status end_scattering(ff_window_file *w)
{
    if (!w->reading) return FF_OK;
    w->reading = 0;
    return ff_scattering_end(&w->blocks[w->n_blocks - 1].data);
}

/* ---- elements with text ---------------------------------------------------------------------- */

/* Drops blanks at both ends, makes those within one space. */
static void tidy(ff_window_file *w)
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

static ff_status read_structure(ff_window_file *w)
{
    static const char *const known[] = {NULL, "Columns", "Rows", "TensorTree3", "TensorTree4"};
    char found[FF_QUOTE];
    for (int k = FF_WINDOW_COLUMNS; k <= FF_WINDOW_TREE_4; k++) {
        if (strcasecmp(w->text, known[k]) != 0) continue;
        if (w->structure != FF_WINDOW_NO_STRUCTURE && w->structure != k)
            return ff_window_fails(w, FF_ERR_FORMAT, "found IncidentDataStructure %s and %s, expected one", known[w->structure],
                                   known[k]);
        w->structure = k;
        return FF_OK;
    }
    return ff_window_fails(w, FF_ERR_UNSUPPORTED,
                           "IncidentDataStructure: found %s, expected Columns, Rows, TensorTree3 or TensorTree4",
                           ff_window_quoted(w->text, found));
}

static ff_status read_direction(ff_window_file *w)
{
    char found[FF_QUOTE];
    for (int k = 0; k < FF_WINDOW_FACES; k++)
        if (strcasecmp(w->text, ff_window_face_name[k]) == 0) w->face = k;
    if (strncasecmp(w->text, "Transmission", 12) == 0) w->face = FF_WINDOW_TRANSMISSION;
    if (w->face != FF_WINDOW_NO_FACE) return FF_OK;
    return ff_window_fails(w, FF_ERR_FORMAT,
                           "WavelengthDataDirection: found %s, expected Reflection or Transmission, Front or Back",
                           ff_window_quoted(w->text, found));
}

static ff_status read_name(ff_window_file *w, const char *what, char *out, size_t size)
{
    char found[FF_QUOTE];
    int plain = w->n_text > 0 && w->n_text < size;
    for (size_t i = 0; i < w->n_text; i++) plain &= (unsigned char)w->text[i] >= 0x20 && w->text[i] != 0x7F;
    if (!plain)
        return ff_window_fails(w, FF_ERR_FORMAT, "%s: found %s, expected a name of 1 to %zu bytes", what,
                               ff_window_quoted(w->text, found), size - 1);
    strcpy(out, w->text);
    return FF_OK;
}

/* A name, or a number of the element's unit: "550nm". */
static ff_status read_wavelength(ff_window_file *w)
{
    const ff_status status = read_name(w, "Wavelength", w->wavelength, FF_CHANNEL_NAME);
    if (status != FF_OK || isnan(w->per_nm)) return status;
    double number;
    const char *end = ff_number_read(w->wavelength, &number);
    if (end && *end == '\0' && number > 0 && isfinite(number * w->per_nm))
        snprintf(w->wavelength, FF_CHANNEL_NAME, "%.6gnm", number * w->per_nm);
    return FF_OK;
}

static ff_status read_tree_basis(ff_window_file *w)
{
    char found[FF_QUOTE];
    if (w->structure < FF_WINDOW_TREE_3) return FF_OK;
    w->tree_basis = strcasecmp(w->text, "LBNL/Shirley-Chiu") == 0;
    if (w->tree_basis) return FF_OK;
    return ff_window_fails(w, FF_ERR_UNSUPPORTED, "AngleBasis: found %s, expected LBNL/Shirley-Chiu",
                           ff_window_quoted(w->text, found));
}

static ff_status end_text(ff_window_file *w, unsigned char element)
{
    tidy(w);
    switch (element) {
    case STRUCTURE:
        return read_structure(w);
    case BASIS_NAME:
        return read_name(w, "AngleBasisName", ff_window_last_basis(w)->name, FF_WINDOW_NAME);
    case THETA:
        return ff_window_read_angle(w, "Theta", &w->ring.theta);
    case LOWER:
        return ff_window_read_angle(w, "LowerTheta", &w->ring.lower);
    case UPPER:
        return ff_window_read_angle(w, "UpperTheta", &w->ring.upper);
    case N_PHIS:
        return ff_window_read_n_phis(w);
    case WAVELENGTH:
        return read_wavelength(w);
    case DIRECTION:
        return read_direction(w);
    case COLUMN_BASIS:
        return ff_window_use_basis(w, &w->column);
    case ROW_BASIS:
        return ff_window_use_basis(w, &w->row);
    case TREE_BASIS:
        return read_tree_basis(w);
    default:
        return FF_OK;
    }
}

/* ---- what the XML calls ---------------------------------------------------------------------- */

static void set_unit(ff_window_file *w, const char *const *attributes)
{
    const char *unit = ff_xml_attribute(attributes, "unit");
    w->per_nm = NAN;
    if (unit && (strncasecmp(unit, "nano", 4) == 0 || strcasecmp(unit, "nm") == 0)) w->per_nm = 1;
    if (unit && (strncasecmp(unit, "micro", 5) == 0 || strcasecmp(unit, "um") == 0)) w->per_nm = 1000;
}

static ff_status on_start(void *user, const char *name, const char *const *attributes)
{
    ff_window_file *w = user;
    char found[FF_QUOTE];
    const unsigned depth = w->xml.depth;
    const unsigned char element = element_of(name, w->stack[depth - 1]);
    if (depth == 1 && element != WINDOW)
        return ff_window_fails(w, FF_ERR_FORMAT, "found the element %s, expected WindowElement", ff_window_quoted(name, found));
    w->stack[depth] = element;
    ff_xml_want_text(&w->xml, has_text(element));
    if (has_text(element)) w->n_text = 0;
    switch (element) {
    case BASIS:
        return ff_window_new_basis(w);
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
        w->face = FF_WINDOW_NO_FACE;
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
    ff_window_file *w = user;
    const unsigned depth = w->xml.depth; /* of the parent */
    const unsigned char element = w->stack[depth + 1];
    ff_xml_want_text(&w->xml, w->stack[depth] == SCATTERING ? w->reading : has_text(w->stack[depth]));
    if (has_text(element)) return end_text(w, element);
    if (element == BASIS) return ff_window_end_basis(w);
    if (element == BASIS_BLOCK) return ff_window_end_basis_block(w);
    if (element == SCATTERING) return end_scattering(w);
    if (element == BLOCK && !w->has_data)
        return ff_window_fails(w, FF_ERR_FORMAT, "found a WavelengthDataBlock without ScatteringData, expected its numbers");
    return FF_OK;
}

static ff_status on_text(void *user, const char *text, size_t n)
{
    ff_window_file *w = user;
    if (w->reading) return ff_scattering_text(&w->blocks[w->n_blocks - 1].data, text, n);
    if (w->n_text + n >= FF_WINDOW_TEXT)
        return ff_window_fails(w, FF_ERR_FORMAT, "found a text of more than %d bytes, expected a name or a number",
                               FF_WINDOW_TEXT - 1);
    memcpy(w->text + w->n_text, text, n);
    w->n_text += n;
    return FF_OK;
}

/* ---- the format ------------------------------------------------------------------------------ */

/* "reflection-front", "reflection-back", either with ":all" or ":NAME" of a wavelength. */
static ff_status read_part(ff_window_file *w, const char *part)
{
    char found[FF_QUOTE];
    w->part = FF_WINDOW_NO_FACE;
    w->wanted = FF_WINDOW_VISIBLE_OR_ALL;
    if (!part) return FF_OK;
    const size_t n = strcspn(part, ":");
    for (int k = 0; k < FF_WINDOW_FACES; k++)
        if (n == strlen(ff_window_part_name[k]) && strncasecmp(part, ff_window_part_name[k], n) == 0) w->part = k;
    const char *name = part[n] == ':' ? part + n + 1 : NULL;
    if (w->part == FF_WINDOW_NO_FACE || (name && (name[0] == '\0' || strlen(name) >= sizeof w->asked)))
        return ff_window_fails(
            w, FF_ERR_UNSUPPORTED,
            "found the part %s, expected reflection-front or reflection-back, or one of them with :all or the name of a "
            "wavelength, as in reflection-front:Solar",
            ff_window_quoted(part, found));
    if (name) {
        w->wanted = strcasecmp(name, "all") == 0 ? FF_WINDOW_ALL : FF_WINDOW_NAMED;
        strcpy(w->asked, name);
    }
    return FF_OK;
}

static ff_status read_window(const char *path, const ff_read_options *o, ff_table *out, ff_error *err)
{
    static const ff_xml_calls calls = {on_start, on_end, on_text};
    ff_window_file *w = calloc(1, sizeof *w);
    if (!w) return ff_error_set(err, FF_ERR_MEMORY, path, 0, -1, "no memory for a reader");
    w->xml = (ff_xml){.path = path, .err = err, .calls = &calls, .user = w};
    w->stack[0] = DOCUMENT;
    ff_status status = read_part(w, o->part);
    if (status == FF_OK) status = ff_xml_read(&w->xml);
    if (status == FF_OK) status = ff_window_to_table(w, out);
    while (w->n_blocks > 0) ff_window_drop_block(w, w->n_blocks - 1);
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
    static const char interrupted[] = "Recover using:"; /* see ff_xml_read */
    const unsigned char *line_end =
        n > sizeof interrupted && memcmp(head, interrupted, sizeof interrupted - 1) == 0 ? memchr(head, '\n', n) : NULL;
    if (line_end) at = (size_t)(line_end + 1 - head);
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
    .holds = FF_HOLDS_NEGATIVE | FF_HOLDS_NAMES | FF_HOLDS_MANY,
    .precision = "means over patches",
    .read = read_window,
    .layout = ff_window_layout,
    .write = ff_window_write,
};
