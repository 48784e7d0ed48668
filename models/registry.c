/* The registry as people see it: every term of models.def by kind, index and name. */
#define FF_ISA_SUFFIX scalar
#include "internal_model.h"
#include "base/internal_name.h"
#include "models/terms/internal_terms.h"
#include <string.h>

/* The descriptors' texts are the same for every instruction set; those of the baseline are shown. */
static const ff_term *const ndf_terms[] = {
#define FF_NDF_ENTRY(id) &FF_ISA_NAME(ff_ndf_##id).term,
#include "models/terms/models.def"
};
static const ff_term *const masking_terms[] = {
#define FF_MASKING_ENTRY(id) &FF_ISA_NAME(ff_masking_##id).term,
#include "models/terms/models.def"
};
static const ff_term *const fresnel_terms[] = {
#define FF_FRESNEL_ENTRY(id) &FF_ISA_NAME(ff_fresnel_##id).term,
#include "models/terms/models.def"
};
static const ff_term *const diffuse_terms[] = {
#define FF_DIFFUSE_ENTRY(id) &FF_ISA_NAME(ff_diffuse_##id).term,
#include "models/terms/models.def"
};

static const struct {
    const char *name;
    const ff_term *const *terms;
    size_t count;
} kinds[FF_TERM_KINDS] = {
    {"distribution", ndf_terms, sizeof ndf_terms / sizeof *ndf_terms},
    {"masking", masking_terms, sizeof masking_terms / sizeof *masking_terms},
    {"fresnel", fresnel_terms, sizeof fresnel_terms / sizeof *fresnel_terms},
    {"diffuse", diffuse_terms, sizeof diffuse_terms / sizeof *diffuse_terms},
};

size_t ff_term_count(ff_term_kind kind)
{
    return (unsigned)kind < FF_TERM_KINDS ? kinds[kind].count : 0;
}

const ff_term *ff_term_at(ff_term_kind kind, size_t i)
{
    return i < ff_term_count(kind) ? kinds[kind].terms[i] : NULL;
}

int ff_term_find(ff_term_kind kind, const char *name)
{
    const size_t n = strlen(name);
    for (size_t i = 0; i < ff_term_count(kind); i++)
        if (ff_name_is(kinds[kind].terms[i]->name, name, n)) return (int)i;
    for (size_t i = 0; i < ff_term_count(kind); i++)
        if (ff_name_is_one_of(kinds[kind].terms[i]->also, name, n)) return (int)i;
    return -1;
}

const char *ff_term_kind_name(ff_term_kind kind)
{
    return (unsigned)kind < FF_TERM_KINDS ? kinds[kind].name : "unknown";
}

const ff_ndf *ff_ndf_at(int ndf)
{
    return ff_kernels_get(FF_ISA_SCALAR)->ndf[ndf];
}

const ff_masking *ff_masking_at(int masking)
{
    return ff_kernels_get(FF_ISA_SCALAR)->masking[masking];
}

const ff_fresnel *ff_fresnel_at(int fresnel)
{
    return ff_kernels_get(FF_ISA_SCALAR)->fresnel[fresnel];
}

const ff_diffuse *ff_diffuse_at(int diffuse)
{
    return ff_kernels_get(FF_ISA_SCALAR)->diffuse[diffuse];
}
