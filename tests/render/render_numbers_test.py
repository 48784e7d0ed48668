#!/usr/bin/env python3
"""The numbers of pictures of lit spheres against formulas of their own: GGX, Beckmann, Smith, Schlick, Lambert; Preetham's sky; curves of
tone; and layers, grids and differences against each other.

usage: render_numbers_test.py FACETFIT"""
import csv
import io
import json
import math
import os
import subprocess
import sys
import tempfile
try:
    import numpy as np
except ImportError:
    print("skipped: this needs python3-numpy")
    sys.exit(77)
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import pictures

program = os.path.abspath(sys.argv[1])
failures = checks = 0
rng = np.random.default_rng(int(os.environ.get("FF_TEST_SEED", "0")))


def check(good, what):
    global failures, checks
    checks += 1
    if not good:
        failures += 1
        if failures < 40:
            print("failed:", what)


def render(*words):
    """The rows of standard output as dictionaries, the image."""
    name = words[words.index("-o") + 1]
    done = subprocess.run([program, "render", *words], cwd=scratch, capture_output=True, text=True, check=False)
    check(done.returncode == 0, f"{' '.join(words)}: {done.stderr}")
    rows = [{k: float(v) for k, v in row.items()} for row in csv.DictReader(io.StringIO(done.stdout))]
    return rows, (pictures.exr if name.endswith(".exr") else pictures.png)(os.path.join(scratch, name))


# ---- the surface --------------------------------------------------------------------------------------------------------------


def dot(a, b):
    return (a * b).sum(-1)


def unit(v):
    return v / np.sqrt(dot(v, v))[..., None]


def lobe(kind, wi, wo, ax, ay, f0):
    """F D G / (4 cos cos), Smith's height-correlated masking; kind "ggx" or "beckmann"."""
    h = unit(wi + wo)
    tan2 = (h[..., 0] / ax) ** 2 + (h[..., 1] / ay) ** 2
    c = h[..., 2]

    def smith(w):
        a2 = w[..., 2] ** 2 / ((ax * w[..., 0]) ** 2 + (ay * w[..., 1]) ** 2 + 1e-300)
        if kind == "ggx":
            return (np.sqrt(1 + 1 / a2) - 1) / 2
        a = np.sqrt(a2)
        erf = np.vectorize(math.erf)(np.minimum(a, 30))
        return (erf - 1) / 2 + np.exp(-np.minimum(a2, 700)) / (2 * a * math.sqrt(math.pi))

    if kind == "ggx":
        D = 1 / (math.pi * ax * ay * (tan2 + c * c) ** 2)
    else:
        D = np.exp(-tan2 / c**2) / (math.pi * ax * ay * c**4)
    F = f0 + (1 - f0) * (1 - dot(wi, h)) ** 5
    return F * D / (1 + smith(wi) + smith(wo)) / (4 * wi[..., 2] * wo[..., 2])


def model(kind, wi, wo, ax, ay, f0, kd):
    up = (wi[..., 2] > 1e-8) & (wo[..., 2] > 1e-8)
    with np.errstate(all="ignore"):
        f = np.stack([(lobe(kind, wi, wo, ax, ay, f) if kind else 0 * wi[..., 0]) + k / math.pi for f, k in zip(f0, kd)], -1)
    return np.where(up[..., None], f * np.maximum(wi[..., 2], 0)[..., None], 0)


def sphere(x, y, perspective):
    """Normals and views in front of places of the picture; whether the sphere is there."""
    if perspective == 0:
        there = x * x + y * y < 1
        n = np.stack([x, y, np.sqrt(np.maximum(1 - x * x - y * y, 1e-30))], -1)
        return n, np.broadcast_to([0.0, 0, 1], n.shape), there
    half = math.radians(perspective) / 2
    eye = np.array([0, 0, 1 / math.sin(half)])
    ray = unit(np.stack([x * math.tan(half), y * math.tan(half), -np.ones_like(x)], -1))
    b = dot(ray, eye)
    under = b * b - (dot(eye, eye) - 1)
    return eye + (-b - np.sqrt(np.maximum(under, 0)))[..., None] * ray, -ray, under > 0


def local(n, v):
    """v in the frame (parallel, meridian, normal)."""
    t = unit(np.cross([0.0, 1, 0], n))
    b = np.cross(n, t)
    return np.stack([dot(t, v), dot(b, v), dot(n, v)], -1)


