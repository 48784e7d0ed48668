/* Models as plain values: what ff_model.h does for others behind a pointer. */
#ifndef FF_MODEL_STRUCT_H
#define FF_MODEL_STRUCT_H
#include "ff_model.h"
#include "models/kernels/composition_struct.h"
#ifdef __cplusplus
extern "C" {
#endif

/* ff_model_new into a model of the caller's. */
ff_status ff_model_parse(const char *expr, ff_model *out, ff_error *err);

/* Composes one lobe (indices into the registry) and a diffuse term (-1 = none). FF_ERR_RANGE for an index out of range,
 * FF_ERR_UNSUPPORTED as ff_model_parse. */
ff_status ff_model_compose(int ndf, int masking, int fresnel, int diffuse, ff_model *out, ff_error *err);

#ifdef __cplusplus
}
#endif
#endif
