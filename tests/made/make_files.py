#!/usr/bin/env python3
"""make_files.py DIRECTORY: one file of every format, of a surface whose reflectance is written down here.

Each is laid out as its sources describe it, by this script alone: what the program reads of it can be compared with value() at the
directions that the program found, and no convention of the program's takes part. Needs numpy.
"""
import os
import struct
import sys
import numpy as np

CHANNELS = 3
TRUTH = {"alpha_x": 0.3, "f0": (0.6, 0.3, 0.1), "kd": (0.05, 0.1, 0.2)}
NM = (465, 525, 630)


def value(wi, wo):
    """f of GGX, Smith's height-correlated masking, Schlick's F and Lambert, [..., 3]; wi, wo [..., 3]. 0 below the horizon."""
    a2 = TRUTH["alpha_x"] ** 2
    zi, zo = wi[..., 2], wo[..., 2]
    up = (zi > 1e-9) & (zo > 1e-9)
    zi, zo = np.where(up, zi, 1), np.where(up, zo, 1)
    h = wi + wo
    h = h / np.maximum(np.linalg.norm(h, axis=-1, keepdims=True), 1e-300)
    d = a2 / (np.pi * (1 + (a2 - 1) * h[..., 2] ** 2) ** 2)
    hidden = [(np.sqrt(1 + a2 * (1 / z**2 - 1)) - 1) / 2 for z in (zi, zo)]
    c5 = (1 - np.clip(np.sum(wi * h, -1), 0, 1)) ** 5
    f = [d / (1 + sum(hidden)) / (4 * zi * zo) * (f0 + (1 - f0) * c5) + kd / np.pi for f0, kd in zip(TRUTH["f0"], TRUTH["kd"])]
    return np.where(up[..., None], np.stack(f, -1), 0)


def direction(theta, phi):
    theta, phi = np.broadcast_arrays(np.radians(np.asarray(theta, float)), np.radians(np.asarray(phi, float)))
    return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1)


def at(ti, pi, to, po):
    return value(direction(ti, pi), direction(to, po))


def grid(*axes):
    return [a.reshape(-1) for a in np.meshgrid(*axes, indexing="ij")]


def goniometer():
    """Angles of a scan in degrees, light at azimuth 0."""
    return grid([0, 15, 30, 45, 60, 70], [0], np.arange(0, 81, 5), np.arange(0, 360, 15))


def text(path, lines):
    with open(path, "w", encoding="ascii") as f:
        f.write("\n".join(lines) + "\n")


def row(numbers, separator=" "):
    return separator.join("%.10g" % x for x in numbers)


# ---- the formats ------------------------------------------------------------------------------------


def csv(path):
    a = goniometer()
    text(path, ["theta_i,phi_i,theta_o,phi_o,red,green,blue"] + [row((*w, *f), ",") for *w, f in zip(*a, at(*a))])


def astm(path):
    a = goniometer()
    head = ["SYSTEM_NAME made", "NUM_POINTS %d" % len(a[0]), "VARS theta_i,phi_i,theta_s,phi_s," + ",".join("%dnm" % n for n in NM)]
    text(path, head + [row((*np.radians(w), *f), ",") for *w, f in zip(*a, at(*a))])


def merl(path):
    """Half and difference angles, [theta_h][theta_d][phi_d], planes of red, green and blue; -1 where a direction is below the horizon."""
    td, pd = np.radians(np.arange(90) + 0.5)[:, None], np.radians(np.arange(180) + 0.5)[None, :]
    out = np.empty((CHANNELS, 90, 90, 180))
    scale = 1500 / np.array([1, 1.15, 1.66])
    for k in range(90):
        th = np.radians((k + 0.5) ** 2 / 90)
        h = np.array([np.sin(th), 0, np.cos(th)])
        d = [np.sin(td) * np.cos(pd), np.sin(td) * np.sin(pd), np.cos(td) + 0 * pd]
        wi = np.stack([np.cos(th) * d[0] + np.sin(th) * d[2], d[1], np.cos(th) * d[2] - np.sin(th) * d[0]], -1)
        wo = 2 * (wi @ h)[..., None] * h - wi
        f = value(wi, wo) * scale
        f[(wi[..., 2] <= 0) | (wo[..., 2] <= 0)] = -1
        out[:, k] = np.moveaxis(f, -1, 0)
    with open(path, "wb") as f:
        f.write(struct.pack("<3i", 90, 90, 180))
        out.astype("<f8").tofile(f)


def utia_planes():
    ti, pi, to, po = grid(np.arange(6) * 15, np.arange(48) * 7.5, np.arange(6) * 15, np.arange(48) * 7.5)
    return np.moveaxis(at(ti, pi, to, po).reshape(288, 288, 3), -1, 0)