def lit(size, pixels, lights, perspective, *surface):
    """Radiance of pixels [k] (row, column): the mean of 4 x 4 points, each under all lights of irradiance pi."""
    row, column = np.divmod(pixels, size)
    sub = (np.arange(4) + 0.5) / 4
    x = 2 * (column[:, None, None] + sub[None, None, :] + 0 * sub[None, :, None]) / size - 1
    y = 1 - 2 * (row[:, None, None] + sub[None, :, None] + 0 * sub[None, None, :]) / size
    n, view, there = sphere(x, y, perspective)
    total = 0
    for light in lights:
        total = total + model(surface[0], local(n, unit(np.broadcast_to(light, n.shape))), local(n, view), *surface[1:]) * math.pi
    return (total * there[..., None]).mean((1, 2)), there.mean((1, 2))


def direction(theta, phi):
    t, p = math.radians(theta), math.radians(phi)
    return np.array([math.sin(t) * math.cos(p), math.sin(t) * math.sin(p), math.cos(t)])


def pixels_are_formulas():
    size = 97
    scenes = [("ggx", 0.3, 0.3, (0.04, 0.5, 0.95), (0.5, 0.1, 0), [(45, 135)], 0), ("ggx", 0.05, 0.6, (0.9, 0.6, 0.3), (0, 0, 0), [(70, 10), (20, -90)], 0),
              ("beckmann", 0.4, 0.15, (0.2, 0.3, 0.4), (0.3, 0.2, 0.1), [(110, 60), (0, 0), (35, 200)], 40), ("ggx", 0.9, 0.2, (1, 0.5, 0), (0, 0.5, 1), [(150, 0), (60, 90)], 120),
              (None, 1, 1, (0, 0, 0), (1, 0.5, 0.25), [(80, 30)], 0)]
    for kind, ax, ay, f0, kd, angles, perspective in scenes:
        join = lambda v: ":".join(map(str, v))
        words = [f"{kind}+lambert", "--set", f"alpha_x={ax},alpha_y={ay},f0={join(f0)},kd={join(kd)}"] if kind else ["lambert", "--set", f"kd={join(kd)}"]
        for angle in angles:
            words += ["--light", f"{angle[0]},{angle[1]}"]
        _, image = render(*words, "--size", str(size), "--perspective", str(perspective), "-o", "a.exr")
        pixels = rng.choice(size * size, 1000, replace=False)
        want, coverage = lit(size, pixels, [direction(*a) for a in angles], perspective, kind, ax, ay, f0, kd)
        got = np.stack([image[c].ravel()[pixels] for c in "RGB"], -1)
        off = np.abs(got - want) / np.maximum(want, 1e-6)
        print(f"{kind or 'lambert'}: 1000 pixels within {off.max():.1e}")
        check((off < 1e-4).all(), f"{words}: pixel {pixels[off.max(1).argmax()]} is off by {off.max()}")
        check((np.abs(image["A"].ravel()[pixels] - coverage) < 1e-6).all(), f"{words}: coverage")
        check((want > 0.01).sum() > 300, f"{words}: the scene is dark")
    _, one = render("ggx", "--light", "0.5,-0.5,0.70710678118654752", "--size", "20", "-o", "a.exr")
    _, other = render("ggx", "--light", "45,-45", "--size", "20", "-o", "b.exr")
    check(np.abs(one["R"] - other["R"]).max() < 1e-6, "a light by its angles is another than by its coordinates")
    _, usual = render("ggx", "--size", "20", "-o", "a.exr")
    _, said = render("ggx", "--light", "45,135", "--size", "20", "-o", "b.exr")
    check((usual["R"] == said["R"]).all(), "the usual light")


# ---- environments -------------------------------------------------------------------------------------------------------------


