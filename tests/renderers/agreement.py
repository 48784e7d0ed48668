#!/usr/bin/env python3
"""agreement.py PROGRAM RENDERER [smoke]: does a renderer show what `facetfit eval` says of the model of its target?

RENDERER is cycles, three-r170 or three-r187. Of every material some 10,000 pairs of directions are looked at (smoke: 256 of one
roughness), of each the value relative to the model's, where that is above a thousandth of the material's largest. What the renderer's
numbers are in terms of the model's is said here once more, apart from the program; `facetfit fit --for` has to find the numbers again
that were set. Ends with 77 where the renderer is not installed."""
import json
import math
import os
import re
import subprocess
import sys
import tempfile

import numpy as np

import measure

PROGRAM = os.path.abspath(sys.argv[1])
ROUGHNESSES = (0.18, 0.3, 0.6, 0.9)  # alpha from 0.0324 on
LIGHTS = [1, 20, 40, 60, 85, 110, 140]
COLOR = [0.8, 0.5, 0.1]
failures = 0


def stretch(major_x, minor_y, radians):
    """alpha_x, alpha_y, r_xy of roughnesses along and across a direction."""
    c, s = math.cos(radians), math.sin(radians)
    m = np.array([[c, -s], [s, c]]) @ np.diag([major_x**2, minor_y**2]) @ np.array([[c, s], [-s, c]])
    ax, ay = math.sqrt(m[0, 0]), math.sqrt(m[1, 1])
    return f"alpha_x={ax!r},alpha_y={ay!r},r_xy={m[0, 1] / (ax * ay)!r}"


def colors(name, color=COLOR):
    return name + "=" + ":".join(map(repr, color))


def cycles_cases(roughnesses):
    """(name, the node as cycles.py takes it, model, settings, target, {control: what was set})"""
    for r in roughnesses:
        a = r * r
        for kind, ndf in (("GGX", "ggx"), ("BECKMANN", "beckmann-walter")):
            yield (f"glossy-{kind.lower()}-{r}", {"node": "ShaderNodeBsdfGlossy", "distribution": kind, "inputs": {"Color": COLOR, "Roughness": r}},
                   f"{ndf}/smith-separable/none", f"alpha={a!r},{colors('ks')}", f"blender-glossy:{'ggx' if kind == 'GGX' else 'beckmann'}",
                   {"Roughness": r, "Glossy Color": COLOR})
        for specular in (0.5, 0.9):
            root = math.sqrt(0.08 * specular)
            yield (f"principled-dielectric-{specular}-{r}",
                   {"node": "ShaderNodeBsdfPrincipled", "distribution": "GGX",
                    "inputs": {"Base Color": COLOR, "Roughness": r, "Specular": specular, "Metallic": 0.0}},
                   "ggx/smith-separable/dielectric+disney-coupled", f"alpha={a!r},eta={(1 + root) / (1 - root)!r},{colors('kd')}",
                   "blender:dielectric", {"Roughness": r, "Specular": specular, "Base Color": COLOR})
        yield (f"principled-metal-{r}", {"node": "ShaderNodeBsdfPrincipled", "distribution": "GGX",
                                         "inputs": {"Base Color": COLOR, "Roughness": r, "Specular": 0.5, "Metallic": 1.0}},
               "ggx/smith-separable/cycles", f"alpha={a!r},{colors('f0')}", "blender:metal", {"Roughness": r, "Base Color": COLOR})
        an, turn = 0.4 if r < 0.9 else 0.1, 0.15  # alpha stays below 1, at which Cycles ends
        yield (f"glossy-anisotropic-{r}", {"node": "ShaderNodeBsdfAnisotropic", "distribution": "GGX",
                                           "inputs": {"Color": COLOR, "Roughness": r, "Anisotropy": an, "Rotation": turn}},
               "ggx/smith-separable/none", stretch(a * (1 - an), a / (1 - an), 2 * math.pi * turn) + "," + colors("ks"), "blender-glossy:ggx",
               {"Roughness": r, "Anisotropy": an, "Rotation": turn})
        if r < 0.9:  # alpha along the grooves stays below 1
            an, aspect = 0.6, math.sqrt(1 - 0.9 * 0.6)
            yield (f"principled-anisotropic-{r}",
                   {"node": "ShaderNodeBsdfPrincipled", "distribution": "GGX",
                    "inputs": {"Base Color": COLOR, "Roughness": r, "Specular": 0.5, "Metallic": 1.0, "Anisotropic": an,
                               "Anisotropic Rotation": turn}},
                   "ggx/smith-separable/cycles", stretch(a / aspect, a * aspect, 2 * math.pi * turn) + "," + colors("f0"), "blender:metal",
                   {"Roughness": r, "Anisotropic": an, "Anisotropic Rotation": turn, "Base Color": COLOR})


