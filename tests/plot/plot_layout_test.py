#!/usr/bin/env python3
"""How figures look, without looking: SVG is XML, no text meets another or leaves the page, PDF is whole, the same is drawn again.

usage: plot_layout_test.py FACETFIT"""
import os
import re
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ET

program = os.path.abspath(sys.argv[1])
failures = 0

# Adobe's widths of Helvetica in thousandths, written down here once more.
WIDTHS = dict(zip(map(chr, range(32, 127)), [
    278, 278, 355, 556, 556, 889, 667, 191, 333, 333, 389, 584, 278, 333, 278, 278] + [556] * 10 + [
    278, 278, 584, 584, 584, 556, 1015, 667, 667, 722, 722, 667, 611, 778, 722, 278, 500, 667, 556, 833, 722, 778, 667, 778, 722, 667, 611, 722,
    667, 944, 667, 667, 611, 278, 278, 278, 469, 556, 333, 556, 556, 500, 556, 556, 278, 556, 556, 222, 222, 500, 222, 833, 556, 556, 556, 556,
    333, 500, 278, 556, 500, 722, 500, 500, 500, 334, 260, 334, 584]))
WIDTHS.update({"°": 400, "±": 584, "−": 584, "…": 1000, "·": 278, "θ": 521, "φ": 521, "α": 631})


def check(good, what):
    global failures
    if not good:
        failures += 1
        print("failed:", what)


def run(*args):
    return subprocess.run([program, *args], capture_output=True, cwd=scratch)


def width(text, size):
    return sum(WIDTHS.get(c, 1000) for c in text) * size / 1000


def boxes(root):
    """(x0, y0, x1, y1, text) of every text."""
    for t in root.iter("{http://www.w3.org/2000/svg}text"):
        x, y, size = float(t.get("x")), float(t.get("y")), float(t.get("font-size"))
        total = width(t.text or "", size)
        for span in t:
            total += width(span.text or "", float(span.get("font-size", size))) + width(span.tail or "", size)
        back = {"middle": total / 2, "end": total}.get(t.get("text-anchor"), 0)
        up, down = 0.72 * size, 0.21 * size
        text = "".join(t.itertext())
        if t.get("transform"):
            check(t.get("transform") == "rotate(-90 %s %s)" % (t.get("x"), t.get("y")), "a turn that is not known: " + t.get("transform"))
            yield x - up, y - (total - back), x + down, y + back, text
        else:
            yield x - back, y - up, x - back + total, y + down, text


def overlaps(found, slack=0.3):
    for i, a in enumerate(found):
        for b in found[i + 1:]:
            if min(a[2], b[2]) - max(a[0], b[0]) > slack and min(a[3], b[3]) - max(a[1], b[1]) > slack:
                yield a[4], b[4]


def look(svg, what):
    try:
        root = ET.fromstring(svg)
    except ET.ParseError as error:
        check(False, f"{what}: no XML: {error}")
        return
    found = list(boxes(root))
    check(len(found) > 3, f"{what}: {len(found)} texts")
    page = [float(x) for x in root.get("viewBox").split()]
    for a, b in overlaps(found):
        check(False, f"{what}: '{a}' meets '{b}'")
    for x0, y0, x1, y1, text in found:
        check(x0 > -0.5 and y0 > -0.5 and x1 < page[2] + 0.5 and y1 < page[3] + 0.5, f"{what}: '{text}' leaves the page")


def self_test():
    planted = ('<svg xmlns="http://www.w3.org/2000/svg"><text x="10" y="20" font-size="10">abc</text>'
               '<text x="25" y="22" font-size="10" text-anchor="middle">x</text><text x="60" y="20" font-size="10">far</text></svg>')
    found = list(overlaps(list(boxes(ET.fromstring(planted)))))
    assert found == [("abc", "x")], f"the search sees {found}"


def whole_pdf(pdf, what):
    """Every object is where the table says, the stream as long as it says."""
    check(pdf.startswith(b"%PDF-1.4") and pdf.rstrip().endswith(b"%%EOF"), f"{what}: its ends")
    start = int(re.search(rb"startxref\n(\d+)\n%%EOF", pdf).group(1))
    check(pdf[start:start + 5] == b"xref\n", f"{what}: the table is not at {start}")
    places = [int(m) for m in re.findall(rb"(\d{10}) 00000 n ", pdf[start:])]
    for k, place in enumerate(places, 1):
        check(pdf[place:].startswith(b"%d 0 obj" % k), f"{what}: object {k} is not at {place}")
    stream = re.search(rb"stream\n(.*)endstream", pdf, re.S)
    length = int(re.search(rb"5 0 obj\n(\d+)\n", pdf).group(1))
    check(len(stream.group(1)) == length, f"{what}: the stream has {len(stream.group(1))} bytes, not {length}")
    check(stream.group(1).count(b"q ") == stream.group(1).count(b"Q\n"), f"{what}: states are not given back")


def strings_of(pdf):
    """Texts of a PDF as (font, rise, bytes)."""
    font, rise, found = "", 0, []
    for piece in re.finditer(rb"/([HS]) \S+ Tf|(\S+) Ts|<([0-9a-f]*)>", re.search(rb"stream\n(.*)endstream", pdf, re.S).group(1)):
        if piece.group(1):
            font = piece.group(1).decode()
        elif piece.group(2):
            rise = float(piece.group(2))
        else:
            found.append((font, rise, bytes.fromhex(piece.group(3).decode())))
    return found


