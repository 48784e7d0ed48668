#!/usr/bin/env python3
"""files_test.py PROGRAM: fit and compare of many files with -o DIR.

The JSON of each is, to the byte, what the command makes that it holds; the summary is the same in whatever order files are done, in shards
and after a stop; what fails is named with its reason and holds up nothing; nothing that is read is written."""
import base64
import csv
import fcntl
import io
import json
import os
import re
import signal
import struct
import subprocess
import sys
import time
import urllib.parse

from batches import Library

lib = Library(sys.argv[1])


def rows(data):
    return list(csv.DictReader(io.StringIO(data.decode())))


def one_by_one(folder):
    """Each recorded command, run by hand, makes the same bytes; so does the plain one, but for its time."""
    for name, data in lib.results(folder).items():
        command = json.loads(data)["command"]
        lib.check(command[0] == "facetfit" and command[-2:] == ["--json", name], f"{name}: its command is {command}")
        lib.run(*command[1:])
        lib.check(lib.read(name) == data, f"{name}: {' '.join(command)} makes other bytes")
        words = [word for word in command[1:] if word != "--no-times"]
        lib.run(*words)
        plain, timed = lib.read(name), rb'"time_s": [0-9.e-]+'
        lib.check(re.search(timed, plain) and b'"time_s": null' in data, f"{name}: times")
        untimed = re.sub(timed, b'"time_s": null', plain).replace(b'"--json"', b'"--no-times", "--json"')
        lib.check(untimed == data, f"{name}: the plain command makes other bytes")
        os.remove(lib.at(name))


def check_row(row, document):
    """A row of a table says what the document says of its best fit."""
    fit = document["fits"][document["ranking"][0]]
    several = len(fit["channels"]) > 1
    for name, p in fit["parameters"].items():
        listed = isinstance(p["value"], list)
        for k, channel in enumerate(fit["channels"] if listed else [""]):
            key = f"{name}[{channel}]" if listed and several else name
            value, error = (p["value"][k], p["std_error"][k]) if listed else (p["value"], p["std_error"])
            same = not row.get(key) if p["held"] else float(row[key]) == value and (float(row[key + "_error"]) if row[key + "_error"] else None) == error
            lib.check(same, f"{row['file']}: {key} is {row.get(key)}, {row.get(key + '_error')} in the table, {value}, {error} in the document")
    lib.check(float(row["explained"]) == fit["explained"]["share"] and int(row["samples"]) == document["data"]["used"], f"{row['file']}: shares")
    lib.check(row["warnings"].split() == [w["code"] for w in fit["warnings"]], f"{row['file']}: warnings")
    lib.check(row["verdict"].split() == [v["code"] for v in document["verdict"]], f"{row['file']}: verdict")


def same_summary():
    lib.fill(12)
    lib.run("fit", "lib", "-o", "one", "--jobs", "1", "--summary", "one.csv", expected=0, said=["12 files: 12 done"])
    one_by_one("one")
    expected, results = lib.read("one.csv"), lib.results("one")
    for row in rows(expected):
        check_row(row, json.loads(results[row["json"]]))
    lib.check(len(results) == 12 and len(rows(expected)) == 12, "12 results and rows")
    names = sorted(os.listdir(lib.at("lib")))
    lib.write("list", "\n".join("lib/" + name for name in names).encode() + b"\n")
    ways = (["lib"], ["--jobs", "4"]), (["lib"], ["--jobs", "2", "--threads", "5"]), (["@list", "lib"], []), (["lib/" + n for n in names], ["--threads", "3"])
    for k, (words, more) in enumerate(ways):
        lib.run("fit", *words, "-o", f"out{k}", "--summary", f"{k}.csv", *more, expected=0)
        lib.check(lib.read(f"{k}.csv") == expected, f"{words[:2]} {more}: another summary")
        lib.check(lib.results(f"out{k}") == results, f"{words[:2]} {more}: other results")
    words = ["lib/" + name for name in reversed(names)]
    lib.run("fit", *words, "-o", "reversed", "--summary", "r.csv", expected=0)
    lib.check(rows(lib.read("r.csv"))[::-1] == rows(expected), "the order of files changes rows")  # columns are in the order of the rows
    lib.run("fit", "lib", "-o", "one", "--summary", "one.json", "--resume", expected=0)
    as_json = json.loads(lib.read("one.json"))["files"]
    for row, other in zip(rows(expected), as_json):
        same = row["file"] == other["file"] and row["model"] == other["model"] and float(row["rmse"]) == other["rmse"]
        same = same and all(float(row[p]) == v["value"] for p, v in other["parameters"].items())
        lib.check(same and row["state"] == "done", f"{row['file']}: CSV and JSON differ")
    lib.check(len(as_json) == 12, "rows of the JSON")


