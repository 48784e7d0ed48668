#!/usr/bin/env python3
"""Figures as Chromium shows them, beside pictures that were looked at and kept.

usage: pictures_test.py FACETFIT [--update | --smoke | --measure]

The first figure of every kind in docs/figures.md, of a file and of models, is drawn by its command, shown in a browser without a screen, and compared with
tests/plot/pictures/NAME.png. The measure is what an eye at reading distance would notice: both pictures in CIE L*a*b*, smoothed
over a point and a half, and the largest colour difference (CIE 1976) between them, in places that differ in more than a speck. A
picture fails from TOLERANCE on; what lies below and above it is said by --measure, which makes changes on purpose.
  --smoke    one figure, to see that the tools work
  --update   keeps what is drawn now, to be looked at before it is committed
Ends with 77 where Chromium or Python's PIL is not there."""
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
KEPT, PAGE = HERE / "pictures", HERE.parents[1] / "docs" / "figures.md"
TOLERANCE = 3.0  # --measure: the same figure 0.0, computed with other instructions too; the least change on purpose, a digit, 4.5
SPECK = 6        # pixels of a point each that must differ
SCALE = 2        # of the screen; another one, or another renderer, moves thin lines by parts of a pixel: 4 to 17
FIGURES = ("polar", "fresnel")  # of the smoke case

if not (chromium := shutil.which("chromium")):
    print("skipped: chromium is not there; ./setup renderers would install it")
    sys.exit(77)
try:
    import numpy
    from PIL import Image
except ImportError as missing:
    print(f"skipped: {missing}; ./setup renderers would install it")
    sys.exit(77)

program = os.path.abspath(sys.argv[1])
failures = 0


def check(good, what):
    global failures
    if not good:
        failures += 1
        print("failed:", what)


# ---- what is drawn -----------------------------------------------------------------------------------------------------------


def kinds():
    """All that the program has, by its completions."""
    said = subprocess.run([program, "plot", "pie"], capture_output=True, text=True, check=False).stderr
    return re.findall(r"[a-z]+", said.split("expected one of", 1)[1].split("\n")[0])


def commands():
    """(commands that make files, {name: first command of a kind}); "slice-data" is that of a file where models are drawn too."""
    lines = [shlex.split(line) for line in PAGE.read_text().splitlines() if line.startswith("    facetfit ")]
    first = {}
    for words in lines:
        if words[1] == "plot":
            of_file = len(words) > 3 and words[3].endswith((".csv", ".json"))
            first.setdefault((words[2], of_file), words)
    return ([words for words in lines if words[1] != "plot"],
            {kind + "-data" * (of_file and (kind, False) in first): words for (kind, of_file), words in first.items()})


def draw(wanted, folder, *more):
    made, first = commands()
    drawn_kinds = {words[2] for words in first.values()}
    check(set(kinds()) == drawn_kinds, f"docs/figures.md has no figure of {sorted(set(kinds()) - drawn_kinds)}")
    for words in made:
        subprocess.run([program, *words[1:]], cwd=folder, check=True, capture_output=True)
    drawn = {}
    for kind in wanted or first:
        words = first[kind][:-1] + [f"{kind}.svg", *more]
        got = subprocess.run([program, *words[1:]], cwd=folder, capture_output=True, text=True, check=False)
        check(got.returncode == 0, f"{' '.join(words)}: status {got.returncode}: {got.stderr}")
        drawn[kind] = (pathlib.Path(folder) / f"{kind}.svg").read_text()
    return drawn


# ---- what is seen --------------------------------------------------------------------------------------------------------------


def size_of(svg):
    width, height = re.search(r'viewBox="0 0 (\S+) (\S+)"', svg).groups()
    return int(float(width)), int(float(height))


