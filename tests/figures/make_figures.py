#!/usr/bin/python3
"""Curves of published figures, from the definitions in the papers and by brute quadrature: nothing of facetfit is used.

    /usr/bin/python3 tests/figures/make_figures.py          (numpy and scipy; a few minutes)

writes, beside itself,

    kelemen_figure_3.csv   directional albedo with F = 1: Kelemen and Szirmay-Kalos 2001, figure 3
    mikkelsen_figure_6.csv 1 - rho and the Fresnel transmittance: Mikkelsen 2009, figures 6c and 6d
    hammon_g2.csv          G2 of ggx by height, in product form, and in Hammon's approximations (GDC 2017)
    walter_g1.csv          G1 of Gaussian slopes and Walter's rational approximation of it, over a = 1 / (alpha tan theta)
    phong_g1.csv           G1 of phong and the same rational approximation of it

Albedos are integrals over the directions of light, with Gauss-Legendre points in angle and azimuth; the same with three quarters of
the points must agree. G1 is cos(theta) over the projected area of the visible facets, an integral over slopes by scipy.
"""
import pathlib

import numpy as np
from scipy import integrate

HERE = pathlib.Path(__file__).resolve().parent
THETAS = [0, 5, 10, 15, 20, 25, 30, 35, 40, 45, 50, 55, 60, 65, 70, 75, 80, 85]


def write(name, columns, rows, comment):
    with open(HERE / name, "w", encoding="ascii") as out:
        out.write(f"# {comment}\n# by make_figures.py\n{','.join(columns)}\n")
        for row in rows:
            out.write(",".join(f"{value:.8g}" for value in row) + "\n")


# ---- albedos -------------------------------------------------------------------------------------


def directional_albedo(brdf, theta_o, points):
    """integral of f cos(theta_i) over the hemisphere; brdf(iz, oz, hz, c) with c = wi.h."""
    x, w = np.polynomial.legendre.leggauss(points)
    theta, w_theta = (x + 1) * np.pi / 4, w * np.pi / 4
    phi, w_phi = (x + 1) * np.pi / 2, w * np.pi / 2
    iz, si = np.cos(theta)[:, None], np.sin(theta)[:, None]
    oz, so = np.cos(theta_o), np.sin(theta_o)
    dot = iz * oz + si * so * np.cos(phi)[None, :]
    c = np.sqrt((1 + dot) / 2)  # |wi + wo| = 2 c
    hz = (iz + oz) / (2 * c)
    f = brdf(iz, oz, hz, c)
    return 2 * np.einsum("ij,i,j", f * iz * si, w_theta, w_phi)


