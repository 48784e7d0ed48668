/* A composed model as a plain value: what ff_composition.h closes to others. Its members may be read by anyone and are changed by
 * the functions of ff_model.h alone. */
#ifndef FF_COMPOSITION_STRUCT_H
#define FF_COMPOSITION_STRUCT_H
#include "ff_composition.h"

enum { FF_MAX_LOBES = 3, FF_MAX_BASES = 2, FF_MAX_SHAPE = 32, FF_MAX_CHANNEL_PARAMS = 16 };
#define FF_FRESNEL_SHARED (-1) /* of a second or third lobe: the Fresnel term of the first one, parameters and all */

/* One specular lobe ks D F G / (4 iz oz): indices into the registry. */
typedef struct ff_lobe {
    int ndf, masking, fresnel;            /* fresnel may be FF_FRESNEL_SHARED                        */
    int isotropic;                        /* 1: one `alpha` (or the distribution's own width) instead of a stretch  */
    uint32_t shape0, n_shape;             /* its slice of the model's shape parameters              */
    uint32_t channel0, n_channel;         /* its slice of the per-channel parameters                */
    const struct ff_profile_table *table; /* of `tabulated`, borrowed (see ff_profile.h); else NULL */
} ff_lobe;

/* A term under the lobes: diffuse reflection, or what the lobes scatter more than once. */
typedef struct ff_base {
    int diffuse; /* index into the registry of FF_DIFFUSE */
    uint32_t shape0, n_shape, channel0, n_channel;
} ff_base;

/* A plain value: copy it freely. */
struct ff_model {
    uint32_t n_lobes, n_bases;
    ff_lobe lobe[FF_MAX_LOBES];
    ff_base base[FF_MAX_BASES];
    uint32_t n_shape, n_channel;
    ff_model_param shape[FF_MAX_SHAPE];
    ff_model_param channel[FF_MAX_CHANNEL_PARAMS];
};
#endif