def damaged():
    """A fifth of the files is damaged, each in its own way."""
    lib.fill(20, "mixed")
    ways = {"m0003.csv": b"", "m0007.csv": b"\x00\xff" * 200, "m0011.csv": b"theta_i,phi_i,theta_o,phi_o,f\n30,0,x,180,1\n",
            "m0015.csv": b"theta_i,phi_i,theta_o,phi_o,f\n"}
    for name, data in ways.items():
        lib.write("mixed/" + name, data)
    os.symlink("nowhere", lib.at("mixed", "m0019.csv.link"))
    words = [f"mixed/m{i:04}.csv" for i in range(20)] + ["mixed/absent.csv", "mixed/m0019.csv.link"]
    done = lib.run("fit", *words, "-o", "damaged", "--summary", "damaged.csv", expected=1, said=["22 files: 16 done", "6 failed, 0 missing"])
    table = {row["file"]: row for row in rows(lib.read("damaged.csv"))}
    for name in list(ways) + ["absent.csv", "m0019.csv.link"]:
        row = table["mixed/" + name]
        lib.check(row["state"] == "failed" and len(row["message"]) > len(name) + 10 and not row["model"] and not row["json"], f"{name}: {row['state']}, {row['message']}")
        lib.check(any(line.startswith(f"facetfit: error: mixed/{name}:") for line in done.err.splitlines()), f"{name} is not named: {done.err}")
    lib.check({row["json"] for row in table.values() if row["json"]} == set(lib.results("damaged")), "the results that the summary names are not those that there are")
    lib.check(len(lib.results("damaged")) == 16 and sum(row["state"] == "done" for row in table.values()) == 16, "all others are done")
    done = lib.run("fit", *words, "-o", "stopped", "--no-keep-going", "--jobs", "1", "--summary", "stopped.csv", expected=1, said=["missing"])
    lib.check(3 <= len(lib.results("stopped")) < 16, "--no-keep-going goes on")
    done = lib.run("fit", "mixed", "-o", "in_folder", expected=1)
    lib.check("mixed/m0007.csv: passed over" in done.err and "mixed/m0003.csv: " in done.err, f"a folder: {done.err}")


def state(folder):
    return {name: os.stat(lib.at(folder, name)).st_mtime_ns for name in os.listdir(lib.at(folder)) if name.endswith(".json")}


