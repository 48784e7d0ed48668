#!/usr/bin/env python3
"""tmux_test.py PROGRAM: what a person sees. `fit`, `compare`, `info` and `models` in tmux windows of 60, 80, 100 and 200 columns: no
line is wrapped by the terminal, nothing of the progress stays, and the screen has what a pipe of that many COLUMNS has; the same with
NO_COLOR and with TERM=dumb, and what a pipe gets has no escapes. tmux is a terminal that interprets what it gets, so this sees what
a test of bytes does not: a cursor left elsewhere, a line that is not cleared, a character wider than it was counted. Ends with 77 where
tmux is not there."""
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import time

PROGRAM = os.path.abspath(sys.argv[1])
LINES = 2000
CHECKS = [0, 0]

if not shutil.which("tmux"):
    print("skipped: tmux is not there; ./setup nightly would install it")
    sys.exit(77)


def check(held, what):
    CHECKS[0] += 1
    if not held:
        CHECKS[1] += 1
        print("failed:", what)


class Window:
    """A tmux server of its own, with one window of so many columns."""

    def __init__(self, columns, folder):
        self.socket, self.folder = os.path.join(folder, "tmux-%d" % columns), folder
        env = {k: v for k, v in os.environ.items() if k not in ("COLUMNS", "NO_COLOR", "TMUX", "TERM")}
        env.update(LC_ALL="C.UTF-8", TERM="xterm-256color")
        self.env = env
        config = os.path.join(folder, "tmux.conf")
        with open(config, "w", encoding="utf-8") as out:
            out.write("set -g history-limit %d\nset -g default-terminal screen-256color\nset -g status off\n" % LINES)
        self.tmux("-f", config, "new-session", "-d", "-x", str(columns), "-y", "50", "env PS1= HISTFILE= sh")

    def tmux(self, *words):
        return subprocess.run(["tmux", "-S", self.socket, *words], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, env=self.env, cwd=self.folder, check=False).stdout.decode()

    def close(self):
        self.tmux("kill-server")

    def shows(self, words, before="", escapes=False):
        """The lines of the screen and of what has left it at the top, after a command: as lines that tmux holds to be wrapped, and
        as they are on the screen."""
        done = os.path.join(self.folder, "done")
        if os.path.exists(done):
            os.remove(done)
        self.tmux("send-keys", "clear; tmux -S %s clear-history" % shlex.quote(self.socket), "Enter")
        script = os.path.join(self.folder, "run.sh")
        with open(script, "w", encoding="utf-8") as out:
            out.write("clear\ntmux -S %s clear-history\n%s %s\nprintf 'END\\n'\ntouch %s\n" % (shlex.quote(self.socket), before, " ".join(map(shlex.quote, [PROGRAM, *words])), shlex.quote(done)))
        self.tmux("send-keys", "stty -echo; sh %s" % shlex.quote(script), "Enter")
        for _ in range(1200):
            if os.path.exists(done):
                break
            time.sleep(0.05)
        time.sleep(0.2)
        raw = self.tmux("capture-pane", "-p", "-S", "-%d" % LINES, *(("-e",) if escapes else ()))
        joined = self.tmux("capture-pane", "-p", "-J", "-S", "-%d" % LINES)
        return [self.cut(raw), self.cut(joined)]

    @staticmethod
    def cut(text):
        """Up to END; blanks at the end of lines are not told from the empty screen."""
        lines = [line.rstrip() for line in text.split("\n")]
        end = max((k for k, line in enumerate(lines) if line.startswith("END")), default=-1)
        check(end >= 0, "the command has come to no end: %r" % lines[-5:])
        lines = lines[:end]
        while lines and not lines[0]:
            lines.pop(0)
        return lines


COMMANDS = {
    "fit": ["fit", "paint.csv"],
    "fit, poor": ["fit", "paint.csv", "--model", "vmf+lambert"],
    "fit of many channels": ["fit", "spectrum.csv"],
    "compare": ["compare", "paint.csv", "--ndf", "ggx,student-t,beckmann-walter"],
    "info": ["info", "paint.csv"],
    "models": ["models"],
}


def piped(words, columns):
    env = {k: v for k, v in os.environ.items() if k not in ("NO_COLOR", "TERM")}
    text = subprocess.run([PROGRAM, *words], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, env=dict(env, COLUMNS=str(columns), LC_ALL="C.UTF-8"), check=False).stdout.decode()
    check("\x1b" not in text and "\r" not in text, "%s in a pipe: escapes" % words)
    return [line.rstrip() for line in text.rstrip("\n").split("\n")]


def words_of(lines):
    """Where lines are broken depends on how many digits the time has that a fit took; both are left out."""
    return re.sub(r"\d[\d.e-]* s\b", "T s", " ".join(" ".join(lines).split())).split()


def look(window, columns):
    for name, words in COMMANDS.items():
        wanted = words_of(piped(words, columns))
        for how, before in (("", ""), ("NO_COLOR", "NO_COLOR=1"), ("a dumb terminal", "TERM=dumb")):
            screen, joined = window.shows(words, before)
            what = "%s, %d columns%s" % (name, columns, how and ", " + how)
            check(screen == joined, "%s: tmux has wrapped %r" % (what, [line for line in joined if line not in screen][:2]))
            check(max(map(len, screen)) <= columns, "%s: a line of %d" % (what, max(map(len, screen))))
            got = words_of(screen)
            other = [(a, b) for a, b in zip(got, wanted) if a != b][:2]
            check(got == wanted, "%s: %d words, a pipe has %d; %r" % (what, len(got), len(wanted), other))
            stray = [line for line in screen if line.strip() in ("s", "%")]
            check(not stray, "%s: a unit without its number" % what)
            if how:
                coloured, _ = window.shows(words, before, escapes=True)
                check(not any("\x1b[3" in line for line in coloured), "%s: colours" % what)
        coloured, _ = window.shows(words, "", escapes=True)
        if name == "compare":
            check(any("\x1b[" in line for line in coloured), "%s, %d columns: no colours on a terminal" % (name, columns))


def main():
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        some = "ggx+lambert --set alpha=0.25,f0=0.5:0.3:0.1,kd=0.1:0.2:0.3 --grid goniometer:10 --noise 0.02 -o paint.csv"
        many = "ggx+lambert --set alpha=0.25,f0=%s --grid goniometer:15 --noise 0.02 -o spectrum.csv" % ":".join(["0.5"] * 31)
        for words in (some, many):
            subprocess.run([PROGRAM, "simulate", *words.split()], check=True, stdout=subprocess.DEVNULL)
        for columns in (60, 80, 100, 200):
            window = Window(columns, folder)
            try:
                look(window, columns)
            finally:
                window.close()
        os.chdir("/")
    print("%d checks, %d failures" % tuple(CHECKS))
    return CHECKS[1] > 0


if __name__ == "__main__":
    sys.exit(main())
