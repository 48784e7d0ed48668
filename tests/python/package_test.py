#!/usr/bin/env python3
"""package_test.py BITS PROGRAM: the Python package against the library and the program, to the bit; views, errors, threads, forms."""
import gc
import json
import os
import subprocess
import sys
import tempfile
import threading
import time
import unittest

try:
    import numpy as np
    import facetfit
except ImportError as missing:
    print("skipped: " + str(missing))
    sys.exit(0)

BITS, PROGRAM = sys.argv.pop(1), sys.argv.pop(1)
TRUE = {"alpha": 0.3, "f0": [0.05, 0.06, 0.04], "kd": [0.3, 0.2, 0.1]}


def directions(n, seed=1):
    """Random pairs above the horizon, some of them below."""
    random = np.random.default_rng(seed)
    z = random.uniform(-0.1, 1, (2, n))
    phi = random.uniform(0, 2 * np.pi, (2, n))
    r = np.sqrt(1 - np.minimum(z, 1) ** 2)
    w = np.stack([r * np.cos(phi), r * np.sin(phi), z], axis=-1)
    return w[0], w[1]


def paint(**options):
    return facetfit.simulate(facetfit.Model("ggx+lambert", **TRUE), "goniometer:10", relative=0.02, seed=4, **options)


def run(*words):
    return subprocess.run([PROGRAM, *words], capture_output=True, text=True, check=True).stdout


def without_times(document):
    """A document of fits, but for what says when and how it was made."""
    if isinstance(document, dict):
        return {
            k: without_times(v) for k, v in document.items() if k not in ("time_s", "command", "seconds", "path", "format", "notes")
        }
    if not isinstance(document, list):
        return document
    # What is to be tried next is a command line, which a program in Python has not got.
    return [without_times(v) for v in document if not (isinstance(v, dict) and v.get("code") in ("next", "look"))]


