#include "ff_report.h"
#include "internal_text.h"

_Static_assert((int)FF_REPORT_NUMBER == (int)FF_TEXT_NUMBER, "one size of number text");

void ff_report_head_json(ff_json *j, ff_schema schema, const ff_report_head *head)
{
    ff_json_string(j, "schema", ff_schema_name(schema));
    ff_json_string(j, "version", head->version);
    ff_json_array(j, "command", FF_JSON_LINE);
    for (size_t i = 0; i < head->n_command; i++) ff_json_string(j, NULL, head->command[i]);
    ff_json_close(j);
}

const char *ff_report_number(double x, char *out)
{
    return ff_text_exact(x, out);
}
