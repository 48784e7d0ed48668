/* Formats and files for programs that do not see inside. */
#include "base/internal_options.h"
#include "data_formats/table/table_struct.h"

const char *ff_format_name(const ff_format *f)
{
    return f->name;
}

const char *ff_format_title(const ff_format *f)
{
    return f->title;
}

const char *ff_format_extensions(const ff_format *f)
{
    return f->extensions;
}

const char *ff_format_source(const ff_format *f)
{
    return f->source;
}

unsigned ff_format_reads(const ff_format *f)
{
    return f->reads;
}

unsigned ff_format_holds(const ff_format *f)
{
    return f->write ? f->holds : 0;
}

const char *ff_format_precision(const ff_format *f)
{
    return f->precision;
}

int ff_format_can_write(const ff_format *f)
{
    return f->write != NULL;
}

ff_status ff_table_read(const char *path, const char *format, ff_table **out, ff_error *err)
{
    ff_table t;
    const ff_status status = ff_table_read_into(path, format, &t, err);
    return status ? status : ff_table_move(&t, out, err);
}

ff_status ff_table_read_with(const char *path, const ff_read_options *o, ff_table **out, ff_error *err)
{
    ff_read_options own;
    ff_table t;
    ff_read_options_init(&own);
    ff_status status =
        o ? ff_options_take("ff_read_options", o, FF_END_OF(ff_read_options, ask_context), &own, sizeof own, err) : FF_OK;
    if (!status) status = ff_table_read_with_into(path, &own, &t, err);
    return status ? status : ff_table_move(&t, out, err);
}
