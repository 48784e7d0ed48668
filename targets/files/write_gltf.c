/* glTF 2.0: a sphere with the material, as .gltf with its mesh in base64. */
#include "internal_gltf.h"
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979323846
enum { ROUND = 64, DOWN = 32, VERTICES = (ROUND + 1) * (DOWN + 1), INDICES = 6 * ROUND * (DOWN - 1) };

/* ---- the mesh -------------------------------------------------------------------------------- */

static void put_float(unsigned char **at, double x)
{
    const float f = (float)x;
    uint32_t bits;
    memcpy(&bits, &f, sizeof bits);
    for (int k = 0; k < 4; k++) *(*at)++ = (unsigned char)(bits >> 8 * k);
}

static void put_index(unsigned char **at, size_t i)
{
    *(*at)++ = (unsigned char)(i & 255);
    *(*at)++ = (unsigned char)(i >> 8);
}

/* Calls put for every vertex: a ring from the pole down, once more around for the seam of u. */
static void each_vertex(unsigned char **at, void (*put)(unsigned char **, double theta, double phi))
{
    for (int j = 0; j <= DOWN; j++)
        for (int i = 0; i <= ROUND; i++) put(at, PI * j / DOWN, 2 * PI * (i % ROUND) / ROUND + (i == ROUND ? 2 * PI : 0));
}

static void put_place(unsigned char **at, double theta, double phi)
{
    put_float(at, sin(theta) * cos(phi));
    put_float(at, cos(theta));
    put_float(at, -sin(theta) * sin(phi));
}

/* Along rising u. */
static void put_tangent(unsigned char **at, double theta, double phi)
{
    (void)theta;
    put_float(at, -sin(phi));
    put_float(at, 0);
    put_float(at, -cos(phi));
    put_float(at, 1);
}

static void put_uv(unsigned char **at, double theta, double phi)
{
    put_float(at, phi / (2 * PI));
    put_float(at, theta / PI);
}

static void put_triangles(unsigned char **at)
{
    for (size_t j = 0; j < DOWN; j++)
        for (size_t i = 0; i < ROUND; i++) {
            const size_t a = j * (ROUND + 1) + i, b = a + ROUND + 1;
            const size_t upper[3] = {a, b, a + 1}, lower[3] = {a + 1, b, b + 1};
            for (int k = 0; k < 3 && j + 1 < DOWN; k++) put_index(at, lower[k] == a + 1 ? a + 1 : lower[k]);
            for (int k = 0; k < 3 && j > 0; k++) put_index(at, upper[k]);
        }
}

ff_status ff_gltf_mesh_make(ff_gltf_mesh *out)
{
    const size_t bytes = VERTICES * 4 * (3 + 3 + 4 + 2) + INDICES * 2;
    unsigned char *made = malloc(bytes), *at = made;
    if (!made) return FF_ERR_MEMORY;
    each_vertex(&at, put_place);
    each_vertex(&at, put_place); /* of the unit sphere the normals are the places */
    each_vertex(&at, put_tangent);
    each_vertex(&at, put_uv);
    put_triangles(&at);
    *out = (ff_gltf_mesh){VERTICES, INDICES, bytes, made};
    return FF_OK;
}

/* ---- the text -------------------------------------------------------------------------------- */

static void put_material(const ff_scene *s, FILE *out)
{
    char text[FF_NUMBER_TEXT + 1];
    const double index = ff_scene_control(s, "ior", 0, ff_scene_control(s, "reflectance", 0, NAN)),
                 stretch = ff_scene_control(s, "anisotropyStrength", 0, 0);
    const char *color = !strcmp(s->target->name, "filament") ? "baseColor" : "baseColorFactor",
               *roughness = !strcmp(s->target->name, "filament") ? "roughness" : "roughnessFactor";
    const double metal = ff_scene_setting(s, "metallicFactor", ff_scene_setting(s, "metallic", 0));
    const double f0 = 0.16 * index * index, ior = !strcmp(s->target->name, "filament") ? (1 + sqrt(f0)) / (1 - sqrt(f0)) : index;
    const int has_index = !isnan(ior) && metal<1, has_stretch = stretch> 0;
    fputs("  \"materials\": [{\"name\": \"facetfit\", \"pbrMetallicRoughness\": {\"baseColorFactor\": [", out);
    ff_scene_color(s, color, ", ", out);
    fputs(", 1], \"roughnessFactor\": ", out);
    ff_scene_put(s, roughness, 1, out);
    fprintf(out, ", \"metallicFactor\": %s}", ff_scene_number(metal, text));
    if (has_index || has_stretch) fputs(",\n    \"extensions\": {", out);
    if (has_index) fprintf(out, "\"KHR_materials_ior\": {\"ior\": %s}", ff_scene_number(ior, text));
    if (has_stretch) {
        fprintf(out, "%s\"KHR_materials_anisotropy\": {\"anisotropyStrength\": %s, \"anisotropyRotation\": ", has_index ? ", " : "",
                ff_scene_number(stretch, text));
        ff_scene_put(s, "anisotropyRotation", 0, out);
        fputc('}', out);
    }
    fprintf(out, "%s}],\n", has_index || has_stretch ? "}" : "");
    if (has_index || has_stretch)
        fprintf(out, "  \"extensionsUsed\": [%s%s%s],\n", has_index ? "\"KHR_materials_ior\"" : "",
                has_index && has_stretch ? ", " : "", has_stretch ? "\"KHR_materials_anisotropy\"" : "");
}

