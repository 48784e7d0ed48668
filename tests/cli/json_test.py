#!/usr/bin/env python3
"""json_test.py PROGRAM: every JSON document parses strictly and has the keys of the contract, whatever the path looks like."""
import json
import math
import os
import subprocess
import sys
import tempfile

PROGRAM = os.path.abspath(sys.argv[1])
failures = 0


def check(condition, what):
    global failures
    if not condition:
        failures += 1
        print("failed:", what)


def strict(text):
    """JSON without NaN, Infinity and repeated keys."""
    def constant(name):
        raise ValueError("not JSON: " + name)

    def pairs(items):
        keys = [k for k, _ in items]
        if len(keys) != len(set(keys)):
            raise ValueError("repeated key in %s" % keys)
        return dict(items)
    return json.loads(text.decode("utf-8"), parse_constant=constant, object_pairs_hook=pairs)


def document(*args, status=0, stdin=b""):
    p = subprocess.run([PROGRAM, *args, "--json", "-"], input=stdin, capture_output=True)
    check(p.returncode == status, "%s: status %d, %s" % (args, p.returncode, p.stderr))
    d = strict(p.stdout)
    check(d["version"].count(".") == 2 and d["command"][1] == args[0], "head of %s" % (args,))
    return d


def number(x):
    return isinstance(x, (int, float)) and not isinstance(x, bool) and math.isfinite(x)


def number_or_null(x):
    return x is None or number(x)


def keys(d, wanted, what):
    missing = [k for k in wanted.split() if k not in d]
    check(not missing, "%s lacks %s" % (what, missing))


def check_fit(f):
    keys(f, "model ndf masking fresnel diffuse shape outcome iterations passes time_s parameters ellipse residual aic bic warnings", "fit")
    keys(f["residual"], "objective rmse cosine_rmse log_rmse cube_root_rmse max_abs", "residual")
    check(all(number(v) for v in f["residual"].values()), "residuals of %s" % f["model"])
    keys(f["ellipse"] or {"alpha_major": 0, "alpha_minor": 0, "phi_deg": 0}, "alpha_major alpha_minor phi_deg", "ellipse")
    keys(f["parameters"], "f0" if f["diffuse"] is None else "f0 kd", "parameters of " + f["model"])
    for name, p in f["parameters"].items():
        keys(p, "value std_error at_bound", name)
        values = p["value"] if isinstance(p["value"], list) else [p["value"]]
        errors = p["std_error"] if isinstance(p["value"], list) else [p["std_error"]]
        bounds = p["at_bound"] if isinstance(p["value"], list) else [p["at_bound"]]
        check(len(values) == len(errors) == len(bounds), "lengths of " + name)
        check(all(number(v) for v in values) and all(number_or_null(e) for e in errors), "numbers of " + name)
        check(all(b in (None, "lower", "upper") for b in bounds), "bounds of " + name)
        if name in ("f0", "kd"):
            check(isinstance(p["value"], list) and len(values) == len(f["channels"]), name + " per channel")
    per_channel = ["%s[%s]" % (name, c) for name in f["parameters"] for c in f["channels"]]
    for w in f["warnings"]:
        check_warning(w, list(f["parameters"]) + per_channel, f["channels"])
    c = f["correlation"]
    n = len(c["names"])
    check(n == len(set(c["names"])) and len(c["matrix"]) == n and all(len(r) == n for r in c["matrix"]), "correlation of %s" % f["model"])
    for i in range(n):
        for j in range(n):
            check(abs(c["matrix"][i][j] - c["matrix"][j][i]) < 1e-6 and abs(c["matrix"][i][j]) < 1 + 1e-9, "correlation %d %d" % (i, j))


def check_warning(w, names, channels):
    """A code with its numbers, and of what: for programs; and the sentence that people read."""
    keys(w, "code severity values text", "warning")
    check(set(w) <= set("code severity parameter parameters channel channels values text".split()), "keys of warning %s" % w)
    check(w["code"].replace("-", "").islower() and w["severity"] in ("note", "warning", "problem") and len(w["text"]) > 20, "warning %s" % w)
    check(all(number(v) for v in w["values"].values()), "values of warning %s" % w)
    for one, many, known in (("parameter", "parameters", names), ("channel", "channels", channels)):
        check(not (one in w and many in w) and (many not in w or len(w[many]) > 1), "%s of warning %s" % (one, w))
        check(all(n in known for n in w.get(many, [w[one]] if one in w else [])), "%s of warning %s" % (one, w))


