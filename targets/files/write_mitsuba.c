/* Mitsuba 3: a scene of a sphere under one directional light. A rotation turns the sphere, whose tangents run along its meridians'
 * normal. */
#include "internal_files.h"
#include <string.h>

static void put_float(const ff_scene *s, const char *name, FILE *out)
{
    fprintf(out, "        <float name=\"%s\" value=\"", name);
    ff_scene_put(s, name, 0, out);
    fputs("\"/>\n", out);
}

static void put_rgb(const ff_scene *s, const char *name, FILE *out)
{
    fprintf(out, "        <rgb name=\"%s\" value=\"", name);
    ff_scene_color(s, name, ", ", out);
    fputs("\"/>\n", out);
}

static void put_conductor(const ff_scene *s, FILE *out)
{
    fprintf(out, "    <bsdf type=\"roughconductor\" id=\"facetfit\">\n        <string name=\"distribution\" value=\"%s\"/>\n",
            !strcmp(s->material->name, "conductor-beckmann") ? "beckmann" : "ggx");
    put_float(s, "alpha_u", out);
    put_float(s, "alpha_v", out);
    put_rgb(s, "eta", out);
    put_rgb(s, "k", out);
    fputs("    </bsdf>\n", out);
}

static void put_plastic(const ff_scene *s, FILE *out)
{
    fputs("    <bsdf type=\"roughplastic\" id=\"facetfit\">\n        <string name=\"distribution\" value=\"ggx\"/>\n", out);
    put_float(s, "alpha", out);
    put_float(s, "int_ior", out);
    fputs("        <float name=\"ext_ior\" value=\"1\"/>\n        <boolean name=\"nonlinear\" value=\"false\"/>\n", out);
    put_rgb(s, "diffuse_reflectance", out);
    fputs("    </bsdf>\n", out);
}

static void put_principled(const ff_scene *s, FILE *out)
{
    char text[FF_NUMBER_TEXT + 1];
    const double metal = ff_scene_setting(s, "metallic", 0);
    fputs("    <bsdf type=\"principled\" id=\"facetfit\">\n", out);
    put_rgb(s, "base_color", out);
    put_float(s, "roughness", out);
    fprintf(out, "        <float name=\"metallic\" value=\"%s\"/>\n", ff_scene_number(metal, text));
    if (metal < 1) put_float(s, "eta", out);
    if (ff_scene_control(s, "anisotropic", 0, 0) > 0) put_float(s, "anisotropic", out);
    fputs("    </bsdf>\n", out);
}

static ff_status write_mitsuba(const ff_scene *s, FILE *out)
{
    char text[FF_NUMBER_TEXT + 1];
    const char *name = s->material->name;
    const double turns = ff_scene_control(s, "rotation", 0, 0) * (!strcmp(s->target->name, "mitsuba-principled") ? 360 : 1);
    fprintf(out, "<!-- %s, %s: written by facetfit %s -->\n<scene version=\"3.0.0\">\n    <integrator type=\"path\"/>\n",
            s->target->title, s->material->title, s->version);
    fputs("    <sensor type=\"orthographic\">\n        <transform name=\"to_world\">\n            <scale x=\"1.1\" y=\"1.1\"/>\n"
          "            <lookat origin=\"0, 0, 5\" target=\"0, 0, 0\" up=\"0, 1, 0\"/>\n        </transform>\n"
          "        <film type=\"hdrfilm\">\n            <integer name=\"width\" value=\"256\"/>\n            <integer "
          "name=\"height\" value=\"256\"/>\n"
          "        </film>\n    </sensor>\n",
          out);
    if (!strncmp(name, "conductor", 9))
        put_conductor(s, out);
    else if (!strcmp(name, "plastic"))
        put_plastic(s, out);
    else
        put_principled(s, out);
    fputs("    <shape type=\"sphere\">\n", out);
    if (turns > 0)
        fprintf(out,
                "        <!-- the larger roughness lies %s degrees from the tangent: turn the tangents of a mesh by as much -->\n",
                ff_scene_number(turns, text));
    fputs("        <ref id=\"facetfit\"/>\n    </shape>\n    <emitter type=\"directional\">\n"
          "        <vector name=\"direction\" value=\"-1, -1, -2\"/>\n        <rgb name=\"irradiance\" value=\"1, 1, 1\"/>\n    "
          "</emitter>\n</scene>\n",
          out);
    return FF_OK;
}

static const char *const targets[] = {"mitsuba", "mitsuba-principled", NULL};

const ff_scene_file ff_scene_file_mitsuba = {
    .name = "mitsuba", .extension = ".xml", .title = "a scene of Mitsuba 3", .targets = targets, .write = write_mitsuba};
