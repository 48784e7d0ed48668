#!/usr/bin/env python3
"""export_test.py PROGRAM COMPILER: files for renderers say what was fitted, and what is lost is listed; code computes what `facetfit eval` does.

The text of every kind of file is read back by a parser that is written here, and must have the numbers that `fit --for` printed. The renderers
themselves are in tests/renderers."""
import base64
import json
import math
import os
import re
import struct
import subprocess
import sys
import tempfile
import xml.etree.ElementTree

import numpy as np

PROGRAM, COMPILER = os.path.abspath(sys.argv[1]), sys.argv[2]
failures = 0
FOLDER = tempfile.TemporaryDirectory()
os.chdir(FOLDER.name)


def check(right, what):
    global failures
    if not right:
        failures += 1
        print("failed:", what)


def run(*words, status=0):
    done = subprocess.run([PROGRAM, *words], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    check(done.returncode == status, f"{' '.join(words)}: status {done.returncode}, expected {status}: {done.stderr.decode()[-400:]}")
    return done.stdout, done.stderr.decode()


def simulate(expression, settings, name, *more):
    run("simulate", expression, "--set", settings, "--noise", "0.01", "-o", name, *more)


def fit_for(data, target, *more):
    """Controls and the JSON file of a fit for a target."""
    run("fit", data, "--for", target, "--cut-off", "0", "--json", "fit.json", *more)
    with open("fit.json") as f:
        return json.load(f)["fits"][0]["renderer"]


def export(target, path, *more):
    run("export", "fit.json", "--to", target, "-o", path, "--json", "export.json", "--force", *more)
    with open("export.json") as f:
        return json.load(f)


def number(x):
    return struct.unpack("f", struct.pack("f", x))[0]


def close(a, b, what):
    a, b = np.atleast_1d(a).astype(float), np.atleast_1d(b).astype(float)
    check(a.shape == b.shape and np.allclose(a, b, rtol=1e-12, atol=1e-15), f"{what}: {a}, expected {b}")


# ---- files of renderers -----------------------------------------------------------------------

DIELECTRIC = ("ggx/smith-height-correlated/schlick+lambert", "alpha=0.2,f0=0.05,kd=0.6:0.3:0.1")
METAL = ("ggx/smith-height-correlated/schlick", "alpha_x=0.2,alpha_y=0.35,r_xy=0.3,f0=0.9:0.7:0.4")


def read_python(path):
    """{(variable, input): value} of the assignments of a script, which has to compile."""
    text = open(path).read()
    compile(text, path, "exec")
    found = re.findall(r'^    (\w+)\.inputs\["([^"]+)"\]\.default_value = (.*)$', text, re.M)
    return {(node, name): eval(value) for node, name, value in found}


def blender():
    for data, material in (("dielectric.csv", "dielectric"), ("metal.csv", "metal")):
        controls = fit_for(data, "blender:" + material)["controls"]
        export("blender", "a.py")
        said = read_python("a.py")
        close(said["surface", "Base Color"][:3], controls["Base Color"]["value"], "Base Color")
        close(said["surface", "Roughness"], controls["Roughness"]["value"], "Roughness")
        check(said["surface", "Metallic"] == (material == "metal"), "Metallic")
        if material == "metal":
            close(said["surface", "Anisotropic Rotation"], controls["Anisotropic Rotation"]["value"], "Anisotropic Rotation")
        else:
            close(said["surface", "Specular"], controls["Specular"]["value"], "Specular")
    controls = fit_for("metal.csv", "blender-4:metal")["controls"]
    export("blender-4", "a.py")
    close(read_python("a.py")["surface", "Specular Tint"][:3], np.minimum(controls["Specular Tint"]["value"], 1), "Specular Tint")
    controls = fit_for("metal.csv", "blender-glossy:ggx")["controls"]
    export("blender-glossy", "a.py")
    close(read_python("a.py")["surface", "Anisotropy"], controls["Anisotropy"]["value"], "Anisotropy")


def read_glb(path):
    data = open(path, "rb").read()
    magic, version, size, n, kind = struct.unpack("<4sIII4s", data[:20])
    check(magic == b"glTF" and version == 2 and size == len(data) and n % 4 == 0 and kind == b"JSON", "the header of the .glb")
    m, kind = struct.unpack("<I4s", data[20 + n:28 + n])
    check(kind == b"BIN\0" and 28 + n + m == len(data), "the binary chunk")
    return json.loads(data[20:20 + n]), data[28 + n:]


def check_sphere(scene, mesh):
    def numbers(k, count):
        view, accessor = scene["bufferViews"][k], scene["accessors"][k]
        at = mesh[view["byteOffset"]:view["byteOffset"] + view["byteLength"]]
        return np.frombuffer(at, np.uint16 if k == 4 else np.float32).reshape(accessor["count"], count)

    place, normal, tangent, uv, index = (numbers(k, n) for k, n in enumerate((3, 3, 4, 2, 1)))
    check(np.allclose(np.linalg.norm(place, axis=1), 1, atol=1e-6) and np.allclose(place, normal), "places and normals")
    check(np.allclose(np.linalg.norm(tangent[:, :3], axis=1), 1, atol=1e-6) and np.abs(np.sum(tangent[:, :3] * normal, axis=1)).max() < 1e-6,
          "tangents")
    corner = place[index.reshape(-1, 3)].astype(float)
    n = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    check((np.sum(n * corner.sum(axis=1), axis=1) > 0).all(), "triangles seen from outside")
    check(abs(np.sum(np.linalg.norm(n, axis=1)) / 2 / (4 * math.pi) - 1) < 0.01, "the area of the sphere")
    # along the tangent u rises
    edge, du = corner[:, 1] - corner[:, 0], (uv[index.reshape(-1, 3)][:, 1] - uv[index.reshape(-1, 3)][:, 0])[:, 0]
    along = np.sum(edge * tangent[index.reshape(-1, 3)[:, 0], :3], axis=1)
    check((along[np.abs(du) > 1e-3] * du[np.abs(du) > 1e-3] > 0).all(), "u against the tangent")


def gltf():
    for target in ("gltf", "three-r170", "three-r187", "filament"):
        for data, material in (("dielectric.csv", "dielectric"), ("metal.csv", "metal")):
            fit = fit_for(data, f"{target}:{material}")
            controls, filament = fit["controls"], target == "filament"
            export(target, "a.gltf")
            scene = json.load(open("a.gltf"))
            mesh = base64.b64decode(scene["buffers"][0]["uri"].split(",")[1])
            check(len(mesh) == scene["buffers"][0]["byteLength"], "length of the buffer")
            check_sphere(scene, mesh)
            said = scene["materials"][0]
            physical = said["pbrMetallicRoughness"]
            close(physical["baseColorFactor"][:3], controls["baseColor" if filament else "baseColorFactor"]["value"], "baseColorFactor")
            close(physical["roughnessFactor"], controls["roughness" if filament else "roughnessFactor"]["value"], "roughnessFactor")
            check(physical["metallicFactor"] == (material == "metal"), "metallicFactor")
            if material == "dielectric" and not filament:
                close(said["extensions"]["KHR_materials_ior"]["ior"], controls["ior"]["value"], "ior")
            if "anisotropyStrength" in controls and controls["anisotropyStrength"]["value"] > 0:
                close(said["extensions"]["KHR_materials_anisotropy"]["anisotropyRotation"], controls["anisotropyRotation"]["value"], "rotation")
            check(sorted(said.get("extensions", {})) == sorted(scene.get("extensionsUsed", [])), "extensionsUsed")
            export(target, "a.glb")
            binary, bytes_ = read_glb("a.glb")
            check(binary["materials"] == scene["materials"] and bytes_[:len(mesh)] == mesh, "the .glb has the same")


def inputs_of(node):
    return {i.get("name"): i for i in node.iter("input")}


def materialx():
    for target, node, color in (("openpbr", "open_pbr_surface", "base_color"), ("standard-surface", "standard_surface", "base_color")):
        for data, material in (("dielectric.csv", "dielectric"), ("metal.csv", "metal")):
            controls = fit_for(data, f"{target}:{material}")["controls"]
            export(target, "a.mtlx")
            root = xml.etree.ElementTree.parse("a.mtlx").getroot()
            check(root.get("version") == "1.39", "version")
            said = inputs_of(root.find(node))
            close([float(x) for x in said[color].get("value").split(",")], controls[color]["value"], color)
            close(float(said["specular_roughness"].get("value")), controls["specular_roughness"]["value"], "specular_roughness")
            names = {n.get("name") for n in root}
            used = {i.get("nodename") for i in root.iter("input") if i.get("nodename")}
            check(used <= names, f"{target}: nodes {used - names} are not there")


def usd():
    controls = fit_for("dielectric.csv", "usd:dielectric")["controls"]
    export("usd", "a.usda")
    text = open("a.usda").read()
    check(text.startswith("#usda 1.0\n") and text.count("{") == text.count("}") and text.count("(") == text.count(")"), "brackets")
    close([float(x) for x in re.search(r"diffuseColor = \(([^)]*)\)", text)[1].split(",")], controls["diffuseColor"]["value"], "diffuseColor")
    close(float(re.search(r"inputs:ior = (\S+)", text)[1]), controls["ior"]["value"], "ior")
    close(float(re.search(r"inputs:roughness = (\S+)", text)[1]), controls["roughness"]["value"], "roughness")


def mitsuba():
    for target, data, material, names in (("mitsuba", "dielectric.csv", "plastic", {"alpha": "alpha", "int_ior": "int_ior"}),
                                          ("mitsuba", "metal.csv", "conductor", {"alpha_u": "alpha_u", "alpha_v": "alpha_v"}),
                                          ("mitsuba-principled", "metal.csv", "metal", {"roughness": "roughness", "anisotropic": "anisotropic"})):
        controls = fit_for(data, f"{target}:{material}")["controls"]
        export(target, "a.xml")
        root = xml.etree.ElementTree.parse("a.xml").getroot()
        bsdf = root.find("bsdf")
        check(root.tag == "scene" and bsdf.get("id") == root.find("shape").find("ref").get("id"), "the shape has the material")
        said = {e.get("name"): e.get("value") for e in bsdf}
        for name, control in names.items():
            close(float(said[name]), controls[control]["value"], name)
        for rgb in bsdf.findall("rgb"):
            close([float(x) for x in rgb.get("value").split(",")], controls[rgb.get("name")]["value"], rgb.get("name"))


def pbrt_tokens(text):
    """Directives of a scene: (name, type, {parameter: values})."""
    words = re.findall(r'"[^"]*"|\[|\]|[^\s\[\]"]+', re.sub(r"#.*", "", text))
    at, found = 0, []
    while at < len(words):
        name = words[at]
        check(re.fullmatch(r"[A-Z]\w+", name) is not None, f"pbrt: '{name}' is no directive")
        at += 1
        kind, params = None, {}
        while at < len(words) and not re.fullmatch(r"[A-Z]\w+", words[at]):
            if words[at].startswith('"') and at + 1 < len(words) and words[at + 1] == "[":
                end = words.index("]", at)
                params[words[at].strip('"')] = words[at + 2:end]
                at = end + 1
            else:
                kind = kind or words[at].strip('"')
                at += 1
        found.append((name, kind, params))
    return found


def pbrt():
    for data, material, kind in (("dielectric.csv", "coated", "coateddiffuse"), ("metal.csv", "conductor", "conductor")):
        controls = fit_for(data, "pbrt:" + material)["controls"]
        export("pbrt", "a.pbrt")
        scene = pbrt_tokens(open("a.pbrt").read())
        names = [name for name, _, _ in scene]
        check(names.index("WorldBegin") > names.index("Camera") and names.index("Material") < names.index("Shape"), "pbrt: order of directives")
        said = next(params for name, k, params in scene if name == "Material" and k == kind)
        check(said.pop("bool remaproughness") == ["false"], "remaproughness")
        check(set(p.split()[0] for p in said) <= {"rgb", "float"}, "types of parameters")
        for param, values in said.items():
            close([float(v) for v in values], controls[param.split()[1]]["value"], param)


# ---- what is lost -----------------------------------------------------------------------------

def goniometer(expression, settings):
    """Values times the cosine of the light over the directions of a goniometer."""
    run("simulate", expression, "--set", settings, "-o", "v.csv", "--grid", "goniometer:5")
    rows = np.array([[float(x) for x in line.split(",")] for line in open("v.csv") if line[0].isdigit() or line[0] == "-"])
    return rows[:, 4:7] * np.cos(np.radians(rows[:, :1]))


def lost():
    run("fit", "dielectric.csv", "--model", "ggx/smith-height-correlated/schlick+lambert", "--json", "fit.json")
    said = export("blender", "a.py")
    what = {item["what"].split(" ")[0] + " " + item["what"].split(" ")[1]: item["share"] for item in said["lost"]}
    check(said["refitted"] and any(w.startswith("masking") for w in what) and any(w.startswith("Fresnel") for w in what), f"lost: {what}")
    check(all(0 < s < 0.2 for s in what.values()) and 0 < said["left"] < 0.05, f"shares {what}, left {said['left']}")
    # all of it at once, without a fit, is worse than the fit
    with open("fit.json") as f:
        p = json.load(f)["fits"][0]["parameters"]
    f0, kd = (np.array(p[k]["value"]) for k in ("f0", "kd"))
    eta = (1 + np.sqrt(f0)) / (1 - np.sqrt(f0))
    alpha = p["alpha_x"]["value"]
    colors = lambda x: ":".join(repr(float(v)) for v in x)
    own = goniometer(DIELECTRIC[0], f"alpha={alpha!r},f0={colors(f0)},kd={colors(kd)}")
    other = goniometer("ggx/smith-separable/dielectric+disney-coupled", f"alpha={alpha!r},eta={colors(eta)},kd={colors(kd)}")
    unfitted = np.sqrt(np.nansum((other - own)**2) / np.nansum(own**2))
    check(0.2 * unfitted < said["left"] < unfitted, f"left {said['left']}, without a fit {unfitted}")
    fit_for("dielectric.csv", "blender:dielectric")
    said = export("blender", "a.py")
    check(not said["refitted"] and said["lost"] == [] and said["left"] == 0, f"the renderer's own model loses {said['lost']}")
    # the share is what the masking changes, over the directions of a goniometer
    run("fit", "metal.csv", "--model", "ggx/smith-height-correlated/schlick", "--json", "fit.json")
    said = export("mitsuba-principled", "a.xml")
    share = next(item["share"] for item in said["lost"] if item["what"].startswith("masking"))
    with open("fit.json") as f:
        p = json.load(f)["fits"][0]["parameters"]
    settings = ",".join(f"{k}={p[k]['value']!r}" for k in ("alpha_x", "alpha_y", "r_xy")) + ",f0=" + ":".join(map(repr, p["f0"]["value"]))
    values = [goniometer(f"ggx/{masking}/schlick", settings) for masking in ("smith-height-correlated", "smith-separable")]
    expected = np.sqrt(np.nansum((values[1] - values[0])**2) / np.nansum(values[0]**2))
    check(abs(share / expected - 1) < 1e-6, f"the masking changes {expected}, said is {share}")
    correlation = next(item for item in said["lost"] if item["what"].startswith("correlation"))
    check(correlation["share"] == 0, "a rotation is the same ellipse")


# ---- code -------------------------------------------------------------------------------------

MODELS = [("ggx/smith-height-correlated/schlick+lambert", "alpha_x=0.2,alpha_y=0.4,r_xy=0.5,f0=0.9:0.5:0.2,kd=0.1:0.2:0.3"),
          ("ggx/smith-separable/dielectric+disney-coupled", "alpha=0.16,eta=1.4:1.5:1.6,kd=0.7:0.4:0.2"),
          ("ggx/smith-separable/cycles", "alpha_x=0.3,alpha_y=0.1,r_xy=-0.4,f0=0.9:0.6:0.3"),
          ("ggx/smith-height-correlated/schlick-karis+fresnel-coupled", "alpha=0.3,f0=0.04:0.05:0.06,kd=0.5"),
          ("beckmann/v-cavity/conductor+lambert", "alpha=0.3,eta=0.2:0.9:1.5,k=3.9:2.4:1.9,kd=0.01"),
          ("beckmann/smith-separable/schlick-f82", "alpha=0.5,f0=0.9:0.6:0.3,f82=0.8:0.5:0.4"),
          ("beckmann-walter/smith-separable/none+lambert", "alpha_x=0.1,alpha_y=0.4,ks=0.5:0.4:0.3,kd=0.2"),
          ("ggx/hammon/schlick+lambert", "alpha=0.4,f0=0.04,kd=0.5:0.3:0.2"),
          ("ggx/kelemen/schlick+ggx/schlick-smith/shared+shirley-coupled", "alpha=0.1,lobe2.alpha=0.5,lobe2.weight=0.3,f0=0.05,kd=0.5")]


def code():
    draw = np.random.default_rng(3)
    angles = np.stack([np.degrees(np.arccos(draw.uniform(0.05, 1, 300))), draw.uniform(0, 360, 300), np.degrees(np.arccos(draw.uniform(0.05, 1, 300))),
                       draw.uniform(0, 360, 300)], axis=1)
    with open("directions.csv", "w") as f:
        f.write("theta_i,phi_i,theta_o,phi_o\n" + "".join(",".join("%.17g" % x for x in row) + "\n" for row in angles))
    main = r"""
#include <stdio.h>
#include <math.h>
#include "CODE"
int main(void)
{
    double a[4];
    const double d = 3.14159265358979323846 / 180;
    while (scanf("%lf,%lf,%lf,%lf", &a[0], &a[1], &a[2], &a[3]) == 4) {
        for (int k = 0; k < 3; k++)
            printf("%.17g ", facetfit_brdf(sin(a[0] * d) * cos(a[1] * d), sin(a[0] * d) * sin(a[1] * d), cos(a[0] * d),
                                           sin(a[2] * d) * cos(a[3] * d), sin(a[2] * d) * sin(a[3] * d), cos(a[2] * d), k));
        printf("\n");
    }
    return facetfit_brdf(0, 0, -1, 0, 0, 1, 0) != 0 || facetfit_brdf(0, 0, 1, 0, 0, -1, 2) != 0;
}
"""
    for expression, settings in MODELS:
        simulate(expression, settings, "m.csv", "--grid", "scattered:3000:0.5")
        run("fit", "m.csv", "--model", expression, "--loss", "log", "--json", "fit.json", *(["--free", "ks"] if "none" in expression else []))
        said, _ = run("eval", "--from", "fit.json", "directions.csv")
        wanted = np.array([[float(x) for x in line.split(",")[4:]] for line in said.decode().splitlines()[1:]])
        export("c", "code.h")
        with open("main.c", "w") as f:
            f.write(main.replace("CODE", "code.h"))
        subprocess.run([COMPILER, "-O1", "-std=c11", "-Wall", "-Wextra", "-Werror", "-o", "main", "main.c", "-lm"], check=True)
        rows = "\n".join(",".join("%.17g" % x for x in row) for row in angles)
        done = subprocess.run(["./main"], input=rows, stdout=subprocess.PIPE, text=True)
        found = np.array([[float(x) for x in line.split()] for line in done.stdout.splitlines()])
        check(done.returncode == 0, f"{expression}: light below the horizon")
        off = np.max(np.abs(found - wanted) / np.abs(wanted))
        print(f"code of {expression}: off by at most {off:.2g}")
        check(off < 1e-10, f"code of {expression}: {off}")
        for language in ("glsl", "hlsl", "osl"):
            export(language, "code." + language)
            check_shader(open("code." + language).read(), language)


def check_shader(text, language):
    body = re.sub(r"/\*.*?\*/", "", text, flags=re.S)
    check(body.count("{") == body.count("}") and body.count("(") == body.count(")"), f"{language}: brackets")
    check(not re.search(r"\bdouble\b|\bfm(in|ax)\b|\$|#include|static", body), f"{language}: words of C")
    # in GLSL a number without a point is an integer: none but those compared with the channel
    integers = re.findall(r"(?<![\w.])\d+(?![\w.])", re.sub(r"channel == \d+", "", re.sub(r"\d+\.\d+(e[-+]?\d+)?|\d+e[-+]?\d+", "", body)))
    check(integers == [], f"{language}: integers {integers[:3]}")


def refused():
    run("fit", "dielectric.csv", "--model", "gtr+lambert", "--json", "fit.json")
    _, said = run("export", "fit.json", "--to", "c", "-o", "no.h", status=2)
    check("no code for the distribution gtr" in said and "beckmann-walter" in said and not os.path.exists("no.h"), said)
    _, said = run("export", "fit.json", "--to", "blendr", "-o", "a.py", status=2)
    check("did you mean 'blender'" in said, said)
    _, said = run("export", "fit.json", "--to", "blender", "-o", "a.gltf", status=2)
    check(".py" in said, said)
    _, said = run("export", "fit.json", "--to", "unreal", "-o", "a.txt", status=2)
    check("fit --for unreal" in said, said)
    _, said = run("export", "fit.json", "--to", "blender:glass", "-o", "a.py", status=2)
    check("no such material" in said, said)
    run("export", "fit.json", "--to", "blender", "-o", "nowhere/a.py", status=4)
    run("export", "dielectric.csv", "--to", "blender", "-o", "a.py", status=3)
    run("export", "fit.json", "--to", "blender", "-o", "fit.json", status=2)


def tables():
    run("fit", "metal.csv", "--model", "ggx/smith-height-correlated/schlick", "--json", "fit.json")
    for name, path in (("rgl", "a.bsdf"), ("merl", "a.binary"), ("zemax", "a.zemax.bsdf"), ("astm", "a.astm"), ("csv", "a.csv")):
        export(name, path, *(["--channel", "g"] if name == "zemax" else []))
        out, _ = run("info", path)
        check(name in out.decode(), f"{name}: {out.decode()[:200]}")
    _, said = run("export", "fit.json", "--to", "zemax", "-o", "b.zemax.bsdf", status=2)
    check("--channel r takes one" in said, said)
    _, said = run("export", "fit.json", "--to", "zemax", "-o", "b.zemax.bsdf", "--channel", "x", status=2)
    check("it has r, g, b" in said, said)
    # values of the table are the model's
    out, _ = run("fit", "a.astm", "--model", "ggx/smith-height-correlated/schlick", "--json", "again.json")
    first, again = (json.load(open(name))["fits"][0]["parameters"] for name in ("fit.json", "again.json"))
    close(np.round(again["alpha_x"]["value"], 6), np.round(first["alpha_x"]["value"], 6), "alpha_x of the table")
    run("fit", "a.zemax.bsdf", "--model", "ggx/smith-height-correlated/schlick", "--json", "again.json")
    again = json.load(open("again.json"))["fits"][0]["parameters"]
    check(abs(again["alpha_x"]["value"] / first["alpha_x"]["value"] - 1) < 1e-4, f"alpha_x of Zemax: {again['alpha_x']['value']}")


def main():
    simulate(*DIELECTRIC, "dielectric.csv")
    simulate(*METAL, "metal.csv")
    for test in (blender, gltf, materialx, usd, mitsuba, pbrt, lost, code, refused, tables):
        before = failures
        test()
        print(f"{test.__name__}: {'passed' if failures == before else 'failed'}", flush=True)
    print(f"{failures} failures")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