def check_fits(d, path, n_fits, loss="cosine", robust=None, max_theta=80):
    check(d["schema"] == "facetfit.fit/2", "schema")
    keys(d, "data loss fits ranking", "document")
    keys(d["data"], "path format samples used rejected channels isotropic", "data")
    check(d["data"]["path"] == path, "path %r" % d["data"]["path"])
    keys(d["data"]["rejected"], "invalid grazing below_horizon", "rejected")
    check(d["data"]["samples"] == d["data"]["used"] + sum(d["data"]["rejected"].values()), "samples add up")
    check(d["loss"]["name"] == loss and d["loss"]["robust"] == robust and d["loss"]["max_theta_deg"] == max_theta, "loss %s" % d["loss"])
    check(len(d["fits"]) == n_fits and sorted(d["ranking"]) == list(range(n_fits)), "%d fits, ranking %s" % (len(d["fits"]), d["ranking"]))
    for f in d["fits"]:
        check_fit(f)


def check_interval(value, interval, source, what):
    check((interval is None) == (source is None), "%s: interval %s from %s" % (what, interval, source))
    if interval is not None:
        check(len(interval) == 2 and interval[0] <= value <= interval[1], "%s: %s lies outside %s" % (what, value, interval))


def check_trust(f, source="standard-error"):
    """What a fit says of its trust: intervals about their values, rank, effective number of values."""
    keys(f, "rank condition effective_samples correlated_over correlation_settled", "trust of " + f["model"])
    check(f["rank"] >= 1 and f["effective_samples"] > 0 and f["correlated_over"] >= 1, "numbers of trust of " + f["model"])
    sources = set()
    for name, p in f["parameters"].items():
        if not isinstance(p["value"], list):
            check_interval(p["value"], p["interval"], p["interval_from"], name)
            sources.add(p["interval_from"])
            continue
        for v, i, s in zip(p["value"], p["interval"], p["interval_from"]):
            check_interval(v, i, s, name)
            sources.add(s)
    check(source in sources and sources <= {None, source, "one-sided"}, "intervals from %s" % sources)


def check_bands(bands):
    check(sorted(bands) == ["theta_d", "theta_h", "theta_i"], "bands %s" % list(bands))
    for rows in bands.values():
        check([(r["from"], r["to"]) for r in rows] == [(b, b + 10) for b in range(0, 90, 10)], "limits of bands")
        check(all(number(r["mean"]) and r["rms"] >= abs(r["mean"]) - 1e-12 if r["n"] else r["mean"] is None for r in rows), "bands %s" % rows)


