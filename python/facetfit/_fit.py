"""Fits and comparisons."""

from __future__ import annotations

import difflib
import importlib
import json
import math
import os
from typing import Any, Callable, Dict, Iterator, List, Mapping, NamedTuple, Optional, Sequence, Tuple, Union, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._errors import ArgumentError, Code, Error
from ._measurement import Array, Measurement, Path, measurement, read
from ._model import Model, Noise, Profile
from ._plot import Figure, form_of, options_of

Data = Union[Measurement, str, "os.PathLike[str]", Tuple[ArrayLike, ArrayLike, ArrayLike]]
Progress = Callable[[str, Optional[int], Optional[float]], object]


class Parameter(NamedTuple):
    """A fitted number: NaN where there is no error or interval (held, on a bound, not determined)."""

    name: str
    channel: Optional[str]
    value: float
    std_error: float
    low: float
    high: float
    interval_from: str
    at_bound: int
    held: bool
    tied: bool
    carriers: float
    determined: bool
    unit: str
    meaning: str


class Warning(NamedTuple):
    """What a result should be taken with. `code` is for programs, `text` for people."""

    code: str
    severity: str
    text: str
    parameters: List[str]
    channels: List[str]
    values: Dict[str, float]


class Covariance(NamedTuple):
    """Names of the parameters that have a standard error, "f0[r]" of a channel, and the matrix of their covariances."""

    names: List[str]
    matrix: Array


class Residuals(NamedTuple):
    """Of the samples that were used: their places in the measurement, data and model in 1/sr, weighted residuals as in the
    objective
    ([used, channels] each), and what each sample adds to it."""

    samples: NDArray[np.intp]
    data: Array
    model: Array
    residual: Array
    cost: Array


class Export(NamedTuple):
    """What was written: the content where no path was given, and the document about it with controls and losses."""

    content: Optional[bytes]
    about: Dict[str, Any]

    @property
    def text(self) -> str:
        return "" if self.content is None else self.content.decode()


# ---- options

_OPTIONS: Dict[str, Any] = {
    "loss": "cosine",
    "robust": "none",
    "weight": "auto",
    "shape": "auto",
    "channels": "rgb",
    "errors": None,
    "max_theta": 80.0,
    "saturation": math.inf,
    "noise_floor": -math.inf,
    "noise_sigmas": 0.0,
    "negative": "keep",
    "mean_slope": False,
    "threads": 0,
    "max_iterations": 100,
    "noise": None,
    "aperture": None,
    "source": 0.0,
    "free": (),
    "fix": {},
    "bounds": {},
    "priors": {},
    "ties": {},
    "energy_conserving": False,
    "bootstrap": 0,
    "seed": 1,
    "profile": False,
    "cross_validate": 0,
    "cut_off": None,
    "reach": None,
    "as_is": False,
    "table": None,
    "command": None,
}
_OF_ONE = ("bootstrap", "profile", "cut_off", "reach")
_OF_MANY = ("cross_validate",)


def _check_names(said: Mapping[str, Any], leave_out: Sequence[str]) -> None:
    known = [name for name in _OPTIONS if name not in leave_out]
    for name in said:
        if name not in known:
            near = difflib.get_close_matches(name, known, 1)
            raise TypeError(f"no option '{name}'" + (f"; did you mean '{near[0]}'?" if near else f"; known are {', '.join(known)}"))


def _split(name: str) -> Tuple[str, Optional[str]]:
    """ "f0[r]": the parameter and the channel."""
    if name.endswith("]") and "[" in name:
        bare, channel = name[:-1].split("[", 1)
        return bare, channel
    return name, None


def _constraints(o: Mapping[str, Any], where_present: bool) -> Dict[str, Any]:
    bounds = [(_split(k)[0], float(v[0]), float(v[1]), _split(k)[1]) for k, v in o["bounds"].items()]
    priors = [(_split(k)[0], float(v[0]), float(v[1]), _split(k)[1]) for k, v in o["priors"].items()]
    fixed = []
    for key, value in o["fix"].items():
        name, channel = _split(key)
        values = np.atleast_1d(np.asarray(value, dtype=float))
        if channel is not None or len(values) > 1:
            fixed.append((name, [float(x) for x in values], channel))
    ties: List[Tuple[str, Optional[str]]] = (
        list(o["ties"].items()) if isinstance(o["ties"], Mapping) else [(str(k), None) for k in o["ties"]]
    )
    return {
        "bounds": bounds,
        "priors": priors,
        "fixed": fixed,
        "ties": ties,
        "energy_conserving": bool(o["energy_conserving"]),
        "where_present": where_present,
    }


