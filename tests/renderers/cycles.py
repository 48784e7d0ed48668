"""blender --background -noaudio --python-exit-code 1 --python cycles.py -- JOB.json: reflectances of nodes of Cycles.

The job says {"out": FOLDER, "side": N, "lights": [degrees], "width": W, "seed": N, "materials": [{"name", "node", "distribution",
"inputs": {socket: value}}]}; of each material FOLDER/NAME.npy gets [lights * side^2, 7]: the four angles of pairs.py and f of three
channels. One pixel sees one facet, the sun has no size, so that one sample is exact."""
import json
import math
import os
import sys

import bpy
import numpy as np
from mathutils import Vector

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import pairs

with open(sys.argv[sys.argv.index("--") + 1]) as f:
    job = json.load(f)
side = job["side"]


def add(scene, name, data):
    thing = bpy.data.objects.new(name, data)
    scene.collection.objects.link(thing)
    return thing


def set_up():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.device, cycles.samples, cycles.max_bounces, cycles.pixel_filter_type = "CPU", 1, 0, "BOX"
    cycles.use_denoising = cycles.use_adaptive_sampling = False
    cycles.light_sampling_threshold = cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.blur_glossy = 0
    scene.render.threads_mode, scene.render.threads = "FIXED", 1
    scene.render.resolution_x = scene.render.resolution_y = side
    scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
    scene.render.film_transparent = True
    scene.view_settings.view_transform = "Raw"
    scene.world = bpy.data.worlds.new("black")
    scene.world.color = (0, 0, 0)
    camera = bpy.data.cameras.new("camera")
    camera.type, camera.ortho_scale, camera.clip_end = "ORTHO", side, 1000
    scene.camera = add(scene, "camera", camera)
    scene.camera.location = (side / 2, side / 2, 100)
    sun = bpy.data.lights.new("sun", "SUN")
    sun.energy, sun.angle = 1, 0
    return scene, add(scene, "sun", sun)


def facets(scene, n):
    """A quad in each pixel, in the plane of its normal; u runs along the tangent."""
    t, b = pairs.frames(n)
    corners, uv = [], []
    for k in range(len(n)):
        centre = np.array([k % side + 0.5, k // side + 0.5, 0.0])
        for dx, dy in ((-0.45, -0.45), (0.45, -0.45), (0.45, 0.45), (-0.45, 0.45)):
            d = np.array([dx, dy, -(n[k, 0] * dx + n[k, 1] * dy) / n[k, 2]])
            corners.append(tuple(centre + d))
            uv.append((float(d @ t[k]), float(d @ b[k])))
    mesh = bpy.data.meshes.new("facets")
    mesh.from_pydata(corners, [], [tuple(range(4 * k, 4 * k + 4)) for k in range(len(n))])
    layer = mesh.uv_layers.new(name="uv")
    for k, place in enumerate(uv):
        layer.data[k].uv = place
    mesh.update()
    thing = add(scene, "facets", mesh)
    thing.visible_shadow = False
    return thing


def material_of(spec):
    """The node with a tangent along u, as the material's surface."""
    material = bpy.data.materials.new(spec["name"])
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    node, end, tangent = (tree.nodes.new(name) for name in (spec["node"], "ShaderNodeOutputMaterial", "ShaderNodeTangent"))
    node.distribution = spec["distribution"]
    for name, value in spec["inputs"].items():
        node.inputs[name].default_value = (*value, 1) if isinstance(value, list) else value
    tangent.direction_type, tangent.uv_map = "UV_MAP", "uv"
    if "Tangent" in node.inputs:
        tree.links.new(tangent.outputs[0], node.inputs["Tangent"])
    tree.links.new(node.outputs[0], end.inputs["Surface"])
    return material


def render(scene):
    path = os.path.join(job["out"], "frame.exr")
    scene.render.filepath = path
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(path, check_existing=False)
    image.colorspace_settings.is_data = True
    pixels = np.array(image.pixels[:]).reshape(side * side, -1)
    bpy.data.images.remove(image)
    assert (pixels[:, 3] > 0.5).all(), "a pixel without a facet"
    return pixels[:, :3]


def main():
    scene, sun = set_up()
    materials = [material_of(spec) for spec in job["materials"]]
    rows = [[] for _ in materials]
    for degrees in job["lights"]:
        n = pairs.normals(side, degrees, job["width"], job["seed"])
        angles = pairs.angles(n, degrees)
        sun.rotation_euler = Vector(pairs.light(degrees)).to_track_quat("Z", "Y").to_euler()
        thing = facets(scene, n)
        for k, material in enumerate(materials):
            thing.data.materials.clear()
            thing.data.materials.append(material)
            f = render(scene) / np.cos(np.radians(angles[:, :1]))
            rows[k].append(np.concatenate([angles, f], axis=1))
        bpy.data.objects.remove(thing)
    for spec, found in zip(job["materials"], rows):
        np.save(os.path.join(job["out"], spec["name"] + ".npy"), np.concatenate(found))
    assert math.isfinite(sum(float(np.sum(r)) for found in rows for r in found))


main()