def trust(path):
    f = document("fit", path)["fits"][0]
    check_trust(f)
    check_bands(f["residual_bands"])
    keys(f["cut_off"], "max_theta_deg used parameters", "cut-off")
    check(f["cut_off"]["max_theta_deg"] == 70 and all(number(p["value"]) for p in f["cut_off"]["parameters"]), "cut-off")
    b = document("fit", path, "--scale-uncertainty", "0.02", "--angle-uncertainty", "0.1")["fits"][0]["uncertainty_budget"]
    keys(b, "of parameters", "budget")
    check(b["of"] == {"scale": 0.02, "offset_deg": 0, "angle_deg": 0.1, "aperture_deg": 0}, "what was stated: %s" % b["of"])
    for p in b["parameters"]:
        keys(p, "name random scale incidences readings combined", "budget of a parameter")
        check(abs(p["combined"] ** 2 - p["random"] ** 2 - p["scale"] ** 2 - p["incidences"] ** 2) < 1e-9 * p["combined"] ** 2, "sum of %s" % p)
    f = document("fit", path, "--bootstrap", "40", "--cut-off", "0")["fits"][0]
    check_trust(f, "bootstrap")
    check("cut_off" not in f and f["bootstrap"]["repeats"] == 40 and f["bootstrap"]["failed"] == 0, "bootstrap %s" % f["bootstrap"])
    check_trust(document("fit", path, "--profile")["fits"][0], "profile")
    f = document("fit", path, "--robust", "cauchy")["fits"][0]
    keys(f["outliers"], "beyond_std_deviations samples values theta_i theta_h theta_d worst", "outliers")
    check(sum(f["outliers"]["theta_i"]) == f["outliers"]["samples"], "outliers %s" % f["outliers"])
    d = document("compare", path, "--ndf", "beckmann,ggx", "--masking", "v-cavity,smith-height-correlated", "--cross-validate", "3")
    best = d["ranking"][0]
    check(d["groups"]["folds"] == 3 and d["groups"]["n"] > 0, "groups %s" % d["groups"])
    for i, f in enumerate(d["fits"]):
        v = f["versus_best"]
        keys(v, "delta_objective delta_aic delta_bic vuong_z vuong_p test cross_validation told_apart", "versus")
        check_bands(f["residual_bands"])
        check(v["delta_objective"] == 0 if i == best else v["delta_objective"] > 0 and number(v["cross_validation"]["std_error"]), "versus %s" % v)
        check(i == best or (v["test"] == "incidences" and (not v["told_apart"] or v["vuong_p"] < 0.05)), "verdict %s" % v)
    for f in document("compare", path, "--ndf", "beckmann,ggx", "--masking", "v-cavity,smith-height-correlated", "--cross-validate", "3",
                      "--errors", "residuals")["fits"]:
        v = f["versus_best"]
        if v["delta_objective"] == 0:
            continue
        check(v["test"] == "objective" and v["told_apart"] == (
            v["vuong_p"] < 0.05 and v["cross_validation"]["difference"] * v["vuong_z"] > 0 and
            abs(v["cross_validation"]["difference"]) > v["cross_validation"]["std_error"]), "verdict %s" % v)


def check_choice(d, names):
    """Of --loss auto: a candidate for every loss, the chosen one among them with the parameters of the fit."""
    keys(d["loss"], "name robust max_theta_deg chosen_by pictures candidates", "loss")
    check(d["loss"]["chosen_by"] == "picture", "chosen by %s" % d["loss"]["chosen_by"])
    check(0 < d["loss"]["pictures"]["measured"] <= d["loss"]["pictures"]["pixels"], "pixels %s" % d["loss"]["pictures"])
    candidates = {c["name"]: c for c in d["loss"]["candidates"]}
    check([c["name"] for c in d["loss"]["candidates"]] == names, "candidates %s" % list(candidates))
    for c in candidates.values():
        keys(c, "name picture_difference outcome parameters", "candidate")
        check(0 < c["picture_difference"] < 1 and c["outcome"] == "converged", "candidate %s" % c["name"])
        check(set(c["parameters"]) == set(d["fits"][0]["parameters"]), "parameters of %s" % c["name"])
    best = candidates[d["loss"]["name"]]
    check(best["picture_difference"] <= min(c["picture_difference"] for c in candidates.values()) + 1e-6, "not the best was chosen")
    check(best["parameters"] == d["fits"][0]["parameters"], "the fit is not the candidate's")


