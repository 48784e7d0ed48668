/* BibTeX of what the terms of models name as their sources. */
#include "internal_html.h"
#include "models/internal_model.h"
#include <string.h>

static const struct {
    const char *named, *entry;
} references[] = {
#define REFERENCE(named, entry) {named, entry},
#include "references.def"
#undef REFERENCE
};

enum { REFERENCES = sizeof references / sizeof *references };

static void look_at_source(const char *source, unsigned char used[REFERENCES])
{
    for (size_t k = 0; k < REFERENCES; k++)
        if (strstr(source, references[k].named)) used[k] = 1;
}

static void look_at_model(const ff_model *m, unsigned char used[REFERENCES])
{
    for (uint32_t l = 0; l < m->n_lobes; l++) {
        look_at_source(ff_ndf_at(m->lobe[l].ndf)->term.source, used);
        look_at_source(ff_masking_at(m->lobe[l].masking)->term.source, used);
        look_at_source(ff_fresnel_at(m->lobe[ff_model_group(m, l)].fresnel)->term.source, used);
    }
    for (uint32_t b = 0; b < m->n_bases; b++) look_at_source(ff_diffuse_at(m->base[b].diffuse)->term.source, used);
}

ff_status ff_html_references(const ff_html_subject *s, FILE *out)
{
    unsigned char used[REFERENCES] = {0};
    for (size_t k = 0; k < s->r->n_fits; k++) look_at_model(&s->r->fit[k].model, used);
    for (size_t k = 0; k < REFERENCES; k++)
        if (used[k]) fprintf(out, "%s\n\n", references[k].entry);
    return FF_OK;
}
