"""What renderers show of a material: rows of theta_i, phi_i, theta_o, phi_o (degrees) and f of three channels, 1/sr."""
import base64
import html
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile

import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))
MODULES = os.path.join(HERE, "node_modules")
sys.path.insert(0, HERE)
import pairs

SKIP = 77


def skip(what):
    print(f"skipped: {what} is not there; ./setup renderers would install it")
    sys.exit(SKIP)


def cycles(materials, side, lights, width=0.3, seed=1):
    """{name: rows} of nodes as cycles.py takes them."""
    if not shutil.which("blender"):
        skip("blender")
    with tempfile.TemporaryDirectory() as folder:
        job = {"out": folder, "side": side, "lights": lights, "width": width, "seed": seed, "materials": materials}
        path = os.path.join(folder, "job.json")
        with open(path, "w") as f:
            json.dump(job, f)
        done = subprocess.run(["blender", "--background", "-noaudio", "--python-exit-code", "1", "--python", os.path.join(HERE, "cycles.py"),
                               "--", path], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        if done.returncode:
            raise SystemExit(done.stdout[-3000:])
        return {m["name"]: np.load(os.path.join(folder, m["name"] + ".npy")) for m in materials}


def facets_gltf(n, side, material):
    """A quad in each pixel whose four normals are one of n, and whose tangent is that of pairs.frames."""
    t, _ = pairs.frames(n)
    k = np.arange(len(n))
    corner = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
    place = np.zeros((len(n), 4, 3), np.float32)
    place[:, :, 0] = (k % side)[:, None] + corner[:, 0]
    place[:, :, 1] = (k // side)[:, None] + corner[:, 1]
    normal = np.repeat(n[:, None, :], 4, axis=1).astype(np.float32)
    tangent = np.ones((len(n), 4, 4), np.float32)
    tangent[:, :, :3] = t[:, None, :]
    uv = np.repeat(corner[None], len(n), axis=0).astype(np.float32)
    index = (4 * k[:, None] + np.array([0, 1, 2, 0, 2, 3])).astype(np.uint32)
    parts = [place, normal, tangent, uv, index]
    views, at = [], 0
    for part in parts:
        views.append({"buffer": 0, "byteOffset": at, "byteLength": part.nbytes})
        at += part.nbytes
    kinds = ["VEC3", "VEC3", "VEC4", "VEC2"]
    accessors = [{"bufferView": i, "componentType": 5126, "count": 4 * len(n), "type": kind} for i, kind in enumerate(kinds)]
    accessors[0].update(min=[0, 0, 0], max=[side, side, 0])
    accessors.append({"bufferView": 4, "componentType": 5125, "count": int(index.size), "type": "SCALAR"})
    data = base64.b64encode(b"".join(part.tobytes() for part in parts)).decode()
    return {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1, "TANGENT": 2, "TEXCOORD_0": 3}, "indices": 4,
                                        "material": 0}]}],
            "materials": [material], "extensionsUsed": sorted(material.get("extensions", {})),
            "buffers": [{"uri": "data:application/octet-stream;base64," + data, "byteLength": at}], "bufferViews": views,
            "accessors": accessors}


def browser(page, files, seconds=120):
    """Text of the element `said` of a page, with files {name: path or text} beside it."""
    if not shutil.which("chromium"):
        skip("chromium")
    with tempfile.TemporaryDirectory() as folder:
        shutil.copy(os.path.join(HERE, page), folder)
        for name, what in files.items():
            if os.path.isabs(what) and os.path.exists(what):
                os.symlink(what, os.path.join(folder, name))
            else:
                with open(os.path.join(folder, name), "w") as f:
                    f.write(what)
        done = subprocess.run(
            ["chromium", "--headless", "--no-sandbox", "--disable-gpu-sandbox", "--use-gl=angle", "--use-angle=swiftshader",
             "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist", "--allow-file-access-from-files",
             "--user-data-dir=" + os.path.join(folder, "profile"), f"--virtual-time-budget={1000 * seconds}", "--dump-dom",
             "file://" + os.path.join(folder, page)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
            env=dict(os.environ, HOME=folder), timeout=10 * seconds)
        found = re.search(r'id="said">([^<]*)<', done.stdout)
        if not found or found[1].startswith("failed") or found[1] == "nothing":
            raise SystemExit(f"{page}: {found[1] if found else done.stdout[-500:]}\n{done.stderr[-2000:]}")
        return html.unescape(found[1])


def three(module, revision, materials, side, lights, width=0.3, seed=1):
    """{name: rows} of glTF materials {name: material}, by the three.js that lies in node_modules/module."""
    root = os.path.join(MODULES, module)
    if not os.path.isdir(root):
        skip(module)
    pictures, order = [], []
    for name, material in materials.items():
        for degrees in lights:
            # normals as they are stored, of 32 bits
            n = pairs.normals(side, degrees, width, seed).astype(np.float32).astype(float)
            pictures.append({"gltf": facets_gltf(n, side, material), "light": list(pairs.light(degrees))})
            order.append((name, pairs.angles(n / np.linalg.norm(n, axis=1)[:, None], degrees)))
    said = browser("three.html", {"three": root, "job.js": "window.job = " + json.dumps({"side": side, "pictures": pictures}) + ";"}).split("\n")
    if said[0] != f"REVISION {revision}":
        raise SystemExit(f"{module}: {said[0]}, wanted {revision}")
    rows = {name: [] for name in materials}
    for (name, angles), text in zip(order, said[1:]):
        f = np.frombuffer(base64.b64decode(text), np.float32).reshape(-1, 4)[:, :3].astype(float)
        rows[name].append(np.concatenate([angles, f / np.cos(np.radians(angles[:, :1]))], axis=1))
    return {name: np.concatenate(found) for name, found in rows.items()}


def evaluate(program, expression, settings, rows, column="f"):
    """f of three channels by `facetfit eval` for the directions of rows, or another column of it, as often."""
    table = "theta_i,phi_i,theta_o,phi_o\n" + "".join(",".join("%.17g" % x for x in row[:4]) + "\n" for row in rows)
    done = subprocess.run([program, "eval", expression, "--set", settings, "--terms"], input=table, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          text=True)
    if done.returncode:
        raise SystemExit(done.stderr)
    lines = [line.split(",") for line in done.stdout.splitlines()]
    at = [k for k, head in enumerate(lines[0]) if head.split("_")[0] == column and head != "theta_i"]
    f = np.array([[float(line[k]) for k in at] for line in lines[1:]])
    return f if f.shape[1] == 3 else np.repeat(f[:, :1], 3, axis=1)


def write_csv(path, rows):
    with open(path, "w") as f:
        f.write("# quantity: brdf\ntheta_i,phi_i,theta_o,phi_o,f_r,f_g,f_b\n")
        f.writelines(",".join("%.9g" % x for x in row) + "\n" for row in rows)