def again():
    """--resume does what is not done, and nothing else."""
    lib.fill(8, "again")
    lib.run("fit", "again", "-o", "resumed", "--summary", "first.csv", expected=0)
    before = state("resumed")
    lib.run("fit", "again", "-o", "resumed", "--resume", "--summary", "second.csv", expected=0, said=["8 of them were done before"])
    lib.check(state("resumed") == before and lib.read("first.csv") == lib.read("second.csv"), "nothing is to be done")
    journal = lib.read("resumed", "journal.tsv")
    lib.check(journal.count(b"\n") == 8, "a line for each file that was done")
    lib.write("again/m0002.csv", b"# another\n" + lib.bases[4])  # changed meanwhile
    lib.write("resumed/m0003.csv.json", lib.read("resumed", "m0003.csv.json")[:-9])  # cut
    os.remove(lib.at("resumed", "m0004.csv.json"))  # lost
    lib.write("resumed/m0001.csv.json", re.sub(rb'"rmse": 0', b'"rmse": 1', lib.read("resumed", "m0001.csv.json")))  # a document still, and another
    lib.write("resumed/m0005.csv.json.part-1-0", b"{")  # what a kill leaves
    lib.write("resumed/other.json.part-1-0", b"{")  # of somebody else
    lib.write("resumed/journal.tsv", journal[:-20])  # half a line, of m0007 or another
    cut = journal.splitlines()[-1].split(b"\t")[0].decode()
    lib.run("fit", "again", "-o", "resumed", "--resume", "--summary", "third.csv", expected=0)
    lib.check([n for n in os.listdir(lib.at("resumed")) if ".part-" in n] == ["other.json.part-1-0"], "parts of results that a kill left")
    after = state("resumed")
    changed = {name for name in after if after[name] != before.get(name)}
    lib.check(changed == {"m0001.csv.json", "m0002.csv.json", "m0003.csv.json", "m0004.csv.json", cut}, f"done again: {sorted(changed)}")
    lib.run("fit", "again", "-o", "resumed", "--resume", expected=0, said=["8 of them were done before"])  # no line is lost in the half one
    lib.run("fit", "again", "-o", "fresh", "--summary", "fresh.csv", expected=0)
    lib.check(lib.read("fresh.csv") == lib.read("third.csv") and lib.results("fresh") == lib.results("resumed"), "as an undisturbed run")
    lib.write("fresh/journal.tsv", lib.read("fresh", "journal.tsv")[:-20])  # the next line must not go on in the half one
    for n in (7, 8):
        lib.run("fit", "again", "-o", "fresh", "--resume", expected=0, said=[f"{n} of them were done before"])
    lib.run("fit", "again", "-o", "resumed", "--resume", "--loss", "log", expected=0)
    lib.check(all(state("resumed")[name] != after[name] for name in after), "another loss is another command")
    lib.run("fit", "again", "-o", "resumed", "--resume", "--jobs", "1", "--loss", "log", expected=0, said=["8 of them were done before"])


def without_answer():
    """A fit that does not converge is a result, and the answer is no; so it is when it was done before."""
    lib.fill(3, "slow")
    words = ["fit", "slow", "-o", "limited", "--model", "student-t+beckmann+lambert", "--max-iterations", "1", "--summary", "limited.csv"]
    for more in ([], ["--resume"]):
        lib.run(*words, *more, expected=1, said=["3 done, of which 2 did not converge; 0 failed"])
        for row in rows(lib.read("limited.csv")):
            lib.check((row["outcome"] == "limit") == ("did not converge" in row["message"]), f"{row['file']}: {row['outcome']}, {row['message']}")


def names():
    for folder in ("x/a", "x/b"):
        lib.fill(1, folder)
    one, two = "x/a/m0000.csv", "x/b/m0000.csv"
    for words in ((one, two), (two, one)):
        lib.run("fit", *words, "-o", "collided", expected=2, said=[one, two, "--names path"])
    lib.check(not os.path.exists(lib.at("collided")), "a refused batch leaves a folder")
    for words in ((one, two), (two, one)):
        lib.run("fit", *words, "-o", "by_path", "--names", "path", expected=0)
        lib.check(set(lib.results("by_path")) == {"x_a_m0000.csv.json", "x_b_m0000.csv.json"}, "names of whole paths")
    lib.run("fit", "x", "-o", "of_folder", expected=0)
    lib.check(set(lib.results("of_folder")) == {"a_m0000.csv.json", "b_m0000.csv.json"}, "names below a folder")
    lib.write("-dash.csv", lib.bases[0])
    lib.run("fit", "-o", "dash", "--", "-dash.csv", expected=0)
    command = json.loads(lib.read("dash", "-dash.csv.json"))["command"]
    lib.check(command[-2:] == ["--", "-dash.csv"], f"a name that looks like a flag: {command}")


