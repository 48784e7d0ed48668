#!/usr/bin/env python3
"""ranks_test.py PROGRAM: `compare` lists the models of made data sets in one order, whatever the instruction set; models whose
objectives are equal but for rounding by their parameters, then by their names. One data set has exactly tied models: it is exact,
and several models contain the one it was made of. On a lobe without a diffuse part others differ by nothing but rounding."""
import json
import os
import subprocess
import sys
import tempfile

PROGRAM = sys.argv[1]
TIE = 1e-9
SETS = {
    "noise": ["ggx+lambert", "--set", "alpha=0.3,f0=0.3,kd=0.2", "--noise", "0.04", "--grid", "goniometer:15"],
    "gaussian": ["beckmann+lambert", "--set", "alpha=0.15,f0=0.1,kd=0.3", "--noise", "0.01", "--grid", "goniometer:15"],
    "exact": ["ggx+lambert", "--set", "alpha=0.2,f0=0.3,kd=0.1", "--grid", "goniometer:15"],
    "channels": ["ggx+lambert", "--set", "alpha=0.25,f0=0.5:0.3:0.1,kd=0.1:0.2:0.3", "--grid", "scattered:300:0.5", "--noise", "0.02"],
}


def run(*words):
    return subprocess.run([PROGRAM, *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, check=False)


def ranked(path, isa):
    """(objective, root mean square, parameters, model) of all models in the order of the report; None without that set."""
    done = run("compare", path, "--isa", isa, "--json", path + ".json")
    if b"instruction set" in done.stderr and done.returncode not in (0, 1):
        return None
    with open(path + ".json", encoding="utf-8") as file:
        report = json.load(file)
    rows = [report["fits"][k] for k in report["ranking"]]
    return [(row["residual"]["objective"], row["residual"]["rmse"], count(row["parameters"]), row["model"]) for row in rows]


def count(parameters):
    """Of an object of parameters, those of a channel's own as lists: the ones that a fit could move."""
    each = [p for entry in parameters.values() for p in (entry if isinstance(entry, list) else [entry])]
    return sum(not p["held"] and not p["tied"] for p in each)


def wrong_ties(rows, largest):
    """Pairs that are equal but for rounding and stand in another order than by (parameters, name); how many pairs are equal."""
    wrong, ties, first = [], 0, None
    for one, other in zip(rows, rows[1:]):
        exact = other[1] <= TIE * largest
        first = one if first is None else first
        if exact or other[0] <= first[0] * (1 + TIE):
            ties += 1
            if one[2:] > other[2:]:
                wrong.append(f"{one[3]} before {other[3]}")
        else:
            first = other
    return wrong, ties


def between_sets(orders):
    """The largest relative difference of the objectives of one model by two instruction sets, of fits that are not exact."""
    by_model = {}
    for rows in orders.values():
        for objective, rmse, _, model in rows:
            if rmse > TIE:
                by_model.setdefault(model, []).append(objective)
    return max((max(all_of) - min(all_of)) / min(all_of) for all_of in by_model.values())


def gaps(rows):
    """Relative differences of neighbours, of fits that are not exact: the largest that counts as none, the least that counts."""
    all_of = [b[0] / a[0] - 1 for a, b in zip(rows, rows[1:]) if min(a[1], b[1]) > TIE]
    return max([abs(g) for g in all_of if g <= TIE], default=0), min(g for g in all_of if g > TIE)


def main():
    failed, ties = [], {}
    with tempfile.TemporaryDirectory() as folder:
        for title, words in SETS.items():
            path = os.path.join(folder, title + ".csv")
            run("simulate", *words, "-o", path)
            orders = {isa: ranked(path, isa) for isa in ("scalar", "avx2", "avx512")}
            orders = {isa: rows for isa, rows in orders.items() if rows}
            first = orders["scalar"]
            for isa, rows in orders.items():
                failed += [f"{title}: {isa} has {b[3]} where scalar has {a[3]}" for a, b in zip(first, rows) if a[3] != b[3]]
                wrong, ties[title] = wrong_ties(rows, 1)
                failed += [f"{title}, {isa}: {pair}" for pair in wrong]
            print(f"{title}: {len(first)} models by {', '.join(orders)}; {ties[title]} tied with the one before")
            print(f"  between sets {between_sets(orders):.1e}, between models {gaps(first)[0]:.1e} that counts as none, else {gaps(first)[1]:.1e}")
    if ties["exact"] < 2:
        failed.append("the exact data have no tied models: the test is wrong")
    print("\n".join(failed), end="\n" if failed else "")
    return bool(failed)


if __name__ == "__main__":
    sys.exit(main())
