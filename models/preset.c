/* Models by the names that people know: expressions with parameters held at the values their sources have. */
#include "base/internal_name.h"
#include "internal_model.h"
#include <string.h>

static const ff_preset presets[] = {
    {.name = "torrance-sparrow",
     .title = "Gaussian facet angles in V-grooves, exact Fresnel, Lambert",
     .source = "Torrance and Sparrow 1967",
     .note = "D is normalised to unit area here, which their b absorbs",
     .expression = "gaussian/v-cavity/conductor+lambert"},
    {.name = "cook-torrance",
     .title = "Beckmann in V-grooves, exact Fresnel of a dielectric, Lambert",
     .source = "Cook and Torrance 1981; Mikkelsen 2009, section 4",
     .note = "their F D G / (pi iz oz) with D = exp(-tan^2 / m^2) / (m^2 cos^4) is four times F D G / (4 iz oz): ks is held at 4",
     .expression = "beckmann/v-cavity/dielectric+lambert",
     .hold = {"ks=4"}},
    {.name = "ngan-2005",
     .title = "Beckmann in V-grooves, Schlick, Lambert: the Cook-Torrance fits to the MERL materials",
     .source = "Ngan, Durand and Matusik 2005",
     .note = "their rho_s / pi D F G / (iz oz) with D = exp(-tan^2 / m^2) / (m^2 cos^4) is ks D F G / (4 iz oz) with ks = 4 rho_s, "
             "held at rho_s = 1 unless freed; alpha is their m, f0 their F0, kd their rho_d",
     .expression = "beckmann/v-cavity/schlick+lambert",
     .hold = {"ks=4"}},
    {.name = "walter-2007",
     .title = "GGX, separable Smith, exact Fresnel of a dielectric: the reflected part",
     .source = "Walter et al. 2007, eq. 20, 22, 33 and 34",
     .note = "no refraction; beckmann-walter and phong-walter are the other distributions of the source",
     .expression = "ggx/smith-separable/dielectric"},
    {.name = "kelemen-2001",
     .title = "Ward's distribution as a probability of half vectors, coupled matte part",
     .source = "Kelemen and Szirmay-Kalos 2001",
     .note = "keeps the normalisation of the source: integral P dh = 1",
     .expression = "kelemen-ward/kelemen/schlick+kelemen-matte"},
    {.name = "mikkelsen-2009",
     .title = "von Mises-Fisher facets in V-grooves, exact Fresnel, coupled diffuse part",
     .source = "Mikkelsen 2009, eq. 13, 25, 28 and 29",
     .note = "",
     .expression = "vmf/v-cavity/dielectric+mikkelsen-coupled"},
    {.name = "disney-2012",
     .title = "GTR of gamma = 2, Schlick, Disney's diffuse term of the same roughness",
     .source = "Burley 2012",
     .note = "gamma is held at 2 and may be freed; masking is Smith's for that roughness, without the source's remapping of it; no "
             "clear coat, sheen or subsurface part",
     .expression = "gtr/smith-separable/schlick+disney-coupled",
     .hold = {"gamma=2"}},
    {.name = "hammon-2017",
     .title = "GGX with the cheap height-correlated masking, and a diffuse term fitted to the same surface",
     .source = "Hammon 2017",
     .note = "",
     .expression = "ggx/hammon/schlick+hammon"},
};

size_t ff_preset_count(void)
{
    return sizeof presets / sizeof presets[0];
}

const ff_preset *ff_preset_at(size_t i)
{
    return i < ff_preset_count() ? &presets[i] : NULL;
}

const ff_preset *ff_preset_find(const char *name)
{
    for (size_t i = 0; i < ff_preset_count(); i++)
        if (ff_name_is(presets[i].name, name, strlen(name))) return &presets[i];
    return NULL;
}
