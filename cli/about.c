/* What this program is made of and runs on: --version --verbose. */
#define _GNU_SOURCE
#include "internal_flags.h"
#include "ff_isa.h"
#include "fit/linalg/internal_linalg.h"
#include "fit/minimise/ceres_bridge.h"
#include "simulate/surface/rays_bridge.h"
#include <OpenEXRConfig.h>
#include <expat.h>
#include <string.h>
#include <unistd.h>
#include <zlib.h>
#ifdef FF_HAVE_IMAGES
#include "data_formats/formats/images/oiio_bridge.h"
#endif

static void put_sets(FILE *out)
{
    fprintf(out, "instruction set  %s, of", ff_isa_name(FF_ISA_BEST));
    for (int k = FF_ISA_SCALAR; k <= FF_ISA_AVX512; k++)
        if (ff_isa_available((ff_isa)k)) fprintf(out, " %s", ff_isa_name((ff_isa)k));
    fputc('\n', out);
}

/* Modules are opened when they are needed: here they are. */
static void put_modules(FILE *out)
{
#ifdef FF_HAVE_IMAGES
    const ff_image_reader *reader;
    ff_error err = {0};
    if (ff_image_reader_get(&reader, &err) == FF_OK)
        fputs("module images    there: image stacks, pictures of environments\n", out);
    else
        fprintf(out, "module images    not there: %s\n", err.message);
#else
    fputs("module images    left out of this build: libopenimageio-dev was not there\n", out);
#endif
    const ff_rays *rays;
    ff_error why = {0};
    if (ff_rays_get(&rays, &why) == FF_OK)
        fputs("module rays      there: light on surfaces whose heights are known\n", out);
    else
        fprintf(out, "module rays      not there: %s\n", why.message);
}

void cli_about(FILE *out)
{
    char eigen[32];
    fprintf(out, "compiler         %s\n", __VERSION__);
    fprintf(out, "Ceres Solver     %s\n", ff_ceres_version());
    fprintf(out, "Eigen            %s\n", ff_eigen_version(eigen, sizeof eigen));
    fprintf(out, "OpenEXR          %s\n", OPENEXR_VERSION_STRING);
    fprintf(out, "expat            %s\n", XML_ExpatVersion() + (strncmp(XML_ExpatVersion(), "expat_", 6) ? 0 : 6));
    fprintf(out, "zlib             %s\n", zlibVersion());
    put_sets(out);
    fprintf(out, "processors       %ld\n", sysconf(_SC_NPROCESSORS_ONLN));
    put_modules(out);
}