class Models(unittest.TestCase):
    CASES = [
        ("ggx+lambert", 1, {"alpha": 0.3}),
        ("ggx+lambert", 3, TRUE),
        ("beckmann/v-cavity/cook-torrance+oren-nayar", 1, {}),
        ("student-t+kulla-conty", 1, {}),
        ("ggx+beckmann/smith-separable/shared+lambert", 2, {"lobe2.alpha_x": 0.1, "f0": [0.2, 0.3]}),
        ("abc+lambert", 1, {}),
    ]

    def test_bits(self):
        """numpy and C agree to the bit, in values and in derivatives."""
        wi, wo = directions(1000)
        for expression, channels, said in self.CASES:
            try:
                model = facetfit.Model(expression, **said)
            except facetfit.ArgumentError:
                self.assertIn("cook-torrance", expression)
                continue
            words = [f"{k}=" + ":".join(repr(float(x)) for x in np.atleast_1d(v)) for k, v in said.items()]
            planes = np.concatenate([wi.T, wo.T]).tobytes()
            out = subprocess.run(
                [BITS, expression, str(channels), "1000", *words], input=planes, capture_output=True, check=True
            ).stdout
            out = np.frombuffer(out)
            parameters = model.parameters
            f, df = out[: channels * 1000].reshape(channels, 1000), out[channels * 1000 :].reshape(channels, len(parameters), 1000)
            own, gradient = model.gradient(wi, wo)
            self.assertEqual(model(wi, wo).tobytes(), own.tobytes())
            self.assertEqual(own.reshape(1000, -1).T.tobytes(), f.tobytes(), expression)
            for k, p in enumerate(parameters):
                self.assertEqual(gradient[p.name].reshape(1000, -1).T.tobytes(), df[:, k].tobytes(), f"{expression} {p.name}")
            self.assertGreater(np.count_nonzero(f), 500)

    def test_gradient_is_derivative(self):
        wi, wo = directions(200, 2)
        wi[:, 2], wo[:, 2] = np.abs(wi[:, 2]), np.abs(wo[:, 2])
        model = facetfit.Model("ggx+lambert", **TRUE)
        _, gradient = model.gradient(wi, wo)
        step = 1e-6
        by_hand = (model(wi, wo, alpha_x=0.3 + step) - model(wi, wo, alpha_x=0.3 - step)) / (2 * step)
        np.testing.assert_allclose(gradient["alpha_x"], by_hand, rtol=1e-6, atol=1e-8)
        by_hand = (model(wi, wo, kd=np.add(TRUE["kd"], step)) - model(wi, wo, kd=np.subtract(TRUE["kd"], step))) / (2 * step)
        np.testing.assert_allclose(gradient["kd"], by_hand, rtol=1e-6, atol=1e-8)

    def test_shapes(self):
        model, three = facetfit.Model("ggx+lambert"), facetfit.Model("ggx+lambert", **TRUE)
        w = facetfit.directions(np.full((4, 5), 0.5), 0.3)
        one = facetfit.directions(0.2, 3)
        self.assertEqual(w.shape, (4, 5, 3))
        for a, b, shape in ((w, w, (4, 5)), (w, one, (4, 5)), (one, w, (4, 5)), (one, one, ())):
            self.assertEqual(model(a, b).shape, shape)
            self.assertEqual(three(a, b).shape, shape + (3,))
            self.assertEqual(three.gradient(a, b)[1]["f0"].shape, shape + (3,))
        self.assertEqual(model(np.empty((0, 3)), np.empty((0, 3))).shape, (0,))
        self.assertEqual(float(model(list(one), tuple(one))), float(model(one, one)))
        for bad in (np.ones((3, 2)), np.ones(4), 1.0):
            self.assertRaises(ValueError, model, bad, bad)
        self.assertRaises(ValueError, model, np.ones((4, 3)), np.ones((5, 3)))
        self.assertRaises(ValueError, three, one, one, f0=[1, 2])

    def test_values(self):
        model = facetfit.Model("ggx+lambert", alpha=0.25, f0=[0.1, 0.2])
        self.assertEqual(model.channels, 2)
        self.assertEqual((model.values["alpha_x"], model.values["alpha_y"]), (0.25, 0.25))
        other = model.replace(alpha_y=0.5)
        self.assertEqual((model.values["alpha_y"], other.values["alpha_y"], list(other.values["f0"])), (0.25, 0.5, [0.1, 0.2]))
        self.assertEqual(facetfit.Model(model.expression, **{"alpha_x": 0.1}).expression, model.expression)
        for bad in ({"alpha": -1}, {"alpha": float("nan")}, {"alphas": 1}, {"lobe2.alpha": 1}):
            with self.assertRaises(facetfit.ArgumentError):
                facetfit.Model("ggx+lambert")(*directions(3), **bad)
        self.assertRaises(TypeError, facetfit.Model, "ggx", alpha="0.3")
        self.assertRaises(TypeError, facetfit.Model, "ggx", alpha=None)

    def test_terms(self):
        wi, wo = directions(50, 3)
        terms = facetfit.Model("ggx", alpha=0.3).terms(wi, wo)
        up = (wi[:, 2] > 0) & (wo[:, 2] > 0)
        f = terms["D"] * terms["G"] * terms["F"] / (4 * wi[:, 2] * wo[:, 2])
        np.testing.assert_allclose(f[up], facetfit.Model("ggx", alpha=0.3)(wi, wo)[up], rtol=1e-12)
        self.assertRaises(facetfit.Error, facetfit.Model("ggx").terms, wi, wo, lobe=3)

    def test_samples_and_albedo(self):
        """The mean of the weights is the albedo, within four standard errors."""
        model = facetfit.Model("ggx+lambert", alpha=0.4, f0=[0.5, 0.9], kd=[0.2, 0.1])
        view = facetfit.directions(np.radians(40))
        samples = model.sample(np.tile(view, (20000, 1)), seed=3)
        albedo, error = model.albedo(view)
        self.assertEqual((samples.wi.shape, samples.weight.shape, albedo.shape), ((20000, 3), (20000, 2), (2,)))
        spread = samples.weight.std(axis=0) / np.sqrt(20000)
        self.assertTrue(
            np.all(np.abs(samples.weight.mean(axis=0) - albedo) < 4 * spread + error), samples.weight.mean(axis=0) - albedo
        )
        kept = samples.pdf > 0
        np.testing.assert_array_equal(model.pdf(samples.wi, view)[kept], samples.pdf[kept])
        np.testing.assert_array_equal(model(samples.wi, view)[kept], samples.f[kept])

    def test_overhead(self):
        """A call takes less than 20 us more than its work. The best of many is counted: the machine may be busy."""
        model = facetfit.Model("ggx+lambert")
        w = facetfit.directions(0.3)
        best = []
        for said in ({}, {"alpha": 0.3, "f0": 0.1, "kd": 0.2}):
            times = []
            for _ in range(2000):
                begin = time.perf_counter()
                model(w, w, **said)
                times.append(time.perf_counter() - begin)
            best.append(1e6 * min(times))
        print(f"a call takes {best[0]:.1f} us, with three parameters {best[1]:.1f} us")
        self.assertLess(max(best), 20)