def utia(path):
    utia_planes().astype("<f8").tofile(path)


def exr(path):
    """A plain image of 288 x 288 floats without compression: the database's other form."""
    planes = utia_planes()[::-1].astype("<f4")  # channels are stored by name: B, G, R
    window = struct.pack("<4i", 0, 0, 287, 287)
    channels = b"".join(c + b"\0" + struct.pack("<iB3xii", 2, 0, 1, 1) for c in (b"B", b"G", b"R")) + b"\0"
    head = struct.pack("<ii", 20000630, 2)
    for name, kind, data in ((b"channels", b"chlist", channels), (b"compression", b"compression", b"\0"), (b"dataWindow", b"box2i", window),
                             (b"displayWindow", b"box2i", window), (b"lineOrder", b"lineOrder", b"\0"), (b"pixelAspectRatio", b"float", struct.pack("<f", 1)),
                             (b"screenWindowCenter", b"v2f", struct.pack("<2f", 0, 0)), (b"screenWindowWidth", b"float", struct.pack("<f", 1))):
        head += name + b"\0" + kind + b"\0" + struct.pack("<i", len(data)) + data
    head += b"\0"
    lines = [struct.pack("<ii", y, 3 * 288 * 4) + planes[:, y].tobytes() for y in range(288)]
    first = len(head) + 8 * 288
    with open(path, "wb") as f:
        f.write(head + struct.pack("<288Q", *(first + y * len(lines[0]) for y in range(288))) + b"".join(lines))


def images(path):
    """An image of one colour for each pair of directions, and the list of them."""
    folder = os.path.dirname(path)
    a = grid([0, 20, 40, 60], [0], np.arange(0, 76, 15), np.arange(0, 360, 30))
    lines = ["# facetfit-images: 1", "image,theta_i,phi_i,theta_o,phi_o"]
    for k, (*w, f) in enumerate(zip(*a, at(*a))):
        with open(os.path.join(folder, "made-%d.pfm" % k), "wb") as out:
            out.write(b"PF\n2 2\n-1.0\n" + np.tile(f, 4).astype("<f4").tobytes())
        lines.append("made-%d.pfm," % k + row(w, ","))
    text(path, lines)


def rgl(path):
    """The warps are those of a constant density, so that s = u; ndf = 1 and sigma = 1/4 make the stored colour f cos(theta_o)."""
    n, incidences = 32, np.radians(np.array([0, 12, 24, 36, 48, 60, 70, 80], float))
    u = np.linspace(0, 1, n)
    phi, theta = (2 * u - 1) * np.pi, np.pi / 2 * u**2
    p, t = np.meshgrid(phi, theta, indexing="ij")
    m = np.stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)], -1)
    rgb = np.empty((1, len(incidences), 3, n, n), "<f4")
    for k, incidence in enumerate(incidences):
        wi = np.broadcast_to([np.sin(incidence), 0, np.cos(incidence)], m.shape)
        wo = 2 * np.sum(wi * m, -1, keepdims=True) * m - wi
        rgb[0, k] = np.moveaxis(value(wi, wo) * np.maximum(wo[..., 2:], 0), -1, 0)
    flat = np.ones((2, 2), "<f4")
    even = np.ones((1, len(incidences), n, n), "<f4")
    fields = {"phi_i": np.zeros(1, "<f4"), "theta_i": incidences.astype("<f4"), "ndf": flat, "sigma": flat / 4, "vndf": even, "luminance": even,
              "rgb": rgb, "jacobian": np.ones(1, "u1"), "description": np.frombuffer(b"made", "u1")}
    heads, at_byte = [], 12 + 2 + 4 + sum(2 + len(k) + 2 + 1 + 8 + 8 * v.ndim for k, v in fields.items())
    for name, v in fields.items():
        heads.append(struct.pack("<H", len(name)) + name.encode() + struct.pack("<HBQ", v.ndim, 1 if v.dtype == "u1" else 10, at_byte) +
                     struct.pack("<%dQ" % v.ndim, *v.shape))
        at_byte += v.nbytes
    with open(path, "wb") as f:
        f.write(b"tensor_file\0" + struct.pack("<BBI", 1, 0, len(fields)) + b"".join(heads) + b"".join(np.ascontiguousarray(v).tobytes() for v in fields.values()))


def alta(path):
    ti, pi, to, po = goniometer()
    x, y = np.radians(to) * np.cos(np.radians(po)), np.radians(to) * np.sin(np.radians(po))
    head = ["#DIM 3 3", "#VS 0", "#PARAM_IN ISOTROPIC_TL_TV_PROJ_DPHI", "#PARAM_OUT RGB_COLOR_COSINE_FACTOR"]
    head[3] = "#PARAM_OUT RGB_COLOR"
    text(path, head + [row((np.radians(a), b, c, *f)) for a, b, c, f in zip(ti, x, y, at(ti, pi, to, po))])