def _radians(degrees: Optional[float]) -> float:
    return math.nan if degrees is None else math.radians(degrees)


def _core_options(o: Mapping[str, Any], compare: bool) -> Dict[str, Any]:
    """As the extension takes them."""
    name, _, scale = str(o["robust"]).partition(":")
    negative = str(o["negative"])
    if negative not in ("keep", "drop"):
        raise ArgumentError(Code.UNKNOWN, f"negative '{negative}'; known are keep, drop")
    errors = o["errors"] or ("incidences" if o["weight"] == "noise" else "noise")
    made = {
        key: o[key]
        for key in (
            "weight",
            "shape",
            "channels",
            "saturation",
            "noise_floor",
            "noise_sigmas",
            "mean_slope",
            "threads",
            "max_iterations",
            "aperture",
            "bootstrap",
            "seed",
            "profile",
            "cross_validate",
            "command",
        )
    }
    made.update(
        loss="cosine" if o["loss"] == "auto" else o["loss"],
        choose_loss=o["loss"] == "auto",
        robust=name,
        robust_scale=float(scale) if scale else 0.0,
        errors=errors,
        errors_asked=o["errors"] is not None,
        max_theta=math.radians(o["max_theta"]),
        drop_negative=negative == "drop",
        noise=None if o["noise"] is None else o["noise"]._core,
        source=math.radians(o["source"]),
        cut_off=_radians(o["cut_off"]),
        reach=_radians(o["reach"]),
        compare=compare,
    )
    made.update(_constraints(o, compare))
    return made


# ---- data and models


def _measured(data: Data) -> Measurement:
    if isinstance(data, Measurement):
        return data
    if isinstance(data, (str, os.PathLike)):
        return read(data)
    wi, wo, f = data
    return measurement(wi, wo, f)


def _look(of: Measurement, o: Mapping[str, Any]) -> None:
    """As the program does: data that leave no doubt that their angles are something else are not fitted as they are."""
    found, is_open = of._table.diagnose(math.radians(o["max_theta"]))
    if o["as_is"] or not is_open or not any(sure for _, sure, *_ in found):
        return
    for finding in of.diagnose(o["max_theta"]):
        if finding.sure and finding.option:
            raise Error(
                Code.DATA, f"{finding.kind}: read it with {finding.option}='{finding.value}', or fit it with as_is=True", of.path
            )


def _prepared(model: Union[Model, str], o: Mapping[str, Any], strict: bool) -> _core.Model:
    """The model with what is held and let vary."""
    if isinstance(model, Model):
        core = model._core._with()
    else:
        table: Optional[Profile] = o["table"]
        core = _core.Model(model, table=None if table is None else table._profile)
    known = {p[0] for p in core._parameters()}

    def has(name: str) -> bool:
        return name in known or f"{name}_x" in known

    for name in [o["free"]] if isinstance(o["free"], str) else o["free"]:
        if strict or has(name):
            core._vary(name)
    for key, value in o["fix"].items():
        name, channel = _split(key)
        if channel is None and np.size(value) == 1 and (strict or has(name)):
            core._hold(name, float(np.asarray(value, dtype=float).ravel()[0]))
    return core


def _tabulated(model: Union[Model, str], o: Mapping[str, Any]) -> Optional[Profile]:
    found: Optional[Profile] = model._table if isinstance(model, Model) else o["table"]
    return found


# ---- fits


