/* glTF 2.0 in one binary file: a header, the JSON and the mesh, each padded to four bytes. */
#include "internal_gltf.h"
#include "base/internal_kept.h"
#include <stdint.h>
#include <stdlib.h>

static void put_word(uint32_t x, FILE *out)
{
    for (int k = 0; k < 4; k++) fputc((int)(x >> 8 * k & 255), out);
}

static ff_status write_glb(const ff_scene *s, FILE *out)
{
    ff_gltf_mesh mesh;
    ff_kept text;
    ff_status status = ff_gltf_mesh_make(&mesh);
    if (status != FF_OK) return status;
    FILE *json = ff_kept_open(&text);
    if (json) ff_gltf_json(s, &mesh, 0, json);
    status = ff_kept_close(&text, json);
    if (status == FF_OK) {
        const size_t n = text.n, padded = (n + 3) / 4 * 4, bytes = (mesh.n_bytes + 3) / 4 * 4;
        put_word(0x46546C67, out);
        put_word(2, out);
        put_word((uint32_t)(12 + 8 + padded + 8 + bytes), out);
        put_word((uint32_t)padded, out);
        put_word(0x4E4F534A, out);
        fwrite(text.text, 1, n, out);
        for (size_t i = n; i < padded; i++) fputc(' ', out);
        put_word((uint32_t)bytes, out);
        put_word(0x004E4942, out);
        fwrite(mesh.bytes, 1, mesh.n_bytes, out);
        for (size_t i = mesh.n_bytes; i < bytes; i++) fputc(0, out);
    }
    free(text.text);
    free(mesh.bytes);
    return status;
}

static const char *const targets[] = {"gltf", "three-r170", "three-r187", "filament", NULL};

const ff_scene_file ff_scene_file_glb = {.name = "glb",
                                         .extension = ".glb",
                                         .title = "glTF 2.0 in one binary file",
                                         .targets = targets,
                                         .is_binary = 1,
                                         .write = write_glb};
