"""Conversions between conventions of roughness and reflectance, and what fits are exported to."""

from __future__ import annotations

import math
from typing import Any, Dict, List, NamedTuple, Optional

from . import _core


class ConversionStep(NamedTuple):
    """One formula on the way. `matches` says that a feature of two different things is made equal."""

    start: str
    to: str
    by: str
    formula: str
    source: str
    assumes: str
    limits: str
    matches: bool


class Conversion(NamedTuple):
    """What came of it: values by their names, the steps, and a sentence where the answer is outside its good range."""

    values: Dict[str, float]
    steps: List[ConversionStep]
    doubt: Optional[str]

    def __getitem__(self, name: Any) -> Any:
        return self.values[name] if isinstance(name, str) else tuple.__getitem__(self, name)


def _step(d: Dict[str, Any]) -> ConversionStep:
    return ConversionStep(d["from"], d["to"], d["by"], d["formula"], d["source"], d["assumes"], d["limits"], d["matches"])


def convert(start: str, to: str, *, by: Optional[str] = None, theta_i: float = 0.0, **arguments: float) -> List[Conversion]:
    """One roughness or reflectance in terms of another, convert("beckmann", "phong", m=0.25), by every way that there is.

    by names a criterion, theta_i is an angle of incidence in degrees for those that ask for it."""
    return [
        Conversion(values, [_step(s) for s in steps], doubt)
        for values, steps, doubt in _core.convert(start, to, by, math.radians(theta_i), arguments)
    ]


def conversions() -> List[ConversionStep]:
    """All formulas that there are."""
    return [_step(d) for d in _core.conversions()]


def targets() -> List[str]:
    """What Fit.export takes: renderers, languages, formats of files."""
    return _core.export_names()
