"""Numbers of your own: directions and values in numpy arrays, with what is known of their errors.

A goniometer measured three incidences in the plane of incidence. Its detector errs by 2 % and never by less than 0.001 / sr."""

import numpy as np

import facetfit

# One row a sample: polar angle of the light, of the detector (negative towards the light), and the BRDF in 1/sr.
theta_i = np.repeat(np.radians([15.0, 40.0, 65.0]), 33)
theta_o = np.tile(np.radians(np.linspace(-80, 80, 33)), 3)

wi = facetfit.directions(theta_i, 0)
wo = facetfit.directions(np.abs(theta_o), np.where(theta_o < 0, 0, np.pi))

# Here stand your values; these are of a rough dielectric, with noise.
truth = facetfit.Model("ggx+lambert", alpha=0.25, f0=0.05, kd=0.2)
random = np.random.default_rng(1)
f = truth(wi, wo) * (1 + 0.02 * random.normal(size=len(wi))) + 0.001 * random.normal(size=len(wi))

data = facetfit.measurement(wi, wo, f, isotropic=True)
print(data, "light at", np.degrees(np.unique(theta_i)).round(), "degrees")

noise = facetfit.Noise(relative=0.02, floor=0.001)
fit = facetfit.fit(data, "ggx+lambert", noise=noise)
print(fit)
for name in ("alpha_x", "f0", "kd"):
    low, high = fit.intervals[name]
    print(f"{name}: {fit.values[name]:.4f} +- {fit.errors[name]:.4f}, 95 % from {low:.4f} to {high:.4f}")

# Five standard errors are more than chance does.
for name, true in (("alpha_x", 0.25), ("f0", 0.05), ("kd", 0.2)):
    assert abs(fit.values[name] - true) < 5 * fit.errors[name], name

# Residuals are arrays beside the samples that were used; the model is a function.
residuals = fit.residuals
worst = residuals.samples[np.argmax(np.abs(residuals.model - residuals.data))]
print("furthest off at theta_o", np.degrees(theta_o[worst]).round(1), "degrees")
assert np.allclose(fit.model(wi, wo)[residuals.samples], residuals.model[:, 0])

for warning in fit.warnings:
    print(warning.severity, warning.code, warning.text)
