"""Figures, as the program draws them."""

from __future__ import annotations

import math
import os
from typing import Any, Dict, List, Optional, Sequence, Union

from . import _core
from ._measurement import Measurement, Path
from ._model import Model

_FORMS = ("svg", "pdf", "csv")


class Figure:
    """A figure as SVG, PDF or a table of its numbers. A notebook shows it."""

    def __init__(self, content: bytes, form: str) -> None:
        self.content, self.form = content, form

    @property
    def text(self) -> str:
        """SVG or CSV as a string."""
        if self.form == "pdf":
            raise ValueError("a PDF is no text: see content")
        return self.content.decode()

    def save(self, path: Path) -> None:
        with open(path, "wb") as out:
            out.write(self.content)

    def _repr_svg_(self) -> Optional[str]:
        return self.text if self.form == "svg" else None

    def __repr__(self) -> str:
        return f"<Figure: {len(self.content)} bytes of {self.form}>"


def options_of(
    form: str = "svg",
    *,
    title: Optional[str] = None,
    channel: Optional[str] = None,
    parameter: Optional[str] = None,
    incidence: Union[float, Sequence[float]] = (),
    log: Optional[bool] = None,
    bootstrap: int = 200,
    seed: int = 1,
    width: float = math.nan,
    height: float = math.nan,
    font: float = math.nan,
    per_row: int = 0,
) -> Dict[str, Any]:
    """The options of a figure: form "svg", "pdf" or "csv"; incidence in degrees; width and height in mm, font in points;
    docs/plot.md
    says which kind looks at what."""
    shown = [float(incidence)] if isinstance(incidence, (int, float)) else [float(x) for x in incidence]
    return {
        "form": form,
        "title": title,
        "channel": channel,
        "parameter": parameter,
        "incidence": shown,
        "log": -1 if log is None else int(log),
        "repeats": bootstrap,
        "seed": seed,
        "width": width,
        "height": height,
        "font": font,
        "per_row": per_row,
    }


def plot(kind: str, *sources: Union[Model, str, Measurement], **options: Any) -> Figure:
    """A figure of models, of expressions with the values that they start with, or of one measurement alone. plot_kinds()
    lists the
    kinds; a Fit and a Comparison have plot() of their own."""
    chosen = options_of(**options)
    tables = [s for s in sources if isinstance(s, Measurement)]
    if tables:
        if len(sources) != 1:
            raise ValueError("a figure is of one measurement, or of models")
        return Figure(_core.plot_table(tables[0]._table, kind, chosen), chosen["form"])
    of = [s if isinstance(s, Model) else Model(str(s)) for s in sources]
    labels = [s if isinstance(s, str) else m.expression for s, m in zip(sources, of)]
    return Figure(_core.plot_models([m._core for m in of], labels, kind, chosen), chosen["form"])


def plot_kinds() -> List[str]:
    """Kinds of figures."""
    return _core.plot_kinds()


def form_of(path: Path) -> str:
    """The form that the end of a name asks for."""
    end = os.path.splitext(os.fspath(path))[1][1:]
    if end not in _FORMS:
        raise ValueError(f"{os.fspath(path)}: expected a name that ends in .svg, .pdf or .csv")
    return end
