/** @file internal_json.h  Reading JSON (RFC 8259): a whole document, checked to its last byte, as a tree to be looked at.
 *
 *      ff_json_tree *tree;
 *      if ((status = ff_json_read("fit.json", &tree, err)) != FF_OK) return status;
 *      const ff_json_node *fits = ff_json_member(ff_json_root(tree), "fits");
 *      for (const ff_json_node *fit = ff_json_first(fits); fit; fit = ff_json_next(fit)) ...
 *      ff_json_free(tree);
 *
 *  Strict   no comments, no commas at ends, no NaN, nothing behind the value; text is UTF-8 without NUL. Of members of one name the
 *           first is found.
 *  Bounds   FF_JSON_BYTES and FF_JSON_NESTING; memory is at most some 30 bytes for a byte of the document.
 *  Looking  every function takes NULL and a node of another kind, and has then nothing to give: a reader checks what it needs,
 * once. Memory   nodes and texts belong to the tree. Threads  a tree may be read from many threads at once. */
#ifndef FF_INTERNAL_JSON_H
#define FF_INTERNAL_JSON_H
#include "ff_status.h"
#include <stddef.h>

enum { FF_JSON_BYTES = 1 << 26, FF_JSON_NESTING = 64 };

typedef enum ff_json_kind {
    FF_JSON_NULL,
    FF_JSON_FALSE,
    FF_JSON_TRUE,
    FF_JSON_NUMBER,
    FF_JSON_TEXT,
    FF_JSON_ARRAY,
    FF_JSON_OBJECT
} ff_json_kind;

typedef struct ff_json_node ff_json_node;
typedef struct ff_json_tree ff_json_tree;

/** Reads the file ("-": standard input). FF_ERR_FORMAT with the line, and what ff_input_open and ff_input_read say; FF_ERR_MEMORY.
 *  *out is written only on FF_OK. */
ff_status ff_json_read(const char *path, ff_json_tree **out, ff_error *err);
/** The same of text [n] in memory, which is copied; path is for messages, NULL allowed. */
ff_status ff_json_parse(const char *text, size_t n, const char *path, ff_json_tree **out, ff_error *err);
void ff_json_free(ff_json_tree *tree); /**< NULL is allowed */

const ff_json_node *ff_json_root(const ff_json_tree *tree);
ff_json_kind ff_json_kind_of(const ff_json_node *node); /**< FF_JSON_NULL of NULL */

/** The value of a member; NULL when there is none. */
const ff_json_node *ff_json_member(const ff_json_node *object, const char *name);
/** The values in an array or object, one after another; NULL after the last. */
const ff_json_node *ff_json_first(const ff_json_node *node);
const ff_json_node *ff_json_next(const ff_json_node *node);
size_t ff_json_count(const ff_json_node *node);     /**< of them                                       */
const char *ff_json_name(const ff_json_node *node); /**< of a member; NULL of what stands in an array   */
const char *ff_json_text(const ff_json_node *node); /**< NULL when it is no text                        */
double ff_json_real(const ff_json_node *node);      /**< NaN when it is no number, also where it is null */
int ff_json_is_true(const ff_json_node *node);

#endif
