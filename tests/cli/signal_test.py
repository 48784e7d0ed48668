#!/usr/bin/env python3
"""signal_test.py PROGRAM: a signal ends every command that writes within a second, and leaves no output behind, whole or in part,
and what was there before as it was. Ctrl-C gives exit status 130, other signals are what the process died of."""
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time

program = os.path.abspath(sys.argv[1])
failures = runs = 0
ENDING = [signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT, signal.SIGXCPU]
PATIENCE = 60
for number in ENDING:  # whoever runs the tests in the background may ignore some, and the program then does as well
    signal.signal(number, signal.SIG_DFL)


def fail(text):
    global failures
    failures += 1
    print("failed: " + text)


def state():
    return {name: os.stat(name).st_mtime_ns for name in os.listdir(".")}


def unfinished():
    return [name for name in os.listdir(".") if ".part-" in name]


def start(args, **more):
    global runs
    runs += 1
    more.setdefault("stdout", subprocess.DEVNULL)
    return subprocess.Popen([program, *args.split()], stdin=subprocess.DEVNULL, stderr=subprocess.PIPE, **more)


def wait_until(p, holds, what):
    """0 when the process ended before."""
    limit = time.monotonic() + PATIENCE
    while not holds():
        if p.poll() is not None:
            fail("%s: ended before it was interrupted: status %d, %s" % (what, p.returncode, p.stderr.read()))
            return 0
        if time.monotonic() > limit:
            fail("%s: nothing came of it" % what)
            p.kill()
            return 0
        time.sleep(0.002)
    return 1


def check_end(p, what, number, before, began):
    err = p.communicate(timeout=PATIENCE)[1]
    took = time.monotonic() - began
    print("%s, %s: status %d after %.2f s" % (what, number.name, p.returncode, took))
    expected = 130 if number == signal.SIGINT else -number
    if p.returncode != expected or (number == signal.SIGINT and b"facetfit: cancelled" not in err):
        fail("%s, %s: status %d, expected %d: %s" % (what, number.name, p.returncode, expected, err[-200:]))
    if took > 1:
        fail("%s, %s: ended after %.1f s" % (what, number.name, took))
    if state() != before:
        fail("%s, %s left %s" % (what, number.name, set(state().items()) ^ set(before.items())))


def interrupted(what, args, number, ready, times=1):
    before = state()
    p = start(args)
    if not wait_until(p, ready, what):
        return
    began = time.monotonic()
    for _ in range(times):
        p.send_signal(number)
    check_end(p, what, number, before, began)


def after(seconds):
    begin = time.monotonic()
    return lambda: time.monotonic() - begin > seconds


def written(name, args):
    """Each command that takes long enough for its unfinished file to be seen, with every signal."""
    for number in ENDING:
        interrupted(name, args, number, unfinished)
    interrupted(name + ", twice", args, signal.SIGINT, unfinished, 2)


NO_FILES = (resource.RLIMIT_FSIZE, (0, resource.RLIM_INFINITY))


def can_start_without_files():
    """ThreadSanitizer makes a file of its own before main; any other program can."""
    with open(program, "rb") as f:
        if b"__tsan_init" not in f.read():
            return True
    return start("--version", preexec_fn=lambda: resource.setrlimit(*NO_FILES)).wait(PATIENCE) == 0


def short(name, args, output):
    """What writes in a moment is stopped at its first byte: by a file size of nothing, then by a pipe that nobody reads."""
    before = state()
    p = start(args, preexec_fn=lambda: resource.setrlimit(*NO_FILES))
    err = p.communicate(timeout=PATIENCE)[1]
    if not can_start_without_files():
        print("SIGXFSZ: not tried, for a sanitizer ends the program at its start")
    elif p.returncode != 4 or b"File too large" not in err or state() != before:
        fail("%s, SIGXFSZ: status %d, %s, left %s" % (name, p.returncode, err[-200:], set(state()) - set(before)))
    read, write = os.pipe()
    os.close(read)
    p = start(args, stdout=write)
    os.close(write)
    err = p.communicate(timeout=PATIENCE)[1]
    if p.returncode not in (0, -signal.SIGPIPE) or unfinished():
        fail("%s, SIGPIPE: status %d, %s, left %s" % (name, p.returncode, err[-200:], unfinished()))
    if output in state():
        os.remove(output)


