/* pbrt-v4: a scene of a sphere under one distant light. */
#include "internal_files.h"
#include <string.h>

static void put_rgb(const ff_scene *s, const char *name, FILE *out)
{
    fprintf(out, "    \"rgb %s\" [ ", name);
    ff_scene_color(s, name, " ", out);
    fputs(" ]\n", out);
}

static void put_float(const ff_scene *s, const char *name, FILE *out)
{
    fprintf(out, "    \"float %s\" [ ", name);
    ff_scene_put(s, name, 0, out);
    fputs(" ]\n", out);
}

static ff_status write_pbrt(const ff_scene *s, FILE *out)
{
    char text[FF_NUMBER_TEXT + 1];
    const double turned = ff_scene_control(s, "rotation", 0, 0);
    fprintf(out, "# %s, %s: written by facetfit %s\n", s->target->title, s->material->title, s->version);
    fputs("LookAt 0 0 5  0 0 0  0 1 0\nCamera \"orthographic\" \"float screenwindow\" [ -1.1 1.1 -1.1 1.1 ]\n"
          "Film \"rgb\" \"integer xresolution\" [ 256 ] \"integer yresolution\" [ 256 ] \"string filename\" [ \"facetfit.exr\" ]\n"
          "WorldBegin\nLightSource \"distant\" \"point3 from\" [ 1 1 2 ] \"point3 to\" [ 0 0 0 ] \"rgb L\" [ 1 1 1 ]\n",
          out);
    if (turned > 0)
        fprintf(out, "# the larger roughness lies %s degrees from dp/du: turn the uv of a mesh by as much\n",
                ff_scene_number(turned, text));
    if (!strcmp(s->material->name, "conductor")) {
        fputs("Material \"conductor\"\n", out);
        put_rgb(s, "eta", out);
        put_rgb(s, "k", out);
        put_float(s, "uroughness", out);
        put_float(s, "vroughness", out);
    } else {
        fputs("Material \"coateddiffuse\"\n", out);
        put_rgb(s, "reflectance", out);
        put_float(s, "roughness", out);
        put_float(s, "eta", out);
    }
    fputs("    \"bool remaproughness\" [ false ]\nShape \"sphere\"\n", out);
    return FF_OK;
}

static const char *const targets[] = {"pbrt", NULL};

const ff_scene_file ff_scene_file_pbrt = {
    .name = "pbrt", .extension = ".pbrt", .title = "a scene of pbrt-v4", .targets = targets, .write = write_pbrt};
