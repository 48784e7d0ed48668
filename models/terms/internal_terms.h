/* Declarations of every descriptor in models.def for the instruction set this file is compiled for. */
#ifndef FF_INTERNAL_TERMS_H
#define FF_INTERNAL_TERMS_H
#include "internal_term.h"
#define FF_NDF_ENTRY(id)     extern const ff_ndf FF_ISA_NAME(ff_ndf_##id);
#define FF_MASKING_ENTRY(id) extern const ff_masking FF_ISA_NAME(ff_masking_##id);
#define FF_FRESNEL_ENTRY(id) extern const ff_fresnel FF_ISA_NAME(ff_fresnel_##id);
#define FF_DIFFUSE_ENTRY(id) extern const ff_diffuse FF_ISA_NAME(ff_diffuse_##id);
#include "models.def"
#endif