def alta_cosine(path):
    ti, pi, to, po = goniometer()
    x, y = np.radians(to) * np.cos(np.radians(po)), np.radians(to) * np.sin(np.radians(po))
    f = at(ti, pi, to, po)[:, 0] * np.cos(np.radians(to))
    text(path, ["#DIM 3 1", "#VS 0", "#PARAM_IN ISOTROPIC_TL_TV_PROJ_DPHI", "#PARAM_OUT INV_STERADIAN_COSINE_FACTOR"] +
         [row((np.radians(a), b, c, v)) for a, b, c, v in zip(ti, x, y, f)])


def zemax(path):
    """Azimuth and radius about the mirror direction, azimuth 0 towards the normal."""
    az, rad, incidences = np.arange(0, 181, 15), np.array([0, 2, 5, 10, 15, 20, 30, 40, 50, 60, 75, 90]), [0, 20, 40, 60]
    lines = ["# made", "Source Measured", "Symmetry PlaneSymmetrical", "SpectralContent Monochrome", "ScatterType BRDF", "SampleRotation 1", "0",
             "AngleOfIncidence %d" % len(incidences), row(incidences), "ScatterAzimuth %d" % len(az), row(az), "ScatterRadial %d" % len(rad), row(rad),
             "", "Monochrome", "DataBegin"]
    for i in incidences:
        s, a, r = np.radians(i), np.radians(az)[:, None], np.radians(rad)[None, :]
        mirror, up, aside = np.array([-np.sin(s), 0, np.cos(s)]), np.array([np.cos(s), 0, np.sin(s)]), np.array([0, 1, 0])
        wo = np.cos(r)[..., None] * mirror + np.sin(r)[..., None] * (np.cos(a)[..., None] * up + np.sin(a)[..., None] * aside)
        f = value(np.broadcast_to(direction(i, 0), wo.shape), wo)[..., 0]
        lines += ["TIS 0.5"] + [row(line) for line in f]
    text(path, lines + ["DataEnd"])


def cornell(path):
    ti, pi, to, po = goniometer()
    rows = [row((*np.radians(w), *f)) for *w, f in zip(ti, pi, to, po, at(ti, pi, to, po))]
    text(path, ["# num wls", "3", "# wls", row(NM), "# theta i, phi i, theta s, phi_s, spectral sample values"] + rows)


def fred(path):
    lines = ["type bsdf_data", "format angles=deg bsdf=value scale=1"]
    for i in (10, 30, 50, 70):
        to, po = grid(np.arange(0, 81, 5), np.arange(0, 181, 10))
        lines += ["%d\t0" % i] + [row(r, "\t") for r in zip(to, po, at(i, 180, to, po)[:, 0])]  # the mirror direction is at azimuth 0
    text(path, lines)


def lighttools(path):
    az, rad = np.arange(0, 361, 15), np.array([0, 5, 10, 15, 20, 30, 40, 50, 60, 70, 80])
    lines = ["#Data made", "Model #: made", "Source\tMeasured", "Symmetry\tAsymmetric", "SpectralContent\tMonochrome", "ScatterAzimuth\t%d" % len(az), row(az, "\t"),
             "ScatterRadial\t%d" % len(rad), row(rad, "\t"), "DataBegin"]
    for i in (0, 20, 40, 60):
        po, to = np.meshgrid(az, rad, indexing="ij")
        f = at(i, 90, to, po)
        for c in range(CHANNELS):
            lines += ["", "AOI %d" % i, "POI 0", "Side Front", "Wavelength %d" % NM[c], "ScatterType BRDF", "TIS 0.5"] + [row(v, "\t") for v in f[..., c]]
    text(path, lines)


def mbsdf(path):
    n, m = 30, 61
    ti, to, p = np.meshgrid(np.arange(n) * 90 / n, np.arange(n) * 90 / n, np.arange(m) * 180 / (m - 1), indexing="ij")
    with open(path, "wb") as f:
        f.write(b'NVIDIA ARC MBSDF V1\nMBSDF_DATA_REFLECTION=\n' + struct.pack("<3I", 1, n, m) + at(ti, 0, to, p).astype("<f4").tobytes())


def nist(path):
    a = goniometer()
    head = "lambda,thetai,phi,thetar,phir,f_r11," + ",".join("f_r%d%d/f_r11" % (i, j) for i in range(1, 5) for j in range(1, 5) if i + j > 2)
    text(path, [head] + [row((0.532, *w, f[0], *[0] * 15), ",") for *w, f in zip(*a, at(*a))])


