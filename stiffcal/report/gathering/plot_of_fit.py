"""Pictures of a fit that its statistics hang on, for `plot` and Python."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache, partial
from typing import TYPE_CHECKING

import numpy as np

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.identification.profiles import profiled, profiles
from stiffcal.identification.readings.row_layout import MEASURES
from stiffcal.model.catalogue.campaign_effects import placed_robot
from stiffcal.presentation.pictures import Picture
from stiffcal.presentation.values import Page
from stiffcal.quantity import of_measure
from stiffcal.results.fit_pictures import (
    correlation_picture,
    history_picture,
    in_standard_uncertainties,
    influence_picture,
    normal_picture,
    profile_picture,
)
from stiffcal.stages.fit import fit_again, up_to_date_fit_at_hand
from stiffcal.stages.history import stored_fits
from stiffcal.stages.steps import Ingested, RunContext

if TYPE_CHECKING:
    from stiffcal.arrays import Floats
    from stiffcal.identification.fitting.fit import Fit
    from stiffcal.measurements.rms import Rms
    from stiffcal.results.identify_result import IdentifyResult

OF_FIT = {
    "normal": "residuals against a normal law",
    "influence": "influence of each run on each parameter",
    "correlation": "correlations of the parameters",
    "profile": "sums of squares over parameters that bend their law or are near a bound",
    "history": "errors of all fits of the history",
}
"""What can be drawn of a fit, in words."""
MEASURES_IN_WORDS = {
    "translation": "displacements and gauges",
    "rotation": "rotations",
    "length": "rods",
    "motor_angle": "angles of clamped motors",
}
STATISTICS = "Statistics of the fit"
CAPTIONS = {
    "normal": "Residuals in order against a normal law. Within the grey band are 95 of 100 samples of pure noise: "
    "points outside it at the ends are outliers, a steeper line is noise that is larger than stated.",
    "influence": "Change of each value without one run, in standard uncertainties. A value that one run changes by "
    "several of them rests on that run.",
    "correlation": "Correlations of the values: the larger a square, the more a change of one value is made up for by "
    "the other.",
    "profile": "Sum of squares over the values of a parameter that bends its law or is near a bound, all others free. "
    "Where it leaves the parabola, the interval by the profile holds rather than value ± uncertainty. Both are "
    "without the geometry's tolerance, which stated values hold as well.",
    "history": "Error in held-out data of each fit of the history, next to the noise.",
}
"""What each picture shows, and how to read it."""
LEAST_FREE = 1e-3
"""Share of a reading's variance that its run's constant leaves, below which it shows no noise: as of a run of one."""


def check_picture(of: str) -> None:
    """Refuse a word that is no key of `OF_FIT`; raises `InputError`."""
    if of not in OF_FIT:
        mend = f"choose {', '.join(OF_FIT)}"
        raise InputError.at(FaultCode.OPTION_INVALID, "command line", "--of", f"unknown picture {of}", mend)


def picture_of_fit(of: str, data: Ingested, context: RunContext) -> Picture:
    """Return a picture of the present fit.

    Parameters
    ----------
    of : a key of `OF_FIT`. data : up to date. context : store, progress and so on.

    Raises
    ------
    InputError : there is no such picture, or the campaign holds no load states or places.
    """
    check_picture(of)
    identified, fit = up_to_date_fit_at_hand(data, context)
    if of in ("correlation", "history"):
        return _of_results(of, data, identified)
    fit = fit or fit_again(data, identified, context)
    if fit is None:
        mend = "choose correlation or history"
        raise InputError.at(
            FaultCode.DATA_MISSING, "command line", "--of", "the campaign contains no load states", mend
        )
    return _of_fit(of, fit)


def _of_results(of: str, data: Ingested, identified: IdentifyResult) -> Picture:
    if of == "history":
        return _history(data)
    names = identified.free_parameters
    return correlation_picture(names, np.array(identified.covariance, dtype=np.float64).reshape(len(names), len(names)))


def _of_fit(of: str, fit: Fit) -> Picture:
    if of == "profile":
        return profile_picture(profiles(fit), {one.name: one.interval for one in fit.parameters})
    return _influence(fit) if of == "influence" else normal_picture(residuals_in_noises(fit))


def pictures_of_fit(
    data: Ingested, identified: IdentifyResult, context: RunContext, at_hand: Fit | None = None
) -> dict[str, Callable[[], Picture]]:
    """Return what makes each picture of the present fit that has something to show; the fit is made once, if at all.

    Parameters
    ----------
    data : the campaign with its states. identified : the stored fit of them. context : store, progress and so on.
    at_hand : the fit itself where it was made now.
    """
    if len(data.states) == 0 or not identified.free_parameters:
        return {}

    @cache
    def fit() -> Fit:
        made = at_hand or fit_again(data, identified, context)
        assert made is not None, "a campaign with load states has a fit"
        return made

    robot = placed_robot(data.campaign).with_values(identified.robot_values())
    variances = np.diag(np.array(identified.covariance, dtype=np.float64))
    known = dict(zip(identified.free_parameters, np.sqrt(np.maximum(variances, 0.0)).tolist(), strict=True))
    wanted = ["normal", "influence", *["profile"] * bool(profiled(robot, known))]
    made: dict[str, Callable[[], Picture]] = {of: partial(lambda of: _of_fit(of, fit()), of) for of in wanted}
    several = len(identified.free_parameters) > 1
    return made | {"correlation": partial(_of_results, "correlation", data, identified)} if several else made


def statistics_page(data: Ingested, identified: IdentifyResult, context: RunContext) -> Page | None:
    """Return pictures of the present fit as a page; None of a fit without a free parameter.

    The fit is made again where a parameter has a profile, and only there.

    Parameters
    ----------
    data, identified, context : as in `pictures_of_fit`.
    """
    pictures = pictures_of_fit(data, identified, context)
    if not pictures:
        return None
    pictures["history"] = partial(_of_results, "history", data, identified)
    wanted = [of for of in ("profile", "correlation", "history") if of in pictures]
    blocks = [replace(pictures[of](), caption=(CAPTIONS[of],)) for of in wanted]
    return Page(STATISTICS, tuple(blocks), "statistics of the fit")


def residuals_in_noises(fit: Fit) -> dict[str, Floats]:
    """Return (n,) per kind of reading what a fit leaves, in standard deviations of the noise.

    Where the noise is not known, in those of what is left itself.
    """
    rows = fit.linearised()
    # a run's constant is taken out of its readings, and a part of their variance with it
    free = np.sqrt(np.where(rows.space.free > LEAST_FREE, rows.space.free, np.nan))
    white = np.where(rows.mask, rows.white[-1].reshape(rows.measured.shape), np.nan) / free
    if fit.noise is None:
        white = white / np.sqrt(np.nanmean(white**2))
    found = {}
    for measure, kinds in MEASURES.items():
        part = white[np.isin(fit.data.layout.kind, kinds)]
        if np.isfinite(part).any():
            found[MEASURES_IN_WORDS[measure]] = part[np.isfinite(part)]
    return found


def _influence(fit: Fit) -> Picture:
    from stiffcal.validation.heldout import changes_without_each

    if not fit.free_names:
        return influence_picture([], [], np.zeros((0, 0)))
    numbers, fold = np.unique(fit.data.run, return_inverse=True)
    names = fit.linearised().unknowns.names
    own = [names.index(name) for name in fit.free_names]
    changes = in_standard_uncertainties(changes_without_each(fit, fold)[:, own], fit.covariance)
    return influence_picture(fit.free_names, [fit.data.run_names[k] for k in numbers], changes)


def _history(data: Ingested) -> Picture:
    from stiffcal.report.figures.ladder import leading_component

    fits = stored_fits(data.store)
    measure = leading_component(fits) or "translation"
    unit = of_measure(measure).unit_for(
        getattr(rms, measure) for fit in fits for rms in (fit.heldout_rms, fit.noise) if rms is not None
    )

    def sizes(errors: list[Rms | None]) -> Floats:
        values = (None if rms is None else getattr(rms, measure) for rms in errors)
        return np.array([np.nan if value is None else unit.factor * value for value in values])

    return history_picture(
        [fit.id for fit in fits],
        sizes([fit.heldout_rms for fit in fits]),
        sizes([fit.noise for fit in fits]),
        unit.in_brackets("error in held-out data, rms"),
    )