/* Parts of the bytes, in their order. */
static void put_views(const ff_gltf_mesh *m, FILE *out)
{
    static const struct {
        const char *type;
        size_t numbers;
    } part[] = {{"VEC3", 3}, {"VEC3", 3}, {"VEC4", 4}, {"VEC2", 2}};
    size_t at = 0;
    fputs("  \"bufferViews\": [", out);
    for (size_t k = 0; k < 4; k++) {
        fprintf(out, "{\"buffer\": 0, \"byteOffset\": %zu, \"byteLength\": %zu, \"target\": 34962}, ", at,
                m->n_vertices * 4 * part[k].numbers);
        at += m->n_vertices * 4 * part[k].numbers;
    }
    fprintf(out, "{\"buffer\": 0, \"byteOffset\": %zu, \"byteLength\": %zu, \"target\": 34963}],\n", at, m->n_indices * 2);
    fputs("  \"accessors\": [", out);
    for (size_t k = 0; k < 4; k++)
        fprintf(out, "{\"bufferView\": %zu, \"componentType\": 5126, \"count\": %zu, \"type\": \"%s\"%s}, ", k, m->n_vertices,
                part[k].type, k == 0 ? ", \"min\": [-1, -1, -1], \"max\": [1, 1, 1]" : "");
    fprintf(out, "{\"bufferView\": 4, \"componentType\": 5123, \"count\": %zu, \"type\": \"SCALAR\"}]", m->n_indices);
}

void ff_gltf_json(const ff_scene *s, const ff_gltf_mesh *m, int with_uri, FILE *out)
{
    fprintf(out, "{\n  \"asset\": {\"version\": \"2.0\", \"generator\": \"facetfit %s\"},\n", s->version);
    fputs("  \"scene\": 0,\n  \"scenes\": [{\"nodes\": [0]}],\n  \"nodes\": [{\"mesh\": 0, \"name\": \"sphere\"}],\n", out);
    fputs("  \"meshes\": [{\"primitives\": [{\"attributes\": {\"POSITION\": 0, \"NORMAL\": 1, \"TANGENT\": 2, \"TEXCOORD_0\": 3}, "
          "\"indices\": 4, \"material\": 0}]}],\n",
          out);
    put_material(s, out);
    put_views(m, out);
    fprintf(out, ",\n  \"buffers\": [{\"byteLength\": %zu%s", m->n_bytes, with_uri ? ", \"uri\": \"" : "}]\n}\n");
}

static void put_base64(const unsigned char *bytes, size_t n, FILE *out)
{
    static const char digit[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < n; i += 3) {
        const unsigned b0 = bytes[i], b1 = i + 1 < n ? bytes[i + 1] : 0, b2 = i + 2 < n ? bytes[i + 2] : 0,
                       all = b0 << 16 | b1 << 8 | b2;
        fputc(digit[all >> 18], out);
        fputc(digit[all >> 12 & 63], out);
        fputc(i + 1 < n ? digit[all >> 6 & 63] : '=', out);
        fputc(i + 2 < n ? digit[all & 63] : '=', out);
    }
}

static ff_status write_gltf(const ff_scene *s, FILE *out)
{
    ff_gltf_mesh mesh;
    const ff_status status = ff_gltf_mesh_make(&mesh);
    if (status != FF_OK) return status;
    ff_gltf_json(s, &mesh, 1, out);
    fputs("data:application/octet-stream;base64,", out);
    put_base64(mesh.bytes, mesh.n_bytes, out);
    fputs("\"}]\n}\n", out);
    free(mesh.bytes);
    return FF_OK;
}

static const char *const targets[] = {"gltf", "three-r170", "three-r187", "filament", NULL};

const ff_scene_file ff_scene_file_gltf = {
    .name = "gltf", .extension = ".gltf", .title = "glTF 2.0, a sphere with the material", .targets = targets, .write = write_gltf};