def fits(directory):
    path = os.path.join(directory, "a.csv")
    subprocess.run([PROGRAM, "simulate", "ggx+lambert", "--set", "alpha_x=0.2,alpha_y=0.45,r_xy=0.4,f0=0.9:0.6:0.3,kd=0.1", "--grid",
                    "goniometer:10", "--noise", "0.02", "-o", path], check=True)
    check_fits(document("fit", path), path, 1)
    trust(path)
    check_fits(document("fit", path, "--model", "beckmann"), path, 1)
    check_fits(document("fit", path, "--loss", "log", "--robust", "huber:0.1", "--max-theta", "75"), path, 1, "log",
               {"name": "huber", "scale": 0.1}, 75)
    d = document("fit", path, "--model", "beckmann+lambert", "--loss", "auto")
    check_fits(d, path, 1, d["loss"]["name"])
    check_choice(d, "cosine log cube-root relative plain ln".split())
    d = document("compare", path, "--ndf", "beckmann,ggx", "--masking", "v-cavity,smith-height-correlated")
    check_fits(d, path, 4)
    order = [(f["ndf"], f["masking"]) for f in d["fits"]]
    check(order == [(n, m) for n in ("beckmann", "ggx") for m in ("v-cavity", "smith-height-correlated")], "order %s" % order)
    objective = [d["fits"][i]["residual"]["objective"] for i in d["ranking"]]
    check(objective == sorted(objective) and d["fits"][d["ranking"][0]]["ndf"] == "ggx", "ranking %s" % objective)
    check(all(p["tied_to"] is None and p["prior"] is None and len(p["bounds"]) == 2 for n, p in
              document("fit", path, "--shape", "axis")["fits"][0]["parameters"].items()), "nothing but the data was given")
    d = document("fit", path, "--shape", "axis", "--bound", "alpha=0.05:0.9", "--prior", "f0=0.5+-0.2", "--tie", "kd,alpha_y=alpha_x",
                 "--energy-conserving")
    check_fits(d, path, 1)
    check(d["constraints"] == {"bounds": {"alpha": [0.05, 0.9]}, "priors": {"f0": {"mean": 0.5, "sd": 0.2}},
                               "ties": [["kd", None], ["alpha_y", "alpha_x"]], "fixed": {}, "energy_conserving": True}, "constraints")
    of = d["data"]["channels"]
    e = document("fit", path, "--fix", "f0[%s]=0.45" % of[1], "--bound", "kd[%s]=0:0.9" % of[0], "--prior", "f0[%s]=0.5+-0.2" % of[0])
    check(e["constraints"]["fixed"] == {"f0[%s]" % of[1]: [0.45]} and e["constraints"]["bounds"] == {"kd[%s]" % of[0]: [0, 0.9]}, "of channels")
    f0 = e["fits"][0]["parameters"]["f0"]
    check(f0["value"][1] == 0.45 and f0["std_error"][1] is None and f0["std_error"][0] > 0 and not f0["held"] and f0["prior"] is None, "f0")
    every = ":".join("0.%d" % (4 + c) for c in range(len(of)))
    e = document("fit", path, "--fix", "f0=" + every)
    check(e["fits"][0]["parameters"]["f0"]["held"] and e["fits"][0]["parameters"]["f0"]["value"] == [float(v) for v in every.split(":")], "f0 by channel")
    p = d["fits"][0]["parameters"]
    check(p["alpha_y"]["tied_to"] == "alpha_x" and p["alpha_y"]["tied"] and p["alpha_y"]["bounds"] == [0.05, 0.9], "alpha_y")
    check(p["kd"]["tied_to"] == "kd" and len(set(p["kd"]["value"])) == 1 and p["kd"]["prior"] is None, "kd")
    check(p["f0"]["prior"] == {"mean": 0.5, "sd": 0.2} and p["f0"]["tied_to"] is None and p["f0"]["bounds"] == [0, 1], "f0")
    check(d["fits"][0]["prior_penalty"] > 0, "penalty of the prior")
    d = document("fit", path, "--channels", "each")
    check_fits(d, path, 3)
    check([f["channels"] for f in d["fits"]] == [["r"], ["g"], ["b"]] and d["data"]["channels"] == ["r", "g", "b"], "each channel")
    everything = document("compare", path)
    check("smith-masking-only" not in [f["masking"] for f in everything["fits"]], "'all' includes the furnace's masking")
    pairs = [(f["ndf"], f["masking"]) for f in everything["fits"]]
    check(len(pairs) >= 80 and len(set(pairs)) == len(pairs), "%d combinations" % len(pairs))
    check(("ggx", "hammon") in pairs and ("beckmann", "hammon") not in pairs, "terms that do not go together")
    return path


