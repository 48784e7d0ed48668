#!/usr/bin/env python3
"""Runs the benchmark programs of a build directory and prints one JSON object: machine, items, optimum, ratios.

An item is {median, min, max, n, unit}. A ratio carries its target and whether it was met; nothing here fails on a number.
Programs that are compared run by turns within this one call, so that a slow minute of the machine falls on both.
"""
import json
import os
import platform
import resource
import statistics
import subprocess
import sys
import time

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
PARAMETERS = ["alpha_x", "alpha_y", "r_xy", "f0"]
ROUNDS = 3
COMPARE_NDFS, COMPARE_MASKINGS = ["beckmann", "ggx", "student-t", "phong"], [
    "smith-separable", "smith-height-correlated", "smith-direction-correlated", "smith-height-direction-correlated", "v-cavity", "none"]
COMPARE_MODELS = len(COMPARE_NDFS) * len(COMPARE_MASKINGS)
TEXT_FORMATS = ["csv", "astm", "alta", "cornell", "fred", "pgii", "nist", "planetary"]
# Their Lambda is an integral, or they read the directional albedo of the lobes.
BY_TABLE = {"gtr", "vmf", "gaussian", "sgd", "abc", "tabulated", "mikkelsen-coupled", "kelemen-matte", "kulla-conty"}


def say(text):
    print(text, file=sys.stderr, flush=True)


def item(values, unit):
    return {"median": statistics.median(values), "min": min(values), "max": max(values), "n": len(values), "unit": unit}


def program_json(*command):
    say("$ " + " ".join(command))
    return json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout)


def measured_process(command):
    """Runs a command to its end: wall seconds from start to exit and peak resident memory in MB."""
    say("$ " + " ".join(command))
    begin = time.clock_gettime(time.CLOCK_MONOTONIC)
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    wall = time.clock_gettime(time.CLOCK_MONOTONIC) - begin
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise SystemExit(f"{command[0]} ended with exit status {process.returncode}")
    return wall, usage.ru_maxrss * 1024e-6


def machine(kernels):
    with open("/proc/cpuinfo", encoding="utf-8") as f:
        cpu = next((line.split(":", 1)[1].strip() for line in f if line.startswith("model name")), platform.processor())
    return {"cpu": cpu, "cores": os.cpu_count(), "kernel": platform.release(), "compiler": kernels["compiler"],
            "best_isa": kernels["best_isa"]}


def solve(bench, items):
    """The plain Ceres program with two linear solvers and the library, by turns. The faster of the two is the baseline."""
    plain = {"DENSE_NORMAL_CHOLESKY": [], "DENSE_QR": []}
    ours = {"given": [], "errors": [], "search": []}
    ours_rss = []
    for _ in range(ROUNDS):
        for solver, runs in plain.items():
            runs.append(program_json(f"{bench}/bench_plain_ceres", solver))
        for mode, runs in ours.items():
            answer = program_json(f"{bench}/bench_solve", mode, "5" if mode != "search" else "3")
            runs += answer["runs"]
            ours_rss.append(answer["peak_rss_mb"] - answer["base_rss_mb"])
    for solver, runs in plain.items():
        items[f"plain_ceres.{solver}.solve"] = item([r["solve_s"] for r in runs], "s")
        items[f"plain_ceres.{solver}.total"] = item([r["total_s"] for r in runs], "s")
        items[f"plain_ceres.{solver}.memory"] = item([r["peak_rss_mb"] - r["base_rss_mb"] for r in runs], "MB")
        items[f"plain_ceres.{solver}.iterations"] = item([r["iterations"] for r in runs], "1")
    for mode, runs in ours.items():
        items[f"facetfit.{mode}.solve"] = item([r["solve_s"] for r in runs], "s")
        items[f"facetfit.{mode}.total"] = item([r["problem_s"] + r["solve_s"] for r in runs], "s")
        items[f"facetfit.{mode}.iterations"] = item([r["iterations"] for r in runs], "1")
        items[f"facetfit.{mode}.passes"] = item([r["passes"] for r in runs], "1")
    items["facetfit.memory"] = item(ours_rss, "MB")
    best = min(plain, key=lambda s: items[f"plain_ceres.{s}.solve"]["median"])
    return best, plain[best][0], {mode: runs[0] for mode, runs in ours.items()}


