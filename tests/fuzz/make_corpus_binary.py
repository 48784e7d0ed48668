#!/usr/bin/env python3
"""Writes the seeds of the fuzzers for the formats utia and mbsdf into corpus/ beside this file. Nothing in them was measured.
A whole UTIA file has 2 MB, so its seeds are beginnings of one, which the reader refuses for their size."""
import os
import struct

here = os.path.join(os.path.dirname(os.path.abspath(__file__)), "corpus")


def write(name, content):
    path = os.path.join(here, name)
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "wb") as f:
        f.write(content)


def block(n_theta, n_phi, channels, first=0.25):
    count = n_theta * n_theta * n_phi * channels
    header = struct.pack("<3I", 0 if channels == 1 else 1, n_theta, n_phi)
    return header + struct.pack("<%df" % count, *(first - 0.01 * (k % 40) for k in range(count)))


magic = b"NVIDIA ARC MBSDF V1\n"
reflection, transmission = b"MBSDF_DATA_REFLECTION=\n", b"MBSDF_DATA_TRANSMISSION=\n"
write("mbsdf/rgb", magic + reflection + block(3, 4, 3))
write("mbsdf/scalar", magic + b"MBSDF_DATA=\n" + block(4, 3, 1))
write("mbsdf/both", magic + b'NAME="made"\n' + reflection + block(2, 3, 3) + transmission + block(2, 2, 1))
write("mbsdf/transmission", magic + transmission + block(2, 2, 3))
write("mbsdf/one-cell", magic + reflection + block(1, 1, 1))
write("mbsdf/wild-counts", magic + reflection + struct.pack("<3I", 1, 0xFFFFFFFF, 0xFFFFFFFF) + b"\0" * 64)
write("mbsdf/nan", magic + reflection + struct.pack("<3I4f", 0, 1, 4, 1, 2, float("nan"), 3))
write("mbsdf/text-only", magic + b'A="b"\nC="d"\n')

doubles = struct.pack("<64d", *(0.3 + 0.001 * k for k in range(64)))
write("utia/beginning", doubles)
write("utia/negative", struct.pack("<8d", *(0.1 - 0.03 * k for k in range(8))))
write("utia/not-finite", doubles[:64] + struct.pack("<3d", float("nan"), float("inf"), -float("inf")) + doubles[:64])
write("utia/cut-number", doubles[:77])
