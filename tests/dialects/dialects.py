"""One table of measured reflectance, written as laboratories write tables: every dialect is a choice of delimiter, decimal mark, names,
encoding, padding, units and layout. write(seed) gives the bytes of a file and the samples that it holds."""
import gzip
import math
import random

TI = [10.0, 25.0, 40.0, 60.0]
TO = [0.0, 12.5, 20.0, 25.0, 40.0, 55.0, 60.0, 75.0]
PHI = [0.0, 30.0, 90.0, 135.0, 180.0]
RAD = math.pi / 180


def vector(theta, phi):
    return (math.sin(theta * RAD) * math.cos(phi * RAD), math.sin(theta * RAD) * math.sin(phi * RAD), math.cos(theta * RAD))


def reflectance(ti, to, phi, wavelength=0.0):
    """A GGX lobe of alpha 0.3 without masking on a diffuse base; spectra lean."""
    i, o = vector(ti, 0), vector(to, phi)
    h = [a + b for a, b in zip(i, o)]
    c = h[2] / math.sqrt(sum(x * x for x in h))
    d = 0.09 / (math.pi * (c * c * (0.09 - 1) + 1) ** 2)
    return (0.05 + 0.1 * d) * (1 + wavelength / 1000)


LANGUAGES = {  # theta_i, phi_i, theta_o, phi_o, value, sigma
    "own": ("theta_i", "phi_i", "theta_o", "phi_o", "f", "sigma"),
    "english": ("Incidence angle", "Incidence azimuth", "Scatter angle", "Scatter azimuth", "BRDF", "Std. dev."),
    "goniometer": ("Source polar", "Source azimuth", "Detector polar", "Detector azimuth", "BRDF", "Uncertainty"),
    "short": ("AOI", "Az in", "Det", "Az out", "BSDF", "std"),
    "greek": ("θ_i", "φ_i", "θ_r", "φ_r", "BRDF", "σ"),
    "papers": ("theta_l", "phi_l", "theta_v", "phi_v", "fr", "sd"),
    "planets": ("incidence", "incidence azimuth", "emission", "emission azimuth", "BRDF", "error"),
    "shouting": ("THETA_IN", "PHI_IN", "THETA_OUT", "PHI_OUT", "BRDF", "STDDEV"),
    "german": ("Einfallswinkel", "Einfallsazimut", "Ausfallswinkel", "Ausfallsazimut", "BRDF", "Standardabweichung"),
    "german2": ("Beleuchtungswinkel", "Einfallsazimut", "Detektorwinkel", "Detektorazimut", "BRDF", "Unsicherheit"),
    "french": ("Angle d'incidence", "Azimut incidence", "Angle de réflexion", "Azimut réflexion", "BRDF", "Incertitude"),
    "spanish": ("Ángulo de incidencia", "Acimut incidencia", "Ángulo de observación", "Acimut observación", "BRDF", "Incertidumbre"),
    "italian": ("Angolo di incidenza", "Azimut incidenza", "Angolo di osservazione", "Azimut osservazione", "BRDF", "Incertezza"),
}
ONLY_AZIMUTH = {"own": "phi", "german": "Azimut", "german2": "Azimutwinkel", "french": "Azimut", "spanish": "Acimut", "italian": "Azimut"}
UNITS = {"deg": ["", " (deg)", " [deg]", " [°]", " (degrees)", "_deg", ", deg"], "rad": [" (rad)", " [rad]", "_rad"]}
VALUE_UNITS = ["", " [1/sr]", " (sr^-1)", " (1/sr)"]
TITLES = [["Measurement 2026-03-12", "Sample: anodised A3"], ["Messung 12.03.2026 10:31"], ["Operator;J. Doe"], ["# made by: goniometer 4", "# run 17"]]
MISSING = ["", "nan", "NaN", "N/A", "-", "#DIV/0!", "-9999"]