class Measurements(unittest.TestCase):
    def test_views(self):
        """What is stored is looked at without a copy, and lives as long as somebody looks."""
        measured = paint(sigma=True)
        before = measured.stored.__array_interface__["data"][0]
        self.assertEqual(measured.stored.__array_interface__["data"][0], before)
        self.assertFalse(measured.stored.flags.owndata)
        self.assertEqual(measured.f.__array_interface__["data"][0], before)
        for view in (*measured.stored_angles, measured.stored_sigma, measured.valid):
            self.assertFalse(view.flags.owndata)
        measured.stored[0, 0] = 7
        self.assertEqual(measured.f[0, 0], 7)
        view = paint().stored
        gc.collect()
        self.assertTrue(np.isfinite(view.sum()))

    def test_arrays(self):
        """Arrays in are arrays out."""
        wi, wo = directions(300, 5)
        f = np.random.default_rng(1).uniform(0.1, 2, (300, 4))
        measured = facetfit.measurement(wi, wo, f, sigma=0.1 * f, wavelengths=[450, 550, 650, 1050.5])
        np.testing.assert_array_equal(measured.f, f)
        np.testing.assert_array_equal(measured.sigma, 0.1 * f)
        np.testing.assert_array_equal(measured.wavelengths, [450, 550, 650, 1050.5])
        self.assertEqual([c.name for c in measured.channels], ["450nm", "550nm", "650nm", "1050.5nm"])
        back = np.concatenate(measured.directions)
        np.testing.assert_allclose(back, np.concatenate([wi, wo]), atol=1e-15)
        self.assertEqual(len(facetfit.measurement(wi[0], wo, f[:, 0])), 300)
        for bad in (f[:299], f.ravel()[:-1]):
            self.assertRaises(ValueError, facetfit.measurement, wi, wo, bad)
        self.assertRaises(ValueError, facetfit.measurement, wi, wo, f, names=["a"])
        self.assertRaises(facetfit.ArgumentError, facetfit.measurement, wi, wo, f, wavelengths=[1, 2, 3, -4])

    def test_files(self):
        """A file is read as the program reads it, and written as it writes it; errors say where."""
        with tempfile.TemporaryDirectory() as folder:
            path, again = os.path.join(folder, "a.csv"), os.path.join(folder, "b.csv")
            run("simulate", "ggx+lambert", "--set", "alpha=0.3,f0=0.05:0.06:0.04", "--noise", "0.01", "-o", path)
            measured = facetfit.read(path)
            measured.write(again)
            with open(path) as a, open(again) as b:
                rows = [[line for line in file if not line.startswith("#")] for file in (a, b)]
            self.assertEqual(rows[0], rows[1])
            self.assertEqual(without_times(measured.info()), without_times(json.loads(run("info", path, "--json", "-"))))
            self.assertEqual(measured.reduce("mean").f.shape, (len(measured), 1))
            merl, report = measured.resample("csv")
            self.assertTrue(report["as_it_is"] and len(merl) == len(measured))
            with open(again, "w") as file:
                file.write("theta_i,phi_i,theta_o,phi_o,f\n30,0,30,180,x\n")
            with self.assertRaises(facetfit.FileError) as caught:
                facetfit.read(again)
            self.assertEqual((caught.exception.path, caught.exception.line), (again, 2))
            with self.assertRaises(facetfit.FileError) as caught:
                facetfit.read(os.path.join(folder, "none"))
            self.assertEqual(caught.exception.code, facetfit.Code.OPEN)
            with self.assertRaises(facetfit.ArgumentError) as caught:
                facetfit.read(path, quantity="radiance")
            self.assertIn("brdf-cos", str(caught.exception))
            self.assertRaises(facetfit.FileError, measured.write, os.path.join(folder, "no", "such.csv"))

    def test_axes(self):
        t, o = np.meshgrid([0.1, 0.4], [0.2, 0.5, 1.0], indexing="ij")
        measured = facetfit.measurement(facetfit.directions(t.ravel()), facetfit.directions(o.ravel(), np.pi / 2), np.ones(6))
        np.testing.assert_allclose(measured.axes[0], [0.1, 0.4])
        self.assertEqual([len(a) for a in measured.axes], [2, 1, 3, 1])
        self.assertIsNone(facetfit.measurement(*directions(5), np.ones(5)).axes)

    def test_pandas(self):
        try:
            import pandas
        except ImportError:
            self.skipTest("pandas is not there")
        table = paint().to_pandas()
        self.assertEqual(list(table.columns)[4:], ["f_r", "f_g", "f_b", "valid"])
        self.assertIsInstance(facetfit.fit(paint()).to_pandas(), pandas.DataFrame)