def held(name, args, output):
    """A table on stdout and its JSON in a file, both unfinished when the reader of the table hangs up."""
    read, write = os.pipe()
    before = state()
    p = start(args, stdout=write)
    os.close(write)
    if wait_until(p, unfinished, name):
        os.close(read)
        err = p.communicate(timeout=PATIENCE)[1]
        print("%s, a reader that hangs up: status %d" % (name, p.returncode))
        if p.returncode != -signal.SIGPIPE or state() != before:
            fail("%s: status %d, %s, left %s" % (name, p.returncode, err[-200:], set(state()) - set(before)))
    else:
        os.close(read)


def ignored():
    """nohup's: who started us did not want it."""
    p = start("fit a.binary --model student-t+beckmann+lambert --bootstrap 1000000 --json d.json",
              preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN))
    time.sleep(0.5)
    p.send_signal(signal.SIGHUP)
    time.sleep(0.3)
    if p.poll() is not None:
        fail("SIGHUP was ignored by who started the program, and ended it: %d" % p.returncode)
    p.send_signal(signal.SIGTERM)
    p.communicate(timeout=PATIENCE)


with tempfile.TemporaryDirectory() as directory:
    os.chdir(directory)
    simulate = "simulate ggx+lambert --set alpha=0.3,f0=0.5:0.4:0.3 "
    subprocess.run([program, *(simulate + "--grid merl --noise 0.05 -o a.binary").split()], check=True)
    subprocess.run([program, *(simulate + "--grid goniometer:15 -o small.csv").split()], check=True)
    with open("directions.csv", "w") as f:
        f.write("theta_i,phi_i,theta_o,phi_o\n" + "".join("%g,0,30,180\n" % (i * 8e-5) for i in range(1000000)))
    with open("old.csv", "w") as f:
        f.write("precious\n")

    # computing, before anything is written
    mu = ",".join(["0.035"] * 1000)
    fit = "fit a.binary --model student-t+student-t+beckmann+lambert --threads 1 --max-iterations 10000 --json b.json"
    for number in ENDING:
        interrupted("fit", fit, number, after(1))
    interrupted("compare", "compare a.binary --threads 1 --json a.json", signal.SIGINT, after(1))
    interrupted("bootstrap", "fit a.binary --bootstrap 1000000 --json d.json", signal.SIGINT, after(1))
    interrupted("plot", "plot bootstrap a.binary --bootstrap 1000000 -o p.svg", signal.SIGINT, after(1))
    ignored()

    # writing
    written("simulate", simulate + "--grid merl -o large.csv")
    written("simulate over a file", simulate + "--grid merl -o old.csv")
    written("resample", "resample a.binary resampled.csv")
    written("residuals", "fit a.binary --model lambert --residuals residuals.csv")
    written("furnace", "furnace student-t --set alpha_x=0.05,alpha_y=1.5,r_xy=0.9 --json c.json --mu " + mu)
    written("sample", "sample ggx --set alpha=0.3 -n 100000000 --json sample.json")
    written("eval", "eval ggx+lambert directions.csv --json eval.json")
    held("sample", "sample ggx --set alpha=0.3 -n 1000000 --json sample.json", "sample.json")

    # every other one
    for command, output in (
            ("fit small.csv --model lambert --json f.json", "f.json"), ("compare small.csv --ndf ggx --json p.json", "p.json"),
            ("fit small.csv --model lambert --residuals r.csv", "r.csv"), ("info small.csv --json i.json", "i.json"),
            ("ndf small.csv -o n.csv", "n.csv"), ("ndf small.csv --json m.json", "m.json"), ("formats --json o.json", "o.json"),
            ("models --json l.json", "l.json"), ("convert --list --json v.json", "v.json"),
            ("convert --from beckmann --to phong m=0.25 --json w.json", "w.json"), (simulate + "-o s.csv", "s.csv"),
            (simulate + "-o s.binary --grid merl", "s.binary"), ("resample small.csv t.csv --json t.json", "t.csv"),
            ("furnace lambert --mu 0.5 --json u.json", "u.json"), ("sample ggx -n 10 --json x.json", "x.json"),
            ("plot slice small.csv -o y.svg", "y.svg"), ("plot ndf ggx -o y.pdf", "y.pdf"), ("plot coverage small.csv -o y.csv", "y.csv")):
        short(command.split()[0], command, output)
        for rest in set(state()) & {"t.json"}:
            os.remove(rest)
    os.chdir("/")
print("%d runs, %d failures" % (runs, failures))
sys.exit(1 if failures or not runs else 0)
