/* MaterialX 1.39: the surface, its tangent turned where it is anisotropic, and a material that has it. */
#include "internal_files.h"
#include <string.h>

static void put_float(const ff_scene *s, const char *input, FILE *out)
{
    fprintf(out, "    <input name=\"%s\" type=\"float\" value=\"", input);
    ff_scene_put(s, input, 0, out);
    fputs("\" />\n", out);
}

static void put_color(const ff_scene *s, const char *input, FILE *out)
{
    fprintf(out, "    <input name=\"%s\" type=\"color3\" value=\"", input);
    ff_scene_color(s, input, ", ", out);
    fputs("\" />\n", out);
}

/* The tangent of OpenPBR has no rotation of its own. */
static void put_turned_tangent(const ff_scene *s, FILE *out)
{
    char text[FF_NUMBER_TEXT + 1];
    fputs(
        "  <tangent name=\"along_u\" type=\"vector3\">\n    <input name=\"space\" type=\"string\" value=\"world\" />\n  "
        "</tangent>\n"
        "  <normal name=\"upwards\" type=\"vector3\">\n    <input name=\"space\" type=\"string\" value=\"world\" />\n  </normal>\n"
        "  <rotate3d name=\"turned\" type=\"vector3\">\n    <input name=\"in\" type=\"vector3\" nodename=\"along_u\" />\n",
        out);
    fprintf(out, "    <input name=\"amount\" type=\"float\" value=\"%s\" />\n",
            ff_scene_number(360 * ff_scene_control(s, "tangent_rotation", 0, 0), text));
    fputs("    <input name=\"axis\" type=\"vector3\" nodename=\"upwards\" />\n  </rotate3d>\n", out);
}

static void put_openpbr(const ff_scene *s, FILE *out)
{
    const int metal = ff_scene_setting(s, "base_metalness", 0) > 0,
              stretched = ff_scene_control(s, "specular_roughness_anisotropy", 0, 0) > 0;
    if (stretched) put_turned_tangent(s, out);
    fputs("  <open_pbr_surface name=\"surface\" type=\"surfaceshader\">\n", out);
    put_color(s, "base_color", out);
    fprintf(out, "    <input name=\"base_metalness\" type=\"float\" value=\"%d\" />\n", metal);
    put_float(s, "specular_roughness", out);
    if (metal)
        put_color(s, "specular_color", out);
    else
        put_float(s, "specular_ior", out);
    if (stretched) {
        put_float(s, "specular_roughness_anisotropy", out);
        fputs("    <input name=\"geometry_tangent\" type=\"vector3\" nodename=\"turned\" />\n", out);
    }
    fputs("  </open_pbr_surface>\n", out);
}

static void put_standard(const ff_scene *s, FILE *out)
{
    const int metal = ff_scene_setting(s, "metalness", 0) > 0;
    fputs("  <standard_surface name=\"surface\" type=\"surfaceshader\">\n    <input name=\"base\" type=\"float\" value=\"1\" />\n",
          out);
    put_color(s, "base_color", out);
    fprintf(out, "    <input name=\"metalness\" type=\"float\" value=\"%d\" />\n", metal);
    put_float(s, "specular_roughness", out);
    if (metal)
        put_color(s, "specular_color", out);
    else
        put_float(s, "specular_IOR", out);
    if (ff_scene_control(s, "specular_anisotropy", 0, 0) > 0) {
        put_float(s, "specular_anisotropy", out);
        put_float(s, "specular_rotation", out);
    }
    fputs("  </standard_surface>\n", out);
}

static ff_status write_materialx(const ff_scene *s, FILE *out)
{
    fprintf(out,
            "<?xml version=\"1.0\"?>\n<!-- %s, %s: written by facetfit %s -->\n<materialx version=\"1.39\" "
            "colorspace=\"lin_rec709\">\n",
            s->target->title, s->material->title, s->version);
    if (!strcmp(s->target->name, "openpbr"))
        put_openpbr(s, out);
    else
        put_standard(s, out);
    fputs("  <surfacematerial name=\"facetfit\" type=\"material\">\n"
          "    <input name=\"surfaceshader\" type=\"surfaceshader\" nodename=\"surface\" />\n"
          "  </surfacematerial>\n</materialx>\n",
          out);
    return FF_OK;
}

static const char *const targets[] = {"openpbr", "standard-surface", NULL};

const ff_scene_file ff_scene_file_materialx = {
    .name = "materialx", .extension = ".mtlx", .title = "MaterialX 1.39", .targets = targets, .write = write_materialx};