class Fits(unittest.TestCase):
    def test_same_as_program(self):
        """A fit, a bootstrap, each channel and a comparison have the document that the program writes."""
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "a.csv")
            paint().write(path)
            measured = facetfit.read(path)
            cases = [
                ({"shape": "isotropic"}, ["--shape", "isotropic"]),
                ({"bootstrap": 25, "seed": 3}, ["--bootstrap", "25", "--seed", "3"]),
                ({"loss": "log", "robust": "huber"}, ["--loss", "log", "--robust", "huber"]),
                ({"weight": "noise"}, ["--weight", "noise"]),
                ({"loss": "auto"}, ["--loss", "auto"]),
                ({"profile": True, "max_theta": 70}, ["--profile", "--max-theta", "70"]),
                ({"fix": {"kd": [0.3, 0.2, 0.1]}, "free": "ks"}, ["--fix", "kd=0.3:0.2:0.1", "--free", "ks"]),
                (
                    {"bounds": {"f0[r]": (0, 0.04)}, "priors": {"alpha": (0.3, 0.01)}},
                    ["--bound", "f0[r]=0:0.04", "--prior", "alpha=0.3+-0.01"],
                ),
                ({"ties": {"alpha_y": "alpha_x"}, "energy_conserving": True}, ["--tie", "alpha_y=alpha_x", "--energy-conserving"]),
                ({"noise": facetfit.Noise(relative=0.02), "reach": 80}, ["--noise-model", "relative=0.02", "--reach", "80"]),
                ({"aperture": "2"}, ["--aperture", "2"]),
            ]
            for options, words in cases:
                own = without_times(facetfit.fit(measured, "ggx+lambert", **options).to_dict())
                said = without_times(json.loads(run("fit", path, *words, "--json", "-")))
                self.assertEqual(own, said, options)
            each = facetfit.fit_each(measured, "ggx+lambert")
            said = without_times(json.loads(run("fit", path, "--channels", "each", "--json", "-")))
            self.assertEqual(without_times(each[0].to_dict()), said)
            self.assertEqual([f.channels for f in each], [["r"], ["g"], ["b"]])
            compared = facetfit.compare(measured, ndf="ggx,beckmann", masking="v-cavity,smith-separable", cross_validate=3)
            words = ["--ndf", "ggx,beckmann", "--masking", "v-cavity,smith-separable", "--cross-validate", "3"]
            said = json.loads(run("compare", path, *words, "--json", "-"))
            self.assertEqual(without_times(compared.to_dict()), without_times(said))
            ranked = sorted(range(len(said["fits"])), key=lambda k: said["fits"][k]["residual"]["objective"])
            self.assertEqual([f.model.expression for f in compared], [said["fits"][k]["model"] for k in ranked])

    def test_all_combinations(self):
        """What is compared without names is what the program compares."""
        measured = facetfit.simulate("ggx+lambert", "goniometer:30", relative=0.02)
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "a.csv")
            measured.write(path)
            said = json.loads(run("compare", path, "--json", "-"))
        compared = facetfit.compare(measured)
        self.assertEqual(len(compared), len(said["fits"]))
        self.assertEqual(sorted(f.model.expression for f in compared), sorted(f["model"] for f in said["fits"]))

    def test_values(self):
        measured = paint()
        fit = facetfit.fit(measured, "ggx+lambert", shape="isotropic")
        self.assertTrue(fit.converged)
        for name, true in TRUE.items():
            found, error = fit.values["alpha_x" if name == "alpha" else name], fit.errors["alpha_x" if name == "alpha" else name]
            self.assertTrue(np.all(np.abs(found - np.asarray(true)) < 5 * np.asarray(error)), name)
        names, matrix = fit.covariance
        self.assertEqual(names[:2], ["alpha_x", "f0[r]"])
        self.assertAlmostEqual(matrix[0, 0] ** 0.5, fit.errors["alpha_x"], places=15)
        np.testing.assert_allclose(matrix, matrix.T)
        self.assertTrue(np.all(np.linalg.eigvalsh(fit.correlation.matrix) > 0))
        low, high = fit.intervals["f0"]
        self.assertTrue(np.all(low < fit.values["f0"]) and np.all(fit.values["f0"] < high))
        residuals = fit.residuals
        np.testing.assert_array_equal(residuals.data, measured.f[residuals.samples])
        wi, wo = measured.directions
        np.testing.assert_allclose(residuals.model, fit.model(wi, wo)[residuals.samples], rtol=1e-12)
        self.assertAlmostEqual(residuals.cost.sum(), fit.objective, delta=1e-9 * fit.objective)
        self.assertEqual(fit.selection["used"], len(residuals.samples))
        self.assertAlmostEqual(float(fit.noise.relative[0]), 0.02, delta=0.005)
        self.assertGreater(float(fit.noise.sd(1.0)), 0)

    def test_each_channel_alone_has_its_residuals(self):
        measured = paint()
        for k, fit in enumerate(facetfit.fit_each(measured)):
            np.testing.assert_array_equal(fit.residuals.data[:, 0], measured.f[fit.residuals.samples, k])
            self.assertLess(np.abs(fit.residuals.model - fit.residuals.data).max(), 0.1)
        mean = facetfit.fit(measured, channels="mean").residuals
        np.testing.assert_allclose(mean.data[:, 0], measured.f[mean.samples].mean(axis=1))

    def test_arrays(self):
        """Arrays, a path and a measurement are the same data."""
        measured = paint()
        by_arrays = facetfit.fit((*measured.directions, measured.f), shape="isotropic", weight="sample")
        by_table = facetfit.fit(measured, shape="isotropic", weight="sample")
        self.assertAlmostEqual(by_arrays.values["alpha_x"], by_table.values["alpha_x"], places=9)

    def test_warnings(self):
        dark = facetfit.simulate(facetfit.Model("ggx+lambert", alpha=0.3, f0=[0.05, 0.05], kd=[0.2, 0.2]), "goniometer:15")
        dark.stored[:, 1] = 0
        found = [w for w in facetfit.fit(dark).warnings if w.code == "dark-channel"]
        self.assertEqual(len(found), 1)
        self.assertEqual(found[0].severity, "warning")
        self.assertTrue(found[0].channels and found[0].text)

    def test_options(self):
        measured = paint()
        with self.assertRaisesRegex(TypeError, "did you mean 'max_theta'"):
            facetfit.fit(measured, maxtheta=3)
        self.assertRaisesRegex(TypeError, "no option 'cross_validate'", facetfit.fit, measured, cross_validate=3)
        for bad in (
            {"loss": "squares"},
            {"max_theta": 0},
            {"max_theta": 91},
            {"bounds": {"alpha": (2, 1)}},
            {"fix": {"beta": 1}},
            {"negative": "x"},
            {"aperture": "wide"},
            {"bootstrap": 3},
            {"channels": "each"},
            {"cut_off": 85},
        ):
            with self.assertRaises(facetfit.ArgumentError, msg=bad):
                facetfit.fit(measured, **bad)
        with self.assertRaisesRegex(facetfit.ArgumentError, "cosine, log"):
            facetfit.fit(measured, loss="squares")
        self.assertRaises(facetfit.Error, facetfit.fit, (np.ones((3, 3)), np.ones((3, 3)), np.ones(3)))

    def test_turned_angles_are_not_fitted(self):
        """As in the program: what leaves no doubt is an error that says what mends it."""
        lines = ["theta_i,phi_i,theta_o,phi_o,f"]
        model = facetfit.Model("ggx+lambert", alpha=0.2, f0=0.5)
        for i in (10, 25, 40, 55):
            for o in range(0, 80, 4):
                for p in (0, 60, 120, 180):
                    f = float(model(facetfit.directions(np.radians(i)), facetfit.directions(np.radians(o), np.radians(p + 180))))
                    lines.append(f"{i},0,{o},{p},{f!r}")
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "turned.csv")
            with open(path, "w") as file:
                file.write("\n".join(lines) + "\n")
            with self.assertRaisesRegex(facetfit.Error, "azimuth='mirror'"):
                facetfit.fit(path)
            self.assertLess(facetfit.fit(facetfit.read(path, azimuth="mirror")).rmse, 1e-6)
            self.assertTrue(facetfit.fit(path, as_is=True).values)

    def test_tabulated(self):
        theta = np.linspace(0, np.pi / 2 - 0.01, 400)
        truth = facetfit.Model("beckmann+lambert", alpha=0.25, f0=0.6, kd=0.1)
        table = facetfit.Profile(theta, np.exp(-np.tan(theta) ** 2) / np.cos(theta) ** 4)
        model = facetfit.Model("tabulated+lambert", table=table)
        fit = facetfit.fit(facetfit.simulate(truth, "goniometer:10"), model, shape="isotropic")
        self.assertAlmostEqual(fit.values["alpha_x"], 0.25, places=3)
        wi, wo = directions(20, 6)
        np.testing.assert_allclose(fit.model(wi, wo), truth(wi, wo), rtol=0.02, atol=1e-6)
        self.assertTrue(fit.plot("slice").content and fit.html() and fit._repr_html_())
        self.assertRaises(facetfit.ArgumentError, facetfit.Model, "tabulated+lambert")
        with self.assertRaises(facetfit.Error):
            facetfit.fit(facetfit.simulate(truth, "goniometer:10"), "tabulated+lambert")
        self.assertRaises(facetfit.Error, facetfit.Profile, [0, 1], [1, 1])

    def test_progress(self):
        heard = []
        facetfit.fit(paint(), bootstrap=20, progress=lambda *said: heard.append(said))
        self.assertTrue(any(what.startswith("ggx") for what, _, _ in heard) and ("bootstrap", None, None) in heard, heard[:5])
        compared = []
        facetfit.compare(paint(), ["ggx", "beckmann"], progress=lambda *said: compared.append(said[0]))
        self.assertTrue(any(what.startswith("2 of 2: beckmann") for what in compared))

        def fail(*_):
            raise ZeroDivisionError("of the callback")

        self.assertRaisesRegex(ZeroDivisionError, "of the callback", facetfit.compare, paint(), progress=fail)

    def test_threads(self):
        """Several fits, and several questions to one fit, at once."""
        measured = paint()
        alone = facetfit.fit(measured)
        found, failed = [], []

        def work():
            try:
                found.append(facetfit.fit(measured, threads=1).values["alpha_x"])
                found.append(alone.residuals.model.sum())
                alone.plot("sweep")
            except Exception as e:  # noqa: said below
                failed.append(e)

        threads = [threading.Thread(target=work) for _ in range(4)]
        for t in threads:
            t.start()
        for t in threads:
            t.join()
        self.assertEqual(failed, [])
        self.assertEqual(len(set(found)), 2)

    def test_lock_is_released(self):
        """Another thread goes on while the library works."""
        ticks, stop = [0], threading.Event()

        def tick():
            while not stop.wait(0.001):
                ticks[0] += 1

        other = threading.Thread(target=tick)
        other.start()
        begin = time.perf_counter()
        facetfit.fit(paint(), bootstrap=400)
        taken = time.perf_counter() - begin
        stop.set()
        other.join()
        self.assertGreater(ticks[0], 20 * taken, f"{ticks[0]} ticks in {taken:.2f} s")


