"""Measured reflectance: files and arrays."""

from __future__ import annotations

import importlib
import json
import math
import os
from typing import Any, Dict, List, NamedTuple, Optional, Sequence, Tuple, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core

Array = NDArray[np.float64]
Path = Union[str, "os.PathLike[str]"]


class Channel(NamedTuple):
    """A colour channel. A value is `scale` times what the file stores, in 1/sr."""

    name: str
    wavelength: float  # nm; NaN where the channel is not a wavelength
    scale: float


class Finding(NamedTuple):
    """Something about angles or values that may not be what they were taken for; `option` and `value` of read() would mend
    it."""

    kind: str
    sure: bool
    option: str
    value: str
    numbers: Tuple[float, float]


_FINDINGS = (
    "azimuth 0 is the mirror direction",
    "azimuth 0 is the light's",
    "both polar angles are elevations",
    "the polar angle of the light is an elevation",
    "the polar angle of the detector is an elevation",
    "one azimuth grows the other way than the other",
    "angles are radians",
    "values are 100 times what can be",
    "values are pi times what can be",
    "every sample is beyond the largest angle that is looked at",
)


class Measurement:
    """Samples of a BRDF: pairs of directions with a value for each channel.

    Made by read() and measurement(). What is called stored is a view of the library's own memory, without a copy: writing to it
    changes the measurement. Such an array keeps the measurement alive."""

    def __init__(self, table: _core.Table) -> None:
        self._table = table

    def __len__(self) -> int:
        return self._table.samples

    def __repr__(self) -> str:
        names = [c.name for c in self.channels]
        shown = ", ".join(names[:8]) + (" ..." if len(names) > 8 else "")
        return f"<Measurement of {self.path}: {len(self)} samples, channels {shown}>"

    @property
    def path(self) -> str:
        """What it is called in reports."""
        return self._table.path

    @property
    def format(self) -> str:
        """Name of the format it was read from, "" of arrays."""
        return self._table.format

    @property
    def quantity(self) -> str:
        """What the file declared; values are the BRDF already."""
        return self._table.quantity

    @property
    def isotropic(self) -> bool:
        """Were only differences of azimuths measured?"""
        return self._table.isotropic

    @property
    def channels(self) -> List[Channel]:
        return [Channel(*c) for c in self._table.channels]

    @property
    def wavelengths(self) -> Array:
        """[channels] nm; NaN where a channel is not a wavelength."""
        return np.array([c.wavelength for c in self.channels])

    @property
    def notes(self) -> List[str]:
        """What the reader had to assume, in sentences."""
        return self._table.notes

    # ---- arrays

    @property
    def stored(self) -> Array:
        """[samples, channels] values as the file has them, a view; times the channel's scale they are in 1/sr."""
        return self._table.values_view()

    @property
    def stored_sigma(self) -> Optional[Array]:
        """[samples, channels] standard deviations as the file has them, a view; None where it has none."""
        return self._table.sigmas_view()

    @property
    def stored_angles(self) -> Optional[Tuple[Array, Array, Array, Array]]:
        """theta_i, phi_i, theta_o, phi_o, [samples] each in units of angle_unit, views; None of a grid, whose angles are a
        formula."""
        views = [self._table.angle_view(k) for k in range(4)]
        found = [v for v in views if v is not None]
        return (found[0], found[1], found[2], found[3]) if len(found) == 4 else None

    @property
    def angle_unit(self) -> float:
        """Radians per unit of the stored angles."""
        return self._table.angle_unit

    @property
    def valid(self) -> NDArray[np.bool_]:
        """[samples] a view; False where there is no measurement. May be written to leave samples out."""
        return self._table.valid_view()

    @property
    def weights(self) -> Optional[Array]:
        """[samples] solid-angle weights of scattered samples, a view; None where there are none."""
        return self._table.weight_view()

    @property
    def f(self) -> Array:
        """[samples, channels] BRDF in 1/sr: the view `stored` where all scales are 1, else a new array."""
        return self.stored if all(c.scale == 1 for c in self.channels) else self._table.values()

    @property
    def sigma(self) -> Optional[Array]:
        """[samples, channels] standard deviations in 1/sr; None where there are none."""
        return None if self.stored_sigma is None else self._table.sigmas()

    @property
    def directions(self) -> Tuple[Array, Array]:
        """wi, wo: [samples, 3] unit vectors to the light and to the detector, new arrays."""
        return self._table.directions()

    @property
    def wi(self) -> Array:
        return self.directions[0]

    @property
    def wo(self) -> Array:
        return self.directions[1]

    @property
    def axes(self) -> Optional[Tuple[Array, Array, Array, Array]]:
        """The values that theta_i, phi_i, theta_o and phi_o take, radians, where the samples are all combinations of them;
        else None."""
        angles = self.stored_angles
        if angles is None:
            return None
        nodes = [np.unique(a) for a in angles]
        if math.prod(len(n) for n in nodes) != len(self):
            return None
        return (nodes[0] * self.angle_unit, nodes[1] * self.angle_unit, nodes[2] * self.angle_unit, nodes[3] * self.angle_unit)

    # ---- what is done with it

    def reduce(self, to: str) -> "Measurement":
        """Fewer channels: "srgb", "bands:NAME=LO-HI,...", "channels:NAME,..." or "mean"."""
        return Measurement(self._table.reduce(to))

    def write(self, path: Path, format: Optional[str] = None) -> None:
        """Writes a file, in the format that its name asks for unless one is named; it appears whole or not at all."""
        self._table.write(os.fspath(path), format)

    def resample(
        self, format: str, *, grid: Optional[str] = None, extrapolate: bool = False, threads: int = 0
    ) -> Tuple["Measurement", Dict[str, Any]]:
        """The measurement at the directions that a format needs, and what became of the samples."""
        table, report = self._table.resample(format, grid, extrapolate, threads)
        return Measurement(table), report

    def info(self) -> Dict[str, Any]:
        """Coverage, symmetries, reflectances: the document of `facetfit info --json`."""
        document: Dict[str, Any] = json.loads(self._table.describe("json"))
        return document

    def text(self) -> str:
        """The same in words."""
        return self._table.describe("text")

    def diagnose(self, max_theta: float = 80) -> List[Finding]:
        """Whether angles and values are what they were taken for, looking at polar angles up to max_theta degrees."""
        found, _ = self._table.diagnose(math.radians(max_theta))
        return [Finding(_FINDINGS[kind], sure, option, value, (a, b)) for kind, sure, option, value, a, b in found]

    def to_pandas(self) -> Any:
        """A pandas.DataFrame with a row for each sample: angles in degrees, f of every channel, valid."""
        pandas = importlib.import_module("pandas")
        wi, wo = self.directions
        columns: Dict[str, Any] = {}
        for name, w in (("i", wi), ("o", wo)):
            columns[f"theta_{name}"] = np.degrees(np.arctan2(np.hypot(w[:, 0], w[:, 1]), w[:, 2]))
            columns[f"phi_{name}"] = np.degrees(np.arctan2(w[:, 1], w[:, 0])) % 360
        f = self.f
        for c, channel in enumerate(self.channels):
            columns[channel.name if channel.name == "f" else f"f_{channel.name}"] = f[:, c]
        columns["valid"] = self.valid
        return pandas.DataFrame(columns)