def warnings(directory, path):
    """Warnings as programs read them: of one channel and of several, of one parameter and of a pair, with and without numbers."""
    def of(code, *args, status=0):
        found = [w for w in document("fit", path, *args, status=status)["fits"][0]["warnings"] if w["code"] == code]
        check(found, "no warning '%s' of %s" % (code, args))
        return found[0] if found else {}

    w = of("at-bound", "--shape", "isotropic", "--bound", "alpha=0.01:0.1")
    check(abs(w["values"].pop("bound") - 0.1) < 1e-12, "the bound of a shared parameter")
    check(0 < w["values"].pop("reflects") < 1, "what the data reflect at least")
    check(w == {"code": "at-bound", "severity": "warning", "parameter": "alpha_x", "values": {"side": 1, "given": 1},
                "text": "alpha_x is on the given upper bound, 0.1"}, "of a shared parameter: %s" % w)
    w = of("at-bound", "--shape", "axis", "--bound", "kd=0.3:0.4")
    check(0 < w["values"].pop("reflects") < 1, "what the data reflect at least, once more")
    check(w["parameter"] == "kd" and w["channels"] == ["r", "g", "b"] and w["values"] == {"bound": 0.3, "side": -1, "given": 1},
          "of several channels: %s" % w)
    w = of("prior-disagrees", "--prior", "f0=0.1+-0.0001", "--channels", "mean")
    check(w["parameter"] == "f0" and "channel" not in w and w["values"]["mean"] == 0.1 and w["values"]["sd"] == 1e-4, "prior: %s" % w)
    w = of("prior-disagrees", "--prior", "f0=0.1+-0.0001")
    check(w["parameter"] == "f0" and w["channel"] == "r" and w["text"].startswith("data and prior disagree about f0[r]"), "prior: %s" % w)
    w = of("correlated", "--free", "ks", "--channels", "mean", "--max-theta", "60")
    check(len(w["parameters"]) == 2 and abs(w["values"]["correlation"]) > 0.99, "a pair: %s" % w)
    w = of("correlated", "--free", "ks", "--max-theta", "60")
    check(all(p[-3:] in ("[r]", "[g]", "[b]") for p in w["parameters"]) and "channel" not in w, "a pair of channels: %s" % w)
    w = of("iteration-limit", "--model", "ggx+beckmann+lambert", "--max-iterations", "1", status=1)
    check(w["severity"] == "problem" and w["values"] == {"iterations": 1} and "--max-iterations" in w["text"], "limit: %s" % w)
    d = document("ndf", path, "-o", os.path.join(directory, "t.csv"))
    check(d["schema"] == "facetfit.ndf/2" and any(w["code"] == "direction-averaged" for w in d["warnings"]), "of a retrieval")
    for w in d["warnings"]:
        check_warning(w, [], [])


def spectra(directory):
    """Of many channels the correlations are those of the shape, and for each channel its own with these and among each other."""
    path = os.path.join(directory, "many.csv")
    f0 = ":".join("%.2f" % (0.3 + 0.04 * c) for c in range(12))
    subprocess.run([PROGRAM, "simulate", "ggx+lambert", "--set", "alpha=0.3,kd=0.1,f0=" + f0, "--grid", "scattered:2000", "--noise", "0.02",
                    "-o", path], check=True)
    d = document("fit", path)
    check_fits(d, path, 1)
    f = d["fits"][0]
    c = f["correlation"]
    check(c["names"] == ["alpha_x", "alpha_y", "r_xy"] and c["channel_names"] == ["f0", "kd"] and len(c["channels"]) == 12, "columns")
    for rows in c["channels"]:
        check(len(rows) == 2 and all(len(r) == 5 and all(number(v) and abs(v) <= 1 for v in r) for r in rows), "rows %s" % rows)
        check(rows[0][3] == 1 and rows[1][4] == 1 and abs(rows[0][4] - rows[1][3]) < 1e-9 and rows[0][4] < -0.1, "own %s" % rows)
    check(all(e > 0 for e in f["parameters"]["f0"]["std_error"] + f["parameters"]["kd"]["std_error"]), "errors")
    with open(path) as source:
        lines = [line.rstrip("\n").split(",") for line in source]
    few = os.path.join(directory, "few.csv")
    with open(few, "w") as target:
        target.writelines(",".join(w[:12] if len(w) > 12 else w) + "\n" for w in lines)
    check("channels" not in document("fit", few)["fits"][0]["correlation"], "eight channels are few")
    w = document("fit", path, "--bound", "kd=0.2:0.3")["fits"][0]["warnings"][0]
    check(w["code"] == "at-bound" and w["channels"] == ["c%d" % c for c in range(12)] and "(12 of 12 channels, c0 to c11)" in w["text"],
          "channels of a warning: %s" % w)


