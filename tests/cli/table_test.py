#!/usr/bin/env python3
"""table_test.py PROGRAM: the tables of --table. CSV and TSV have the numbers of the JSON, bit by bit; every row of every form has as
many cells as its head, also with hundreds of columns and with names that are full of separators."""
import csv
import io
import json
import os
import re
import subprocess
import sys
import tempfile

PROGRAM = os.path.abspath(sys.argv[1])
failures = 0
checks = 0


def check(condition, what):
    global failures, checks
    checks += 1
    if not condition:
        failures += 1
        print("failed:", what)


def run(*args, status=(0,)):
    p = subprocess.run([PROGRAM, *args], capture_output=True)
    check(p.returncode in status, "%s: status %d, %s" % (args, p.returncode, p.stderr.decode()))
    return p.stdout.decode("utf-8"), p.stderr.decode("utf-8")


def rows_of(form, text):
    """Rows of cells, the head first."""
    if form == "csv":
        return list(csv.reader(io.StringIO(text)))
    lines = text.splitlines()
    if form == "tsv":
        return [line.split("\t") for line in lines]
    if form == "md":
        lines = lines[:lines.index("")] if "" in lines else lines
        cells = [[re.sub(r"\\(.)", r"\1", c.strip()) for c in re.split(r"(?<!\\)\|", line)[1:-1]] for line in lines]
        check(set("".join(cells[1])) <= set("-:"), "the second line of Markdown: " + lines[1])
        return [cells[0]] + cells[2:]
    check(lines[0].startswith("\\begin{tabular}{") and "\\end{tabular}" in lines, "a tabular: " + lines[0])
    body = [line for line in lines if line.endswith("\\\\")]
    cells = [[c.strip() for c in re.split(r"(?<!\\)&", line[:-2])] for line in body]
    check(len(cells[0]) == len(lines[0]) - len("\\begin{tabular}{}"), "the columns of the tabular: " + lines[0])
    plain = re.sub(r"\\[&%$#_{}]|\\textbackslash\{\}|\\\^\{\}|\$\\sim\$|\$[<>|]\$|\$-?[0-9.]+(\\times10\^\{-?[0-9]+\})?\$", "", "".join(body))
    check(not re.search(r"[%$#_^~{}]", plain), "LaTeX without bare commands")
    return cells


def table(form, *args, status=(0,)):
    out, messages = run(*args, "--table", form, status=status)
    rows = rows_of(form, out)
    check(len(rows) > 1 and all(len(r) == len(rows[0]) for r in rows), "%s as %s: rows of one length" % (args, form))
    if form in ("csv", "tsv"):
        check(len(set(rows[0])) == len(rows[0]) and all(rows[0]), "%s as %s: unique names, %s" % (args, form, rows[0]))
        check(not any(" " in name for name in rows[0] if "[" not in name), "%s as %s: names in one word" % (args, form))
    return rows, messages


def records(form, *args, status=(0,)):
    rows, messages = table(form, *args, status=status)
    return [dict(zip(rows[0], r)) for r in rows[1:]], messages


def same(cell, number):
    return (cell == "") == (number is None) and (number is None or float(cell) == number)


def check_fit(file, *flags, status=(0,)):
    document = json.loads(run("fit", file, *flags, "--json", "-", status=status)[0])
    for form in ("csv", "tsv"):
        rows, messages = records(form, "fit", file, *flags, status=status)
        said = sum(len(f["warnings"]) for f in document["fits"])
        check(messages.count("warning:") == said, "fit %s: %d warnings on stderr, %d in the JSON" % (flags, messages.count("warning:"), said))
        seen = 0
        for f in document["fits"]:
            mine = [r for r in rows if r.get("fit", f["channels"][0]) == f["channels"][0]]
            for r in mine:
                p = f["parameters"][r["parameter"]]
                if isinstance(p["value"], list):
                    k = f["channels"].index(r["channel"])
                    p = {key: p[key][k] if isinstance(p[key], list) else p[key] for key in ("value", "std_error", "at_bound", "held")}
                check(same(r["value"], p["value"]), "fit %s: %s = %s, %s" % (flags, r["parameter"], r["value"], p["value"]))
                if not p.get("held") and not p.get("tied"):
                    check(same(r["std_error"], p.get("std_error")) or p.get("at_bound"), "fit %s: error of %s" % (flags, r))
                seen += 1
        check(seen == len(rows), "fit %s: every row is of a fit" % (flags,))