def read(
    path: Union[Path, Sequence[Path]],
    *,
    format: Optional[str] = None,
    columns: Optional[str] = None,
    grid: Optional[str] = None,
    part: Optional[str] = None,
    quantity: Optional[str] = None,
    scale: Optional[float] = None,
    dialect: Optional[str] = None,
    azimuth: Optional[str] = None,
    phi: Optional[str] = None,
    angles: Optional[str] = None,
) -> Measurement:
    """Reads a file, or several that are one measurement, as where each has one incidence; a folder stands for the files in it.

    The content decides which format it is. The options are those of the command line: format,
    columns="theta_i=incidence,f=value",
    grid, part, quantity ("brdf", "brdf-cos", "reflectance-factor"), scale (1/sr per unit), dialect, azimuth ("mirror", "light"),
    phi, angles ("degrees", "radians", "elevation", ...)."""
    paths = [os.fspath(path)] if isinstance(path, (str, os.PathLike)) else [os.fspath(p) for p in path]
    if not paths:
        raise ValueError("no path: expected one at least")
    return Measurement(_core.read(paths, format, columns, grid, part, quantity, scale, dialect, azimuth, phi, angles))


def measurement(
    wi: ArrayLike,
    wo: ArrayLike,
    f: ArrayLike,
    *,
    sigma: Optional[ArrayLike] = None,
    weights: Optional[ArrayLike] = None,
    names: Sequence[str] = (),
    wavelengths: Optional[ArrayLike] = None,
    isotropic: bool = False,
) -> Measurement:
    """A measurement of arrays: directions [..., 3], values f [...] or [..., channels] in 1/sr, standard deviations like them.

    names are those of the channels, wavelengths in nm; isotropic says that nothing can be said of a direction of the
    surface, since
    only differences of azimuths were measured."""
    nm = [] if wavelengths is None else [float(x) for x in np.asarray(wavelengths, dtype=float).ravel()]
    return Measurement(_core.make_table(wi, wo, f, sigma, weights, list(names), nm, isotropic))


def formats() -> List[Dict[str, Any]]:
    """The formats that are read, and which of them are written."""
    return _core.formats()
