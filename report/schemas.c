/* The JSON Schema of every document, to be had without the files of an installation. */
#include "ff_report.h"

/* NAME_<ID>, TEXT_<ID>: name and bytes of docs/schema/<id>.schema.json, put there by cmake/embed_schemas.cmake when they change. */
#include <embedded_schemas.inc>

static const struct {
    const char *name;
    const unsigned char *text;
    size_t size;
} schemas[FF_SCHEMA_COUNT] = {
#define FF_SCHEMA(ID) [FF_SCHEMA_##ID] = {NAME_##ID, TEXT_##ID, sizeof TEXT_##ID},
#include "ff_schemas.def"
#undef FF_SCHEMA
};

const char *ff_schema_name(ff_schema schema)
{
    return (unsigned)schema < FF_SCHEMA_COUNT ? schemas[schema].name : NULL;
}

ff_status ff_report_schema_json(ff_schema schema, FILE *out)
{
    if (!ff_schema_name(schema)) return FF_ERR_RANGE;
    fwrite(schemas[schema].text, 1, schemas[schema].size, out);
    return FF_OK;
}