def albedo(brdf, theta_deg, agree, points=1200):
    fine = directional_albedo(brdf, np.radians(theta_deg), points)
    coarse = directional_albedo(brdf, np.radians(theta_deg), 3 * points // 4)
    assert abs(fine - coarse) < agree, (theta_deg, fine, coarse)
    return fine


def v_cavity(iz, oz, hz, c):
    return np.minimum(1, np.minimum(2 * hz * iz / c, 2 * hz * oz / c))


# ---- Kelemen and Szirmay-Kalos -------------------------------------------------------------------


def kelemen():
    def ward(m):  # equation 4
        return lambda hz: np.exp((1 - 1 / hz**2) / m**2) / (np.pi * m**2 * hz**3)

    def phong(n):  # equation 5
        return lambda hz: (n + 1) / (2 * np.pi) * hz**n

    def beckmann(m):
        return lambda hz: np.exp((1 - 1 / hz**2) / m**2) / (np.pi * m**2 * hz**4)

    def new_brdf(density):  # equation 3 with F = 1: P_H / |wi + wo|^2
        return lambda iz, oz, hz, c: density(hz) / (4 * c**2)

    def cook_torrance(density):  # equation 1 with F = 1
        return lambda iz, oz, hz, c: density(hz) * v_cavity(iz, oz, hz, c) / (4 * iz * oz)

    rows = []
    for n, m in ((2, 0.8), (11, 0.4)):
        brdfs = (new_brdf(ward(m)), new_brdf(phong(n)), new_brdf(beckmann(m)), cook_torrance(beckmann(m)))
        rows += [[n, m, theta] + [albedo(f, theta, 2e-6) for f in brdfs] for theta in THETAS]
    write("kelemen_figure_3.csv", ["n", "m", "theta", "ward", "phong", "beckmann", "cook_torrance"], rows,
          "Kelemen and Szirmay-Kalos 2001, figure 3: directional albedo with F = 1 over the angle in degrees")


# ---- Mikkelsen -----------------------------------------------------------------------------------


def fresnel(index, c):
    """Unpolarised reflectance of a smooth surface of complex index eta + i k."""
    w = np.sqrt(index**2 - (1 - c**2) + 0j)
    rs, rp = (c - w) / (c + w), (index**2 * c - w) / (index**2 * c + w)
    return (abs(rs) ** 2 + abs(rp) ** 2) / 2


def mikkelsen():
    def brdf(index, kappa):  # equations 18, 25 and 29, D = p / hz
        scale = kappa / (2 * np.pi * -np.expm1(-kappa))
        return lambda iz, oz, hz, c: (
            scale * np.exp(kappa * (hz - 1)) / hz * fresnel(index, c) * v_cavity(iz, oz, hz, c) / (4 * iz * oz))

    rows = []
    for eta, k in ((1.329, 0), (0.769, 6.08)):  # methanol; aluminium at 500 nm
        for theta in THETAS:
            transmitted = 1 - fresnel(eta + 1j * k, np.cos(np.radians(theta)))
            reflected = [albedo(brdf(eta + 1j * k, kappa), theta, 2e-6) for kappa in (17, 1024)]
            rows.append([eta, k, theta, transmitted, 1 - reflected[0], 1 - reflected[1]])
    write("mikkelsen_figure_6.csv", ["eta", "k", "theta", "transmittance", "kappa_17", "kappa_1024"], rows,
          "Mikkelsen 2009, figures 6c (methanol) and 6d (aluminium): 1 - rho over the angle in degrees")


# ---- masking -------------------------------------------------------------------------------------


def g1(p22, mu):
    """1 / (1 + Lambda), Lambda = (1 / mu) times the mean of (slope - mu)+ along one direction (Heitz 2014, section 3)."""

    def beyond(y):  # integral over x > mu of (x - mu) P22(sqrt(x^2 + y^2))
        return integrate.quad(lambda x: x * p22(np.hypot(x + mu, y)), 0, np.inf, epsabs=1e-13, epsrel=1e-11, limit=400)[0]

    facets = 2 * integrate.quad(beyond, 0, np.inf, epsabs=1e-12, epsrel=1e-10, limit=400)[0]
    return 1 / (1 + facets / mu)


def walter(a):
    """Walter et al. 2007: G1 of Gaussian slopes as a rational function."""
    return (3.535 * a + 2.181 * a**2) / (1 + 2.276 * a + 2.577 * a**2) if a < 1.6 else 1


def hammon():
    alphas = [0.05, 0.1, 0.2, 0.35, 0.5, 0.7, 0.85, 1]
    cosines = [0.02, 0.06, 0.12, 0.2, 0.35, 0.5, 0.7, 0.85, 1]
    rows = []
    for alpha in alphas:

        def ggx(t, alpha=alpha):
            return alpha**2 / (np.pi * (alpha**2 + t**2) ** 2)

        exact = [1 if mu == 1 else g1(ggx, mu / np.sqrt(1 - mu**2)) for mu in cosines]
        for i, nl in enumerate(cosines):
            for j, nv in enumerate(cosines):
                by_height = 1 / (1 / exact[i] + 1 / exact[j] - 1)
                new = 2 * nl * nv / (2 * nl * nv * (1 - alpha) + (nl + nv) * alpha)
                product = 2 * nl / (nl * (2 - alpha) + alpha) * 2 * nv / (nv * (2 - alpha) + alpha)
                rows.append([alpha, nl, nv, by_height, exact[i] * exact[j], new, product])
    write("hammon_g2.csv", ["alpha", "nl", "nv", "correlated", "uncorrelated", "hammon", "hammon_product"], rows,
          "Hammon 2017: G2 of ggx over N.L and N.V, exact and approximate")


def rational():
    a = [0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1, 1.1, 1.2, 1.3, 1.4, 1.5, 1.599, 1.601, 1.7, 1.8, 2, 2.5, 3, 4]
    rows = [[x, g1(lambda t: np.exp(-(t**2)) / np.pi, x), walter(x)] for x in a]
    write("walter_g1.csv", ["a", "exact", "walter"], rows, "Walter et al. 2007, Heitz 2014 section 2: G1 of Gaussian slopes over a")
    rows = []
    for n in (1, 5, 20, 100):
        for theta in THETAS[1:] + [88]:
            mu = 1 / np.tan(np.radians(theta))
            exact = g1(lambda t: (n + 2) / (2 * np.pi) * (1 + t**2) ** (-n / 2 - 2), mu)
            rows.append([n, theta, exact, walter(np.sqrt(n / 2 + 1) * mu)])
    write("phong_g1.csv", ["n", "theta", "exact", "walter"], rows, "G1 of phong, and Walter's with a = sqrt(n/2 + 1) / tan(theta)")


if __name__ == "__main__":
    kelemen()
    mikkelsen()
    hammon()
    rational()