def show(svgs, folder, scale=SCALE):
    """A picture of each, one pixel a point, from one page of the browser on a screen of so many pixels a point."""
    places, y, widest = {}, 0, 0
    page = ['<!DOCTYPE html><meta charset="utf-8"><style>body{margin:0;background:#fff}img{position:absolute;left:0}</style>']
    for name, svg in svgs.items():
        width, height = size_of(svg)
        places[name] = (y, width, height)
        (pathlib.Path(folder) / f"shown-{name}.svg").write_text(svg)
        page.append(f'<img src="shown-{name}.svg" style="top:{y}px" width="{width}" height="{height}">')
        y += height + 4
        widest = max(widest, width)
    path = pathlib.Path(folder) / "page.html"
    path.write_text("\n".join(page))
    shot = pathlib.Path(folder) / "shot.png"
    shot.unlink(missing_ok=True)
    run = subprocess.run([chromium, "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", f"--force-device-scale-factor={scale}",
                          f"--window-size={max(widest, 500)},{y}", f"--user-data-dir={folder}/profile", f"--screenshot={shot}", path.as_uri()],
                         capture_output=True, text=True, timeout=300, env=dict(os.environ, HOME=folder), check=False)
    if not shot.exists():
        sys.exit(f"failed: Chromium has shown nothing: {run.stderr[-2000:]}")
    whole = Image.open(shot).convert("RGB")
    return {name: whole.crop((0, scale * top, scale * w, scale * (top + h))).resize((w, h), Image.BOX) for name, (top, w, h) in places.items()}


# ---- how different -------------------------------------------------------------------------------------------------------------


def lab(picture):
    """CIE L*a*b* of sRGB under D65 (IEC 61966-2-1, CIE 15)."""
    c = numpy.asarray(picture, dtype=float) / 255
    c = numpy.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)
    xyz = c @ numpy.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]).T / [0.95047, 1, 1.08883]
    f = numpy.where(xyz > (6 / 29) ** 3, numpy.cbrt(xyz), xyz / (3 * (6 / 29) ** 2) + 4 / 29)
    return numpy.stack([116 * f[..., 1] - 16, 500 * (f[..., 0] - f[..., 1]), 200 * (f[..., 1] - f[..., 2])], axis=-1)


def smooth(x, sigma=1.5):
    """By a Gaussian, along both axes."""
    at = numpy.arange(-5, 6)
    weight = numpy.exp(-0.5 * (at / sigma) ** 2)
    weight /= weight.sum()
    for axis in (0, 1):
        padded = numpy.pad(x, [(5, 5) if a == axis else (0, 0) for a in range(3)], mode="edge")
        x = sum(w * numpy.take(padded, range(5 + k, 5 + k + x.shape[axis]), axis=axis) for k, w in zip(at, weight))
    return x


def difference(a, b):
    """Of two pictures: the colour difference that SPECK pixels reach. One of another size is another figure."""
    if a.size != b.size:
        return float("inf")
    delta = numpy.sqrt(((smooth(lab(a)) - smooth(lab(b))) ** 2).sum(axis=-1)).ravel()
    return float(numpy.partition(delta, -SPECK)[-SPECK])


def self_test():
    white, grey = Image.new("RGB", (40, 30), "#ffffff"), Image.new("RGB", (40, 30), "#777777")
    black = Image.new("RGB", (40, 30), "#000000")
    assert abs(difference(white, black) - 100) < 0.1 and abs(lab(grey)[0, 0, 0] - 50.03) < 0.1 and difference(white, white) == 0
    red = lab(Image.new("RGB", (1, 1), "#ff0000"))[0, 0]
    assert numpy.abs(red - [53.24, 80.09, 67.20]).max() < 0.1, red
    line = white.copy()
    line.paste("#000000", (5, 10, 35, 11))
    assert difference(white, line) > TOLERANCE


# ---- changes on purpose --------------------------------------------------------------------------------------------------------


def without(svg, pattern, what="", count=1):
    changed = re.sub(pattern, what, svg, count=count, flags=re.S)
    assert changed != svg, pattern
    return changed


