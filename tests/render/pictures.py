"""OpenEXR images without compression, and PNG, as arrays: no more than the tests of pictures need."""
import struct
import zlib
import numpy as np


def exr(path):
    """{channel: array [height][width]}"""
    with open(path, "rb") as f:
        data = f.read()
    assert data[:4] == b"\x76\x2f\x31\x01"
    at, attributes = 8, {}
    while data[at]:
        name, kind, rest = data[at:].split(b"\0", 2)
        at += len(name) + len(kind) + 2
        size = struct.unpack_from("<i", data, at)[0]
        attributes[name.decode()] = data[at + 4:at + 4 + size]
        at += 4 + size
    at += 1
    assert attributes["compression"] == b"\0"
    x0, y0, x1, y1 = struct.unpack("<4i", attributes["dataWindow"])
    names, rest = [], attributes["channels"]
    while rest[0]:
        name = rest.split(b"\0", 1)[0]
        assert struct.unpack_from("<i", rest, len(name) + 1)[0] == 2  # float
        names.append(name.decode())
        rest = rest[len(name) + 17:]
    width, height = x1 - x0 + 1, y1 - y0 + 1
    out = {name: np.zeros((height, width)) for name in names}
    for place in struct.unpack_from(f"<{height}q", data, at):
        y, size = struct.unpack_from("<2i", data, place)
        assert size == 4 * width * len(names)
        line = np.frombuffer(data, "<f4", width * len(names), place + 8).reshape(len(names), width)
        for name, values in zip(names, line):
            out[name][y - y0] = values
    return out


def png(path):
    """array [height][width][3 or 4] of 0 to 255"""
    with open(path, "rb") as f:
        data = f.read()
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    at, packed, head, ended = 8, b"", None, False
    while at < len(data):
        size, kind = struct.unpack_from(">I4s", data, at)
        body = data[at + 8:at + 8 + size]
        assert zlib.crc32(kind + body) == struct.unpack_from(">I", data, at + 8 + size)[0], kind
        head = struct.unpack(">2I5B", body) if kind == b"IHDR" else head
        packed += body if kind == b"IDAT" else b""
        ended = kind == b"IEND"
        at += 12 + size
    width, height, depth, colour, *rest = head
    assert ended and depth == 8 and colour in (2, 6) and rest == [0, 0, 0]
    n = 3 if colour == 2 else 4
    raw = np.frombuffer(zlib.decompress(packed), np.uint8).reshape(height, 1 + n * width)
    out, above = np.zeros((height, width * n), np.uint8), [0] * (width * n)
    for y in range(height):
        kind, line, row = raw[y, 0], raw[y, 1:].tolist(), []
        for k, v in enumerate(line):
            a, b, c = (row[k - n] if k >= n else 0), above[k], (above[k - n] if k >= n else 0)
            p = a + b - c
            nearest = a if abs(p - a) <= abs(p - b) and abs(p - a) <= abs(p - c) else b if abs(p - b) <= abs(p - c) else c
            row.append((v + (0, a, b, (a + b) // 2, nearest)[kind]) & 255)
        out[y] = above = row
    return out.reshape(height, width, n)
