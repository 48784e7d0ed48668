#!/usr/bin/env python3
"""twice_test.py PROGRAM: every flag of every command that takes one value is refused when it is given twice, before anything is
read or written; those that can be given several times are not. The flags are those of the man pages."""
import os
import re
import subprocess
import sys
import tempfile

program = os.path.abspath(sys.argv[1])
FOLDER = tempfile.TemporaryDirectory()  # where a flag that is taken would write
# Values, of which every flag takes one.
VALUES = ["1", "s", "20", "30", "0.5", "text", "csv", "merl", "rgb", "srgb", "ggx", "smith-uncorrelated", "schlick", "lambert", "none", "log",
          "huber", "sample", "noise", "isotropic", "scalar", "brdf", "d", "D", "slopes", "keep", "drop", "x=1", "f0=0.5", "f0", "f0=0.1:0.5",
          "beckmann", "phong", "relative=0.1", "30,0", "goniometer", "bash", "zemax", "never", "black", "out.png", "blender", "mirror",
          "clockwise", "radians", "decimal=comma", "file", "projected", "1-2"]
EXAMPLE = {"fit": ["FILE"], "compare": ["FILE"], "ndf": ["FILE"], "info": ["FILE"], "resample": ["FILE", "OUT"], "convert": [],
           "eval": ["ggx"], "simulate": ["ggx"], "furnace": ["ggx"], "sample": ["ggx"], "render": ["ggx"], "export": ["FILE"]}


def says(*words):
    done = subprocess.run([program, *words], stdin=subprocess.DEVNULL, capture_output=True, check=False, cwd=FOLDER.name)
    return done.returncode, (done.stdout + done.stderr).decode("utf-8", "replace")


def flags(command):
    """(name, has a value, can be given several times) of every flag."""
    for text in re.split(r"^\.TP\n", says("man", command)[1], flags=re.M)[1:]:
        found = re.match(r"\.B (?:\\-\w, )?\\-\\-(\[no\\-\])?((?:\w|\\-)+)( \\fI)?", text)
        if found:
            yield found[2].replace("\\-", "-"), bool(found[3]), "Can be given several times" in text


def is_refused(command, flag):
    """Whether the second is; None where none of the values is one of the flag's."""
    for value in VALUES:
        status, said = says(command, *EXAMPLE.get(command, []), f"--{flag}={value}", f"--{flag}={value}")
        if f"--{flag} is given twice, " in said and "takes one value" in said:
            return status == 2
        if not re.search(rf"--{flag}\b.*(expected|needs|takes|is not|unknown|no |neither)|expected|unknown", said) or status != 2:
            return False
    return None


def main():
    commands = re.findall(r"^  (\w+) ", says("--help")[1], re.M)
    failed, tried = [], 0
    for command in commands:
        for flag, has_value, repeats in flags(command):
            if not has_value:
                continue
            refused = is_refused(command, flag)
            tried += 1
            if refused is None and not repeats:
                failed.append(f"{command} --{flag}: none of the values is one of its own")
            elif bool(refused) == repeats:
                failed.append(f"{command} --{flag}: {'refused' if refused else 'taken'} when it is given twice")
    print(f"{tried} flags of {len(commands)} commands, {len(failed)} failures")
    print("\n".join(failed), end="\n" if failed else "")
    return bool(failed) or tried < 100


if __name__ == "__main__":
    sys.exit(main())