def gltf_cases(target, roughnesses):
    """The same with the material of glTF in place of the node."""
    for r in roughnesses:
        a = r * r
        physical = {"baseColorFactor": COLOR + [1], "roughnessFactor": r}
        lobe = "ggx/smith-height-correlated/schlick-karis"
        base, metal = ("+lambert", "") if target == "three-r170" else ("+fresnel-coupled+turquin", "+turquin")
        for ior in (1.5, 1.8):
            f0 = ((ior - 1) / (ior + 1))**2
            yield (f"dielectric-{ior}-{r}", {"pbrMetallicRoughness": dict(physical, metallicFactor=0), "extensions": {"KHR_materials_ior": {"ior": ior}}},
                   lobe + base, f"alpha={a!r},f0={f0!r},{colors('kd')}", target + ":dielectric",
                   {"roughnessFactor": r, "ior": ior, "baseColorFactor": COLOR})
        yield (f"metal-{r}", {"pbrMetallicRoughness": dict(physical, metallicFactor=1)}, lobe + metal, f"alpha={a!r},{colors('f0')}",
               target + ":metal", {"roughnessFactor": r, "baseColorFactor": COLOR})
        if target == "three-r170":
            strength, turn = 0.5, 0.7
            yield (f"anisotropic-{r}", {"pbrMetallicRoughness": dict(physical, metallicFactor=1),
                                        "extensions": {"KHR_materials_anisotropy": {"anisotropyStrength": strength, "anisotropyRotation": turn}}},
                   lobe, stretch(a + (1 - a) * strength**2, a, turn) + "," + colors("f0"), target + ":metal",
                   {"roughnessFactor": r, "anisotropyStrength": strength, "anisotropyRotation": turn, "baseColorFactor": COLOR})


def of_the_table(roughness, mu):
    """E of three.js r187: its table of 16 by 16, bilinear between the centres of the texels."""
    with open(os.path.join(measure.MODULES, "three-r187/src/renderers/shaders/DFGLUTData.js")) as f:
        words = [int(word, 16) for word in re.findall(r"0x([0-9a-f]{4})", f.read())]
    table = np.array(words, np.uint16).view(np.float16).astype(float).reshape(16, 16, 2).sum(axis=2)
    x, y = np.clip(roughness * 16 - 0.5, 0, 15), np.clip(mu * 16 - 0.5, 0, 15)
    i, j = min(int(x), 14), np.minimum(y.astype(int), 14)
    u, v = x - i, y - j
    return (1 - u) * (1 - v) * table[j, i] + u * (1 - v) * table[j, i + 1] + (1 - u) * v * table[j + 1, i] + u * v * table[j + 1, i + 1]


def with_the_table(case, rows):
    """The model with E from there: f without the compensation, and F0 (1/E - 1) times the lobe."""
    name, _, expression, settings, _, wanted = case
    plain = measure.evaluate(PROGRAM, expression.replace("+turquin", ""), settings, rows)
    lobe, own = plain, np.array(COLOR)
    if name.startswith("dielectric"):
        own = ((wanted["ior"] - 1) / (wanted["ior"] + 1))**2
        lobe = measure.evaluate(PROGRAM, expression.split("+")[0], ",".join(s for s in settings.split(",") if not s.startswith("kd")), rows)
    return plain + lobe * own * (1 / of_the_table(wanted["roughnessFactor"], np.cos(np.radians(rows[:, 2])))[:, None] - 1)


