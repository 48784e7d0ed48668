"""Models: what a surface reflects, with derivatives; samples, albedos, simulated data."""

from __future__ import annotations

import math
import os
from typing import Any, Dict, List, NamedTuple, Optional, Tuple, Union

import numpy as np
from numpy.typing import ArrayLike

from . import _core
from ._measurement import Array, Measurement, Path


class ModelParameter(NamedTuple):
    """A parameter with the value that the model has for it: one for each channel where it is per channel."""

    name: str
    meaning: str
    unit: str
    per_channel: bool
    held: bool
    low: float
    high: float
    value: Array


class Samples(NamedTuple):
    """Directions wi [..., 3] drawn in proportion to a model, their density in 1/sr, weights f cos(theta_i) / pdf, values f."""

    wi: Array
    pdf: Array
    weight: Array
    f: Array


def _short(x: Array) -> str:
    return f"{float(x[0]):g}" if len(x) == 1 else "[" + ", ".join(f"{v:g}" for v in x) + "]"


class Profile:
    """A distribution of normals by a table: D(theta) in 1/sr at any scale, theta in radians, rising from the normal on."""

    def __init__(self, theta: ArrayLike, D: ArrayLike) -> None:
        self._profile = _core.Profile(theta, D)

    @staticmethod
    def of_slopes(q2: ArrayLike, p: ArrayLike) -> "Profile":
        """By the density p of the square of the slope instead."""
        made = Profile.__new__(Profile)
        made._profile = _core.Profile(q2, p, of_slopes=True)
        return made

    @staticmethod
    def read(path: Path) -> "Profile":
        """A file with the columns theta_deg,D or q2,p."""
        made = Profile.__new__(Profile)
        made._profile = _core.Profile.read(os.fspath(path))
        return made


class Model:
    """A sum of lobes NDF[/MASKING[/FRESNEL]] and a diffuse term, or a preset, with values of its parameters.

        m = Model("ggx+lambert", alpha=0.3, f0=[0.9, 0.6, 0.3])
        m(wi, wo)                    # [..., 3 channels]
        m(wi, wo, alpha=0.4)         # with another value for this call

    A parameter is a number, or has one for each channel; "alpha" is both axes. Names with a point are given as
    **{"lobe2.f0": 0.1}.
    """

    def __init__(self, expression: str, *, table: Optional[Profile] = None, **parameters: ArrayLike) -> None:
        self._table = table
        self._core = _core.Model(expression, table=None if table is None else table._profile, **parameters)

    @staticmethod
    def _of(core: _core.Model, table: Optional[Profile]) -> "Model":
        made = Model.__new__(Model)
        made._core, made._table = core, table
        return made

    def __repr__(self) -> str:
        said = [f"{p.name}={_short(p.value)}" for p in self.parameters if not p.held]
        return f"Model({', '.join([repr(self.expression)] + said)})"

    @property
    def expression(self) -> str:
        """With every default spelled out."""
        return self._core.expression

    @property
    def channels(self) -> int:
        """How many channels its values have."""
        return self._core.channels

    @property
    def parameters(self) -> List[ModelParameter]:
        return [ModelParameter(*p) for p in self._core._parameters()]

    @property
    def values(self) -> Dict[str, Union[float, Array]]:
        return {p.name: p.value if p.per_channel and len(p.value) > 1 else float(p.value[0]) for p in self.parameters}

    def replace(self, **parameters: ArrayLike) -> "Model":
        """The same model with other values."""
        return Model._of(self._core._with(**parameters), self._table)

    def __call__(self, wi: ArrayLike, wo: ArrayLike, /, **parameters: ArrayLike) -> Array:
        """f in 1/sr for pairs of directions [..., 3]: [...] of one channel, [..., channels] of several; 0 below the horizon."""
        return self._core(wi, wo, **parameters)

    def gradient(self, wi: ArrayLike, wo: ArrayLike, /, **parameters: ArrayLike) -> Tuple[Array, Dict[str, Array]]:
        """f, and its derivative by every parameter, {name: like f}; of a per-channel one by the channel's own value."""
        return self._core.gradient(wi, wo, **parameters)

    def terms(
        self, wi: ArrayLike, wo: ArrayLike, /, *, lobe: int = 0, channel: int = 0, **parameters: ArrayLike
    ) -> Dict[str, Array]:
        """The factors of a lobe: D, Lambda_i, Lambda_o, G and F."""
        return self._core.terms(wi, wo, lobe=lobe, channel=channel, **parameters)

    def sample(self, wo: ArrayLike, /, *, seed: int = 1, **parameters: ArrayLike) -> Samples:
        """Draws wi for each wo [..., 3] in proportion to the model. The mean of the weights is the albedo."""
        wi, density, weight, f = _core.sample(self._core, wo, seed, **parameters)
        return Samples(wi, density, weight, f)

    def pdf(self, wi: ArrayLike, wo: ArrayLike, /, **parameters: ArrayLike) -> Array:
        """Density with which sample() draws wi for wo, 1/sr."""
        return _core.pdf(self._core, wi, wo, **parameters)

    def albedo(self, wo: ArrayLike, /, **parameters: ArrayLike) -> Tuple[Array, Array]:
        """Directional albedo of each wo by quadrature, and the estimate of its error."""
        return _core.albedo(self._core, wo, **parameters)


