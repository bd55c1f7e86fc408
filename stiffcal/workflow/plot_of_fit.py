"""Pictures of a fit that its statistics hang on, for `plot` and Python."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.identification.readings.row_layout import MEASURES
from stiffcal.kinds.presentation import Picture
from stiffcal.results.fit_pictures import (
    correlation_picture,
    history_picture,
    in_standard_uncertainties,
    influence_picture,
    normal_picture,
)
from stiffcal.workflow.history import stored_fits
from stiffcal.workflow.identify import fit_now, up_to_date_fit_at_hand
from stiffcal.workflow.steps import Ingested, RunContext

if TYPE_CHECKING:
    from stiffcal.arrays import Floats
    from stiffcal.identification.fitting.fit import Fit
    from stiffcal.measurements.rms import Rms

OF_FIT = {
    "normal": "residuals against a normal law",
    "influence": "influence of each run on each parameter",
    "correlation": "correlations of the parameters",
    "history": "errors of all fits of the history",
}
"""What can be drawn of a fit, in words."""
MEASURES_IN_WORDS = {
    "translation": "displacements and gauges",
    "rotation": "rotations",
    "length": "rods",
    "motor_angle": "angles of clamped motors",
}
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
    if of == "history":
        return _history(data)
    if of == "correlation":
        names = identified.free_parameters
        covariance = np.array(identified.covariance, dtype=np.float64)
        return correlation_picture(names, covariance.reshape(len(names), len(names)))
    fit = fit or fit_now(data, identified.loss, context)
    if fit is None:
        mend = "choose correlation or history"
        raise InputError.at(
            FaultCode.DATA_MISSING, "command line", "--of", "the campaign contains no load states", mend
        )
    return _influence(fit) if of == "influence" else normal_picture(residuals_in_noises(fit))


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
    from stiffcal.report.figures.ladder import SCALES, leading_component

    fits = stored_fits(data.store)
    measure = leading_component(fits) or "translation"
    unit, factor, _ = SCALES[measure]

    def sizes(errors: list[Rms | None]) -> Floats:
        values = (None if rms is None else getattr(rms, measure) for rms in errors)
        return np.array([np.nan if value is None else factor * value for value in values])

    return history_picture(
        [fit.id for fit in fits],
        sizes([fit.heldout_rms for fit in fits]),
        sizes([fit.noise for fit in fits]),
        f"error in held-out data, rms [{unit}]",
    )
