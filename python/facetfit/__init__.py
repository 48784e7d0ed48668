"""Microfacet parameters from measured reflectance.

    import facetfit
    data = facetfit.read("paint.csv")
    fit = facetfit.fit(data, "ggx+lambert", shape="isotropic")
    print(fit.values["alpha_x"], fit.errors["alpha_x"])

Arrays  directions are unit vectors (x, y, z) that point away from the surface, normal along z, in arrays [..., 3]; values f
are the
        BRDF in 1/sr without the cosine, in arrays [...] of one channel and [..., channels] of several.
Angles  in arrays radians; in options and in names that people type degrees, as on the command line.
Errors  facetfit.Error, with the library's code and the place.
Threads the interpreter's lock is released while the library works. A Fit answers one call at a time.
"""

from ._core import version as _version
from ._errors import ArgumentError, Code, Error, FileError, NoMemoryError
from ._fit import Comparison, Covariance, Export, Fit, Parameter, Residuals, Warning, compare, fit, fit_each
from ._measurement import Channel, Finding, Measurement, formats, measurement, read
from ._model import Model, ModelParameter, Noise, Profile, Samples, directions, models, simulate
from ._ndf import Retrieval, RetrievedChannel, retrieve_ndf
from ._plot import Figure, plot, plot_kinds
from ._tools import Conversion, ConversionStep, conversions, convert, targets

__version__: str = _version()

__all__ = [
    "ArgumentError",
    "Channel",
    "Code",
    "Comparison",
    "Conversion",
    "ConversionStep",
    "Covariance",
    "Error",
    "Export",
    "Figure",
    "FileError",
    "Finding",
    "Fit",
    "Measurement",
    "Model",
    "ModelParameter",
    "NoMemoryError",
    "Noise",
    "Parameter",
    "Profile",
    "Residuals",
    "Retrieval",
    "RetrievedChannel",
    "Samples",
    "Warning",
    "__version__",
    "compare",
    "conversions",
    "convert",
    "directions",
    "fit",
    "fit_each",
    "formats",
    "measurement",
    "models",
    "plot",
    "plot_kinds",
    "read",
    "retrieve_ndf",
    "simulate",
    "targets",
]
