"""Pairs of directions that a renderer shows one of in each pixel: tilted facets seen along z, lit from one side.

The facets of a light are laid out on a square of SIDE by SIDE pixels, each with a normal and a tangent of its own; in the frame of the
facet light and view are a pair of directions. Half of the normals lie about the half vector, so that a narrow lobe is met."""
import numpy as np


def light(degrees):
    """From this far off the view, in the plane of x and z."""
    a = np.radians(degrees)
    return np.array([np.sin(a), 0.0, np.cos(a)])


def normals(side, degrees, width, seed):
    """[side * side, 3]: both light and view at least 3 degrees above the facet's horizon."""
    draw = np.random.default_rng([seed, int(1000 * degrees)])
    towards, view = light(degrees), np.array([0.0, 0.0, 1.0])
    half = (towards + view) / np.linalg.norm(towards + view)
    found = np.empty((0, 3))
    while len(found) < side * side:
        n = draw.normal(size=(4 * side * side, 3))
        n[::2] = half + width * n[::2]
        n /= np.linalg.norm(n, axis=1)[:, None]
        found = np.concatenate([found, n[(n @ towards > 0.05) & (n[:, 2] > 0.05)]])
    return found[: side * side]


def frames(n):
    """(tangents, bitangents): the x axis laid into the facet, or where that is nearly the normal the y axis."""
    axis = np.where(np.abs(n[:, :1]) < 0.9, np.array([[1.0, 0, 0]]), np.array([[0, 1.0, 0]]))
    t = axis - n * np.sum(axis * n, axis=1)[:, None]
    t /= np.linalg.norm(t, axis=1)[:, None]
    return t, np.cross(n, t)


def angles(n, degrees):
    """[len(n), 4] theta_i, phi_i, theta_o, phi_o in degrees."""
    t, b = frames(n)
    columns = []
    for w in (light(degrees), np.array([0.0, 0.0, 1.0])):
        x, y, z = t @ w, b @ w, n @ w
        columns += [np.degrees(np.arctan2(np.hypot(x, y), z)), np.degrees(np.arctan2(y, x))]
    return np.stack(columns, axis=1)
