"""Thirty-one channels from 400 to 700 nm: one shape for all, a spectrum of each reflectance with its errors, and its colour.

A reddish paint: the facets reflect alike at all wavelengths, what comes from underneath does not."""

import numpy as np

import facetfit

nm = np.arange(400, 701, 10)
kd = 0.05 + 0.4 / (1 + np.exp(-(nm - 590) / 15))
paint = facetfit.Model("ggx+lambert", alpha=0.35, f0=np.full(31, 0.045), kd=kd)

# A measurement of the paint: the directions of a goniometer, the values of the model with noise.
there = facetfit.simulate("lambert", "goniometer:15")
wi, wo = there.directions
f = paint(wi, wo) * (1 + 0.01 * np.random.default_rng(2).normal(size=(len(there), 31)))
data = facetfit.measurement(wi, wo, f, wavelengths=nm, isotropic=True)
print(data)
assert data.wavelengths[-1] == 700

fit = facetfit.fit(data, "ggx+lambert")
print(fit.outcome, "alpha", round(fit.values["alpha_x"], 4), "+-", round(fit.errors["alpha_x"], 5))

# A parameter of the channels is an array beside data.wavelengths; so are its error and its interval.
for k in range(0, 31, 6):
    print(f"{nm[k]} nm: kd {fit.values['kd'][k]:.4f} +- {fit.errors['kd'][k]:.4f}")
assert np.all(np.abs(fit.values["kd"] - kd) < 5 * fit.errors["kd"])

# How far the channels share their errors: names and a matrix, NaN where a correlation is not formed.
names, correlation = fit.correlation
print(len(names), "parameters have errors; of", names[0], "and", names[1], f"the correlation is {correlation[0, 1]:.2f}")

# The same measurement as linear sRGB, and the fit of that.
rgb = facetfit.fit(data.reduce("srgb"), "ggx+lambert")
print("kd in sRGB:", np.round(rgb.values["kd"], 3))
assert rgb.values["kd"][0] > 3 * rgb.values["kd"][1]

# With pandas, a row for each number.
table = fit.to_pandas()
table[table.name == "kd"][["channel", "value", "std_error", "low", "high"]].to_csv("kd.csv", index=False)
print(open("kd.csv").readline().strip())