def check(right, what):
    global failures
    if not right:
        failures += 1
        print("failed:", what)


def controls_found(rows, target):
    """{control: value or values} that `fit --for` finds in what was rendered; no noise, so that every sample counts alike."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "rendered.csv")
        measure.write_csv(path, rows)
        done = subprocess.run([PROGRAM, "fit", path, "--for", target, "--model", "ggx/smith-separable+lambert", "--max-theta", "87", "--loss", "log",
                               "--cut-off", "0", "--json", "-"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        if not done.stdout:
            raise SystemExit(f"{target}: {done.stderr}")
        return {name: c["value"] for name, c in json.loads(done.stdout)["fits"][0]["renderer"]["controls"].items()}


def look_at(renderer, case, rows, tolerance, refit):
    """Values, and where they are all the model's the numbers that a fit to them finds."""
    name, _, expression, settings, target, wanted = case
    model = measure.evaluate(PROGRAM, expression, settings, rows)
    f = rows[:, 4:7]
    bright = model > 1e-3 * model.max()
    if renderer == "three-r170" and name.startswith("anisotropic"):  # it cuts G / (4 cos cos) of a stretched lobe at 1
        cosines = np.cos(np.radians(rows[:, 0])) * np.cos(np.radians(rows[:, 2]))
        bright &= (measure.evaluate(PROGRAM, expression, settings, rows, "g")[:, :1] < 4 * cosines[:, None] * 0.999)
    off = np.abs(f / np.where(bright, model, 1) - 1)
    print(f"{name:34} {len(rows):6} pairs, {int(bright.sum()):6} values, off by at most {off[bright].max():.2g}, "
          f"rms {np.sqrt(np.mean(off[bright]**2)):.2g}")
    if renderer == "three-r187":
        # all of it is the table: with its E nothing is left, and it is constant beyond the centres of its outer texels
        table = with_the_table(case, rows)
        of_table = np.abs(f / np.where(bright, table, 1) - 1)[bright].max()
        print(f"{'':34} with E from its table at most {of_table:.2g}")
        check(of_table <= 1e-3, f"{name}: {of_table:.3g} of the value with E from the table, allowed 0.001")
        bright &= ((rows[:, 2] < np.degrees(np.arccos(1.5 / 16))) & (rows[:, 2] > np.degrees(np.arccos(15.5 / 16))))[:, None]
    off = off[bright]
    check(off.max() <= tolerance, f"{name}: {off.max():.3g} of the value, allowed {tolerance:g}")
    if not refit or (renderer == "three-r170" and name.startswith("anisotropic")):
        return
    found = controls_found(rows, target)
    for control, value in wanted.items():
        miss = np.max(np.abs(np.array(found[control]) - value))
        check(miss <= 5 * tolerance, f"{name}: {control} is {found[control]}, set was {value}")


def main():
    renderer, smoke = sys.argv[2], "smoke" in sys.argv[3:]
    side, lights, roughnesses = (16, [30], (0.4, )) if smoke else (40, LIGHTS, ROUGHNESSES)
    if renderer == "cycles":
        cases, tolerance = list(cycles_cases(roughnesses)), 1e-3
        rows = measure.cycles([dict(case[1], name=case[0]) for case in cases], side, lights)
    else:
        cases, tolerance = list(gltf_cases(renderer, roughnesses)), 1e-3 if renderer == "three-r170" else 5e-3
        rows = measure.three("three" if renderer == "three-r170" else renderer, renderer[-3:], {case[0]: case[1] for case in cases}, side, lights)
    for case in cases:
        look_at(renderer, case, rows[case[0]], tolerance, not smoke)
    print(f"{len(cases)} materials, {failures} failures")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