def measure(drawn, seen, folder):
    """What stays the same figure, and what does not."""
    same = {f"{kind}, once more": difference(seen[kind], picture) for kind, picture in show(drawn, folder).items()}
    scalar = show(draw(None, folder, "--isa", "scalar", "--threads", "1"), folder)
    same.update({f"{kind}, other instructions": difference(seen[kind], picture) for kind, picture in scalar.items()})
    elsewhere = {f"{kind}, a finer screen": difference(seen[kind], picture) for kind, picture in show(drawn, folder, 3).items()}
    if rsvg := shutil.which("rsvg-convert"):
        for kind, svg in drawn.items():
            path = pathlib.Path(folder) / "other.png"
            w, h = size_of(svg)
            subprocess.run([rsvg, "-w", str(SCALE * w), "-h", str(SCALE * h), "-b", "white", str(pathlib.Path(folder) / f"{kind}.svg"), "-o", str(path)], check=True)
            elsewhere[f"{kind}, another renderer"] = difference(seen[kind], Image.open(path).convert("RGB").resize((w, h), Image.BOX))
    wrong = {}
    for name, kind, change in (
            ("a dash less", "masking", lambda s: without(s, r' stroke-dasharray="[^"]*"')),
            ("a colour for another", "albedo", lambda s: s.replace("#d55e00", "#0072b2")),
            ("a curve a point and a half lower", "fresnel", lambda s: without(s, r'(<path [^>]*stroke="#0072b2" stroke-width="1.1")', r'\1 transform="translate(0 1.5)"')),
            ("no curve", "profile", lambda s: without(s, r'<path [^>]*stroke="#d55e00"[^>]*/>')),
            ("a label less", "ndf", lambda s: without(s, r"<text [^>]*>[^<]*</text>")),
            ("another digit", "likelihood", lambda s: without(s, r">0\.(\d*)[0-79]</text>", r">0.\g<1>8</text>")),
            ("a marker less", "forest", lambda s: without(s, r"<circle [^>]*/>") if "<circle" in s else without(s, r"<use [^>]*/>") if "<use" in s else without(s, r'<path [^>]*stroke-linecap="round"[^>]*/>')),
            ("a cell of another colour", "correlation", lambda s: without(s, r'<rect fill="#([0-9a-f]{6})"', '<rect fill="#ffffff"'))):
        if kind in drawn:
            wrong[f"{kind}, {name}"] = difference(seen[kind], show({kind: change(drawn[kind])}, folder)[kind])
    for title, values in (("the same figure", same), ("elsewhere", elsewhere), ("another figure", wrong)):
        for name, value in sorted(values.items(), key=lambda item: -item[1]):
            print(f"{value:7.2f}  {title}: {name}")
    check(max(same.values()) < TOLERANCE < min(wrong.values()), f"{TOLERANCE} does not tell what is the same ({max(same.values()):.1f}) from what is not ({min(wrong.values()):.1f})")


def main():
    mode = sys.argv[2] if len(sys.argv) > 2 else ""
    self_test()
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        drawn = draw(FIGURES if mode == "--smoke" else None, folder)
        seen = show(drawn, folder)
        if mode == "--measure":
            measure(drawn, seen, folder)
        for kind, picture in seen.items():
            path = KEPT / f"{kind}.png"
            if mode == "--update":
                picture.save(path, optimize=True)
            if not path.exists():
                check(False, f"no picture of '{kind}' is kept: look at it, then --update")
                continue
            far = difference(picture, Image.open(path).convert("RGB"))
            print(f"{far:7.2f}  {kind}")
            if far >= TOLERANCE:
                look_at = pathlib.Path(tempfile.gettempdir()) / f"facetfit-{kind}.png"
                picture.save(look_at)
                check(False, f"{kind} is another figure: {far:.1f} from {path.name}, at most {TOLERANCE}; it is in {look_at}")
        if not mode:
            left = {p.stem for p in KEPT.glob("*.png")} - set(drawn)
            check(not left, f"pictures that nothing draws: {sorted(left)}")
    print(f"{len(seen)} pictures, {failures} failures")
    return failures > 0


sys.exit(main())