def optimum(bench, plain, ours):
    """How far the library's optimum is from that of the plain program, run on to convergence: relative, per way of starting.
    With its default tolerances, as it is timed, the plain program stops a little before."""
    timed = plain
    plain = program_json(f"{bench}/bench_plain_ceres", plain["linear_solver"], "converged")

    def against(run):
        differences = [a / b - 1 for a, b in zip(run["parameters"], plain["parameters"])]
        return {"outcome": run["outcome"], "cost": run["cost"],
                "cost_relative_difference": run["cost"] / plain["cost"] - 1,
                "parameters": dict(zip(PARAMETERS, run["parameters"])),
                "parameter_relative_difference": dict(zip(PARAMETERS, differences))}
    return {"plain_ceres_as_timed": against(timed), "plain_ceres": against(plain),
            "facetfit": {mode: against(run) for mode, run in ours.items()}}


def threads(bench, items):
    runs = program_json(f"{bench}/bench_solve", "threads", "7")["runs"]
    for n in (1, 2):
        items[f"threads.{n}.solve"] = item([r["solve_s"] for r in runs if r["threads"] == n], "s")
        items[f"threads.{n}.problem"] = item([r["problem_s"] for r in runs if r["threads"] == n], "s")
    return len({tuple(r["parameters"]) + (r["cost"],) for r in runs}) == 1


def kernel_items(kernels, items):
    for k in kernels["kernels"]:
        name = "value_and_derivatives" if k["derivatives"] else "value"
        items[f"eval.{k['model']}.{k['isa']}.{k['where']}.{name}"] = item([r * 1e-6 for r in k["rate"]], "M samples/s")


def passes(bench, items):
    """Each model's pass over all samples against ggx's, one thread. Returns the slowest of those with a closed form, and of the rest."""
    slowest = {False: ("", 0), True: ("", 0)}
    for p in program_json(f"{bench}/bench_passes")["passes"]:
        items[f"pass.{p['kind']}.{p['name']}"] = {"ratio": p["ratio"], "seconds": p["seconds"], "model": p["model"], "unit": "ggx passes"}
        integral = p["name"] in BY_TABLE
        if p["ratio"] > slowest[integral][1]:
            slowest[integral] = (p["name"], p["ratio"])
    return slowest


def channels(bench, items):
    """Fits of 1 to 301 channels. Returns the time per channel at 121 over that at 8, the larger of the two kinds of fits."""
    fits = {f["channels"]: f for f in program_json(f"{bench}/bench_channels", "5")["fits"]}
    for n, f in fits.items():
        items[f"channels.{n}"] = {"search_ns": f["search_ns"], "given_ns": f["given_ns"], "unit": "ns per sample and channel"}
    return max(fits[121][key] / fits[8][key] for key in ("search_ns", "given_ns"))


def merl_file(build, program):
    """A full-size MERL file: of a real material where the shared tools are, simulated otherwise. Returns path and origin."""
    data = os.environ.get("FACETFIT_DATA")
    shared = os.path.dirname(os.path.abspath(data)) if data else os.path.join(ROOT, "..", "shared")
    tool = os.path.join(shared, "tools", "make_merl.py")
    path = os.path.join(build, "bench", "merl.binary")
    origin = "gold-metallic-paint"
    if not os.access(tool, os.X_OK) or subprocess.run([tool, origin, path], check=False, stdout=sys.stderr).returncode != 0:
        origin = "simulated"
        subprocess.run([program, "simulate", "ggx+lambert", "--set", "alpha=0.25,f0=0.9:0.6:0.3,kd=0.1:0.05:0.02", "--grid", "merl",
                        "--noise", "0.02", "--seed", "1", "-o", path], check=True, stdout=sys.stderr)
    return path, origin


