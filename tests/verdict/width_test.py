#!/usr/bin/env python3
"""width_test.py PROGRAM [DATA]: what is printed fits the terminal, on pseudo-terminals of 60, 80, 100 and 200 columns and by COLUMNS:
no line is longer, nothing but the report is on the screen, the lines of the progress are gone, colours come where they should and
not otherwise; a pipe gets all columns."""
import fcntl
import os
import pty
import re
import struct
import subprocess
import sys
import tempfile
import termios

PROGRAM = os.path.abspath(sys.argv[1])
DATA = sys.argv[2] if len(sys.argv) > 2 else ""
CHECKS = [0, 0]
COLOR = re.compile("\x1b\\[[0-9;]*m")
CLEAN = {k: v for k, v in os.environ.items() if k not in ("COLUMNS", "NO_COLOR", "TERM")}


def check(held, what):
    CHECKS[0] += 1
    if not held:
        CHECKS[1] += 1
        print("failed:", what)


def on_terminal(words, columns, term="xterm-256color", **more):
    """What arrives at a terminal of so many columns, as bytes."""
    master, slave = pty.openpty()
    fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("HHHH", 50, columns, 0, 0))
    run = subprocess.Popen([PROGRAM, *words], stdin=slave, stdout=slave, stderr=slave, env=dict(CLEAN, TERM=term, **more))
    os.close(slave)
    text = b""
    while True:
        try:
            piece = os.read(master, 65536)
        except OSError:
            break
        if not piece:
            break
        text += piece
    run.wait()
    os.close(master)
    return text.decode("utf-8", "replace").replace("\r\n", "\n")


def shown(text):
    """Lines that stay on the screen; and the longest that was there for a moment."""
    lines, longest = [], 0
    for line in text.split("\n"):
        passing = line.split("\r")
        longest = max([longest] + [len(COLOR.sub("", p.replace("\x1b[K", ""))) for p in passing])
        lines.append(passing[-1].replace("\x1b[K", ""))
    return lines, longest


COMMANDS = {
    "fit": ["fit", "paint.csv"],
    "fit of many channels": ["fit", "spectrum.csv"],
    "compare": ["compare", "paint.csv", "--ndf", "ggx,student-t,beckmann-walter"],
    "compare bases": ["compare", "paint.csv", "--ndf", "ggx", "--masking", "v-cavity", "--diffuse", "all"],
    "info": ["info", "paint.csv"],
    "info of many channels": ["info", "spectrum.csv"],
    "models": ["models"],
    "formats": ["formats"],
    "ndf": ["ndf", "paint.csv", "-o", "d.csv"],
    "resample": ["resample", "paint.csv", "out.astm"],
    "a mistake": ["fit", "a file of a long name that is not here and that nobody has ever seen in any folder of any machine.csv"],
    "another mistake": ["fit", "paint.csv", "--model", "ggx/there-is-no-masking-of-this-long-name-in-any-paper-of-any-year"],
}


def widths():
    for name, words in COMMANDS.items():
        for columns in (60, 80, 100, 200) if os.environ.get("FF_TEST_THOROUGH") else (60, 80):
            lines, longest = shown(on_terminal(words, columns, NO_COLOR="1"))
            words_too_long = [w for line in lines for w in line.split() if len(w) > columns - 12]
            for line in lines:
                check(len(line) <= columns or any(w in line for w in words_too_long), "%s, %d columns: %r" % (name, columns, line))
                check("\x1b" not in line, "%s, %d columns, NO_COLOR: %r" % (name, columns, line))
                check(line == line.rstrip(), "%s, %d columns, blanks at the end: %r" % (name, columns, line))
            check(longest <= max([columns] + [len(w) + 12 for w in words_too_long]), "%s, %d columns: %d for a moment" % (name, columns, longest))
            check(not any("iteration " in line and ", objective" in line for line in lines), "%s: a line of the progress stayed" % name)


