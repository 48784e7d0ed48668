# blender --background --python-exit-code 1 --python sphere.py -- OUT.exr: a sphere of Cycles' Glossy BSDF under a sun, seen along z. Where
# the normal is the half vector the radiance is known: f = D G / (4 iz oz) with D = 1 / (pi alpha^2), times iz, alpha = roughness^2.
import math
import sys
import bpy
import mathutils
import numpy as np

SIZE, ROUGHNESS, LIGHT = 65, 0.5, math.radians(40)
out = sys.argv[sys.argv.index("--") + 1]
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
scene.render.engine = "CYCLES"
scene.cycles.samples = 4
scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
scene.cycles.max_bounces = 0
scene.render.resolution_x = scene.render.resolution_y = SIZE
scene.render.image_settings.file_format = "OPEN_EXR"
scene.render.image_settings.color_depth = "32"
scene.render.filepath = out
scene.world = bpy.data.worlds.new("black")
scene.world.color = (0, 0, 0)

bpy.ops.mesh.primitive_uv_sphere_add(segments=256, ring_count=128)
bpy.ops.object.shade_smooth()
material = bpy.data.materials.new("glossy")
material.use_nodes = True
nodes = material.node_tree.nodes
nodes.clear()
glossy, end = nodes.new("ShaderNodeBsdfGlossy"), nodes.new("ShaderNodeOutputMaterial")
glossy.distribution = "GGX"
glossy.inputs["Color"].default_value = (1, 0.5, 0.25, 1)
glossy.inputs["Roughness"].default_value = ROUGHNESS
material.node_tree.links.new(glossy.outputs[0], end.inputs["Surface"])
bpy.context.object.data.materials.append(material)


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
towards = mathutils.Vector((math.sin(LIGHT), 0, math.cos(LIGHT)))
add("sun", sun).rotation_euler = towards.to_track_quat("Z", "Y").to_euler()
bpy.ops.render.render(write_still=True)

image = bpy.data.images.load(out)
image.colorspace_settings.is_data = True
pixels = np.array(image.pixels[:]).reshape(SIZE, SIZE, -1)[:, :, :3]
alpha, cosine = ROUGHNESS**2, math.cos(LIGHT / 2)
hidden = (math.sqrt(1 + alpha**2 * math.tan(LIGHT / 2) ** 2) - 1) / 2
known = 1 / (math.pi * alpha**2) / (1 + 2 * hidden) / (4 * cosine)
column = round((math.sin(LIGHT / 2) + 1) / 2 * SIZE - 0.5)
seen = pixels[SIZE // 2, column]
print(f"at the half vector {seen}, known {known:.5g} of red; corner {pixels[0, 0]}")
assert np.isfinite(pixels).all() and (pixels[0, 0] == 0).all(), "the background is not black"
assert np.allclose(seen, known * np.array([1, 0.5, 0.25]), rtol=0.03), "not what the formula says"