def refused():
    lib.fill(2, "r")
    lib.write("r.json", lib.bases[0])
    os.makedirs(lib.at("same"))
    os.link(lib.at("r", "m0000.csv"), lib.at("same", "m0001.csv.json"))  # a result of one is the file of another
    before = lib.read("r", "m0000.csv")
    lib.run("fit", "r", "-o", "same", "--force", expected=2, said=["is the input r/m0000.csv"])
    lib.run("fit", "r", "-o", "out", "--summary", "r/m0001.csv", expected=2)
    os.symlink(lib.at("r", "m0001.csv"), lib.at("link.csv"))
    lib.run("fit", "r", "-o", "out", "--summary", "link.csv", "--force", expected=2, said=["r/m0001.csv"])
    lib.check(lib.read("r", "m0000.csv") == before, "an input was written")
    for words, text in ((["--summary", "s.csv"], "-o DIR"), (["--resume"], "-o DIR"), (["-o", "d", "--json", "j.json"], "--json is of one file"),
                        (["-o", "d", "--shard", "0/3"], "I from 1 to N"), (["-o", "d", "--shard", "4/3"], "I from 1 to N"),
                        (["-o", "d", "--shard", "1"], "expected I/N"), (["-o", "d", "--summary", "s.txt"], "NAME.csv or NAME.json"),
                        (["-o", "d", "--sort", "verdict"], "--summary FILE"), (["-o", "d", "--times"], "leave out --times")):
        lib.run("fit", "r/m0000.csv", *words, expected=2, said=[text])
        lib.check(not os.path.exists(lib.at("d")), f"{words} made the folder")
    lib.run("fit", "-", "-o", "d", expected=2, said=["standard input"])
    lib.run("fit", "@absent", "-o", "d", expected=3, said=["absent"])
    lib.run("fit", "r", "-o", "r.json", expected=4, said=["is no folder"])
    lib.run("gather", "r", expected=3, said=["jobs.tsv"])
    lib.run("fit", "r", "-o", "locked", expected=0)
    with open(lib.at("locked", "journal.tsv"), "ab") as journal:
        fcntl.flock(journal, fcntl.LOCK_EX)
        lib.run("fit", "r", "-o", "locked", expected=4, said=["another run"])


def shards():
    lib.fill(10, "s")
    lib.run("fit", "s", "-o", "whole", "--summary", "whole.csv", expected=0)
    for k in (1, 2, 4):  # 3 is lost
        lib.run("fit", "s", "-o", "parts", "--shard", f"{k}/4", expected=0, said=["2 files: 2 done" if k == 4 else "3 files: 3 done"])
    gathered = lib.run("gather", "parts", "--summary", "g.csv", expected=1)
    missing = re.findall(r"^(s/m\d+\.csv): missing$", gathered.stdout.decode(), re.M)
    lib.check(missing == ["s/m0002.csv", "s/m0006.csv"] and b"8 done" in gathered.stdout, f"missing: {missing}")
    lib.check([row["state"] for row in rows(lib.read("g.csv"))].count("missing") == 2, "the summary says what is missing")
    lib.run("fit", "s", "-o", "parts", "--resume", expected=0, said=["shard 3 of 4", "2 files: 2 done"], SLURM_ARRAY_TASK_ID="5",
            SLURM_ARRAY_TASK_COUNT="4", SLURM_ARRAY_TASK_MIN="3", SLURM_ARRAY_TASK_STEP="1")
    lib.run("gather", "parts", "--summary", "g.csv", "--json", "g.json", expected=0)
    lib.check(lib.read("g.csv") == lib.read("whole.csv") and lib.results("parts") == lib.results("whole"), "shards make what a whole run does")
    lib.run("fit", "s", "-o", "whole", "--resume", "--summary", "whole.json", expected=0)
    lib.check(lib.read("g.json") == lib.read("whole.json"), "the JSON of gather is the summary")
    lib.write("parts/m0005.csv.json", b"{}")
    lib.run("gather", "parts", expected=1)
    lib.run("fit", "s", "-o", "parts", expected=2, said=["none of it"], SLURM_ARRAY_TASK_ID="9", SLURM_ARRAY_TASK_COUNT="4", SLURM_ARRAY_TASK_MIN="3")