def main():
    weird = 'a|b&c_d%e"f,g'
    run("simulate", "ggx+lambert", "--set", "alpha=0.2,f0=0.5:0.4:0.3,kd=0.1", "--grid", "goniometer:10", "--noise", "0.05", "-o", "a.csv")
    check_fit("a.csv")
    check_fit("a.csv", "--shape", "isotropic", "--fix", "kd=0")
    check_fit("a.csv", "--channels", "mean")
    check_fit("a.csv", "--channels", "each")

    document = json.loads(run("compare", "a.csv", "--ndf", "ggx,gtr,beckmann", "--cross-validate", "3", "--json", "-")[0])
    for form in ("csv", "tsv"):
        rows, _ = records(form, "compare", "a.csv", "--ndf", "ggx,gtr,beckmann", "--cross-validate", "3", "--rows", "2")
        check(len(rows) == len(document["fits"]), "compare as %s has all fits" % form)
        known = ("rank distribution masking model objective rmse cosine_rmse log_rmse delta_aic vuong_z told_apart held_out "
                 "held_out_error outcome on_bound alpha_x").split()
        check([c for c in rows[0] if c in known] == known, "columns: %s" % list(rows[0]))
        check("(null)" not in rows[0] and list(rows[0])[-1] == "kd[b]", "the last column")
        check([r["rank"] for r in rows] == [str(k + 1) for k in range(len(rows))], "ranks")
        check(float(rows[0]["objective"]) == min(f["residual"]["objective"] for f in document["fits"]), "the best is first")
        for r in rows:
            f = next(f for f in document["fits"] if f["model"] == r["model"])
            check(same(r["objective"], f["residual"]["objective"]), "objective of " + r["model"])
            check(r["outcome"] == f["outcome"], "outcome of " + r["model"])
            for name, p in f["parameters"].items():
                for channel, value in zip(f["channels"], p["value"]) if isinstance(p["value"], list) else [(None, p["value"])]:
                    column = "%s[%s]" % (name, channel) if channel else name
                    if column in r:
                        check(same(r[column], value), "%s of %s" % (column, r["model"]))
                    else:
                        check(p.get("held", False), "no column %s" % column)
    for form in ("md", "latex"):
        rows, _ = table(form, "compare", "a.csv", "--ndf", "ggx,gtr,beckmann", "--rows", "2", "--channels", "each")
        check(len(rows) == 1 + 3 * 2, "two rows of each channel as " + form)
        check("more of each (--rows 0 shows all)" in run("compare", "a.csv", "--ndf", "ggx,gtr,beckmann", "--rows", "2", "--channels",
                                                        "each", "--table", form)[0], "says that there are more as " + form)
        for command in (["fit", "a.csv"], ["fit", "a.csv", "--channels", "each"], ["ndf", "a.csv"], ["info", "a.csv"], ["models"], ["formats"]):
            table(form, *command)

    for form in ("csv", "tsv"):
        rows, _ = records(form, "info", "a.csv")
        document = json.loads(run("info", "a.csv", "--json", "-")[0])
        for r, c in zip(rows, document["channels"]):
            check(r["channel"] == c["name"] and same(r["max"], c["max"]), "info: %s" % r)
        check(len(rows) == 3, "info: rows")
        check(len(records(form, "models")[0]) == len(json.loads(run("models", "--json", "-")[0])["terms"]), "models: all")
        check(len(records(form, "formats")[0]) == len(json.loads(run("formats", "--json", "-")[0])["formats"]), "formats: all")
        rows, _ = records(form, "ndf", "a.csv")
        check([r["quantity"] for r in rows][-6:] == ["f0[r]", "f0[g]", "f0[b]", "kd[r]", "kd[g]", "kd[b]"], "ndf: parameters")

    # Names with every separator, and more columns than anyone counts on.
    lines = open("a.csv").read().splitlines()
    head = next(i for i, line in enumerate(lines) if line.startswith("theta_i"))
    with open("many.csv", "w") as out:
        names = ["f_c%d" % k for k in range(60)]
        out.write("# quantity: brdf\n" + ",".join(["theta_i,phi_i,theta_o,phi_o"] + names) + "\n")
        for line in lines[head + 1:]:
            cells = line.split(",")
            out.write(",".join(cells[:4] + [cells[4]] * 60) + "\n")
    rows, _ = table("csv", "compare", "many.csv", "--ndf", "ggx", "--masking", "smith-separable,v-cavity")
    check(sum(name.startswith(("f0[", "kd[")) for name in rows[0]) == 120, "120 columns of 60 channels")
    check(len(table("csv", "fit", "many.csv")[0]) > 120, "a row for every parameter of 60 channels")
    with open("weird.csv", "w") as out:
        out.write("# quantity: brdf\n" + "theta_i,phi_i,theta_o,phi_o,f_x,\"f_%s\"\n" % weird.replace('"', '""'))
        for line in lines[head + 1:]:
            out.write(",".join(line.split(",")[:6]) + "\n")
    named = json.loads(run("info", "weird.csv", "--json", "-")[0])["channels"][1]["name"]
    for form in ("csv", "tsv"):
        check(any(r["channel"] == named for r in records(form, "info", "weird.csv")[0]), "the name %s as %s" % (named, form))
    check(any(named in r[0] for r in table("md", "info", "weird.csv")[0]), "the name %s as md" % named)
    table("latex", "info", "weird.csv")

    out, messages = run("fit", "a.csv", "--table", "csv", "--json", status=(2,))
    check(out == "" and "standard output" in messages, "both on standard output")
    out, _ = run("fit", "a.csv", "--table", "csv", "--json", "fit.json")
    check(out.startswith("parameter,") and json.load(open("fit.json"))["fits"], "the table and a file of JSON")
    check(run("fit", "a.csv", "--table", "text")[0].startswith("alpha"), "text is the report")


with tempfile.TemporaryDirectory() as folder:
    os.chdir(folder)
    main()
print("%d checks, %d failures" % (checks, failures))
sys.exit(failures != 0)