class Dialect:
    def __init__(self, seed):
        r = self.r = random.Random(seed)
        self.delimiter = r.choice([",", ",", ";", ";", "\t", "\t", "|", " ", " ", ", "])
        self.decimal = r.choice([".", ".", ","])
        self.language = r.choice(sorted(LANGUAGES))
        self.encoding = r.choice(["utf-8", "utf-8", "utf-8-sig", "utf-16", "utf-16-be", "utf-16-le", "latin-1", "cp1252"])
        self.ends = r.choice(["\n", "\n", "\r\n", "\r\n", "\r", "\r\r\n"])
        self.units = r.choice(["deg", "deg", "deg", "rad"])
        self.unit = r.choice(UNITS[self.units])
        self.value_unit = r.choice(VALUE_UNITS)
        self.layout = r.choice(["full", "full", "difference", "difference", "plane", "wide", "blocks", "pivot", "half", "vectors", "elevation",
                                "spectrum", "long spectrum"])
        self.names = r.choices(["line", "comment", "quoted", "units below", "none"], [12, 2, 2, 2, 1])[0]
        self.padding = r.choice(["none", "none", "columns", "rows", "blanks", "quotes"])
        self.numbers = r.choice(["plain", "plain", "plain", "exponent", "fortran"])
        self.missing = r.choice(MISSING) if r.random() < 0.3 else None
        self.title = r.choice(TITLES) if r.random() < 0.3 else []
        self.foreign = r.random() < 0.2
        self.sigma = r.random() < 0.25 and self.layout in ("full", "difference", "elevation")
        self.packed = r.random() < 0.1
        self.settle()

    def settle(self):
        """What no program writes: names of blanks in columns of blanks, letters that an encoding lacks, empty cells between blanks."""
        if self.delimiter == ", " and self.decimal == ",":
            self.decimal = "."
        if self.encoding in ("latin-1", "cp1252") and self.language == "greek":
            self.encoding = "utf-8"
        if self.delimiter == " ":
            self.language = self.r.choice(["own", "papers", "shouting"])
            self.unit = "_rad" if self.units == "rad" else self.r.choice(["", "_deg", "(deg)"])
            self.value_unit = self.r.choice(["", "[1/sr]"])
            if self.missing == "" or self.padding in ("columns", "quotes", "blanks"):
                self.missing, self.padding = None, "none"
            if self.names == "quoted" or self.names == "units below":
                self.names = "line"
            self.title = [t for t in self.title if ";" not in t]
        if self.layout in ("wide", "pivot", "blocks", "spectrum", "vectors", "half", "elevation") and self.names in ("none", "units below"):
            self.names = "line"
        if self.layout in ("wide", "pivot", "blocks") and self.names == "comment":
            self.names = "line"
        if self.layout in ("wide", "pivot") and self.units == "rad":
            self.units, self.unit = "deg", " [deg]" if self.delimiter != " " else "_deg"
        if self.names == "units below":
            self.below = self.unit.strip(" ([])_,/") or "deg"
            self.unit = self.value_unit = ""
        if self.layout in ("half", "vectors", "elevation", "spectrum", "long spectrum", "pivot"):
            self.foreign = False
        if self.names == "none":
            self.foreign = self.sigma = False
            self.unit = ""
        if self.missing == "-9999" and self.sigma:
            self.sigma = False
        if self.units == "rad" and self.unit == "" and self.names not in ("none", "units below"):
            self.unit = "_rad"

    def __str__(self):
        return " ".join("%s=%r" % (k, v) for k, v in sorted(vars(self).items()) if k != "r")

    # ---- cells

    def number(self, v, digits=9):
        text = "%.*e" % (digits, v) if self.numbers != "plain" else "%.*g" % (digits, v)
        if self.numbers == "fortran":
            text = text.replace("e", "D")
        return text.replace(".", self.decimal)

    def angle(self, degrees):
        return self.number(degrees * RAD if self.units == "rad" else degrees, 12 if self.units == "rad" else 6)

    def value(self, v, missing=False):
        return self.missing if missing else self.number(v)

    def cell(self, text):
        if self.padding == "quotes" or (self.decimal == "," and self.delimiter.strip() == "," and "," in text):
            return '"%s"' % text
        return " %s " % text if self.padding == "blanks" and text else text

    def line(self, cells):
        if self.padding == "columns":
            cells = cells + ["", ""]
        return self.delimiter.join(self.cell(c) if c or self.padding == "quotes" and c else c for c in cells)

    def header(self, names):
        if self.delimiter.strip() == ",":
            names = ['"%s"' % n if "," in n else n for n in names]
        if self.names == "quoted":
            names = [n if n.startswith('"') else '"%s"' % n for n in names]
        if self.padding == "columns":
            names = names + ["", ""]
        text = self.delimiter.join(names)
        return "# " + text if self.names == "comment" else text

    # ---- layouts: each gives lines and samples (theta_i, phi_i, theta_o, phi_o, value or None)

    def name(self, k):
        return LANGUAGES[self.language][k] + (self.unit if k < 4 else self.value_unit if k == 4 else "")

    def is_missing(self):
        return self.missing is not None and self.r.random() < 0.03

    def rows(self, angles_of, names, with_sigma=True):
        lines, samples = [], []
        sigma = with_sigma and self.sigma
        if self.names != "none":
            lines.append(self.header((["Temperature"] if self.foreign else []) + names + [self.name(4)] + ([self.name(5)] if sigma else [])))
        if self.names == "units below":
            lines.append(self.line(([""] if self.foreign else []) + [self.below] * len(names) + ["1/sr"] + (["1/sr"] if sigma else [])))
        for ti in TI:
            for to in TO:
                for phi in PHI:
                    missing = self.is_missing()
                    f = reflectance(ti, to, phi)
                    angles, sample = angles_of(ti, to, phi)
                    if angles is None:
                        continue
                    lines.append(self.line((["21%s5" % self.decimal] if self.foreign else []) + angles + [self.value(f, missing)] +
                                           ([self.number(0.05 * f)] if sigma else [])))
                    samples.append(sample + (None if missing else f,))
        return lines, samples

    def full(self):
        return self.rows(lambda ti, to, phi: ([self.angle(ti), self.angle(15), self.angle(to), self.angle(phi + 15)], (ti, 15, to, phi + 15)),
                         [self.name(k) for k in range(4)])

    def azimuth(self):
        return ONLY_AZIMUTH.get(self.language, "Azimuth" if self.language != "papers" else "phi") + self.unit

    def difference(self):
        return self.rows(lambda ti, to, phi: ([self.angle(ti), self.angle(to), self.angle(phi)], (ti, 0, to, phi)),
                         [self.name(0), self.name(2), self.azimuth()])

    def plane(self):
        def angles(ti, to, phi):
            if phi not in (0, 180) or (to == 0 and phi == 0):
                return None, None
            return [self.angle(ti), self.angle(to if phi else -to)], (ti, 0, to, phi)
        return self.rows(angles, [self.name(0), self.name(2)])

    def half(self):
        def angles(ti, to, phi):
            i, o = vector(ti, 0), vector(to, phi)
            h = [a + b for a, b in zip(i, o)]
            n = math.sqrt(sum(x * x for x in h))
            h = [x / n for x in h]
            th, ph = math.acos(min(1, h[2])), math.atan2(h[1], h[0])
            x, y = i[0] * math.cos(ph) + i[1] * math.sin(ph), -i[0] * math.sin(ph) + i[1] * math.cos(ph)
            x, z = x * math.cos(th) - i[2] * math.sin(th), x * math.sin(th) + i[2] * math.cos(th)
            td, pd = math.acos(max(-1, min(1, z))), math.atan2(y, x)
            if self.r.random() < 0.5:
                pd %= 2 * math.pi
            fine = [self.number(v if self.units == "rad" else v / RAD, 12) for v in (th, td, pd)]
            return fine, (ti, 0, to, phi)
        unit = self.unit
        names = self.r.choice([["theta_h", "theta_d", "phi_d"], ["theta_half", "theta_diff", "phi_diff"]])
        return self.rows(angles, [n + unit for n in names])

    def vectors(self):
        def angles(ti, to, phi):
            return [self.number(v, 12) for v in vector(ti, 0) + vector(to, phi)], (ti, 0, to, phi)
        a, b = self.r.choice([("wi", "wo"), ("light", "view"), ("omega_i", "omega_o")])
        return self.rows(angles, ["%s_%s" % (w, c) for w in (a, b) for c in "xyz"])

    def elevation(self):
        return self.rows(lambda ti, to, phi: ([self.angle(90 - ti), self.angle(90 - to), self.angle(phi)], (ti, 0, to, phi)),
                         ["%s%s%s" % (w, " elevation" if self.delimiter != " " else "_elevation", self.unit) for w in ("source", "detector")] +
                         [self.azimuth()])

    def wide(self):
        signed = self.r.random() < 0.5
        names = ["%s %g°%s" % (LANGUAGES[self.language][4], t, self.value_unit) if self.delimiter != " " else "BRDF_%gdeg" % t for t in TI]
        if not signed:
            names = [n.replace(".", self.decimal) if self.delimiter.strip() != "," else n for n in names]
        lines, samples = [self.header([self.name(2)] + names)], []
        for to in [-t for t in TO[:0:-1]] + TO:
            cells = [self.angle(to)]
            for ti in TI:
                phi, missing = 180 if to >= 0 else 0, self.is_missing()
                cells.append(self.value(reflectance(ti, abs(to), phi), missing))
                samples.append((ti, 0, abs(to), phi, None if missing else reflectance(ti, abs(to), phi)))
            lines.append(self.line(cells))
        return lines, samples

    def blocks(self):
        lines, samples = [], []
        kind = self.r.choice(["%s = %s", "# %s: %s", "%s: %s deg", "%s" + ("=" if self.delimiter == " " else self.delimiter) + "%s"])
        if self.units == "rad":
            kind = kind.replace(" deg", "")
        incidence = "theta_i" + ("" if self.units == "deg" else " (rad)")
        for ti in TI:
            value = self.angle(ti) if self.numbers == "plain" else ("%.12g" % (ti * RAD if self.units == "rad" else ti)).replace(".", self.decimal)
            lines.append(kind % (incidence, value))
            lines.append(self.header([self.name(2), self.azimuth(), self.name(4)]))
            for to in TO:
                for phi in PHI:
                    missing = self.is_missing()
                    lines.append(self.line([self.angle(to), self.angle(phi), self.value(reflectance(ti, to, phi), missing)]))
                    samples.append((ti, 0, to, phi, None if missing else reflectance(ti, to, phi)))
            if self.r.random() < 0.5:
                lines.append("")
        return lines, samples

    def pivot(self):
        lines, samples = [], []
        for ti in TI:
            lines.append("Incidence%s%s" % (": " if self.delimiter == " " else self.delimiter, self.angle(ti) if self.numbers == "plain" else
                                            ("%g" % ti).replace(".", self.decimal)))
            lines.append(self.header(["theta_o\\phi_o"] + ["%g" % p for p in PHI]))
            for to in TO:
                cells = [self.angle(to)]
                for phi in PHI:
                    missing = self.is_missing()
                    cells.append(self.value(reflectance(ti, to, phi), missing))
                    samples.append((ti, 0, to, phi, None if missing else reflectance(ti, to, phi)))
                lines.append(self.line(cells))
        return lines, samples

    def spectrum(self):
        nm = [450.0, 550.0, 632.8]
        form = self.r.choice(["%gnm", "%g nm", "BRDF %g nm", "%g"] if self.delimiter != " " else ["%gnm"])
        lines, samples = [self.header([self.name(k) for k in range(4)] + [form % w for w in nm])], []
        for ti in TI:
            for to in TO:
                for phi in PHI:
                    f = [reflectance(ti, to, phi, w) for w in nm]
                    lines.append(self.line([self.angle(a) for a in (ti, 0, to, phi)] + [self.number(v) for v in f]))
                    samples.append((ti, 0, to, phi, tuple(f)))
        return lines, samples

    def long_spectrum(self):
        nm = [450.0, 550.0, 632.8]
        unit, factor = self.r.choice([("_nm", 1), (" (nm)", 1), (" [um]", 1e-3), ("", 1)] if self.delimiter != " " else [("_nm", 1), ("", 1)])
        lines, samples = [], []
        if self.names != "none":
            lines.append(self.header(["wavelength" + unit] + [self.name(k) for k in range(5)]))
        if self.names == "units below":
            lines[0] = self.header(["wavelength"] + [self.name(k) for k in range(5)])
            lines.append(self.line([unit.strip(" _()[]") or "nm"] + [self.below] * 4 + ["1/sr"]))
        for ti in TI:
            for to in TO:
                for phi in PHI:
                    f = [reflectance(ti, to, phi, w) for w in nm]
                    for w, v in zip(nm, f):
                        lines.append(self.line([self.number(w * factor, 7)] + [self.angle(a) for a in (ti, 0, to, phi)] + [self.number(v)]))
                    samples.append((ti, 0, to, phi, tuple(f)))
        return lines, samples

    def write(self):
        if self.layout == "long spectrum" and self.names == "none":
            self.names = "line"
        lines, samples = getattr(self, self.layout.replace(" ", "_"))()
        lines = list(self.title) + ([""] if self.title and self.padding == "rows" else []) + lines
        if self.padding == "rows":
            empty = "" if self.delimiter in (" ", "\t", ", ") else self.delimiter * (len(lines[-1].split(self.delimiter)) - 1)
            at = self.r.randrange(len(lines) // 2, len(lines))
            lines[at:at] = [empty, ""]
            lines += [empty, ""]
        text = self.ends.join(lines) + self.ends
        if self.encoding in ("utf-16-le", "utf-16-be"):
            data = text.encode(self.encoding)
        else:
            data = text.encode(self.encoding, "replace")
        return (gzip.compress(data, mtime=0) if self.packed else data), samples