class Noise:
    """How large the errors of measured values are: variance (floor^2 + counts f + relative^2 f^2) cos^cos_i cos^cos_o.

    relative is a fraction, floor and counts are in 1/sr; a sequence of each has one for each channel."""

    def __init__(
        self, *, relative: ArrayLike = 0.0, floor: ArrayLike = 0.0, counts: ArrayLike = 0.0, cos_i: float = 0.0, cos_o: float = 0.0
    ) -> None:
        r, a, b = np.broadcast_arrays(*(np.atleast_1d(np.asarray(x, dtype=float)) for x in (relative, floor, counts)))
        if min(r.min(), a.min(), b.min()) < 0:
            raise ValueError("noise below 0: expected relative, floor and counts of at least 0")
        levels = [(float(y) ** 2, float(z), float(x) ** 2) for x, y, z in zip(r, a, b)]
        self._core = _core.Noise(levels, cos_i, cos_o)

    @staticmethod
    def _of(core: Optional[_core.Noise]) -> Optional["Noise"]:
        if core is None:
            return None
        made = Noise.__new__(Noise)
        made._core = core
        return made

    @property
    def relative(self) -> Array:
        return np.array([math.sqrt(c) for _, _, c in self._core.levels])

    @property
    def floor(self) -> Array:
        return np.array([math.sqrt(a) for a, _, _ in self._core.levels])

    @property
    def counts(self) -> Array:
        return np.array([b for _, b, _ in self._core.levels])

    @property
    def cos_i(self) -> float:
        return self._core.cos_i

    @property
    def cos_o(self) -> float:
        return self._core.cos_o

    def sd(self, f: ArrayLike, cos_i: ArrayLike = 1.0, cos_o: ArrayLike = 1.0, channel: int = 0) -> Array:
        """Standard deviation of values f, 1/sr, at these cosines."""
        return np.asarray(self._core.sd(f, cos_i, cos_o, channel))

    def __repr__(self) -> str:
        levels = (("relative", self.relative), ("floor", self.floor), ("counts", self.counts))
        parts = [f"{name}={_short(of)}" for name, of in levels if of.any()]
        return f"Noise({', '.join(parts)}, cos_i={self.cos_i:g}, cos_o={self.cos_o:g})"


def directions(theta: ArrayLike, phi: ArrayLike = 0.0) -> Array:
    """Unit vectors [..., 3] of polar angles and azimuths in radians."""
    t, p = np.broadcast_arrays(np.asarray(theta, dtype=float), np.asarray(phi, dtype=float))
    return np.stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)], axis=-1)


def simulate(
    model: Union[Model, str],
    grid: str = "goniometer:5",
    *,
    relative: float = 0.0,
    floor: float = 0.0,
    noise: Optional[Noise] = None,
    seed: int = 1,
    sigma: bool = False,
    aperture: Optional[str] = None,
    **parameters: ArrayLike,
) -> Measurement:
    """What an instrument would have measured: at "merl", "goniometer:STEP" or "scattered:N", with noise relative to the
    value, a floor
    in 1/sr or a Noise; aperture are half angles of the detector in degrees, "0.75"."""
    of = model if isinstance(model, Model) else Model(model)
    return Measurement(
        _core.simulate(of._core, grid, relative, floor, None if noise is None else noise._core, seed, sigma, aperture, **parameters)
    )


def models() -> List[Dict[str, Any]]:
    """The terms that expressions are made of, and the presets."""
    return _core.models()