class Retrievals(unittest.TestCase):
    def test_same_as_program(self):
        """Rows, channels, measures and the fits beside it are those of `facetfit ndf`, to the bit."""
        data = facetfit.simulate("ggx+lambert", "goniometer:15", alpha=0.3, f0=[0.5, 0.3], kd=0.1, relative=0.02, seed=3)
        found = facetfit.retrieve_ndf(data)
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "a.csv")
            data.write(path)
            with open(os.path.join(folder, "out.json"), "w", encoding="utf-8") as f:
                f.write(run("ndf", path, "--json", "-"))
            found = facetfit.retrieve_ndf(path)
            with open(os.path.join(folder, "out.json"), encoding="utf-8") as f:
                said = json.load(f)
        rows = np.array(said["rows"], dtype=float)
        np.testing.assert_array_equal(found.D, rows[:, 1])
        np.testing.assert_array_equal(found.error, rows[:, 2])
        np.testing.assert_array_equal(found.known, rows[:, 4] != 0)
        self.assertEqual([c.f0 for c in found.channels], said["parameters"]["f0"])
        self.assertEqual([c.kd for c in found.channels], said["parameters"]["kd"])
        self.assertEqual(found.numbers["objective"], said["objective"])
        self.assertEqual(found.numbers["alpha_peak"], said["roughness"]["alpha_same_peak"])
        self.assertEqual(found.objectives["beckmann"], said["fits"][0]["objective"])
        self.assertEqual([w.code for w in found.warnings], [w["code"] for w in said["warnings"]])
        self.assertEqual([w.text for w in found.warnings], [w["text"] for w in said["warnings"]])

    def test_model(self):
        """The model of what was found is the data, and so is one that is made of its table; the formula is near the truth."""
        data = facetfit.simulate("ggx+lambert", "goniometer:15", alpha=0.3, f0=0.5, kd=0.1, relative=0.01, seed=5)
        found = facetfit.retrieve_ndf(data)
        high = (data.wi[:, 2] > 0.3) & (data.wo[:, 2] > 0.3)
        model = np.squeeze(found.model(data.wi[high], data.wo[high]))
        self.assertLess(np.median(np.abs(model / np.squeeze(data.f)[high] - 1)), 0.01)
        again = facetfit.Model(
            "tabulated+lambert", table=found.profile, alpha=1, f0=found.channels[0].f0, kd=found.channels[0].kd
        )
        np.testing.assert_allclose(np.squeeze(again(data.wi[high], data.wo[high])), model, rtol=1e-5)
        self.assertAlmostEqual(float(found.beside("ggx").values["alpha_x"]), 0.3, delta=0.01)

    def test_refusals(self):
        data = paint()
        for words in ({"masking": "nonsense"}, {"monotone": "nonsense"}, {"weight": "nonsense"}, {"nodes": 7}):
            with self.assertRaises(facetfit.Error):
                facetfit.retrieve_ndf(data, **words)
        with self.assertRaises(TypeError):
            facetfit.retrieve_ndf(data, shape="correlated")
        with self.assertRaises(facetfit.ArgumentError):
            facetfit.retrieve_ndf(data).beside("phong")


