#!/usr/bin/env python3
"""lines_test.py SOURCE_DIR: README.md and docs/*.md fit a window, and name nothing that is not there.

Lines of prose have at most 100 characters. Relative links lead to a file, and to a heading in it. Every file, function(), ff_name
and --flag in code type exists in the sources.
"""
import os
import re
import subprocess
import sys

TOP = os.path.abspath(sys.argv[1])
WIDTH, README_LINES = 100, 120
SOURCES = (".c", ".h", ".cpp", ".def")  # and the Python package
NAMED = re.compile(r"^[\w./-]+\.(?:c|h|cpp|def|py|cmake|svg|md|transcript)$")
FLAGS_OF_OTHERS = {"--array", "--with-modules", "--install", "--prefix", "--cflags", "--libs", "--output-on-failure", "--update"}
# Placeholders of a naming rule (`ff_x_new`), and what a recipe adds or a user of the library would write.
EXAMPLES = re.compile(r"^ff_(x|noun)\b|^ff_x_")
INSTALLED = ("include/", "lib/", "share/")
failures = 0


def check(condition, text):
    global failures
    if not condition:
        failures += 1
        print("failed: " + text)


def read(path):
    with open(os.path.join(TOP, path), encoding="utf-8") as f:
        return f.read()


def all_files():
    """Files of the project: those that git knows, or all but builds where there is no git."""
    try:
        done = subprocess.run(["git", "-C", TOP, "ls-files", "-co", "--exclude-standard"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                              check=True, text=True)
        return {path for path in done.stdout.splitlines() if os.path.exists(os.path.join(TOP, path))}
    except (OSError, subprocess.CalledProcessError):
        found = set()
        for folder, folders, names in os.walk(TOP):
            folders[:] = [f for f in folders if not f.startswith(("build", ".git"))]
            found |= {os.path.relpath(os.path.join(folder, name), TOP) for name in names}
        return found


def prose(text):
    """(number, line) of the lines that are neither code nor table; code spans stay in them."""
    fenced = code = False
    before = ""
    for number, line in enumerate(text.splitlines(), 1):
        if line.startswith("```"):
            fenced = not fenced
        elif not fenced:
            code = line.startswith("    ") and (code or not before.strip() or before.startswith("#"))
            if not code:
                yield number, line
        before = line


def anchors(text):
    """Of the headings, as GitHub makes them."""
    found = set()
    for line in re.findall(r"^#+ (.*)$", text, re.M):
        found.add(re.sub(r"[^\w\- ]", "", line.strip().lower()).replace(" ", "-"))
    return found


def check_width(page, text):
    for number, line in prose(text):
        one_word = len(line.split()) == 1 or re.match(r"^\s*(!?\[.*\]\(\S+\)|<!--.*-->)\.?$", line)
        if len(line) > WIDTH and not line.startswith("|") and not one_word:
            check(False, f"{page}:{number}: {len(line)} characters")


def check_links(page, text, pages):
    for label, target in re.findall(r"\[([^\]\n]*(?:\n[^\]\n]*)?)\]\(([^)\s]+)\)", text):
        if re.match(r"[a-z]+:", target):
            continue
        path, _, anchor = target.partition("#")
        where = os.path.normpath(os.path.join(os.path.dirname(page), path)) if path else page
        check(os.path.exists(os.path.join(TOP, where)), f"{page}: the link of '{label}' leads to {target}, which is not there")
        if anchor and where.endswith(".md") and os.path.exists(os.path.join(TOP, where)):
            pages.setdefault(where, anchors(read(where)))
            check(anchor in pages[where], f"{page}: {where} has no heading #{anchor}")


def spans(text):
    return {" ".join(span.split()) for span in re.findall(r"`([^`]+)`", "\n".join(line for _, line in prose(text)))}


def check_places(page, text, files):
    """`f()` in `file`, also `f()`, `g()` and `h()` in `file`: that file has them."""
    for functions, path in re.findall(r"((?:`\w+\(\)`(?:,\s+|\s+and\s+)?)+)\s+in\s+`([\w/]+\.(?:c|cpp|h))`", text):
        for name in re.findall(r"`(\w+)\(\)`", functions):
            check(path in files and re.search(r"\b%s\(" % name, read(path)), f"{page}: {name}() is not in {path}")


def check_names(page, text, files, code, flags, new):
    names = {os.path.basename(path) for path in files}
    for span in spans(text):
        if NAMED.match(span) and not span.startswith(("http", "src/")):
            local = os.path.normpath(os.path.join(os.path.dirname(page), span))
            there = span in files or local in files or any(f.endswith("/" + span) for f in files) if "/" in span \
                else span in names or (span[0] == "_" and any(name.endswith(span) for name in names))
            check(there or span in new, f"{page}: there is no file {span}")
        elif re.match(r"^[\w./-]+/$", span) and not span.startswith(INSTALLED):
            check(any(f.startswith(span) or "/" + span in f for f in files), f"{page}: there is no folder {span}")
        for name in re.findall(r"\b([A-Za-z_]\w*)\(\)", span):
            check(re.search(r"\b%s\(" % name, code), f"{page}: there is no function {name}()")
        for name in re.findall(r"\bff_\w*[a-z0-9]\b(?![*<.])", span):
            if not EXAMPLES.match(name) and not name.endswith("_"):
                check(re.search(r"\b%s\b" % name, code), f"{page}: there is no {name}")
        for flag in re.findall(r"(?<![\w-])--[a-z][a-z-]*", span):
            plain = flag.replace("--no-", "--")
            check(flag in flags or plain in flags or flag in FLAGS_OF_OTHERS, f"{page}: there is no flag {flag}")


files = all_files()
code = "\n".join(read(path) for path in sorted(files) if path.endswith(SOURCES) or path.startswith("python/facetfit/"))
code += "\n".join(os.path.basename(path) for path in files)  # ff_fit.h
flags = set(re.findall(r'"(--[a-z-]+)"', code)) | {"--" + name for name in re.findall(r'^FLAG\w*\([^"]*"([a-z-]+)"', read("cli/flags.def"), re.M)}
flags |= {"--help", "--version"}
page_names = ["README.md", "CONTRIBUTING.md", "SECURITY.md", "reports/README.md"] + sorted(f for f in files if re.match(r"docs/[^/]+\.md$", f))
recipes = read("docs/adding.md")
new = set(re.findall(r"<!-- new: (\S+) -->", recipes))
known_anchors = {}
for page in page_names:
    text = read(page)
    check_width(page, text)
    check_links(page, text, known_anchors)
    check_places(page, text, files)
    check_names(page, text, files, code + recipes, flags, new)
check_width("CHANGELOG.md", read("CHANGELOG.md"))  # names what is no longer there too
check(len(read("README.md").splitlines()) <= README_LINES, f"README.md has more than {README_LINES} lines")
check(len(page_names) >= 10 and len(flags) > 50, f"{len(page_names)} pages, {len(flags)} flags")
print(f"{len(page_names)} pages, {len(flags)} flags, {failures} failures")
sys.exit(1 if failures else 0)
