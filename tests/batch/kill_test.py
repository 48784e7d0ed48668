#!/usr/bin/env python3
"""kill_test.py PROGRAM [--all]: a batch that is killed at random moments, where no handler runs, ends with --resume as one that was not:
the same results and the same summary, to the byte; what a kill leaves is whole, or goes."""
import os
import random
import signal
import subprocess
import sys
import time

from batches import Library

lib = Library(sys.argv[1])
everything = "--all" in sys.argv
FILES, KILLS = (500, 10) if everything else (60, 5)
draw = random.Random(int(os.environ.get("FF_TEST_SEED", "0")))


def whole_results():
    """What has a name is complete."""
    for name, data in lib.results("killed").items():
        lib.check(data.endswith(b"}\n") and data == expected[name], f"{name} is cut or wrong")


lib.fill(FILES)
began = time.monotonic()
lib.run("fit", "lib", "-o", "sound", "--summary", "sound.csv", expected=0)
took = time.monotonic() - began
expected = lib.results("sound")
words = [lib.program, "fit", "lib", "-o", "killed", "--summary", "killed.csv", "--resume", "--jobs", "2"]
done, killed = [], 0
for _ in range(KILLS):
    p = subprocess.Popen(words, cwd=lib.folder, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    time.sleep(draw.uniform(0, took / KILLS))
    p.kill()
    killed += p.wait() == -signal.SIGKILL
    if os.path.exists(lib.at("killed")):
        whole_results()
        done.append(len(lib.results("killed")))
lib.run("fit", "lib", "-o", "killed", "--summary", "killed.csv", "--resume", expected=0)
print(f"{FILES} files, {killed} of {KILLS} kills came in time; done after each: {done}")
lib.check(killed >= KILLS // 2 and done and done[-1] > 0 and done[0] < FILES, "the kills came at the wrong time")
lib.check(lib.results("killed") == expected, "other results")
lib.check(lib.read("killed.csv") == lib.read("sound.csv"), "another summary")
lib.no_parts("killed", "after --resume")
sys.exit(lib.end())