class Forms(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.measured = paint()
        cls.fit = facetfit.fit(cls.measured)
        cls.compared = facetfit.compare(cls.measured, ["ggx+lambert", "beckmann+lambert"])

    def test_reports(self):
        self.assertIn("alpha_x", self.fit.text())
        self.assertIn("</html>", self.fit.html())
        for part in (self.fit._repr_html_(), self.compared._repr_html_()):
            self.assertIn("</table>", part)
            self.assertNotIn("<script", part)
            self.assertEqual(part.count("<section"), part.count("</section>"))
        self.assertIn("|", self.compared.table("md"))
        self.assertIn("tabular", self.compared.table("latex"))
        self.assertRaises(facetfit.ArgumentError, self.compared.table, "rtf")
        self.assertEqual([repr(x)[:4] for x in (self.fit, self.compared, self.measured)], ["<Fit", "<Com", "<Mea"])

    def test_figures(self):
        for kind in facetfit.plot_kinds():
            self.assertIn("</svg>", self.fit.plot(kind, bootstrap=20)._repr_svg_())
        self.assertIn("</svg>", facetfit.plot("albedo", "ggx", facetfit.Model("beckmann", alpha=0.5)).text)
        self.assertIn("</svg>", facetfit.plot("coverage", self.measured).text)
        self.assertTrue(self.fit.plot("slice", form="csv", incidence=[30]).text.startswith("panel"))
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "a.pdf")
            self.compared.plot("forest", path)
            with open(path, "rb") as file:
                self.assertEqual(file.read(5), b"%PDF-")
            self.assertRaises(ValueError, self.fit.plot, "slice", os.path.join(folder, "a.png"))
        for bad in ({"kind": "pie"}, {"width": 1}, {"incidence": [100]}, {"channel": "x"}, {"log": 7}):
            with self.assertRaises(facetfit.ArgumentError):
                self.fit.plot(**{"kind": "slice", **bad})
        self.assertRaises(facetfit.ArgumentError, facetfit.plot, "forest", "ggx")

    def test_figure_is_the_programs(self):
        with tempfile.TemporaryDirectory() as folder:
            path, figure = os.path.join(folder, "a.csv"), os.path.join(folder, "a.svg")
            self.measured.write(path)
            run("plot", "residuals", path, "-o", figure)
            with open(figure) as file:
                self.assertEqual(facetfit.fit(path).plot("residuals").text, file.read())

    def test_exports(self):
        written = 0
        for name in facetfit.targets():
            try:
                written += len(self.fit.export(name).content) > 0
            except facetfit.ArgumentError as e:
                self.assertEqual(e.code, facetfit.Code.UNSUPPORTED, name)
        self.assertGreater(written, 12)
        self.assertIn("facetfit_brdf", self.fit.export("glsl").text)
        with tempfile.TemporaryDirectory() as folder:
            path, fitted = os.path.join(folder, "m.py"), os.path.join(folder, "fit.json")
            made = self.fit.export("blender", path)
            self.assertIsNone(made.content)
            self.assertTrue(made.about["controls"])
            with open(fitted, "w") as file:
                json.dump(self.fit.to_dict(), file)
            run("export", fitted, "--to", "blender", "-o", os.path.join(folder, "p.py"))
            with open(path) as a, open(os.path.join(folder, "p.py")) as b:
                self.assertEqual(a.read(), b.read())


