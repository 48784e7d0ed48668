/* The registry of warnings, and lists of them. */
#include "internal_warning.h"
#include <stdlib.h>
#include <string.h>

static const ff_warning_kind kinds[FF_WARNING_COUNT] = {
#define FF_WARNING(id, name, severity, meaning, ...) {name, FF_SEVERITY_##severity, meaning, {__VA_ARGS__}},
#include "ff_warnings.def"
#undef FF_WARNING
};

const ff_warning_kind *ff_warning_kind_of(int code)
{
    return code >= 0 && code < FF_WARNING_COUNT ? &kinds[code] : NULL;
}

int ff_warning_find(const char *name)
{
    for (int code = 0; code < FF_WARNING_COUNT; code++)
        if (!strcmp(name, kinds[code].name)) return code;
    return -1;
}

const char *ff_severity_name(int severity)
{
    static const char *const name[FF_SEVERITY_COUNT] = {"note", "warning", "problem"};
    return severity >= 0 && severity < FF_SEVERITY_COUNT ? name[severity] : NULL;
}

/* ---- lists ----------------------------------------------------------------------------------- */

/* n items of some size; NULL also where there is nothing to copy. */
static void *copy_of(const void *items, size_t n, size_t size)
{
    void *copy = n ? malloc(n * size) : NULL;
    if (copy) memcpy(copy, items, n * size);
    return copy;
}

static void release(ff_warning *w)
{
    free((void *)w->parameter);
    free((void *)w->channel);
}

/* Room for one more: the capacity is the next power of two. */
static ff_status grow(ff_warnings *list)
{
    if (list->n & (list->n - 1)) return FF_OK;
    ff_warning *item = realloc(list->item, (list->n ? 2 * list->n : 1) * sizeof *item);
    if (!item) return FF_ERR_MEMORY;
    list->item = item;
    return FF_OK;
}

ff_status ff_warnings_add(ff_warnings *list, const ff_warning *w)
{
    ff_warning made = *w;
    made.severity = kinds[w->code].severity;
    made.parameter = copy_of(w->parameter, w->n_parameters, sizeof *w->parameter);
    made.channel = copy_of(w->channel, w->n_channels, sizeof *w->channel);
    if ((w->n_parameters && !made.parameter) || (w->n_channels && !made.channel) || grow(list)) {
        release(&made);
        return FF_ERR_MEMORY;
    }
    list->item[list->n++] = made;
    return FF_OK;
}

ff_status ff_warnings_say(ff_warnings *list, ff_warning_code code, const double *value)
{
    ff_warning w = {.code = code};
    for (size_t k = 0; k < FF_WARNING_VALUES && kinds[code].value[k]; k++) w.value[k] = value[k];
    return ff_warnings_add(list, &w);
}

void ff_warnings_clear(ff_warnings *list)
{
    for (size_t k = 0; k < list->n; k++) release(&list->item[k]);
    free(list->item);
    *list = (ff_warnings){0, NULL};
}
