"""Distributions of normals without a formula."""

from __future__ import annotations

import importlib
import math
from typing import Any, Dict, List, NamedTuple, Optional

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._errors import ArgumentError, Code
from ._fit import _OPTIONS, Data, Progress, Warning, _check_names, _core_options, _look, _measured
from ._measurement import Array
from ._model import Model, Profile

_NOT_HERE = (
    "shape", "robust", "errors", "mean_slope", "free", "fix", "bounds", "priors", "ties", "energy_conserving", "bootstrap", "seed",
    "profile", "cross_validate", "cut_off", "reach", "table", "command",
)  # fmt: skip
_FITS = {"beckmann": 0, "ggx": 1, "student-t": 2}
_TABULATED = 3


class RetrievedChannel(NamedTuple):
    """What one channel multiplies D with, and its diffuse part; NaN for an error on a bound."""

    name: str
    f0: float
    ks: float
    kd: float
    scale_error: float
    kd_error: float


class Retrieval:
    """A distribution of normals as data have it. Made by retrieve_ndf().

    theta, D          angles of the normal in radians, from 0 on, and D in 1/sr
    error, D_error    relative standard errors of F0 D and of D; F0 and D share that of the area under D
    known             where both are small and half vectors reach; elsewhere D is a continuation
    """

    def __init__(self, core: _core.Retrieval, masking: str) -> None:
        self._core, self._masking = core, masking
        self.theta: Array
        self.D: Array
        self.error: Array
        self.D_error: Array
        self.known: NDArray[np.bool_]
        self.theta, self.D, self.error, self.D_error, self.known = core.rows
        self.channels: List[RetrievedChannel] = [RetrievedChannel(*c) for c in core.channels]

    @property
    def profile(self) -> Profile:
        """D as a table, for models: Model("tabulated", table=retrieval.profile)."""
        return Profile(self.theta, self.D)

    @property
    def model(self) -> Model:
        """The model `tabulated` of this D with what was found, alpha = 1."""
        table = self.profile
        return Model._of(self._core.model(_TABULATED, table._profile), table)

    def beside(self, ndf: str) -> Model:
        """The best fit of "beckmann", "ggx" or "student-t" to the same samples, with the same masking."""
        if ndf not in _FITS:
            raise ArgumentError(Code.UNKNOWN, f"no fit of '{ndf}' goes with a retrieval; there are {', '.join(_FITS)}")
        return Model._of(self._core.model(_FITS[ndf], None), None)

    @property
    def objectives(self) -> Dict[str, float]:
        """Of the distribution itself, "retrieved", and of the fits beside it."""
        return {"retrieved": self.numbers["objective"], **{name: self._core.objective(k) for name, k in _FITS.items()}}

    @property
    def numbers(self) -> Dict[str, float]:
        """Roughness by several measures (half_width in radians, mean_slope, rms_slope, alpha_peak, beckmann_mean, ggx_mean; beyond
        is the
        share of the area that lies beyond the data), the angles that half vectors reach (first, reach, sure), the weight of the
        penalty (smooth), the parameters that the data determine (effective), objective, seconds."""
        return self._core.numbers

    @property
    def outcome(self) -> str:
        """ "converged", or what it ended with instead."""
        return self._core.outcome

    @property
    def warnings(self) -> List[Warning]:
        """What it should be taken with."""
        return [Warning(code, severity, text, [], [], values) for code, severity, text, values in self._core.warnings]

    def to_pandas(self) -> Any:
        """A pandas.DataFrame with a row for each angle."""
        pandas = importlib.import_module("pandas")

        return pandas.DataFrame(
            {"theta": self.theta, "D": self.D, "error": self.error, "D_error": self.D_error, "known": self.known}
        )

    def __repr__(self) -> str:
        n = self.numbers
        return (
            f"<Retrieval, masking {self._masking}: {self.outcome}, half width {math.degrees(n['half_width']):.3g} degrees, "
            f"known up to {math.degrees(n['sure']):.3g} degrees>"
        )


def retrieve_ndf(
    data: Data,
    *,
    masking: str = "smith-height-correlated",
    smooth: Optional[float] = None,
    monotone: str = "slopes",
    nodes: int = 0,
    progress: Optional[Progress] = None,
    **options: Any,
) -> Retrieval:
    """The isotropic distribution of normals behind data, without a formula for it, with F0 and kd of each channel: what `facetfit ndf`
    does.

    smooth is the weight of the penalty (None: by cross-validation), monotone what must not rise with the angle ("slopes": the density
    of slopes, "D"), nodes the size of the lattice (0: by the data). Of the options of fit() those of selection, loss and weight."""
    _check_names(options, _NOT_HERE)
    o = {**_OPTIONS, **options}
    of = _measured(data)
    _look(of, o)
    asked = {
        **_core_options({**o, "shape": "isotropic"}, False),
        "masking": masking,
        "smooth": math.nan if smooth is None else float(smooth),
        "monotone": monotone,
        "nodes": nodes,
    }
    return Retrieval(_core.Retrieval(of._table, asked, progress), masking)