class Tools(unittest.TestCase):
    def test_convert(self):
        ways = facetfit.convert("beckmann", "phong", m=0.25)
        self.assertAlmostEqual(ways[0]["n"], 2 / 0.25**2 - 2)
        self.assertEqual(ways[0].steps[0].formula, "n = 2/m^2 - 2")
        said = json.loads(run("convert", "--from", "beckmann", "--to", "phong", "m=0.25", "--json", "-"))
        self.assertEqual([way.values["n"] for way in ways], [way["output"]["n"] for way in said["conversions"]])
        self.assertRaises(facetfit.ArgumentError, facetfit.convert, "beckmann", "nothing", m=1)
        self.assertRaises(facetfit.ArgumentError, facetfit.convert, "beckmann", "phong", m=-1)
        self.assertRaises(TypeError, facetfit.convert, "beckmann", "phong", k=1)
        self.assertGreater(len(facetfit.conversions()), 30)

    def test_simulate(self):
        """The same values as the program's, to the bit."""
        own = facetfit.simulate("ggx+lambert", "goniometer:20", relative=0.05, floor=0.001, seed=9, alpha=0.3, f0=0.2, sigma=True)
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "a.csv")
            run(
                "simulate",
                "ggx+lambert",
                "--set",
                "alpha=0.3,f0=0.2",
                "--grid",
                "goniometer:20",
                "--noise",
                "0.05",
                "--noise-floor",
                "0.001",
                "--seed",
                "9",
                "--sigma",
                "-o",
                path,
            )
            said = facetfit.read(path)
            self.assertEqual(own.f.tobytes(), said.f.tobytes())
            self.assertEqual(own.sigma.tobytes(), said.sigma.tobytes())
        self.assertRaises(facetfit.ArgumentError, facetfit.simulate, "ggx", "moon")
        self.assertRaises(facetfit.ArgumentError, facetfit.simulate, "ggx", noise=facetfit.Noise(relative=0.1), relative=0.1)

    def test_noise(self):
        noise = facetfit.Noise(relative=0.05, floor=0.001, counts=1e-5, cos_o=-1)
        np.testing.assert_allclose(noise.sd([0.0, 2.0], 1, 0.5) ** 2, [1e-6 / 0.5, (1e-6 + 2e-5 + 0.0025 * 4) / 0.5])
        self.assertRaises(ValueError, facetfit.Noise, relative=-0.1)
        self.assertRaises(facetfit.ArgumentError, facetfit.Noise)

    def test_registries(self):
        self.assertIn("ggx", [t["name"] for t in facetfit.models()])
        self.assertIn("merl", [t["name"] for t in facetfit.formats()])
        self.assertEqual(facetfit.__version__, run("--version").split()[-1])


if __name__ == "__main__":
    unittest.main()