def merl(build, items):
    program = os.path.join(build, "bin", "facetfit")
    path, origin = merl_file(build, program)
    fit = [program, "fit", path, "--model", "ggx+lambert", "--max-theta", "90", "--threads", "2"]
    compare = [program, "compare", path, "--ndf", ",".join(COMPARE_NDFS), "--masking", ",".join(COMPARE_MASKINGS), "--diffuse", "lambert", "--max-theta", "90", "--threads", "2", "--json",
               os.path.join(build, "bench", "compare.json")]
    measured_process(fit)  # the file is in the page cache from here on
    runs = [measured_process(fit) for _ in range(5)]
    items["merl.fit.wall"] = item([wall for wall, _ in runs], "s")
    items["merl.fit.rss"] = item([rss for _, rss in runs], "MB")
    runs = [measured_process(fit + ["--bootstrap", "200"]) for _ in range(3)]
    items["merl.bootstrap_200.wall"] = item([wall for wall, _ in runs], "s")
    runs = [measured_process(compare) for _ in range(3)]
    with open(compare[-1], encoding="utf-8") as f:
        fits = len(json.load(f)["fits"])
    items["merl.compare.wall"] = item([wall for wall, _ in runs], "s")
    items["merl.compare.rss"] = item([rss for _, rss in runs], "MB")
    return {"material": origin, "compare_fits": fits, "compare_fits_expected": COMPARE_MODELS}


def processor_time(command):
    """Seconds of user and system time of a command, which a busy machine makes longer by little."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def figures(build, items):
    """Figures that take longest: of a MERL file with the fit given, reading included, and albedos of seven models."""
    program, out = os.path.join(build, "bin", "facetfit"), os.path.join(build, "bench", "figure.svg")
    path, fit = os.path.join(build, "bench", "merl.binary"), os.path.join(build, "bench", "merl.json")
    subprocess.run([program, "fit", path, "--json", fit], check=True)
    models = ["ggx", "ggx/v-cavity", "ggx/smith-separable", "beckmann", "ggx/kelemen", "student-t", "phong"]
    for name, words in {"profile": [path, "--from", fit], "slice": [path, "--from", fit], "image": [path, "--from", fit], "albedo": models}.items():
        command = [program, "plot", name, *words, "--threads", "1", "-o", out]
        say("$ " + " ".join(command))
        items[f"figure.{name}"] = item([processor_time(command) for _ in range(9)], "s")


def readers(build, items):
    """Every reader's speed beside that of reading the bytes. Real tensor and XML files where the shared data are."""
    folder = os.path.join(build, "bench", "files")
    os.makedirs(folder, exist_ok=True)
    data = os.environ.get("FACETFIT_DATA", os.path.join(ROOT, "..", "shared", "data"))
    real = [os.path.join(data, name) for name in ("rgl/aurora_white_rgb.bsdf", "zemax/IMX455.bsdf", "klems/2011-SA1.XML", "mbsdf/carpaint_blue.mbsdf")]
    files = program_json(f"{build}/bench/bench_readers", folder, *[p for p in real if os.path.exists(p)])["files"]
    for f in files:
        items[f"read.{f['format']}"] = {key: f[key] for key in ("bytes", "read_bytes_s", "with_arithmetic_s", "table_s", "mb_per_s")}
    return {f["format"]: f for f in files}


def renders(build, items):
    """Pictures of 512 x 512 pixels: under a light, and under a sky with 256 samples a pixel; by the program, from start to exit."""
    out = os.path.join(build, "bench", "ball.exr")
    line = [os.path.join(build, "bin", "facetfit"), "render", "ggx+lambert", "--set", "alpha=0.2,f0=0.05,kd=0.1:0.3:0.5", "-o", out]
    for name, more in (("light", []), ("environment", ["--environment", "sky"])):
        items[f"render.{name}.wall"] = item([measured_process(line + more)[0] for _ in range(ROUNDS)], "s")


def pages(build, items):
    """What --html costs of a MERL file beside the fit and the comparison of 24 models: processor time with it less that without, by turns."""
    program, path, out = os.path.join(build, "bin", "facetfit"), os.path.join(build, "bench", "merl.binary"), os.path.join(build, "bench", "page.html")
    several = ["compare", path, "--ndf", ",".join(COMPARE_NDFS), "--masking", ",".join(COMPARE_MASKINGS)]
    for name, words, rounds in (("fit", ["fit", path], 7), ("compare", several, ROUNDS)):
        say("$ facetfit " + " ".join(words) + " --html " + out)
        pairs = [(processor_time([program, *words]), processor_time([program, *words, "--html", out])) for _ in range(rounds)]
        items[f"html.{name}.beyond"] = item([b - a for a, b in pairs], "s")


