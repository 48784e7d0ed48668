/* XML as it streams. Entities are refused where they are declared, so that none is ever expanded. */
#define _GNU_SOURCE
#include "internal_xml.h"
#include "internal_input.h"
#include <expat.h>
#include <string.h>
#include <unistd.h>

enum { CHUNK = 1 << 16 };

long ff_xml_line(const ff_xml *x)
{
    return (long)XML_GetCurrentLineNumber(x->parser) + x->lines_before;
}

/* Ends the reading. */
static void stop(ff_xml *x, ff_status status)
{
    if (status == FF_OK || x->status != FF_OK) return;
    x->status = status;
    XML_StopParser(x->parser, XML_FALSE);
}

static const char *without_prefix(const char *name)
{
    const char *colon = strrchr(name, ':');
    return colon ? colon + 1 : name;
}

/* ---- what expat calls ------------------------------------------------------------------------ */

static void XMLCALL on_start(void *user, const XML_Char *name, const XML_Char **attributes)
{
    ff_xml *x = user;
    if (x->status != FF_OK) return;
    if (++x->depth > FF_XML_DEPTH) {
        stop(x, ff_error_set(x->err, FF_ERR_FORMAT, x->path, ff_xml_line(x), -1,
                             "found elements nested deeper than %d, expected those of a measurement", FF_XML_DEPTH));
        return;
    }
    stop(x, x->calls->start(x->user, without_prefix(name), (const char *const *)attributes));
}

static void XMLCALL on_end(void *user, const XML_Char *name)
{
    ff_xml *x = user;
    (void)name;
    if (x->status != FF_OK) return;
    x->depth--;
    stop(x, x->calls->end(x->user));
}

static void XMLCALL on_text(void *user, const XML_Char *text, int n)
{
    ff_xml *x = user;
    if (x->status == FF_OK) stop(x, x->calls->text(x->user, text, (size_t)n));
}

static void XMLCALL on_entity(void *user, const XML_Char *name, int is_parameter, const XML_Char *value, int n,
                              const XML_Char *base, const XML_Char *system, const XML_Char *public, const XML_Char *notation)
{
    ff_xml *x = user;
    char found[FF_QUOTE];
    (void)is_parameter, (void)value, (void)n, (void)base, (void)system, (void)public, (void)notation;
    if (x->status == FF_OK)
        stop(x, ff_error_set(x->err, FF_ERR_FORMAT, x->path, ff_xml_line(x), -1,
                             "found a declaration of the entity %s, which is refused; expected a file without entities of its own",
                             ff_quote(name, strlen(name), found)));
}

static void refuse_external(ff_xml *x)
{
    if (x->status == FF_OK)
        stop(x, ff_error_set(x->err, FF_ERR_FORMAT, x->path, ff_xml_line(x), -1,
                             "found a reference to another document, which is refused; expected a file that stands alone"));
}

static void XMLCALL on_doctype(void *user, const XML_Char *name, const XML_Char *system, const XML_Char *public, int has_internal)
{
    (void)name, (void)has_internal;
    if (system || public) refuse_external(user);
}

static int XMLCALL on_external(XML_Parser parser, const XML_Char *context, const XML_Char *base, const XML_Char *system,
                               const XML_Char *public)
{
    (void)context, (void)base, (void)system, (void)public;
    refuse_external(XML_GetUserData(parser));
    return XML_STATUS_ERROR;
}

static void set_handlers(ff_xml *x)
{
    XML_SetUserData(x->parser, x);
    XML_SetElementHandler(x->parser, on_start, on_end);
    XML_SetEntityDeclHandler(x->parser, on_entity);
    XML_SetStartDoctypeDeclHandler(x->parser, on_doctype);
    XML_SetExternalEntityRefHandler(x->parser, on_external);
    XML_SetParamEntityParsing(x->parser, XML_PARAM_ENTITY_PARSING_NEVER);
}

void ff_xml_want_text(ff_xml *x, int wanted)
{
    XML_SetCharacterDataHandler(x->parser, wanted ? on_text : NULL);
}

const char *ff_xml_attribute(const char *const *attributes, const char *name)
{
    for (; *attributes; attributes += 2)
        if (strcmp(without_prefix(attributes[0]), name) == 0) return attributes[1];
    return NULL;
}

/* ---- feeding --------------------------------------------------------------------------------- */

static ff_status not_xml(ff_xml *x)
{
    if (x->status != FF_OK) return x->status; /* a callback said why */
    const enum XML_Error reason = XML_GetErrorCode(x->parser);
    if (reason == XML_ERROR_NO_MEMORY)
        return ff_error_set(x->err, FF_ERR_MEMORY, x->path, ff_xml_line(x), -1, "no memory for the XML");
    const int ended = reason == XML_ERROR_NO_ELEMENTS || reason == XML_ERROR_UNCLOSED_TOKEN || reason == XML_ERROR_PARTIAL_CHAR ||
                      reason == XML_ERROR_UNCLOSED_CDATA_SECTION;
    return ff_error_set(x->err, ended ? FF_ERR_READ : FF_ERR_FORMAT, x->path, ff_xml_line(x), -1,
                        "found %s%s, expected XML to its end", ended ? "the end of the file: " : "", XML_ErrorString(reason));
}

/* What expat cannot finish it keeps, and reads again with every chunk. */
static ff_status check_token(ff_xml *x, int64_t fed)
{
    const int64_t begin = XML_GetCurrentByteIndex(x->parser);
    if (begin < 0 || fed - begin <= FF_XML_TOKEN) return FF_OK;
    return ff_error_set(x->err, FF_ERR_FORMAT, x->path, ff_xml_line(x), -1,
                        "found a tag or comment of more than %d bytes, expected less", FF_XML_TOKEN);
}

/* Bytes of the line that genBSDF may write before the XML, on how to take it up again; Radiance's own reader passes over it, too.
 */
static size_t line_before(const char *text, size_t n)
{
    static const char begin[] = "Recover using:";
    if (n < sizeof begin || memcmp(text, begin, sizeof begin - 1) != 0) return 0;
    const char *end = memchr(text, '\n', n);
    return end ? (size_t)(end + 1 - text) : 0;
}

static ff_status feed(ff_xml *x, int fd)
{
    for (int64_t fed = 0;;) {
        size_t got = 0;
        void *buffer = XML_GetBuffer(x->parser, CHUNK);
        if (!buffer) return not_xml(x);
        ff_status status = ff_input_read(fd, x->path, fed, buffer, CHUNK, &got, x->err);
        if (status != FF_OK) return status;
        const size_t before = fed == 0 ? line_before(buffer, got) : 0;
        memmove(buffer, (char *)buffer + before, got - before);
        x->lines_before += before > 0;
        fed += (int64_t)got;
        if (XML_ParseBuffer(x->parser, (int)(got - before), got < CHUNK) != XML_STATUS_OK) return not_xml(x);
        if (got < CHUNK) return FF_OK;
        status = check_token(x, fed);
        if (status != FF_OK) return status;
    }
}

ff_status ff_xml_read(ff_xml *x)
{
    int fd;
    ff_status status = ff_input_open(x->path, &fd, &x->size, x->err);
    if (status != FF_OK) return status;
    x->parser = XML_ParserCreate(NULL);
    if (x->parser) {
        set_handlers(x);
        status = feed(x, fd);
        XML_ParserFree(x->parser);
        x->parser = NULL;
    } else {
        status = ff_error_set(x->err, FF_ERR_MEMORY, x->path, 0, -1, "no memory for a reader of XML");
    }
    close(fd);
    return status;
}
