/* A Python script for Blender: a function that makes the material, and a sphere that has it. */
#include "internal_files.h"
#include <string.h>

static void put_head(const ff_scene *s, FILE *out)
{
    fprintf(out,
            "\"\"\"Material for %s (%s), written by facetfit %s.\n\n"
            "Open it in Blender's text editor and run it, or: blender --python FILE. Colours are linear, of Rec. 709.\"\"\"\n"
            "import bpy\n\n\n"
            "def make_material(name=\"facetfit\"):\n"
            "    material = bpy.data.materials.new(name)\n"
            "    material.use_nodes = True\n"
            "    tree = material.node_tree\n"
            "    tree.nodes.clear()\n"
            "    end = tree.nodes.new(\"ShaderNodeOutputMaterial\")\n",
            s->target->title, s->target->version, s->version);
}

static void put_color(const ff_scene *s, const char *node, const char *input, const char *control, FILE *out)
{
    fprintf(out, "    %s.inputs[\"%s\"].default_value = (", node, input);
    ff_scene_color(s, control, ", ", out);
    fputs(", 1)\n", out);
}

static void put_number(const ff_scene *s, const char *node, const char *input, const char *control, double otherwise, FILE *out)
{
    fprintf(out, "    %s.inputs[\"%s\"].default_value = ", node, input);
    ff_scene_put(s, control, otherwise, out);
    fputc('\n', out);
}

static void put_setting(const ff_scene *s, const char *node, const char *name, double otherwise, FILE *out)
{
    char text[FF_NUMBER_TEXT + 1];
    fprintf(out, "    %s.inputs[\"%s\"].default_value = %s\n", node, name,
            ff_scene_number(ff_scene_setting(s, name, otherwise), text));
}

/* The direction that the rotation counts from: along u of the mesh. */
static void put_tangent(const char *node, FILE *out)
{
    fprintf(out,
            "    tangent = tree.nodes.new(\"ShaderNodeTangent\")\n"
            "    tangent.direction_type = \"UV_MAP\"\n"
            "    tree.links.new(tangent.outputs[0], %s.inputs[\"Tangent\"])\n",
            node);
}

static void put_principled(const ff_scene *s, FILE *out)
{
    const int fourth = !strcmp(s->target->name, "blender-4"), metal = ff_scene_setting(s, "Metallic", 0) > 0;
    const double anisotropic = ff_scene_control(s, "Anisotropic", 0, 0);
    fputs("    surface = tree.nodes.new(\"ShaderNodeBsdfPrincipled\")\n    surface.distribution = \"GGX\"\n", out);
    put_color(s, "surface", "Base Color", "Base Color", out);
    put_number(s, "surface", "Roughness", "Roughness", 0.5, out);
    put_setting(s, "surface", "Metallic", 0, out);
    if (fourth && metal) put_color(s, "surface", "Specular Tint", "Specular Tint", out);
    if (fourth && !metal) put_number(s, "surface", "IOR", "IOR", 1.5, out);
    if (!fourth) put_number(s, "surface", "Specular", "Specular", 0.5, out);
    if (anisotropic > 0) {
        put_number(s, "surface", "Anisotropic", "Anisotropic", 0, out);
        put_number(s, "surface", "Anisotropic Rotation", "Anisotropic Rotation", 0, out);
        put_tangent("surface", out);
    }
    fputs("    tree.links.new(surface.outputs[0], end.inputs[\"Surface\"])\n", out);
}

static void put_glossy(const ff_scene *s, FILE *out)
{
    const int stretched = ff_scene_control(s, "Anisotropy", 0, 0) > 0;
    fprintf(out, "    surface = tree.nodes.new(\"%s\")\n    surface.distribution = \"%s\"\n",
            stretched ? "ShaderNodeBsdfAnisotropic" : "ShaderNodeBsdfGlossy",
            !strcmp(s->material->name, "beckmann") ? "BECKMANN" : "GGX");
    put_color(s, "surface", "Color", "Glossy Color", out);
    put_number(s, "surface", "Roughness", "Roughness", 0.5, out);
    if (stretched) {
        put_number(s, "surface", "Anisotropy", "Anisotropy", 0, out);
        put_number(s, "surface", "Rotation", "Rotation", 0, out);
        put_tangent("surface", out);
    }
    fputs("    diffuse = tree.nodes.new(\"ShaderNodeBsdfDiffuse\")\n    diffuse.inputs[\"Roughness\"].default_value = 0\n", out);
    put_color(s, "diffuse", "Color", "Diffuse Color", out);
    fputs("    both = tree.nodes.new(\"ShaderNodeAddShader\")\n"
          "    tree.links.new(surface.outputs[0], both.inputs[0])\n"
          "    tree.links.new(diffuse.outputs[0], both.inputs[1])\n"
          "    tree.links.new(both.outputs[0], end.inputs[\"Surface\"])\n",
          out);
}

static ff_status write_blender(const ff_scene *s, FILE *out)
{
    put_head(s, out);
    if (!strcmp(s->target->name, "blender-glossy"))
        put_glossy(s, out);
    else
        put_principled(s, out);
    fputs("    return material\n\n\n"
          "if __name__ == \"__main__\":\n"
          "    bpy.ops.mesh.primitive_uv_sphere_add(segments=128, ring_count=64)\n"
          "    bpy.ops.object.shade_smooth()\n"
          "    bpy.context.object.data.materials.append(make_material())\n",
          out);
    return FF_OK;
}

static const char *const targets[] = {"blender", "blender-glossy", "blender-4", NULL};

const ff_scene_file ff_scene_file_blender = {.name = "blender-python",
                                             .extension = ".py",
                                             .title = "a script that makes the material in Blender",
                                             .targets = targets,
                                             .write = write_blender};