def preetham(w, elevation, T):
    """Preetham, Shirley and Smits 1999, appendix A.2: linear Rec. 709 in kcd/m^2 of directions w [...][3], y up."""
    t_s = math.pi / 2 - elevation
    sun = np.array([-math.sin(t_s), math.cos(t_s) * math.sqrt(2), math.sin(t_s)]) / math.sqrt(2)
    A = {"Y": [(0.1787, -1.4630), (-0.3554, 0.4275), (-0.0227, 5.3251), (0.1206, -2.5771), (-0.0670, 0.3703)],
         "x": [(-0.0193, -0.2592), (-0.0665, 0.0008), (-0.0004, 0.2125), (-0.0641, -0.8989), (-0.0033, 0.0452)],
         "y": [(-0.0167, -0.2608), (-0.0950, 0.0092), (-0.0079, 0.2102), (-0.0441, -1.6537), (-0.0109, 0.0529)]}
    powers = np.array([t_s**3, t_s**2, t_s, 1])
    zenith = {"Y": (4.0453 * T - 4.9710) * math.tan((4 / 9 - T / 120) * (math.pi - 2 * t_s)) - 0.2155 * T + 2.4192,
              "x": np.array([T * T, T, 1]) @ np.array([[0.00166, -0.00375, 0.00209, 0], [-0.02903, 0.06377, -0.03202, 0.00394], [0.11693, -0.21196, 0.06052, 0.25886]]) @ powers,
              "y": np.array([T * T, T, 1]) @ np.array([[0.00275, -0.00610, 0.00317, 0], [-0.04214, 0.08970, -0.04153, 0.00516], [0.15346, -0.26756, 0.06670, 0.26688]]) @ powers}
    gamma = np.arccos(np.clip(w @ sun, -1, 1))
    cos_t = np.maximum(w[..., 1], 1e-4)
    q = {}
    for name, lines in A.items():
        a, b, c, d, e = (m * T + k for m, k in lines)
        perez = lambda ct, g: (1 + a * np.exp(b / ct)) * (1 + c * np.exp(d * g) + e * np.cos(g) ** 2)
        q[name] = zenith[name] * perez(cos_t, gamma) / perez(1, t_s)
    X, Z = q["x"] / q["y"] * q["Y"], (1 - q["x"] - q["y"]) / q["y"] * q["Y"]
    rgb = np.stack([X, q["Y"], Z], -1) @ np.array([[3.2404542, -1.5371385, -0.4985314], [-0.9692660, 1.8760108, 0.0415560], [0.0556434, -0.2040259, 1.0572252]]).T
    return np.maximum(rgb, 0)


def directions(rows, columns):
    """w [rows][columns][3] and solid angles, by latitude and longitude as maps have them."""
    edge = np.pi * np.arange(rows + 1) / rows
    t, a = ((edge[1:] + edge[:-1]) / 2)[:, None], (2 * np.pi * ((np.arange(columns) + 0.5) / columns - 0.5))[None]
    w = np.stack([np.sin(t) * np.sin(a), np.cos(t) + 0 * a, -np.sin(t) * np.cos(a)], -1)
    return w, (2 * np.pi / columns * (np.cos(edge[:-1]) - np.cos(edge[1:])))[:, None]