def pgii(path):
    a = grid(np.arange(0, 81, 2), np.arange(0, 360, 5))
    f = at(30, 0, *a)[:, 0] * np.cos(np.radians(a[0]))
    head = ["#pgII [DSF] data made", "#incident_angle\t30\t0", "#intheta\t30", "#inphi\t0", "#datapoints_in_file\t%d" % len(f), "#format: theta phi DSF"]
    text(path, head + [row(r, "\t") for r in zip(*a, f)])


def planetary(path):
    names = "counter incidence emission azimuth phase reflectance_factor standard_deviation error_estimate quality_flag absolute_time relative_time bandpass_central"
    lines = ["# " + ", ".join("'%s'" % n for n in names.split())]
    ti, pi, to, po = grid([0, 15, 30, 45, 60], [0], np.arange(0, 76, 5), np.arange(0, 181, 15))
    wi, wo, f = direction(ti, pi), direction(to, po), at(ti, pi, to, po)
    phase = np.degrees(np.arccos(np.clip(np.sum(wi * wo, -1), -1, 1)))
    for c in range(CHANNELS):
        for k in range(len(ti)):
            lines.append(row((len(lines) - 1, ti[k], to[k], po[k], phase[k], np.pi * f[k, c], 1, 2, 5, 0, 0, NM[c]), ", "))
    text(path, lines)


def window(path):
    """Klems' 145 patches, front reflection; columns are the incident patches. Values at the middles of the patches."""
    bounds, counts = [0, 5, 15, 25, 35, 45, 55, 65, 75, 90], [1, 8, 16, 20, 24, 24, 24, 16, 12]
    middles = [0, 10, 20, 30, 40, 50, 60, 70, 82.5]
    theta = np.concatenate([[m] * n for m, n in zip(middles, counts)])
    phi = np.concatenate([np.arange(n) * 360 / n for n in counts])
    # a patch of exit is named by where it comes from: the same azimuth is the mirror direction
    f = at(theta[None, :], phi[None, :], theta[:, None], phi[:, None] + 180)[..., 0]
    f = np.where(theta[:, None] == 0, at(theta[None, :], phi[None, :], 0 * theta[:, None], 0)[..., 0], f)
    blocks = "".join("<AngleBasisBlock><Theta>%g</Theta><ThetaBounds><LowerTheta>%g</LowerTheta><UpperTheta>%g</UpperTheta></ThetaBounds><nPhis>%d</nPhis>"
                     "</AngleBasisBlock>" % z for z in zip(middles, bounds, bounds[1:], counts))
    name = "LBNL/Klems Full"
    text(path, ['<?xml version="1.0" encoding="UTF-8"?>', '<WindowElement xmlns="http://windows.lbl.gov"><WindowElementType>System</WindowElementType><Optical><Layer>',
                "<Material><Name>made</Name></Material><DataDefinition><IncidentDataStructure>Columns</IncidentDataStructure><AngleBasis><AngleBasisName>" + name +
                "</AngleBasisName>" + blocks + "</AngleBasis></DataDefinition>",
                "<WavelengthData><LayerNumber>System</LayerNumber><Wavelength unit=\"Integral\">Visible</Wavelength><WavelengthDataBlock>",
                "<WavelengthDataDirection>Reflection Front</WavelengthDataDirection><ColumnAngleBasis>%s</ColumnAngleBasis><RowAngleBasis>%s</RowAngleBasis>" % (name, name),
                "<ScatteringDataType>BRDF</ScatteringDataType><ScatteringData>"] + [row(line, ", ") + "," for line in f] +
         ["</ScatteringData></WavelengthDataBlock></WavelengthData></Layer></Optical></WindowElement>"])


# Of each: the file, its writer, samples, channels of the truth.
FILES = {"merl": ("made.binary", merl), "astm": ("made.astm", astm), "csv": ("made.csv", csv), "exr": ("made.exr", exr), "images": ("stack.csv", images),
         "rgl": ("made.rgl.bsdf", rgl), "utia": ("made.bin", utia), "alta": ("made.alta", alta), "alta, cosine": ("cosine.alta", alta_cosine),
         "zemax": ("made.zemax.bsdf", zemax), "cornell": ("made.brdf", cornell), "fred": ("made.fred", fred), "lighttools": ("made.lighttools.bsdf", lighttools),
         "mbsdf": ("made.mbsdf", mbsdf), "nist": ("nist.csv", nist), "pgii": ("made.pgii", pgii), "planetary": ("planetary.csv", planetary), "window": ("made.xml", window)}


def make(directory):
    """Writes all; {name: path}."""
    for name, (file, write) in FILES.items():
        write(os.path.join(directory, file))
    return {name: os.path.join(directory, file) for name, (file, _) in FILES.items()}


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    make(sys.argv[1])