def hostile_paths(directory, path):
    """Quotes, control characters and bytes that are no UTF-8 must not break the document."""
    for name in (b'quo"te\\.csv', b"new\nline\t\x01.csv", "mesur\u00e9 \u6e2c\u5b9a.csv".encode(), b"latin\xe9\xff.csv",
                 b"over\xc0\xaflong\xed\xa0\x80.csv"):
        copy = os.path.join(directory.encode(), name)
        with open(path, "rb") as source, open(copy, "wb") as target:
            target.write(source.read())
        d = document("info", copy)
        expected = copy.decode("utf-8", "replace")
        check(d["path"] == expected or "\ufffd" in d["path"] and "\ufffd" in expected, "path %r" % d["path"])


def others(path):
    d = document("info", path)
    keys(d, "path format samples invalid negative quantity isotropic theta_i_deg theta_o_deg channels notes", "info")
    check(d["schema"] == "facetfit.info/1" and d["samples"] > 100 and len(d["channels"]) == 3, "info")
    check(all(c["min"] <= c["median"] <= c["max"] and c["wavelength_nm"] is None for c in d["channels"]), "values of info")
    d = document("models")
    names = {t["name"] for t in d["terms"]}
    check({"ggx", "beckmann", "v-cavity", "schlick", "lambert"} <= names and len(names) >= 10, "models %s" % names)
    check(all(p["min"] <= p["initial"] <= p["max"] for t in d["terms"] for p in t["parameters"]), "boxes")
    check({f["name"] for f in document("formats")["formats"]} >= {"merl", "astm", "csv"}, "formats")
    d = document("convert", "--from", "beckmann", "--to", "ggx", "m=0.5")
    check([c["by"] for c in d["conversions"]] == ["mean-slope", "peak", "lobe"] and d["conversions"][1]["output"] == {"alpha": 0.5}
          and d["conversions"][0]["path"] == ["beckmann", "ggx"], "convert")
    d = document("convert", "--from", "eta", "--to", "reflectance", "ior=1.5:1.33")["conversions"]
    check(len(d) == 1 and d[0]["path"] == ["eta", "f0", "reflectance"] and len(d[0]["output"]["reflectance"]) == 2 and
          d[0]["input"] == {"eta": [1.5, 1.33]}, "convert by two steps")
    check(len(document("convert", "--list")["conversions"]) >= 14, "convert --list")
    rows = b"theta_i,phi_i,theta_o,phi_o\n30,0,30,180\n0,0,10,0\n"
    d = document("eval", "ggx+lambert", "--set", "f0=0.1:0.2:0.3", "--terms", stdin=rows)
    check(len(d["rows"]) == 2 and all(len(r) == len(d["columns"]) for r in d["rows"]) and d["columns"][:7] ==
          ["theta_i", "phi_i", "theta_o", "phi_o", "f_r", "f_g", "f_b"], "eval %s" % d["columns"])
    check(document("eval", "lambert", stdin=b"theta_i,phi_i,theta_o,phi_o\n")["rows"] == [], "eval without rows")
    d = document("furnace", "lambert", "--mu", "1,0.5", "--set", "kd=0.5")
    check(d["columns"] == ["mu", "albedo"] and [[round(x, 9) for x in r] for r in d["rows"]] == [[1, 0.5], [0.5, 0.5]], "furnace")


with tempfile.TemporaryDirectory() as directory:
    path = fits(directory)
    warnings(directory, path)
    spectra(directory)
    hostile_paths(directory, path)
    others(path)
print("%d failures" % failures)
sys.exit(1 if failures else 0)
