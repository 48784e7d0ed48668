#!/usr/bin/env python3
"""terms_test.py PROGRAM: values of the terms that renderers have, against formulas and integrals that are written here once more."""
import math
import os
import subprocess
import sys

import numpy as np

PROGRAM = os.path.abspath(sys.argv[1])
failures = 0
draw = np.random.default_rng(7)
N = 400
angles = np.stack([np.degrees(np.arccos(draw.uniform(0.1, 1, N))), draw.uniform(0, 360, N), np.degrees(np.arccos(draw.uniform(0.1, 1, N))),
                   draw.uniform(0, 360, N)], axis=1)


def unit(theta, phi):
    t, p = np.radians(theta), np.radians(phi)
    return np.stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)], axis=-1)


wi, wo = unit(angles[:, 0], angles[:, 1]), unit(angles[:, 2], angles[:, 3])
h = (wi + wo) / np.linalg.norm(wi + wo, axis=1)[:, None]
c = np.sum(wi * h, axis=1)
iz, oz, hz = wi[:, 2], wo[:, 2], h[:, 2]


def of_program(expression, settings):
    table = "theta_i,phi_i,theta_o,phi_o\n" + "".join(",".join("%.17g" % x for x in row) + "\n" for row in angles)
    done = subprocess.run([PROGRAM, "eval", expression, "--set", settings], input=table, stdout=subprocess.PIPE, text=True, check=True)
    return np.array([float(line.split(",")[4]) for line in done.stdout.splitlines()[1:]])


def compare(expression, settings, wanted, tolerance=1e-11):
    global failures
    found = of_program(expression, settings)
    off = np.max(np.abs(found - wanted) / np.abs(wanted))
    print(f"{expression} {settings}: off by at most {off:.2g}")
    if not off < tolerance:
        failures += 1
        print(f"failed: {expression} {settings}: {off:.3g}, allowed {tolerance:g}")


def ggx(alpha):
    return alpha**2 / (math.pi * (1 + (alpha**2 - 1) * hz**2)**2)


def hidden(z, alpha):
    return (np.sqrt(1 + alpha**2 * (1 / z**2 - 1)) - 1) / 2


def separable(alpha):
    return 1 / ((1 + hidden(iz, alpha)) * (1 + hidden(oz, alpha)))


def correlated(alpha):
    return 1 / (1 + hidden(iz, alpha) + hidden(oz, alpha))


def dielectric(eta, cosine):
    t = np.sqrt(1 - (1 - cosine**2) / eta**2)
    return (((cosine - eta * t) / (cosine + eta * t))**2 + ((eta * cosine - t) / (eta * cosine + t))**2) / 2


def albedo(alpha, mu, fresnel=lambda x: 1.0):
    """Directional albedo of ggx with the height-correlated masking, by the integral over half vectors: Gauss-Legendre in the angle whose
    tangent is alpha tan, and in the azimuth."""
    x, wx = np.polynomial.legendre.leggauss(400)
    total = 0.0
    side = math.sqrt(1 - mu**2)
    a, wa = (x + 1) / 2 * math.pi / 2, wx * math.pi / 4
    tangent = alpha * np.tan(a)
    for phi, w in zip((x + 1) / 2 * math.pi, wx * math.pi / 2):
        cos = 1 / np.sqrt(1 + tangent**2)
        sin = tangent * cos
        d = alpha**2 / (math.pi * (1 + (alpha**2 - 1) * cos**2)**2)
        oh = side * sin * np.cos(phi) + mu * cos
        lz = 2 * oh * cos - mu
        good = (lz > 1e-12) & (oh > 0)
        g = np.zeros_like(lz)
        g[good] = 1 / (1 + hidden(lz[good], alpha) + hidden(mu, alpha))
        # d omega of h = sin d theta; theta = atan(alpha tan a)
        jacobian = sin * alpha / np.cos(a)**2 * cos**2
        value = np.where(good, d * g * fresnel(np.where(oh > 0, oh, 1)) * oh / mu * jacobian, 0)
        total += 2 * w * np.sum(wa * value)
    return total


def main():
    alpha, kd = 0.3, 0.4
    schlick = lambda f0, x=c: f0 + (1 - f0) * (1 - x)**5
    karis = lambda f0, x=c: f0 + (1 - f0) * 2**((-5.55473 * x - 6.98316) * x)
    lobe = ggx(alpha) / (4 * iz * oz)
    for eta in (1.2, 1.5, 1.7):
        r = ((eta - 1) / (eta + 1))**2
        rise = (dielectric(eta, c) - r) / (1 - r)
        compare("ggx/smith-separable/cycles", f"alpha=0.3,f0=0.6,eta={eta}", lobe * separable(alpha) * (0.6 * (1 - rise) + rise))
    compare("ggx/smith-height-correlated/schlick-karis", "alpha=0.3,f0=0.2", lobe * correlated(alpha) * karis(0.2))
    compare("ggx/smith-height-correlated/schlick+fresnel-coupled", "alpha=0.3,f0=0.04,kd=0.4",
            lobe * correlated(alpha) * schlick(0.04) + kd / math.pi * (1 - schlick(0.04)))
    a = 0.05  # of the coat
    d = (a**2 - 1) / (math.pi * math.log(a**2) * (1 + (a**2 - 1) * hz**2))
    compare("gtr/disney-clearcoat/schlick", "alpha=0.05,gamma=1,f0=0.04,ks=0.2", 0.2 * d * separable(0.25) * schlick(0.04) / (4 * iz * oz), 1e-9)
    for alpha in (0.2, 0.7):
        lobe = ggx(alpha) * correlated(alpha) / (4 * iz * oz)
        E = np.array([albedo(alpha, mu) for mu in oz[:40]])
        A = np.array([albedo(alpha, mu, lambda x: schlick(0.3, x)) for mu in oz[:40]])
        global angles
        kept, angles = angles, angles[:40]
        compare("ggx/smith-height-correlated/schlick+turquin", f"alpha={alpha},f0=0.3", (lobe * schlick(0.3))[:40] * (1 + 0.3 * (1 / E - 1)), 1e-6)
        compare("ggx/smith-height-correlated/schlick+albedo-scaled", f"alpha={alpha},f0=0.3,kd=0.4", (lobe * schlick(0.3))[:40] + kd / math.pi * (1 - A), 1e-6)
        angles = kept
    print(f"{failures} failures")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
