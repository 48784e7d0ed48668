"""dialects_test.py FACETFIT [N [SEED]]: one table in N dialects. Most are read without being told anything, to the last sample; the others
are refused with an option that then reads them; none is ever read wrongly."""
import csv
import io
import math
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import dialects  # noqa: E402

program = sys.argv[1]
count = int(sys.argv[2]) if len(sys.argv) > 2 else 500
first = int(sys.argv[3]) if len(sys.argv) > 3 else 0


def run(*words):
    done = subprocess.run([program, *words], stdin=subprocess.DEVNULL, capture_output=True, check=False)
    return done.returncode, done.stdout.decode("utf-8", "replace"), done.stderr.decode("utf-8", "replace")


def convert(path, flags):
    status, out, said = run("resample", path, "-", "--to", "csv", *flags)
    return (out, said) if status == 0 else (None, said)


def key(ti, pi, to, po):
    i, o = dialects.vector(ti, 0), dialects.vector(to, po - pi)
    return tuple(round(x, 4) + 0.0 for x in i + o)


def samples_of(text):
    rows = [row for row in csv.reader(io.StringIO("".join(l for l in text.splitlines(True) if not l.startswith("#"))))]
    names = rows[0]
    values = [k for k, n in enumerate(names) if not n.startswith(("theta", "phi", "sigma"))]
    scale = math.degrees(1) if "# angles: radians" in text else 1
    at = [names.index(n) for n in ("theta_i", "phi_i", "theta_o", "phi_o")]
    for row in rows[1:]:
        f = tuple(float(row[k]) if row[k] else None for k in values)
        yield key(*(scale * float(row[k]) for k in at)), f


def differs(text, samples):
    """What is wrong of a table, None: nothing."""
    found = {}
    for where, f in samples_of(text):
        found.setdefault(where, []).append(f)
    expected = {}
    for s in samples:
        expected.setdefault(key(*s[:4]), []).append(s[4] if isinstance(s[4], tuple) else (s[4],))
    if sum(map(len, found.values())) != len(samples):
        return "%d samples, expected %d" % (sum(map(len, found.values())), len(samples))
    for where, fs in expected.items():
        got = sorted(found.get(where, []), key=str)
        if len(got) != len(fs):
            return "no sample at %s" % (where,)
        for a, b in zip(got, sorted(fs, key=str)):
            if len(a) != len(b) or any((x is None) != (y is None) or (x is not None and abs(x - y) > 2e-6 * abs(y)) for x, y in zip(a, b)):
                return "%s at %s, expected %s" % (a, where, b)
    return None


def advice(said):
    """The flags that a message says."""
    found = re.search(r"say (--[a-z-]+) ('[^']*'|[^\s;]+)", said)
    return shlex.split("%s %s" % found.groups()) if found else []


def main():
    read = told = 0
    wrong = []
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(first, first + count):
            dialect = dialects.Dialect(seed)
            data, samples = dialect.write()
            path = "%s/%d.csv" % (folder, seed)
            pathlib.Path(path).write_bytes(data)
            text, said = convert(path, [])
            if text is not None:
                problem = differs(text, samples)
                read += problem is None
            else:
                flags = advice(said)
                text, again = convert(path, flags) if flags else (None, said)
                problem = again if text is None else differs(text, samples)
                told += problem is None
            if problem:
                wrong.append("%d: %s\n  %s\n  %s" % (seed, dialect, said.strip(), str(problem).strip()))
    print("%d dialects: %d read without a flag, %d with the one that the refusal says, %d wrong" % (count, read, told, len(wrong)))
    if wrong:
        return "\n".join(wrong[:40])
    return 0 if read >= 0.9 * count else "expected nine of ten to be read without a flag"


if __name__ == "__main__":
    sys.exit(main())
