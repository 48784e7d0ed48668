#!/usr/bin/env python3
"""make_merl.py FILE F0 m rho_d rho_d rho_d rho_s rho_s rho_s: a file in the layout of the MERL database, of the formula of Ngan, Durand and
Matusik 2005 with these numbers, one rho for each channel:

    rho_d / pi + rho_s / pi D F G / (n.l n.v),   D = exp(-tan^2 / m^2) / (m^2 cos^4),   F of Schlick, G of V-grooves

Ends with 77 without numpy.
"""
import sys

try:
    import numpy as np
except ImportError:
    sys.exit(77)


def main(argv):
    if len(argv) != 10:
        sys.exit(__doc__)
    f0, m, *rho = map(float, argv[2:])
    rho_d, rho_s = rho[:3], rho[3:]
    theta_h = np.radians((np.arange(90) + 0.5) ** 2 / 90)[:, None, None]
    theta_d = np.radians(np.arange(90) + 0.5)[None, :, None]
    phi_d = np.radians(np.arange(180) + 0.5)[None, None, :]
    # n.l and n.v are cos(theta_h) cos(theta_d) -+ sin(theta_h) sin(theta_d) cos(phi_d): the light is the half vector turned about itself
    middle, side = np.cos(theta_h) * np.cos(theta_d) + 0 * phi_d, np.sin(theta_h) * np.sin(theta_d) * np.cos(phi_d)
    nl, nv, nh, vh = middle - side, middle + side, np.cos(theta_h), np.cos(theta_d)
    valid = (nl > 0) & (nv > 0)
    nl, nv = np.where(valid, nl, 1), np.where(valid, nv, 1)
    d = np.exp(-np.tan(theta_h) ** 2 / m**2) / (m**2 * nh**4)
    f = f0 + (1 - f0) * (1 - vh) ** 5
    g = np.minimum(1, np.minimum(2 * nh * nv / vh, 2 * nh * nl / vh))
    lobe = d * f * g / (nl * nv)
    with open(argv[1], "wb") as out:
        np.array([90, 90, 180], "<i4").tofile(out)
        for diffuse, specular, scale in zip(rho_d, rho_s, (1500, 1500 / 1.15, 1500 / 1.66)):
            np.where(valid, (diffuse + specular * lobe) / np.pi * scale, -1).astype("<f8").tofile(out)


main(sys.argv)
