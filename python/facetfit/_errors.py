"""What went wrong, and where: the library's codes as exceptions."""

from __future__ import annotations

import enum
from typing import Optional


class Code(enum.IntEnum):
    """Outcome of a call, with the numbers of the C library (ff_status.h)."""

    RANGE = 1
    UNKNOWN = 2
    SYNTAX = 3
    UNSUPPORTED = 4
    MEMORY = 5
    OPEN = 6
    READ = 7
    FORMAT = 8
    DATA = 9
    WRITE = 10
    CANCELLED = 11
    INTERNAL = 12


class Error(Exception):
    """An error of the library. `code` says what kind it is, `path`, `line` and `byte` where, `message` what was found and
    expected."""

    def __init__(
        self, code: Code, message: str, path: Optional[str] = None, line: Optional[int] = None, byte: Optional[int] = None
    ) -> None:
        self.code, self.message, self.path, self.line, self.byte = code, message, path, line, byte
        super().__init__(message)

    def __str__(self) -> str:
        place = self.path or ""
        if self.line is not None:
            place += f":{self.line}"
        elif self.byte is not None:
            place += f": byte {self.byte}"
        return f"{place}: {self.message}" if place else self.message


class ArgumentError(Error, ValueError):
    """A number out of its range, a name that is unknown, a combination without a meaning."""


class FileError(Error, RuntimeError):
    """A file that cannot be read, understood, used or written."""


class NoMemoryError(Error, MemoryError):
    """An allocation failed."""


_KINDS = {
    Code.RANGE: ArgumentError,
    Code.UNKNOWN: ArgumentError,
    Code.SYNTAX: ArgumentError,
    Code.UNSUPPORTED: ArgumentError,
    Code.MEMORY: NoMemoryError,
    Code.OPEN: FileError,
    Code.READ: FileError,
    Code.FORMAT: FileError,
    Code.DATA: FileError,
    Code.WRITE: FileError,
}

# What the caller of `read` can say to help, by the numbers of ff_hint.
_HINTS = {
    1: "say scale=X, the 1/sr of one of them",
    2: "say quantity='brdf', 'brdf-cos' or 'reflectance-factor'",
    3: "say quantity='brdf' if they are the BRDF",
    4: "say quantity='brdf-cos' if they are the BRDF times cos(theta_o)",
}


def make(status: int, message: str, path: Optional[str], line: Optional[int], byte: Optional[int], hint: int) -> Error:
    """The exception of a status of the library."""
    code = Code(status)
    if hint in _HINTS:
        message = f"{message}; {_HINTS[hint]}"
    return _KINDS.get(code, Error)(code, message, path, line, byte)