def against_quadrature(words, w, omega, L, what, floor):
    """A sphere of lambert and rough ggx; floor: of the relative deviation, what the map's pixels leave."""
    size = 32
    rows, image = render("ggx+lambert", "--set", "alpha=0.5,f0=0.3,kd=0.5", *words, "--size", str(size), "--samples", "4096", "-o", "a.exr")
    error = rows[0]["error"]
    worst = 0
    for k in range(0, size * size, 37):
        row, column = divmod(k, size)
        x, y = (2 * column + 1) / size - 1, 1 - (2 * row + 1) / size
        if x * x + y * y > 0.8:
            continue
        total = 0
        for q in range(9):  # of the pixel's area
            px, py = x + (q % 3 - 1) * 2 / 3 / size, y + (q // 3 - 1) * 2 / 3 / size
            n, view, _ = sphere(np.array(px), np.array(py), 0)
            f = model("ggx", local(n, w), np.broadcast_to(local(n, view), w.shape), 0.5, 0.5, (0.3,) * 3, (0.5,) * 3)
            total = total + (f * L * omega[..., None]).sum((0, 1)) / 9
        for c, name in enumerate("RGB"):
            off = abs(image[name][row, column] - total[c])
            worst = max(worst, off / total[c])
            check(off < 6 * error + floor * total[c], f"{what}, pixel {k}, {name}: {image[name][row, column]}, by quadrature {total[c]}, error {error}")
    print(f"{what}: within {worst:.1e} of quadrature, error {error:.1e}")


def in_a_mirror(words, radiance, what):
    """A nearly smooth conductor that reflects all shows the sky itself: pixels are means of what is in the mirror direction."""
    size = 64
    rows, image = render("ggx", "--set", "alpha=0.01,f0=1", *words, "--size", str(size), "--samples", "1024", "-o", "a.exr")
    sub = (np.arange(6) + 0.5) / 6
    row, column = np.divmod(np.arange(0, size * size, 7), size)
    x = 2 * (column[:, None, None] + sub[None, None, :] + 0 * sub[None, :, None]) / size - 1
    y = 1 - 2 * (row[:, None, None] + sub[None, :, None] + 0 * sub[None, None, :]) / size
    n, view, _ = sphere(x, y, 0)
    towards = 2 * dot(n, view)[..., None] * n - view
    looked_at = (x * x + y * y).max((1, 2)) < 0.9
    looked_at &= np.abs(towards[..., 1]).min((1, 2)) > 0.1  # not across the horizon
    want = radiance(towards).mean((1, 2))
    got = np.stack([image[c].ravel()[np.arange(0, size * size, 7)] for c in "RGB"], -1)
    off = np.abs(got - want)[looked_at]
    median = np.median(off / want[looked_at])
    print(f"{what} in a mirror: median deviation {median:.1e}, 95 % within {np.quantile(off / want[looked_at], 0.95):.1e}")
    check(looked_at.sum() > 150 and median < 0.004 and (off < 0.02 * want[looked_at] + 6 * rows[0]["error"]).all(), f"{what} in a mirror: {median}")


def the_sky_is_preethams():
    w, omega = directions(180, 360)
    for elevation, T, ground in ((35, 3, 0.2), (10, 6, 0.5)):
        L = preetham(w, math.radians(elevation), T)
        E = (L * np.maximum(w[..., 1:2], 0) * omega[..., None] * (w[..., 1:2] > 0)).sum((0, 1))
        scale = math.pi / (E @ [0.2126, 0.7152, 0.0722])
        L = np.where(w[..., 1:2] > 0, L, ground / math.pi * E) * scale
        words = ["--environment", f"sky:{elevation}:{T}:{ground}"]
        against_quadrature(words if elevation != 35 else ["--environment", "sky"], w, omega, L, f"sky {elevation}, {T}", 0.02)
        in_a_mirror(words, lambda d: np.where(d[..., 1:2] > 0, preetham(d, math.radians(elevation), T), ground / math.pi * E) * scale, f"sky {elevation}, {T}")
        turned = directions(180, 360)[0]
        angle = math.radians(70)  # the sky turned counter-clockwise: what was at w is at w turned
        back = np.stack([turned[..., 0] * math.cos(angle) - turned[..., 2] * math.sin(angle), turned[..., 1], turned[..., 0] * math.sin(angle) + turned[..., 2] * math.cos(angle)], -1)
        L = preetham(back, math.radians(elevation), T)
        L = np.where(back[..., 1:2] > 0, L, ground / math.pi * E) * scale
        against_quadrature(words + ["--turn", "70"], w, omega, L, f"sky {elevation}, turned", 0.02)


def maps_are_read():
    rows, columns = 64, 128
    w, omega = directions(rows, columns)
    L = 0.3 + 3 * np.exp(8 * (w @ np.array([[0.6, -0.3, 0.0], [0.48, 0.9, 0.6], [0.64, 0.3, 0.8]]) - 1))
    exponent = np.ceil(np.log2(L.max(-1) * 1.01)).astype(int)
    mantissa = np.floor(L * 256 / 2.0 ** exponent[..., None])
    L = (mantissa + 0.5) / 256 * 2.0 ** exponent[..., None]
    with open(os.path.join(scratch, "map.hdr"), "wb") as f:
        f.write(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n" % (rows, columns))
        f.write(np.concatenate([mantissa, exponent[..., None] + 128], -1).astype(np.uint8).tobytes())
    done = subprocess.run([program, "render", "lambert", "--environment", "map.hdr", "--size", "2", "-o", "m.png"], cwd=scratch, capture_output=True, text=True, check=False)
    if "need the module" in done.stderr or "reads no images" in done.stderr:
        print("maps: not looked at, for images are not read here")
        return False
    against_quadrature(["--environment", "map.hdr"], w, omega, L, "map", 0.01)
    return True


# ---- what is shown ------------------------------------------------------------------------------------------------------------


def srgb(t):
    return np.where(t <= 0.0031308, 12.92 * t, 1.055 * np.maximum(t, 1e-9) ** (1 / 2.4) - 0.055)


def tones_are_curves():
    words = ["ggx+lambert", "--set", "alpha=0.3,f0=0.1:0.5:0.9,kd=0.6:0.3:0.1", "--size", "48"]
    _, linear = render(*words, "-o", "a.exr")
    L, A = np.stack([linear[c] for c in "RGB"], -1), linear["A"][..., None]
    curves = {"srgb": lambda e: srgb(np.clip(e, 0, 1)), "linear": lambda e: np.clip(e, 0, 1),
              "filmic": lambda e: srgb(np.clip(e * (2.51 * e + 0.03) / (e * (2.43 * e + 0.59) + 0.14), 0, 1))}
    for tone, curve in curves.items():
        for exposure in (-2, 0, 1.5):
            for background, ground in (("white", 1), ("black", 0)):
                _, image = render(*words, "--tone", tone, "--exposure", str(exposure), "--background", background, "-o", "a.png")
                with np.errstate(all="ignore"):
                    shown = np.where(A > 0, curve(L / A * 2.0**exposure), 0)
                off = np.abs(image - 255 * (A * shown + (1 - A) * ground))
                check(off.max() < 0.51, f"{tone}, {exposure}, {background}: off by {off.max()}")
            _, image = render(*words, "--tone", tone, "--exposure", str(exposure), "--background", "transparent", "-o", "a.png")
            check(image.shape[2] == 4 and np.abs(image[..., 3] - 255 * A[..., 0]).max() < 0.51, "transparency is coverage")
            check(np.abs((image[..., :3] - 255 * shown) * (A > 0)).max() < 0.51, f"{tone}, {exposure}, transparent")


def grids_and_layers_are_their_pictures():
    common = ["--size", "24", "--light", "30,60", "--environment", "sky", "--samples", "16"]
    _, grid = render("ggx+lambert", "--set", "kd=0.2", *common, "--across", "alpha={0.1,0.4,1}", "--down", "f0=0.04,0.9", "-o", "a.exr")
    for j, f0 in enumerate((0.04, 0.9)):
        for i, alpha in enumerate((0.1, 0.4, 1)):
            _, one = render("ggx+lambert", "--set", f"kd=0.2,alpha={alpha},f0={f0}", *common, "-o", "b.exr")
            for c in "RGBA":
                check((grid[c][24 * j:24 * j + 24, 24 * i:24 * i + 24] == one[c]).all(), f"picture {j}, {i} of the grid is another, {c}")
    with open(os.path.join(scratch, "paint.csv"), "w", encoding="utf-8") as f:
        f.write(subprocess.run([program, "simulate", "ggx+lambert", "--set", "alpha=0.3,f0=0.3,kd=0.2:0.3:0.5", "--noise", "0.05", "-o", "-"], capture_output=True, text=True, check=True).stdout)
    subprocess.run([program, "fit", "paint.csv", "--json", "fit.json"], cwd=scratch, capture_output=True, check=True)
    rows, layers = render("paint.csv", "--from", "fit.json", *common, "-o", "a.exr")
    check(len(rows) == 2 and rows[0]["samples"] == 16 and 0 < rows[0]["error"] < 1, f"rows {rows}")
    check(sorted(layers) == sorted(f"{layer}.{c}" for layer in ("data", "model", "difference") for c in "RGBA"), f"channels {sorted(layers)}")
    for c in "RGB":
        check(np.abs(layers[f"difference.{c}"] - (layers[f"model.{c}"] - layers[f"data.{c}"])).max() < 1e-6, "difference is not model - data")
        check(0 < np.abs(layers[f"difference.{c}"]).mean() < 0.05 * layers[f"data.{c}"].mean(), "data and their model are not alike")
    _, alone = render("fit.json", *common, "-o", "b.exr")
    check((alone["G"] == layers["model.G"]).all(), "a result alone has another picture")
    _, shown = render("paint.csv", "--from", "fit.json", "--size", "32", "--light", "30,60", "--clip", "0.01", "--no-labels", "-o", "a.png")
    _, same = render("paint.csv", "--from", "fit.json", "--size", "32", "--light", "30,60", "-o", "b.exr")
    d = sum(same[f"difference.{c}"] for c in "RGB") / 3
    panel = shown[1:33, 1 + 2 * 33:1 + 2 * 33 + 32].astype(int)
    inside = same["difference.A"] == 1
    check((panel[inside & (d > 0.004)][:, 0] > panel[inside & (d > 0.004)][:, 2]).all(), "where the model is too bright is not orange")
    check((panel[inside & (d < -0.004)][:, 0] < panel[inside & (d < -0.004)][:, 2]).all(), "where it is too dark is not blue")
    check((inside & (np.abs(d) > 0.004)).sum() > 20, "there is nothing to tell apart")
    _, three = render("lambert", "ggx", "beckmann", "--size", "16", "-o", "a.exr")
    check(three["R"].shape == (16, 48), f"three models beside each other: {three['R'].shape}")
    _, differ = render("ggx", "beckmann", "--difference", "--size", "16", "-o", "a.exr")
    check("difference.R" in differ and np.abs(differ["difference.R"] - differ["second.R"] + differ["first.R"]).max() < 1e-6, "difference of two models")


def wavelengths_have_their_colours():
    """Channels from the blue to the red: measured, fitted and read back the surface is orange, and in any order of the columns."""
    values = subprocess.run([program, "simulate", "ggx+lambert", "--set", "alpha=0.4,f0=0.1:0.3:0.8,kd=0.05:0.2:0.5", "--grid", "goniometer:10", "-o", "-"],
                            capture_output=True, text=True, check=True).stdout.splitlines()
    rows = [line.split(",") for line in values if not line.startswith(("#", "theta"))]
    means = []
    for order, names in (((4, 5, 6), "f_465nm,f_525nm,f_630nm"), ((6, 4, 5), "f_630nm,f_465nm,f_525nm")):
        with open(os.path.join(scratch, "nm.csv"), "w", encoding="ascii") as f:
            f.write("# quantity: brdf\ntheta_i,phi_i,theta_o,phi_o," + names + "\n")
            f.writelines(",".join(row[:4] + [row[k] for k in order]) + "\n" for row in rows)
        subprocess.run([program, "fit", "nm.csv", "--json", "nm.json"], cwd=scratch, capture_output=True, check=True)
        for words in (("nm.csv",), ("nm.json",), ("nm.csv", "--from", "nm.json")):
            done, _ = render(*words, "--size", "16", "--light", "0,0", "-o", "a.exr")
            means += [[row[f"mean_{c}"] for c in "rgb"] for row in done]
    means = np.array(means)
    check((means[:, 0] > 1.2 * means[:, 1]).all() and (means[:, 1] > 1.2 * means[:, 2]).all(), f"the colours are not those of the wavelengths: {means}")
    check(np.abs(means / means[0] - 1).max() < 0.03, f"data, result and order of columns make other colours: {means}")


def rows_are_what_the_picture_has():
    done = subprocess.run([program, "render", "ggx+lambert", "--set", "kd=0.1:0.2:0.3", "--size", "40", "-o", "a.exr", "--json"], cwd=scratch, capture_output=True, text=True, check=True)
    said = json.loads(done.stdout)
    row = dict(zip(said["columns"], said["rows"][0]))
    image = pictures.exr(os.path.join(scratch, "a.exr"))
    for c in "rgb":
        mean = image[c.upper()].sum() / image["A"].sum()
        check(abs(row[f"mean_{c}"] - mean) < 1e-5 * mean, f"mean_{c}: {row[f'mean_{c}']}, of the image {mean}")
    check(row["error"] == 0 and row["samples"] == 0, "lights alone have no error")


with tempfile.TemporaryDirectory() as scratch:
    pixels_are_formulas()
    the_sky_is_preethams()
    with_maps = maps_are_read()
    tones_are_curves()
    grids_and_layers_are_their_pictures()
    wavelengths_have_their_colours()
    rows_are_what_the_picture_has()
print(f"{checks} checks, {failures} failures")
sys.exit(bool(failures) or checks < (400 if with_maps else 350))
