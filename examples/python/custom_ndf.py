"""A distribution of normals of your own, as a table: here one whose slopes fall off exponentially.

D(theta) at any scale is enough; Lambda, masking, samples and albedo follow from it, and alpha stretches it."""

import numpy as np

import facetfit

# D cos^4 is the density of slopes: exp(-sqrt(6) tan theta) has the mean square slope 1 (the tails of an isotropic exponential).
theta = np.linspace(0, np.radians(89.5), 600)
D = np.exp(-np.sqrt(6) * np.tan(theta)) / np.cos(theta) ** 4
table = facetfit.Profile(theta, D)

model = facetfit.Model("tabulated/smith-height-correlated/schlick+lambert", table=table, alpha=0.3, f0=0.6, kd=0.05)

# The library scales D so that the projected area is 1: the integral of D cos(theta) over the normals.
t = (np.arange(4000) + 0.5) * (np.pi / 2 / 4000)
normals = facetfit.directions(t)
unit = model.terms(normals, normals, alpha=1.0)["D"]
area = np.sum(unit * np.cos(t) * np.sin(t)) * 2 * np.pi * (np.pi / 2 / 4000)
print(f"projected area {area:.5f}")
assert abs(area - 1) < 2e-3

# It is sampled and integrated like any other: the mean of the weights is the albedo.
view = facetfit.directions(np.radians(50))
albedo, error = model.albedo(view)
samples = model.sample(np.tile(view, (40000, 1)), seed=5)
print(f"albedo {float(albedo):.4f}, by samples {samples.weight.mean():.4f}")
assert abs(samples.weight.mean() - float(albedo)) < 5 * samples.weight.std() / 200

# A surface of it, as it would be measured, and which model describes that: the table, or one with a formula?
data = facetfit.simulate(model, "goniometer:7.5", relative=0.02, seed=3)
comparison = facetfit.compare(data, [facetfit.Model("tabulated+lambert", table=table), "ggx+lambert", "beckmann+lambert"])
print(comparison.to_pandas()[["model", "over_best", "told_apart"]].to_string(index=False))
best = comparison.best
assert "tabulated" in best.model.expression
assert abs(best.values["alpha_x"] - 0.3) < 0.01

# Derivatives by its parameters are there too, as for a renderer that learns.
f, gradient = best.model.gradient(view, facetfit.directions(np.radians(35), np.pi))
print(f"f {float(f):.4f}, d f / d alpha_x {float(gradient['alpha_x']):.4f}")
