"""A file in the format of the MERL database: looked at, fitted, drawn as the program draws it, and set in Blender.

Any file of the database does in the place of this one, which is made here: gold as a rough conductor."""

import numpy as np

import facetfit

gold = facetfit.Model("ggx/smith-height-correlated/schlick+lambert", alpha=0.12, f0=[1.0, 0.77, 0.34], kd=0.01)
facetfit.simulate(gold, "merl").write("gold.binary")

data = facetfit.read("gold.binary")
print(data, "format", data.format)

# The stored values are a view of 1.458 million samples, not a copy; times the scale of the channel they are in 1/sr.
print("stored", data.stored.shape, data.stored.dtype, "scales", [round(c.scale * 1500, 2) for c in data.channels], "/ 1500")
print("measured:", int(data.valid.sum()), "of", len(data))
assert not data.stored.flags.owndata

fit = facetfit.fit(data, "ggx+lambert", shape="isotropic", max_theta=75)
print(fit)
assert fit.converged
assert abs(fit.values["alpha_x"] - 0.12) < 1e-3
assert np.allclose(fit.values["f0"], [1.0, 0.77, 0.34], atol=5e-3)

# The directional albedo says whether the fit conserves energy.
view = facetfit.directions(np.radians([0, 30, 60, 80]))
albedo, error = fit.model.albedo(view)
for theta, row in zip((0, 30, 60, 80), albedo):
    print(f"reflects {np.round(row, 3)} at {theta} degrees")
assert np.all(albedo < 1.01) and np.all(error < 1e-3)

# A figure of the program, and what to set in a renderer.
fit.plot("slice", "gold.svg", incidence=[30, 60])
made = fit.export("blender", "gold.py")
for name, value in made.about["controls"].items():
    print(name, value)
print("lost on the way:", [lost["what"] for lost in made.about["lost"]] or "nothing")
