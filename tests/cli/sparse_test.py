#!/usr/bin/env python3
"""sparse_test.py PROGRAM: a file of any size that is not of a format is refused by its beginning: within a second of processor time
and 64 MB of memory more than the smallest file takes. Sparse files of 8 GiB stand for large ones; every format reads each, and one
is read by its content. The address space is limited as well, so that memory that is asked for and not touched counts."""
import os
import resource
import subprocess
import sys
import tempfile

program = os.path.abspath(sys.argv[1])
sanitized = b"__asan_init" in open(program, "rb").read() or b"__tsan_init" in open(program, "rb").read()
SIZE, MORE, SECONDS = 8 << 30, 64 << 20, 1
# what the beginning says, with nothing but zeros behind it
BEGINNINGS = {
    "zeros": b"", "tensor": b"tensor_file\0", "tensor-version": b"tensor_file\0\1\0", "tensor-fields": b"tensor_file\0\1\0\1\0\0\0",
    "tensor-field": b"tensor_file\0\1\0\1\0\0\0\1\0x\1\0\1" + (64).to_bytes(8, "little") + (1 << 20).to_bytes(8, "little"),
    "tensor-256": b"tensor_file\0\1\0\0\1\0\0" + b"".join(
        b"\xff\xff" + (b"%05d" % k) * 13107 + b"\0\0\1" + bytes(8) for k in range(256)),
    "merl": b"\x5a\0\0\0\x5a\0\0\0\xb4\0\0\0", "exr": bytes((0x76, 0x2f, 0x31, 1, 2, 0, 0, 0)), "mbsdf": b"NVIDIA ARC MBSDF V1\n",
    "mbsdf-data": b"NVIDIA ARC MBSDF V1\nMBSDF_DATA=\n\0\0\0\0\x5a\0\0\0\x5a\0\0\0", "text": b"# some text\n", "space": b" ",
    "csv": b"theta_i,phi_i,theta_o,phi_o,f\n", "images": b"image,theta_i,phi_i,theta_o,phi_o\n", "xml": b"<?xml version=\"1.0\"?>\n<W>",
    "astm": b"ASTM\n", "alta": b"#ALTA HEADER\n", "zemax": b"Source  Measured\n", "png": b"\x89PNG\r\n\x1a\n", "bom": b"\xef\xbb\xbf",
    "line": b"0 " * (1 << 20), "long-text": b"NVIDIA ARC MBSDF V1\n" + b"# x\n" * (5 << 20),
}
failures = runs = 0


def run(name, form, space):
    p = subprocess.Popen([program, "info", name] + (["--format", form] if form else []), stdin=subprocess.DEVNULL,
                         stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
                         preexec_fn=lambda: space and resource.setrlimit(resource.RLIMIT_AS, (space, space)))
    err = p.stderr.read()
    _, status, used = os.wait4(p.pid, 0)
    p.returncode = status
    return os.waitstatus_to_exitcode(status), err, used


def least_space():
    """The address space that the program needs to refuse a file of 16 bytes."""
    with open("small", "wb") as f:
        f.write(bytes(16))
    low, high = 1 << 20, 1 << 32
    while high - low > 1 << 20:
        middle = (low + high) // 2
        low, high = (low, middle) if run("small", "rgl", middle)[0] == 3 else (middle, high)
    return high, run("small", "rgl", 0)[2].ru_maxrss


def fails(text):
    global failures
    failures += 1
    print("failed: " + text)


with tempfile.TemporaryDirectory() as directory:
    os.chdir(directory)
    table = subprocess.run([program, "formats", "--table", "csv"], capture_output=True, text=True, check=True).stdout
    formats = [line.split(",")[0] for line in table.splitlines()[1:]]
    least, resident = (0, 0) if sanitized else least_space()
    print("%d formats; a small file takes %d MB of address space, %d MB of memory" % (len(formats), least >> 20, resident >> 10))
    slowest = largest = 0
    for label, beginning in BEGINNINGS.items():
        with open("sparse", "wb") as f:
            f.write(beginning)
            f.truncate(SIZE)
        for form in [None] + formats:
            runs += 1
            status, err, used = run("sparse", form, least and least + MORE)
            seconds, memory = used.ru_utime + used.ru_stime, used.ru_maxrss - resident
            slowest, largest = max(slowest, seconds), max(largest, memory)
            if status not in (2, 3) or "memory" in err:
                fails("%s read as %s: status %d, %s" % (label, form, status, err))
            if not sanitized and (seconds > SECONDS or memory > MORE >> 10):
                fails("%s read as %s: %.2f s, %d kB more" % (label, form, seconds, memory))
        os.remove("sparse")
    os.chdir("/")
print("%d runs, at most %.2f s and %d kB more, %d failures" % (runs, slowest, largest, failures))
sys.exit(1 if failures or runs < 100 else 0)