def ratio(value, target, unit, at_least):
    return {"value": value, "target": target, "sense": "at least" if at_least else "at most", "unit": unit,
            "met": value >= target if at_least else value <= target}


def main(argv):
    if len(argv) != 2:
        print("usage: collect.py BUILD_DIR", file=sys.stderr)
        return 2
    build = os.path.abspath(argv[1])
    bench = os.path.join(build, "bench")
    items = {}
    load = os.getloadavg()[0]
    kernels = program_json(f"{bench}/bench_kernels")
    kernel_items(kernels, items)
    baseline, plain, ours = solve(bench, items)
    same = threads(bench, items)
    slowest = passes(bench, items)
    spectra = channels(bench, items)
    merl_info = merl(build, items)
    read = readers(build, items)
    figures(build, items)
    renders(build, items)
    pages(build, items)

    def median(name):
        return items[name]["median"]

    def times(numerator, denominator):
        return median(numerator) / median(denominator) if median(denominator) > 0 else float("inf")
    best_isa = kernels["best_isa"]
    ratios = {
        "solve_vs_plain": ratio(times(f"plain_ceres.{baseline}.solve", "facetfit.given.solve"), 60, "1", True),
        "fit_wall": ratio(median("merl.fit.wall"), 0.5, "s", False),
        "fit_rss": ratio(median("merl.fit.rss"), 200, "MB", False),
        "bootstrap_200_wall": ratio(median("merl.bootstrap_200.wall"), 20, "s", False),
        "errors_over_none": ratio(times("facetfit.errors.solve", "facetfit.given.solve"), 1.1, "1", False),
        "compare_wall": ratio(median("merl.compare.wall"), 10, "s", False),
        "eval_ggx": ratio(median(f"eval.ggx.{best_isa}.cache.value"), 100, "M samples/s", True),
        "eval_beckmann": ratio(median(f"eval.beckmann.{best_isa}.cache.value"), 50, "M samples/s", True),
        "threads_2_over_1": ratio(times("threads.1.solve", "threads.2.solve"), 1.7, "1", True),
        "pass_closed_form": ratio(slowest[False][1], 3, "ggx passes", False),
        "pass_integral": ratio(slowest[True][1], 8, "ggx passes", False),
        "channels_121_over_8": ratio(spectra, 1.2, "time per channel", False),
        "figure_of_merl": ratio(max(median(f"figure.{k}") for k in ("profile", "slice", "image")) - read["merl"]["table_s"], 0.05, "s", False),
        "figure_of_seven_albedos": ratio(median("figure.albedo"), 0.05, "s", False),
        "render_light": ratio(median("render.light.wall"), 0.1, "s", False),
        "render_environment": ratio(median("render.environment.wall"), 5, "s", False),
        "html_of_fit": ratio(median("html.fit.beyond"), 2, "s", False),
        "html_of_compare": ratio(median("html.compare.beyond"), 2, "s", False),
        "read_slowest_text": ratio(min(read[f]["mb_per_s"] for f in TEXT_FORMATS), 150, "MB/s", True),
    }
    for name in ("merl", "exr", "rgl"):
        if name in read:
            ratios[f"read_{name}"] = ratio(read[name]["with_arithmetic_s"] / read[name]["table_s"], 0.5, "of the bytes' speed", True)
    informative = {
        "solve_vs_plain_dense_qr": times("plain_ceres.DENSE_QR.solve", "facetfit.given.solve"),
        "total_vs_plain": times(f"plain_ceres.{baseline}.total", "facetfit.given.total"),
        "search_vs_plain": times(f"plain_ceres.{baseline}.solve", "facetfit.search.solve"),
        "memory_vs_plain": times(f"plain_ceres.{baseline}.memory", "facetfit.memory"),
    }
    info = dict(machine(kernels), load_before=load)
    result = {"schema": "facetfit.bench/1", "machine": info, "baseline_linear_solver": baseline, "ratios": ratios,
              "other_ratios": informative, "optimum": optimum(bench, plain, ours), "threads_same_bits": same, "merl": merl_info,
              "items": items}
    print(json.dumps(result, indent=1))
    for name, r in ratios.items():
        say(f"{name:18} {r['value']:10.4g} {r['unit']:12} {r['sense']} {r['target']:g}: {'met' if r['met'] else 'NOT MET'}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv))
