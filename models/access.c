/* Models for programs that do not see inside: on the heap, read by functions. */
#include "model_struct.h"
#include <stdlib.h>

static ff_status new_like(const ff_model *m, ff_model **out, ff_error *err)
{
    ff_model *made = malloc(sizeof *made);
    if (!made) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    *made = *m;
    *out = made;
    return FF_OK;
}

ff_status ff_model_new(const char *expr, ff_model **out, ff_error *err)
{
    ff_model m;
    const ff_status status = ff_model_parse(expr, &m, err);
    return status ? status : new_like(&m, out, err);
}

ff_status ff_model_copy(const ff_model *m, ff_model **out, ff_error *err)
{
    return new_like(m, out, err);
}

void ff_model_free(ff_model *m)
{
    free(m);
}

uint32_t ff_model_lobe_count(const ff_model *m)
{
    return m->n_lobes;
}

size_t ff_model_param_count(const ff_model *m, ff_param_kind kind)
{
    return kind == FF_PARAM_SHAPE ? m->n_shape : kind == FF_PARAM_CHANNEL ? m->n_channel : 0;
}
