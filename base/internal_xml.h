/** @file internal_xml.h  XML as it streams, over expat: elements and text, and nothing that could reach out or blow up.
 *
 *  Refused at once: entity declarations, references to anything external, elements nested deeper than FF_XML_DEPTH, a tag or
 *  comment of more than FF_XML_TOKEN bytes. Nothing is ever fetched. */
#ifndef FF_INTERNAL_XML_H
#define FF_INTERNAL_XML_H
#include "ff_status.h"
#include <stddef.h>

enum { FF_XML_DEPTH = 64, FF_XML_TOKEN = 1 << 20 };

/** What a format does with a file's content. Names come without a namespace's prefix, text in UTF-8 and in pieces. A status other
 *  than FF_OK ends the reading, which then returns it; the callback has filled err. */
typedef struct ff_xml_calls {
    /** attributes: name, value, name, value ..., NULL */
    ff_status (*start)(void *user, const char *name, const char *const *attributes);
    ff_status (*end)(void *user);
    /** Called only while text is wanted. */
    ff_status (*text)(void *user, const char *text, size_t n);
} ff_xml_calls;

/** Reader of one file. Zero-initialise, set path, err, calls and user. */
typedef struct ff_xml {
    const char *path;
    ff_error *err;
    const ff_xml_calls *calls;
    void *user;
    void *parser;
    unsigned depth;
    long lines_before; /**< lines that were passed over before the XML    */
    int64_t size;      /**< of the file, -1 where it has none              */
    ff_status status;
} ff_xml;

/** Reads x->path to its end. FF_ERR_READ where the file ended early, FF_ERR_FORMAT where it is no XML or one of those refused. */
ff_status ff_xml_read(ff_xml *x);

/** From here on text is wanted (1) or skipped (0, as at the start). For callbacks. */
void ff_xml_want_text(ff_xml *x, int wanted);

/** Line of what the present callback is about. */
long ff_xml_line(const ff_xml *x);

/** The value of an attribute, NULL when there is none of that name. */
const char *ff_xml_attribute(const char *const *attributes, const char *name);
#endif
