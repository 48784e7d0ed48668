"""A comparison for a paper: which distribution and which masking do the data prefer, and is that more than noise?

The table goes into the text as LaTeX, the figures as PDF; what the data cannot tell apart is said."""

import facetfit

# Data to compare on: replace by facetfit.read("measured.csv").
surface = facetfit.Model("ggx/smith-height-correlated+lambert", alpha=0.4, f0=[0.9, 0.7, 0.4], kd=0.02)
data = facetfit.simulate(surface, "goniometer:7.5", relative=0.02, floor=1e-4, seed=11)


def progress(what, iteration, objective):
    if iteration is None and what:
        print(what)


comparison = facetfit.compare(
    data,
    ndf=["beckmann", "ggx", "student-t"],
    masking=["smith-separable", "smith-height-correlated", "v-cavity"],
    cross_validate=3,
    progress=progress,
)
print(comparison)

# The best, and what is as good: the test is of whole incidences (Vuong's, with the penalty of the parameters).
for fit in comparison.not_told_apart:
    print("not told apart:", fit.model.expression, f"alpha {fit.values['alpha_x']:.4f}")
assert "ggx" in comparison.best.model.expression or "student-t" in comparison.best.model.expression
assert all("beckmann" not in fit.model.expression for fit in comparison.not_told_apart)

table = comparison.to_pandas()
print(table[["model", "over_best", "vuong_z", "vuong_p", "told_apart"]].to_string(index=False))

with open("ranking.tex", "w") as file:
    file.write(comparison.table("latex"))
comparison.plot("forest", "forest.pdf", width=85)
comparison.plot("slice", "slices.pdf", width=170, incidence=[30, 60])
with open("comparison.html", "w") as file:
    file.write(comparison.html())

# How sure is the best one of its roughness? By a bootstrap, and by the profile of the objective.
expression = comparison.best.model.expression
for how in ({"bootstrap": 100, "seed": 1}, {"profile": True}):
    low, high = facetfit.fit(data, expression, **how).intervals["alpha_x"]
    print(f"alpha from {low:.4f} to {high:.4f} by {next(iter(how))}")
