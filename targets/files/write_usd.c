/* USD in its text form: a sphere bound to a UsdPreviewSurface. */
#include "internal_files.h"

static ff_status write_usd(const ff_scene *s, FILE *out)
{
    char text[FF_NUMBER_TEXT + 1];
    fprintf(out,
            "#usda 1.0\n(\n    defaultPrim = \"World\"\n    doc = \"%s, %s: written by facetfit %s\"\n    metersPerUnit = 1\n    "
            "upAxis = \"Y\"\n)\n\n",
            s->target->title, s->material->title, s->version);
    fputs("def Xform \"World\"\n{\n    def Sphere \"Ball\" (\n        prepend apiSchemas = [\"MaterialBindingAPI\"]\n    )\n    {\n"
          "        double radius = 1\n        rel material:binding = </World/Looks/Facetfit>\n    }\n\n"
          "    def Scope \"Looks\"\n    {\n        def Material \"Facetfit\"\n        {\n"
          "            token outputs:surface.connect = </World/Looks/Facetfit/Surface.outputs:surface>\n\n"
          "            def Shader \"Surface\"\n            {\n                uniform token info:id = \"UsdPreviewSurface\"\n"
          "                color3f inputs:diffuseColor = (",
          out);
    ff_scene_color(s, "diffuseColor", ", ", out);
    fputs(")\n                float inputs:roughness = ", out);
    ff_scene_put(s, "roughness", 0.5, out);
    fprintf(out, "\n                float inputs:metallic = %s\n                float inputs:ior = ",
            ff_scene_number(ff_scene_setting(s, "metallic", 0), text));
    ff_scene_put(s, "ior", 1.5, out);
    fputs("\n                int inputs:useSpecularWorkflow = 0\n                token outputs:surface\n            }\n        }\n "
          "   }\n}\n",
          out);
    return FF_OK;
}

static const char *const targets[] = {"usd", NULL};

const ff_scene_file ff_scene_file_usd = {
    .name = "usda", .extension = ".usda", .title = "USD preview surface, as text", .targets = targets, .write = write_usd};
