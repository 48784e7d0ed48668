#!/usr/bin/env python3
"""full_disk_test.py PROGRAM SHIM: a disk that is full from one step of a batch on. It ends with status 4 and the system's reason, names
every file that has no result, leaves nothing cut, and goes on with --resume where there is room again."""
import errno
import os
import re
import sys

from batches import Library

lib, shim = Library(sys.argv[1]), os.path.abspath(sys.argv[2])
FILES = 6
lib.fill(FILES)
lib.run("fit", "lib", "-o", "sound", "--jobs", "1", "--summary", "sound.csv", expected=0, LD_PRELOAD=shim, DISK_COUNT=lib.at("count"))
steps, letters = int(lib.read("count").split()[0]), lib.read("count").split()[-1]
expected = lib.results("sound")
full = 0
for step in range(1, steps + 1):
    folder = f"full{step}"
    done = lib.run("fit", "lib", "-o", folder, "--jobs", "1", "--summary", f"{folder}.csv", LD_PRELOAD=shim, DISK_FAIL=f"{step}:{errno.ENOSPC}", DISK_COUNT=lib.at("count"))
    if done.returncode == 0:
        continue  # what failed was the end of something that was whole
    full += 1
    tried = lib.read("count").split()[-1].count(b"o") if letters[step - 1] in b"ow" and step < steps // 2 else 0
    lib.check(tried <= letters[:step].count(b"o") + 2, f"step {step}: {tried} files are opened, though nothing can be written any more")
    lib.check(done.returncode == 4 and "No space left" in done.err, f"step {step}: status {done.returncode}, {done.err}")
    made = lib.results(folder) if os.path.exists(lib.at(folder)) else {}
    missing = set(re.findall(r"^facetfit: error: lib/(m\d+\.csv): missing$", done.err, re.M))
    lib.check(all(data == expected[name] for name, data in made.items()), f"step {step}: a result is cut")
    summary_only = "completely" in done.err and f"{folder}.csv" in done.err
    begun = "files: " in done.err
    unnamed = {f"m{i:04}.csv" for i in range(FILES)} - {name[:-5] for name in made} - missing
    lib.check(not begun or summary_only or not unnamed, f"step {step}: {unnamed} have no result and are not named: {done.err}")
    if os.path.exists(lib.at(folder)):
        lib.no_parts(folder, f"step {step}")
    lib.check(not os.path.exists(lib.at(f"{folder}.csv")), f"step {step}: there is a summary")
    lib.run("fit", "lib", "-o", folder, "--resume", "--summary", f"{folder}.csv", expected=0)
    lib.check(lib.results(folder) == expected and lib.read(f"{folder}.csv") == lib.read("sound.csv"), f"step {step}: --resume ends otherwise")
print(f"{full} of {steps} steps end the batch")
lib.check(full > FILES, "too few steps failed")
sys.exit(lib.end())
