"""names_test.py TOP: the habits of names that a formatter does not know: an ff_status is `status`, a statement counts with i++."""
import pathlib
import re
import sys

ROOMS = ("base", "models", "targets", "data_formats", "simulate", "fit", "report", "cli", "tests", "bench")
RULES = (
    (re.compile(r"\bff_status (?:s|st|stat|ret|rc)\b"), "an ff_status that is not named `status`"),
    (re.compile(r"^\s*(?:\+\+|--)[\w(*][^=]*;"), "a statement that counts with ++i"),
    (re.compile(r"\bfor \([^;]*;[^;]*; (?:[^()]*, )?(?:\+\+|--)"), "a loop that counts with ++i"),
)


def broken(text):
    """(line, what) of all that break a rule."""
    return [(n, what) for n, line in enumerate(text.split("\n"), 1) for rule, what in RULES if rule.search(line)]


def main(top):
    planted = "ff_status st = f();\n    ++n;\nfor (i = 0; i < n; ++i) g();\nfor (i = 0; i < n; i++) g(*++p);\nff_status status;\n"
    if [n for n, _ in broken(planted)] != [1, 2, 3]:
        return "the rules do not see what is planted: %s" % broken(planted)
    found = 0
    for room in ROOMS:
        for path in sorted(pathlib.Path(top, room).rglob("*")):
            if path.suffix not in (".c", ".h", ".cpp"):
                continue
            for n, what in broken(path.read_text()):
                print("%s:%d: %s" % (path.relative_to(top), n, what))
                found += 1
    return "%d break the habits of names" % found if found else 0


sys.exit(main(sys.argv[1]))
