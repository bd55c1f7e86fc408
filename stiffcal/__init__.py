"""stiffcal: find out how an industrial robot bends, and which physical effect the model lacks.

In scripts and notebooks::

    import stiffcal

    campaign = stiffcal.open("my-robot")
    fit = campaign.identify()
    fit.parameters                                          # a table of pandas, with 95 % intervals
    trial = campaign.with_effect("backlash", joints=[4])    # in memory
    stiffcal.compare(fit, trial).errors

Public are the names in ``__all__``, `stiffcal.effects_api` for effects of one's own, and the entry points
``stiffcal.effects`` and ``stiffcal.readers``; all else may change with every version.
"""

import os

TYPE_CHECKING = False  # type checkers take it for true; `typing` itself would be the slowest import here
if TYPE_CHECKING:
    from stiffcal.errors import Fault, InputError
    from stiffcal.python.answers import FitHistory, FittedModel, LoadPrediction, MeasurementPlan, ModelValidation
    from stiffcal.python.comparison import FitComparison
    from stiffcal.python.comparison import compare_fits as compare
    from stiffcal.python.improvement import ImprovementStep, ModelImprovement
    from stiffcal.python.model_diagnosis import ModelDiagnosis
    from stiffcal.python.opening import open_campaign as open  # noqa: A004
    from stiffcal.python.page import CampaignPage
    from stiffcal.python.session import CampaignSession
    from stiffcal.python.trend import RobotTrend
    from stiffcal.python.trend import follow_robot as trend

__version__ = "0.2.0"

__all__ = [
    "CampaignPage",
    "CampaignSession",
    "Fault",
    "FitComparison",
    "FitHistory",
    "FittedModel",
    "ImprovementStep",
    "InputError",
    "LoadPrediction",
    "MeasurementPlan",
    "ModelDiagnosis",
    "ModelImprovement",
    "ModelValidation",
    "RobotTrend",
    "__version__",
    "compare",
    "open",
    "trend",
]

_PLACES = {
    "CampaignPage": ("stiffcal.python.page", "CampaignPage"),
    "CampaignSession": ("stiffcal.python.session", "CampaignSession"),
    "Fault": ("stiffcal.errors", "Fault"),
    "FitComparison": ("stiffcal.python.comparison", "FitComparison"),
    "FitHistory": ("stiffcal.python.answers", "FitHistory"),
    "MeasurementPlan": ("stiffcal.python.answers", "MeasurementPlan"),
    "FittedModel": ("stiffcal.python.answers", "FittedModel"),
    "ImprovementStep": ("stiffcal.python.improvement", "ImprovementStep"),
    "InputError": ("stiffcal.errors", "InputError"),
    "LoadPrediction": ("stiffcal.python.answers", "LoadPrediction"),
    "ModelDiagnosis": ("stiffcal.python.model_diagnosis", "ModelDiagnosis"),
    "ModelImprovement": ("stiffcal.python.improvement", "ModelImprovement"),
    "ModelValidation": ("stiffcal.python.answers", "ModelValidation"),
    "RobotTrend": ("stiffcal.python.trend", "RobotTrend"),
    "compare": ("stiffcal.python.comparison", "compare_fits"),
    "open": ("stiffcal.python.opening", "open_campaign"),
    "trend": ("stiffcal.python.trend", "follow_robot"),
}

# Threaded BLAS is not bit-equal between thread counts and was slower here; the libraries read these once, when numpy is
# imported. OMP_NUM_THREADS is left alone: pyarrow reads it too. A value that the user has set stays.
for _threads in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "BLIS_NUM_THREADS", "VECLIB_MAXIMUM_THREADS"):
    os.environ.setdefault(_threads, "1")


def __getattr__(name: str) -> object:
    """Import a public name when it is first asked for: the command line imports this package, and starts at once."""
    if name not in _PLACES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    module, word = _PLACES[name]
    value: object = getattr(import_module(module), word)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