def other_letters():
    """Small figures are raised, accents that Helvetica lacks are left out, other scripts are the digits of their code."""
    run("plot", "ndf", "ggx", "--title", "Škoda č ł 10⁻² x₃ θ→∞ ≈ 中?", "-o", "odd.pdf")
    with open(os.path.join(scratch, "odd.pdf"), "rb") as f:
        pdf = f.read()
    whole_pdf(pdf, "a title of other letters")
    found = strings_of(pdf)
    plain = b"".join(t for font, rise, t in found[:40] if font == "H")
    check(plain.startswith(b"\x8akoda c l 10-2 x3 "), f"letters of the title: {plain[:40]}")
    check(any(t.startswith(b"-") and rise > 0 for _, rise, t in found), "10^-2 is not raised")
    check(any(t == b"3" and rise < 0 for _, rise, t in found), "x_3 is not lowered")
    symbols = b"".join(t for font, _, t in found[:60] if font == "S")
    check(symbols.startswith(b"q\xae\xa5\xbb"), f"symbols of the title: {symbols[:10]}")
    codes = [(rise, t) for font, rise, t in found if t in (b"4E", b"2D")]
    check(len(codes) == 2 and codes[0][0] > codes[1][0], f"a letter of another script: {codes}")
    check(sum(t.count(b"?") for _, _, t in found) == 1, "a '?' that nobody wrote")


self_test()
with tempfile.TemporaryDirectory() as scratch:
    run("simulate", "ggx+lambert", "--set", "alpha=0.3,f0=0.5:0.4:0.3,kd=0.2", "--noise", "0.04", "-o", "paint.csv")
    run("simulate", "ggx+lambert", "--set", "alpha_x=0.15,alpha_y=0.4,kd=0.1", "--noise", "0.02", "--grid", "scattered:900", "--sigma", "-o", "spread.csv")
    run("compare", "paint.csv", "--ndf", "ggx,beckmann", "--json", "compare.json")
    run("fit", "paint.csv", "--json", "fit.json")
    figures = [
        ["slice", "paint.csv"], ["slice", "paint.csv", "--channel", "r,g,b", "--log"], ["slice", "spread.csv"], ["slice", "fit.json"],
        ["slice", "ggx+lambert", "beckmann+lambert"], ["polar", "paint.csv"], ["profile", "paint.csv"], ["profile", "ggx+lambert"],
        ["image", "paint.csv"], ["image", "ggx+lambert"], ["residuals", "paint.csv"], ["residuals", "compare.json"], ["coverage", "paint.csv"],
        ["coverage", "spread.csv"], ["ndf"], ["ndf", "--roughness", "0.1,0.3,0.5", "--ndf", "ggx,beckmann"], ["masking"], ["albedo", "ggx+lambert"],
        ["albedo", "fit.json", "--channel", "r,g,b"], ["forest", "paint.csv"], ["forest", "compare.json", "--channel", "r,b"],
        ["correlation", "paint.csv"], ["correlation", "spread.csv"], ["likelihood", "paint.csv"], ["bootstrap", "paint.csv", "--bootstrap", "20"],
        ["sweep", "paint.csv", "--parameter", "alpha_x"]]
    drawn = refused = 0
    for figure in figures:
        for size in (["--width", "60mm", "--font-size", "6pt"], ["--width", "85mm"], ["--font-size", "14pt", "--width", "250mm"], ["--height", "70mm"], []):
            if figure[0] in ("sweep", "bootstrap") and size and size[-1] != "85mm":
                continue
            what = " ".join(figure + size)
            got = run("plot", *figure, *size)
            if got.returncode == 2 and b"no room" in got.stderr:
                check(size, f"{what}: no room on the usual page")
                refused += 1
                continue
            check(got.returncode == 0, f"{what}: status {got.returncode}, {got.stderr.decode()}")
            if got.returncode == 0:
                look(got.stdout, what)
                drawn += 1
        pdf = run("plot", *figure, "-o", "a.pdf") if figure[0] not in ("sweep", "bootstrap") else None
        if pdf and pdf.returncode == 0:
            with open(os.path.join(scratch, "a.pdf"), "rb") as f:
                whole_pdf(f.read(), " ".join(figure) + " as PDF")
    check(drawn > 80 and refused < drawn / 4, f"{drawn} drawn, {refused} refused")
    for figure in (["slice", "paint.csv"], ["bootstrap", "paint.csv", "--bootstrap", "20"], ["likelihood", "paint.csv"]):
        once = run("plot", *figure, "--threads", "1").stdout
        check(once and once == run("plot", *figure, "--threads", "3").stdout, f"{figure[0]} with other threads is another figure")
    german = subprocess.run([program, "plot", "slice", "paint.csv"], capture_output=True, cwd=scratch, env={**os.environ, "LC_ALL": "de_DE.UTF-8"})
    check(german.stdout == run("plot", "slice", "paint.csv").stdout, "another locale, another figure")
    other_letters()
    odd = run("plot", "ndf", "ggx", "--title", 'a<b> & "c" _{x} \x1b[31m θ \udcff')
    look(odd.stdout, "a title of odd characters")
    print(f"{drawn} figures looked at, {refused} without room, {failures} failures")
sys.exit(failures > 0)
