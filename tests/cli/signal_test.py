#!/usr/bin/env python3
"""signal_test.py PROGRAM: Ctrl-C in a long run gives exit status 130 and leaves no output behind, whole or in part."""
import os
import signal
import subprocess
import sys
import tempfile
import time

program = os.path.abspath(sys.argv[1])
failures = 0


def interrupted(directory, what, args, delay):
    global failures
    before = sorted(os.listdir(directory))
    p = subprocess.Popen([program, *args], cwd=directory, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    time.sleep(delay)
    if p.poll() is not None:
        print("failed: %s ended before it could be interrupted: status %d, %s" % (what, p.returncode, p.stderr.read()))
        failures += 1
        return
    p.send_signal(signal.SIGINT)
    start = time.monotonic()
    out, err = p.communicate(timeout=60)
    after = sorted(os.listdir(directory))
    print("%s: status %d after %.2f s, stderr %r" % (what, p.returncode, time.monotonic() - start, err[-80:]))
    if p.returncode != 130 or after != before or b"facetfit: cancelled" not in err:
        failures += 1
        print("failed: %s left %s" % (what, set(after) - set(before)))


with tempfile.TemporaryDirectory() as directory:
    simulate = "simulate ggx+lambert --set alpha=0.3,f0=0.5:0.4:0.3 --grid merl --noise 0.05 -o a.binary"
    subprocess.run([program, *simulate.split()], cwd=directory, check=True)
    fit = "fit a.binary --model student-t+student-t+beckmann+lambert --threads 1 --max-iterations 10000 --json b.json"
    furnace = "furnace student-t --set alpha_x=0.05,alpha_y=1.5,r_xy=0.9 --json c.json --mu " + ",".join(["0.035"] * 1000)
    interrupted(directory, "compare", "compare a.binary --threads 1 --json a.json".split(), 1.2)
    interrupted(directory, "fit", fit.split(), 1.2)
    interrupted(directory, "bootstrap", "fit a.binary --bootstrap 1000000 --json d.json".split(), 1.2)
    interrupted(directory, "furnace", furnace.split(), 0.5)
print("%d failures" % failures)
sys.exit(1 if failures else 0)
