/* A sphere with a material of glTF, as text and as bytes. */
#ifndef FF_INTERNAL_GLTF_H
#define FF_INTERNAL_GLTF_H
#include "internal_files.h"

/* The vertices and triangles; bytes, 4-aligned parts one after another. */
typedef struct ff_gltf_mesh {
    size_t n_vertices, n_indices, n_bytes;
    unsigned char *bytes; /* positions, normals, tangents, uv, indices; freed by the caller */
} ff_gltf_mesh;

ff_status ff_gltf_mesh_make(ff_gltf_mesh *out);
/* The JSON; uri: where the bytes are, NULL: in the file itself. Only the part between `"uri": "` and `"` is left to the caller. */
void ff_gltf_json(const ff_scene *s, const ff_gltf_mesh *m, int with_uri, FILE *out);
#endif
