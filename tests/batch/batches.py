"""Files of a library of materials, and what a batch made of them."""
import os
import subprocess
import tempfile


class Library:
    """A folder in which `facetfit` runs; failures are counted."""

    def __init__(self, program):
        self.program = os.path.abspath(program)
        self.room = tempfile.TemporaryDirectory(prefix="batch-")
        self.folder = self.room.name
        self.checked = self.failed = 0
        os.makedirs(self.at("lib"))
        self.bases = [self.simulate(k) for k in range(5)]

    def at(self, *names):
        return os.path.join(self.folder, *names)

    def read(self, *names):
        with open(self.at(*names), "rb") as f:
            return f.read()

    def write(self, name, data):
        with open(self.at(name), "wb") as f:
            f.write(data)

    def simulate(self, k):
        parameters = f"alpha={0.1 + 0.1 * k},f0=0.3:0.4,kd=0.2" if k % 2 else f"alpha={0.1 + 0.1 * k},f0=0.3,kd=0.2"
        self.run("simulate", "ggx+lambert", "--set", parameters, "--noise", "0.04", "--seed", str(k), "--grid", "goniometer:30", "-o", "base.csv",
                 expected=0)
        return self.read("base.csv")

    def fill(self, n, folder="lib", begin=0):
        """n files, no two of them alike."""
        os.makedirs(self.at(folder), exist_ok=True)
        for i in range(begin, begin + n):
            self.write(f"{folder}/m{i:04}.csv", b"# sample %d\n" % i + self.bases[i % len(self.bases)])

    def run(self, *words, expected=None, said=(), **more):
        environment = {**os.environ, "LC_ALL": "C", **more}
        done = subprocess.run(["facetfit", *words], executable=self.program, cwd=self.folder, env=environment, stdin=subprocess.DEVNULL, capture_output=True, check=False)
        done.err = done.stderr.decode()
        if expected is not None:
            self.check(done.returncode == expected, f"{' '.join(words)}: status {done.returncode}, expected {expected}: {done.err[-500:]}")
        for text in said:
            self.check(text in done.err, f"{' '.join(words)}: does not say '{text}', but {done.err[-800:]}")
        return done

    def results(self, folder):
        """{name: bytes} of what a batch made, without the journals."""
        return {name: self.read(folder, name) for name in sorted(os.listdir(self.at(folder))) if name.endswith(".json")}

    def no_parts(self, folder, what):
        left = [name for name in os.listdir(self.at(folder)) if ".part-" in name]
        self.check(not left, f"{what}: left {left}")

    def check(self, good, what):
        self.checked += 1
        if not good:
            self.failed += 1
            print("failed:", what, flush=True)

    def end(self):
        print(f"{self.checked} checks, {self.failed} failures")
        return 1 if self.failed or not self.checked else 0