def commands():
    """What is to be pasted is one command still where it is broken, and says the same at any width."""
    os.rename("paint.csv", "a paint that is 'new'.csv")
    for words in (["fit", "a paint that is 'new'.csv", "--model", "beckmann+lambert"], ["fit", "spectrum.csv", "--model", "vmf+lambert", "--loss", "log", "--max-theta", "70"]):
        for columns in (60, 80, 100, 200):
            for more in ({"NO_COLOR": "1"}, {}):
                lines, _ = shown(on_terminal(words, columns, **more))
                text = COLOR.sub("", "\n".join(lines))
                for begin in ("Next: ", "Look: "):
                    at = text.index("\n" + begin) + 1 + len(begin)
                    command = re.match(r"(?:[^\n]* \\\n)*[^\n]*", text[at:]).group(0)
                    argv = subprocess.run(["sh", "-c", command.replace("facetfit", "printf '%s\\n'", 1)], stdout=subprocess.PIPE, check=True).stdout.decode().split("\n")
                    check(argv[0] in (("compare", "fit") if begin == "Next: " else ("plot",)) and words[1] in argv, "%d columns: %r gives %s" % (columns, command, argv))
                    check(begin == "Next: " or (argv[-3] == "-o" and argv[-2].endswith(".svg")), "%d columns: %r gives %s" % (columns, command, argv))
                    check(max(map(len, command.split("\n"))) <= columns, "%d columns: %r" % (columns, command))
                raw = "\n".join(lines)
                check(raw.count("\x1b[2m") <= raw.count("\x1b[0m"), "%d columns: a colour without an end" % columns)
    os.rename("a paint that is 'new'.csv", "paint.csv")


def plain(words, **more):
    return subprocess.run([PROGRAM, *words], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, env=dict(CLEAN, **more), check=False).stdout.decode()


def colours():
    words = COMMANDS["compare"]
    check("\x1b[" in on_terminal(words, 80), "no colours on a terminal")
    for more in ({"NO_COLOR": "1"}, {"term": "dumb"}):
        check("\x1b" not in on_terminal(words, 80, **more).replace("\r\x1b[K", ""), "escapes with %s" % more)
    check("\x1b" not in on_terminal(words + ["--color", "never"], 80).replace("\r\x1b[K", ""), "--color never")
    check("\x1b[1m" in plain(words + ["--color", "always"]), "--color always, in a pipe")
    check("\x1b" not in plain(words), "colours in a pipe")
    check(COLOR.sub("", plain(words + ["--color", "always"])) == plain(words), "colours change the text")
    for more in ({}, {"TERM": "xterm"}):
        check("\r" not in plain(words, **more), "progress in a pipe")


def all_columns():
    words = COMMANDS["compare"]
    check("log rmse" in plain(words) and max(map(len, plain(words).split("\n"))) > 120, "a pipe gets all columns")
    narrow = plain(words, COLUMNS="80")
    check("log rmse" not in narrow and max(map(len, narrow.split("\n"))) <= 80, "COLUMNS=80 in a pipe")
    check(plain(words + ["--wide"], COLUMNS="80") == plain(words), "--wide")
    for word in ("0", "-5", "x", "", "7", "99999999999999999999"):
        check(plain(words, COLUMNS=word) == plain(words), "COLUMNS=%r" % word)
    head = [line for line in narrow.split("\n") if "distribution" in line and "masking" in line and "alpha" in line][0]
    check(head.split() == ["distribution", "masking", "alpha", "/", "best", "p"], "the narrow table has %s" % head)
    lines = on_terminal(["fit", "paint.csv"], 80, term="dumb")
    check("\r" not in lines.replace("\r\n", "\n") and "\x1b" not in lines, "a dumb terminal")


def main():
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        some = "ggx+lambert --set alpha=0.25,f0=0.5:0.3:0.1,kd=0.1:0.2:0.3 --grid goniometer:10 --noise 0.02 -o paint.csv"
        many = "ggx+lambert --set alpha=0.25,f0=%s --grid goniometer:15 --noise 0.02 -o spectrum.csv" % ":".join(["0.5"] * 31)
        for words in (some, many):
            subprocess.run([PROGRAM, "simulate", *words.split()], check=True, stdout=subprocess.DEVNULL)
        widths()
        commands()
        colours()
        all_columns()
        os.chdir("/")
    print("%d checks, %d failures" % tuple(CHECKS))
    return CHECKS[1] > 0


if __name__ == "__main__":
    sys.exit(main())