class Fit:
    """A model fitted to a measurement: values, errors, warnings, reports, figures. Made by fit() and compare()."""

    def __init__(self, study: _core.Study, index: int, of: Measurement, table: Optional[Profile]) -> None:
        self._study, self._index, self._of, self._table = study, index, of, table

    @property
    def measurement(self) -> Measurement:
        return self._of

    @property
    def model(self) -> Model:
        """With the values that were found."""
        return Model._of(self._study.model(self._index), self._table)

    @property
    def outcome(self) -> str:
        """ "converged", "stalled" or "limit"."""
        return self._study.outcome(self._index)

    @property
    def converged(self) -> bool:
        return self.outcome == "converged"

    @property
    def shape(self) -> str:
        return self._study.shape(self._index)

    @property
    def loss(self) -> str:
        return self._study.loss

    @property
    def channels(self) -> List[str]:
        return self._study.channels(self._index)

    @property
    def parameters(self) -> List[Parameter]:
        """Every number, those of the channels one after another."""
        channels: List[Optional[str]] = list(self.channels)
        all_of = []
        for name, unit, meaning, per_channel, values in self._study.values(self._index):
            of: List[Optional[str]] = channels if per_channel else [None]
            for channel, v in zip(of, values):
                all_of.append(
                    Parameter(name, channel, v[0], v[1], v[2], v[3], v[4], v[5], v[6], v[7], v[9], not v[10], unit, meaning)
                )
        return all_of

    def _by_name(self, column: int) -> Dict[str, Union[float, Array]]:
        made: Dict[str, Union[float, Array]] = {}
        for name, _, _, per_channel, values in self._study.values(self._index):
            x = np.array([float(v[column]) for v in values])
            made[name] = x if per_channel and len(x) > 1 else float(x[0])
        return made

    @property
    def values(self) -> Dict[str, Union[float, Array]]:
        """{name: value, or one for each channel}."""
        return self._by_name(0)

    @property
    def errors(self) -> Dict[str, Union[float, Array]]:
        """Standard errors."""
        return self._by_name(1)

    @property
    def intervals(self) -> Dict[str, Tuple[Union[float, Array], Union[float, Array]]]:
        """95 % intervals, {name: (low, high)}."""
        low, high = self._by_name(2), self._by_name(3)
        return {name: (low[name], high[name]) for name in low}

    @property
    def covariance(self) -> Covariance:
        return Covariance(*self._study.covariance(self._index))

    @property
    def correlation(self) -> Covariance:
        """The same as correlations."""
        names, c = self._study.covariance(self._index)
        sd = np.sqrt(np.diag(c))
        return Covariance(names, c / np.outer(sd, sd))

    @property
    def warnings(self) -> List[Warning]:
        return [Warning(*w) for w in self._study.warnings(self._index)]

    @property
    def residuals(self) -> Residuals:
        index, model, residual, cost = self._study.residuals(self._index)
        return Residuals(index, self._data(index, model.shape[1]), model, residual, cost)

    def _data(self, index: NDArray[np.intp], channels: int) -> Array:
        """The data that the fit saw: all channels, the one of its name, or their mean."""
        f = self._of.f
        if channels == f.shape[1]:
            return f[index]
        names = [c.name for c in self._of.channels]
        if self.channels[0] in names:
            at = names.index(self.channels[0])
            return f[index][:, at : at + 1]
        mean: Array = f[index].mean(axis=1, keepdims=True)
        return mean

    @property
    def objective(self) -> float:
        """What was minimised, of the data alone."""
        return float(self._study.numbers(self._index)["objective"])

    @property
    def rmse(self) -> float:
        """Weighted root mean square of f - y, 1/sr."""
        return float(self._study.numbers(self._index)["rmse"])

    @property
    def aic(self) -> float:
        return float(self._study.numbers(self._index)["aic"])

    @property
    def bic(self) -> float:
        return float(self._study.numbers(self._index)["bic"])

    @property
    def numbers(self) -> Dict[str, Any]:
        """Everything that is one number: objective, rmse, max_abs, aic, bic, rank, condition, effective_samples, iterations,
        ..."""
        return self._study.numbers(self._index)

    @property
    def selection(self) -> Dict[str, int]:
        """How many samples were used, and why others were not."""
        return self._study.selection(self._index)

    @property
    def noise(self) -> Optional[Noise]:
        """The noise of the data as the errors have it; None where they rest on the residuals alone."""
        return Noise._of(self._study.noise(self._index))

    @property
    def versus(self) -> Optional[Dict[str, Any]]:
        """What it differs from the best of a comparison by; None of a fit by itself."""
        return self._study.versus(self._index)

    @property
    def notes(self) -> List[str]:
        """What a person should know though nothing failed."""
        return self._study.notes

    # ---- forms

    def to_dict(self) -> Dict[str, Any]:
        """The document of `facetfit fit --json`."""
        document: Dict[str, Any] = json.loads(self._study.write("json"))
        return document

    def to_pandas(self) -> Any:
        """A pandas.DataFrame with a row for each parameter."""
        pandas = importlib.import_module("pandas")
        return pandas.DataFrame([p._asdict() for p in self.parameters])

    def text(self) -> str:
        """The report of the program."""
        return self._study.write("text")

    def html(self) -> str:
        """The page of the program: one file that a browser opens."""
        return self._study.write("html")

    def _repr_html_(self) -> str:
        return self._study.write("summary")

    def __repr__(self) -> str:
        several = len(self.channels) > 1
        shown = []
        for p in self.parameters:
            if not p.held and not p.tied:
                shown.append(f"{p.name}{f'[{p.channel}]' if several and p.channel else ''}={p.value:.4g}")
        return f"<Fit {self.model.expression}: {self.outcome}, {', '.join(shown)}>"

    def plot(self, kind: str = "slice", path: Optional[Path] = None, **options: Any) -> Figure:
        """A figure of the program; with a path it is saved in the form that its name asks for."""
        if path is not None:
            options.setdefault("form", form_of(path))
        chosen = options_of(**options)
        made = Figure(self._study.plot(kind, chosen), chosen["form"])
        if path is not None:
            made.save(path)
        return made

    def export(self, to: str, path: Optional[Path] = None) -> Export:
        """The fit for a renderer, as code, or as a file of a format; targets() lists them. Without a path the content is
        returned."""
        content, about = self._study.export(self._index, to, None if path is None else os.fspath(path))
        return Export(content, json.loads(about))