def interrupted():
    """Ctrl-C: within a second, no part of a file, and the rest is done by --resume."""
    lib.fill(40, "i")
    words = [lib.program, "fit", "i", "-o", "int", "--model", "student-t+beckmann+lambert", "--bootstrap", "200", "--jobs", "2", "--resume"]
    for number in (signal.SIGINT, signal.SIGTERM):
        before = len(lib.results("int")) if os.path.exists(lib.at("int")) else 0
        p = subprocess.Popen(words, cwd=lib.folder, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
        limit = time.monotonic() + 60
        while p.poll() is None and time.monotonic() < limit and (not os.path.exists(lib.at("int")) or len(lib.results("int")) <= before):
            time.sleep(0.005)
        began = time.monotonic()
        p.send_signal(number)
        err = p.communicate(timeout=60)[1]
        took = time.monotonic() - began
        expected = 130 if number == signal.SIGINT else -number
        lib.check(p.returncode == expected, f"{number.name}: status {p.returncode}, {err}")
        lib.check(took < 1, f"{number.name}: ended after {took:.2f} s")
        lib.no_parts("int", number.name)
        done, journal = lib.results("int"), lib.read("int", "journal.tsv")
        lib.check(before < len(done) < 40, f"{number.name}: came with {len(done)} files done")
        lib.check(journal.count(b"\n") == len(done), f"{number.name}: {len(done)} results, {journal.count(bytes([10]))} lines")
        for data in done.values():
            json.loads(data)


def differences():
    lib.fill(6, "d")
    lib.run("fit", "d", "-o", "old", "--summary", "old.csv", expected=0)
    lib.run("fit", "d", "-o", "new", "--summary", "new.csv", expected=0)
    same = lib.run("diff", "old.csv", "new.csv", expected=0)
    lib.check(same.stdout == b"6 rows in both, 0 changes\n", f"no difference: {same.stdout}")
    table = rows(lib.read("old.csv"))
    error = float(table[2]["alpha_x_error"])
    table[2]["alpha_x"] = repr(float(table[2]["alpha_x"]) + 3 * error)  # by 3 / sqrt(2) errors of the difference
    table[3]["model"] = "beckmann+lambert"
    table[4]["f0_error"] = ""
    gone = table.pop(5)
    text = io.StringIO()
    writer = csv.DictWriter(text, list(table[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(table)
    lib.write("moved.csv", text.getvalue().encode())
    found = rows(lib.run("diff", "old.csv", "moved.csv", "--table", "csv", expected=1).stdout)
    said = [(row["file"], row["what"]) for row in found]
    lib.check(said == [("d/m0002.csv", "alpha_x"), ("d/m0003.csv", "model"), (gone["file"], "file")], f"differences: {said}")
    lib.check(abs(float(found[0]["errors"]) - 3 / 2 ** 0.5) < 1e-6, f"in errors: {found[0]}")
    lib.run("diff", "old.csv", "moved.csv", "--limit", "2.2", expected=1)
    found = rows(lib.run("diff", "old.csv", "moved.csv", "--limit", "2.2", "--table", "csv").stdout)
    lib.check("alpha_x" not in [row["what"] for row in found], "--limit")
    lib.run("diff", "lib/m0000.csv", "old.csv", expected=3, said=["is no summary"])
    lib.write("short.csv", lib.read("old.csv") + b"a,b\n")
    lib.run("diff", "old.csv", "short.csv", expected=3, said=["short.csv:8", "found 2 cells"])


def sorted_ones():
    lib.fill(5, "o")
    lib.write("o/bad.csv", b"")
    grid = "theta_i,phi_i,theta_o,phi_o,f\n" + "".join(f"30,0,{t},180,{(7 * t) % 11 + 1}\n" for t in range(0, 80, 3))
    lib.write("o/a_poor.csv", grid.encode())
    lib.run("fit", "o", "-o", "sorted", "--summary", "v.csv", "--sort", "verdict", expected=1)
    first = rows(lib.read("v.csv"))
    lib.check(first[0]["file"] == "o/bad.csv" and first[1]["file"] == "o/a_poor.csv", f"worst first: {[r['file'] for r in first]}")
    shares = [float(row["explained"]) for row in first if row["quality"] == "good"]
    lib.check(len(shares) == 5 and shares == sorted(shares), f"of good ones the worst first: {shares}")
    lib.run("fit", "o", "-o", "sorted", "--resume", "--summary", "w.csv", "--sort", "residual", expected=1)
    values = [float(row["rmse"]) for row in rows(lib.read("w.csv")) if row["rmse"]]
    lib.check(len(values) == 6 and values == sorted(values, reverse=True), f"by residual: {values}")
    file_order = rows(lib.run("gather", "sorted", "--summary", "-", expected=1).stdout)
    lib.check([r["file"] for r in file_order] == sorted(r["file"] for r in file_order), "by file")


def pages():
    """--html: a page of each file, and an index of them, the worst first, that leads to each and shows a sphere; nothing from elsewhere."""
    lib.fill(4, "p")
    strange = 'p/<i>&"%.csv'
    lib.write(strange, b"# strange\n" + lib.bases[1])
    lib.write("p/zero.csv", b"")
    lib.run("fit", "p", "-o", "without", "--summary", "without.csv", expected=1)
    lib.run("fit", "p", "-o", "pages", "--html", "pages/index.html", "--summary", "pages/s.csv", "--jobs", "2", expected=1)
    lib.check(lib.results("pages") == lib.results("without") and lib.read("pages", "s.csv") == lib.read("without.csv"), "pages change results")
    index = lib.read("pages", "index.html").decode()
    links = [urllib.parse.unquote(link) for link in re.findall(r'href="([^"]*)"', index)]
    lib.check(len(links) == 5 and all(os.path.exists(lib.at("pages", link)) for link in links), f"links of the index: {links}")
    for link in links:
        lib.check(lib.read("pages", link).lower().startswith(b"<!doctype html>"), f"{link} is no page")
    pictures = re.findall(r'src="data:image/png;base64,([A-Za-z0-9+/=]*)"', index)
    lib.check(len(pictures) == 5 and len(set(pictures)) >= 4, f"{len(pictures)} spheres")
    for picture in pictures:
        data = base64.b64decode(picture)
        lib.check(data[:8] == b"\x89PNG\r\n\x1a\n" and struct.unpack(">II", data[16:24]) == (48, 48), "a sphere is no PNG of 48 by 48")
    lib.check(not re.search(r"(?:src|href)=\"(?:https?:)?//|<script|<i>", index), "the index asks for something, or text became markup")
    lib.check(index.index("zero.csv") < index.index("<a href"), "what failed is first")
    lib.check(re.search(r"zero\.csv</td><td class=\"failed\">failed</td><td colspan=\"3\"><small>[^<]", index), "the message of what failed has room")
    lib.check(index.count("alpha_x&nbsp;") == 5 and "alpha_y" not in index, "a parameter that follows another is said twice")
    before = state("pages")
    os.remove(lib.at("pages", "m0001.csv.html"))
    lib.run("fit", "p", "-o", "pages", "--html", "pages/index.html", "--resume", expected=1, said=["4 of them were done before"])
    lib.check(lib.read("pages", "index.html").decode() == index and os.path.exists(lib.at("pages", "m0001.csv.html")), "a page that was lost")
    lib.check({n for n in before if state("pages")[n] != before[n]} == {"m0001.csv.json"}, "the others are left alone")
    lib.run("gather", "pages", "--html", "pages/gathered.html", expected=1)
    lib.check(lib.read("pages", "gathered.html").decode() == index, "the index of gather is another")
    lib.run("gather", "pages", "--html", "above.html", expected=1)
    above = [urllib.parse.unquote(link) for link in re.findall(r'href="([^"]*)"', lib.read("above.html").decode())]
    lib.check(above == ["pages/" + link for link in links], f"from above: {above}")
    os.makedirs(lib.at("beside"))
    lib.run("gather", "pages", "--html", "beside/x.html", expected=1)
    beside = [urllib.parse.unquote(link) for link in re.findall(r'href="([^"]*)"', lib.read("beside", "x.html").decode())]
    lib.check(beside == [os.path.realpath(lib.at("pages", link)) for link in links], f"from beside: {beside}")


def compared():
    lib.fill(4, "c")
    flags = ["--ndf", "ggx,beckmann", "--masking", "smith-separable", "--channels", "each"]
    lib.run("compare", "c", "-o", "compared", *flags, "--summary", "c.csv", expected=0)
    one_by_one("compared")
    table = rows(lib.read("c.csv"))
    expected = sum(2 if i % len(lib.bases) % 2 else 1 for i in range(4))  # channels of each
    lib.check(len(table) == expected and all(row["model"].startswith("ggx/") for row in table), f"the best of each channel: {len(table)} rows")
    lib.run("compare", "c", "-o", "compared", *flags, "--resume", expected=0, said=["4 of them were done before"])


same_summary()
damaged()
again()
without_answer()
names()
refused()
shards()
interrupted()
differences()
sorted_ones()
pages()
compared()
sys.exit(lib.end())
