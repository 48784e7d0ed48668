"""blender --background -noaudio --python-exit-code 1 --python sphere.py -- MATERIAL.py OUT.npy [SIZE]: the sphere that an exported script makes,
under a sun 40 degrees from the view; rows of the pixels inside it: theta_i, phi_i, theta_o, phi_o (degrees) and f of three channels."""
import math
import os
import runpy
import sys

import bpy
import numpy as np
from mathutils import Vector

script, out = sys.argv[sys.argv.index("--") + 1:][:2]
size, light = 96, math.radians(40)
bpy.ops.wm.read_factory_settings(use_empty=True)
runpy.run_path(script, run_name="__main__")
bpy.context.object.rotation_euler = (math.pi / 2, 0, 0)  # the poles, where the mesh has no tangents, to the rim: the axis is -y
scene = bpy.context.scene
scene.render.engine = "CYCLES"
cycles = scene.cycles
cycles.samples, cycles.max_bounces, cycles.pixel_filter_type, cycles.filter_width = 64, 0, "BOX", 0.01
cycles.use_denoising = cycles.use_adaptive_sampling = False
cycles.light_sampling_threshold = 0
scene.render.threads_mode, scene.render.threads = "FIXED", 1
scene.render.resolution_x = scene.render.resolution_y = size
scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
scene.render.film_transparent = True
scene.render.filepath = out + ".exr"
scene.world = bpy.data.worlds.new("black")
scene.world.color = (0, 0, 0)


def add(name, data):
    thing = bpy.data.objects.new(name, data)
    scene.collection.objects.link(thing)
    return thing


camera = bpy.data.cameras.new("camera")
camera.type, camera.ortho_scale = "ORTHO", 2
scene.camera = add("camera", camera)
scene.camera.location = (0, 0, 5)
sun = bpy.data.lights.new("sun", "SUN")
sun.energy, sun.angle = 1, 0
towards = Vector((math.sin(light), 0, math.cos(light)))
add("sun", sun).rotation_euler = towards.to_track_quat("Z", "Y").to_euler()
bpy.ops.render.render(write_still=True)
image = bpy.data.images.load(out + ".exr")
image.colorspace_settings.is_data = True
pixels = np.array(image.pixels[:]).reshape(size, size, -1)[:, :, :3]

x, y = np.meshgrid((np.arange(size) + 0.5) / size * 2 - 1, (np.arange(size) + 0.5) / size * 2 - 1)
inside = x**2 + y**2 < 0.8  # where a pixel sees little of the turn of the normals
n = np.stack([x, y, np.sqrt(np.maximum(1 - x**2 - y**2, 0))], axis=-1)[inside]
towards = np.array(towards)
lit = n @ towards > 0.15
n, f = n[lit], pixels[inside][lit]
around = np.stack([-n[:, 2], 0 * n[:, 0], n[:, 0]], axis=1)  # the mesh's u runs around its axis
around /= np.linalg.norm(around, axis=1)[:, None]
across = np.cross(n, around)
rows = []
for w in (towards, np.array([0.0, 0, 1])):
    a, b, c = around @ w, across @ w, n @ w
    rows += [np.degrees(np.arctan2(np.hypot(a, b), c)), np.degrees(np.arctan2(b, a))]
np.save(out, np.concatenate([np.stack(rows, axis=1), f / (n @ towards)[:, None]], axis=1))
os.remove(out + ".exr")