class Comparison(Sequence[Fit]):
    """Fits of many models to the same samples, the best first. Made by compare()."""

    def __init__(self, study: _core.Study, of: Measurement, tables: Mapping[str, Optional[Profile]]) -> None:
        self._study, self._of, self._tables = study, of, tables
        self._rank = [study.ranked(0, k) for k in range(study.fits // study.problems)]

    def __len__(self) -> int:
        return len(self._rank)

    @overload
    def __getitem__(self, k: int) -> Fit:
        ...

    @overload
    def __getitem__(self, k: slice) -> List[Fit]:
        ...

    def __getitem__(self, k: Union[int, slice]) -> Union[Fit, List[Fit]]:
        if isinstance(k, slice):
            return [self[i] for i in range(*k.indices(len(self)))]
        index = self._rank[k]
        table = self._tables.get(self._study.model(index).expression)
        return Fit(self._study, index, self._of, table)

    def __iter__(self) -> Iterator[Fit]:
        return (self[k] for k in range(len(self)))

    @property
    def best(self) -> Fit:
        """The one with the lowest objective."""
        return self[0]

    @property
    def not_told_apart(self) -> List[Fit]:
        """The best, and those that these data cannot tell from it."""
        kept = []
        for k, fit in enumerate(self):
            versus = fit.versus
            if k == 0 or (versus is not None and not versus["told_apart"]):
                kept.append(fit)
        return kept

    @property
    def notes(self) -> List[str]:
        """Models that were left out, and why."""
        return self._study.notes

    def to_dict(self) -> Dict[str, Any]:
        """The document of `facetfit compare --json`."""
        document: Dict[str, Any] = json.loads(self._study.write("json"))
        return document

    def to_pandas(self) -> Any:
        """A pandas.DataFrame with a row for each model, the best first."""
        pandas = importlib.import_module("pandas")
        rows = []
        least = self.best.objective
        for fit in self:
            versus = fit.versus or {}
            row: Dict[str, Any] = {
                "model": fit.model.expression,
                "outcome": fit.outcome,
                "objective": fit.objective,
                "over_best": fit.objective / least if least else math.nan,
            }
            row.update({k: versus.get(k, math.nan) for k in ("vuong_z", "vuong_p", "told_apart")})
            row.update({k: v for k, v in fit.values.items() if np.size(v) == 1})
            rows.append(row)
        return pandas.DataFrame(rows)

    def text(self) -> str:
        """The report of the program."""
        return self._study.write("text")

    def table(self, form: str = "md") -> str:
        """The ranking as "csv", "tsv", "md" or "latex"."""
        return self._study.write(form)

    def html(self) -> str:
        """The page of the program."""
        return self._study.write("html")

    def _repr_html_(self) -> str:
        return self._study.write("summary")

    def __repr__(self) -> str:
        return f"<Comparison of {len(self)} models, best {self.best.model.expression}>"

    def plot(self, kind: str = "forest", path: Optional[Path] = None, **options: Any) -> Figure:
        """A figure of the program, of the best models."""
        return self.best.plot(kind, path, **options)


def _study(
    data: Data, models: Sequence[Union[Model, str]], said: Mapping[str, Any], compare: bool, progress: Optional[Progress]
) -> Tuple[_core.Study, Measurement, Dict[str, Any], List[_core.Model]]:
    _check_names(said, _OF_ONE if compare else _OF_MANY)
    o = {**_OPTIONS, **said}
    of = _measured(data)
    _look(of, o)
    cores = [_prepared(m, o, not compare) for m in models]
    return _core.Study(of._table, cores, _core_options(o, compare), progress), of, o, cores


def fit(data: Data, model: Union[Model, str] = "ggx+lambert", *, progress: Optional[Progress] = None, **options: Any) -> Fit:
    """Finds the parameters of a model in measured data: a Measurement, a path, or arrays (wi, wo, f).

    The options are those of the command line: loss ("cosine", ..., "auto"), robust ("huber"), weight, shape, channels ("rgb",
    "mean"), errors, max_theta (degrees), saturation, noise_floor, noise_sigmas, negative ("keep", "drop"), mean_slope, threads,
    max_iterations, noise (a Noise), aperture ("0.75"), source (degrees), free (names), fix {name: value}, bounds {name: (low,
    high)}, priors {name: (mean, sd)}, ties {name: other}, energy_conserving, bootstrap (refits), seed, profile, cut_off and reach
    (degrees), as_is, table (a Profile), command (how reports say that it was made). "f0[r]" is the parameter of a channel.

    progress(what, iteration, objective) is called as the fit goes on, with None where it is not at a step of the solver. Ctrl-C
    ends a fit."""
    if options.get("channels") == "each":
        raise ArgumentError(Code.UNSUPPORTED, "channels='each' is several fits: fit_each() makes them")
    study, of, o, _ = _study(data, [model], options, False, progress)
    return Fit(study, 0, of, _tabulated(model, o))


def fit_each(
    data: Data, model: Union[Model, str] = "ggx+lambert", *, progress: Optional[Progress] = None, **options: Any
) -> List[Fit]:
    """As fit(), of every channel by itself."""
    study, of, o, _ = _study(data, [model], {**options, "channels": "each"}, False, progress)
    return [Fit(study, k, of, _tabulated(model, o)) for k in range(study.fits)]


def _is_all(said: Union[str, Sequence[str]]) -> bool:
    return said == "all" or list(said) == ["all"]


def _terms(kind: str, said: Union[str, Sequence[str]]) -> List[str]:
    if not _is_all(said):
        return said.split(",") if isinstance(said, str) else list(said)
    return [t["name"] for t in _core.models() if t["kind"] == kind and not t["furnace_only"]]


def _combinations(
    ndf: Union[str, Sequence[str]],
    masking: Union[str, Sequence[str]],
    fresnel: Union[str, Sequence[str]],
    diffuse: Union[str, Sequence[str]],
    table: Optional[Profile],
) -> List[str]:
    """Expressions of all terms that go together."""
    made: List[str] = []
    refused: Optional[Error] = None
    for d in _terms("distribution", ndf):
        if d == "tabulated" and table is None and _is_all(ndf):
            continue
        for g in _terms("masking", masking):
            for f in _terms("Fresnel", fresnel):
                for b in _terms("diffuse", diffuse):
                    expression = f"{d}/{g}/{f}" + ("" if b == "none" else f"+{b}")
                    try:
                        _core.Model(expression, table=None if table is None else table._profile)
                    except ArgumentError as e:
                        if e.code != Code.UNSUPPORTED:
                            raise
                        refused = e
                        continue
                    made.append(expression)
    if not made and refused is not None:
        raise refused
    return made


def compare(
    data: Data,
    models: Optional[Sequence[Union[Model, str]]] = None,
    *,
    ndf: Union[str, Sequence[str]] = "all",
    masking: Union[str, Sequence[str]] = "all",
    fresnel: Union[str, Sequence[str]] = "schlick",
    diffuse: Union[str, Sequence[str]] = "lambert",
    progress: Optional[Progress] = None,
    **options: Any,
) -> Comparison:
    """Fits many models to the same samples, ranks them, and says which these data tell apart: those that are named, or every
    combination of the terms. Options as of fit(), and cross_validate (folds)."""
    if options.get("channels") == "each":
        raise ArgumentError(
            Code.UNSUPPORTED, "channels='each': compare the channels of a measurement one by one, with reduce('channels:NAME')"
        )
    of: Sequence[Union[Model, str]] = (
        _combinations(ndf, masking, fresnel, diffuse, options.get("table")) if models is None else models
    )
    study, measured, o, cores = _study(data, of, options, True, progress)
    tables = {core.expression: _tabulated(m, o) for core, m in zip(cores, of)}
    return Comparison(study, measured, tables)
