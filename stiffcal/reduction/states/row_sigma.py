"""Uncertainties that a log states row by row: in base axes, and their size as a whole."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.measurements.load_states import MeasurementSetup
from stiffcal.measurements.tracker_axes import each_tracker
from stiffcal.reduction.states.raw_states import RawStates


def stated_row_by_row(gathered: RawStates, setup: MeasurementSetup, tracker: Integers, place: Floats) -> Floats:
    """Return (n, B, 6) standard uncertainty of each target, m and rad, base axes; NaN where none is stated.

    Variances are turned, not covariances: the axes of the instrument err independently of each other.

    Parameters
    ----------
    gathered : the states, signals in the instrument's axes.
    setup : where the instruments sit.
    tracker : (n,) which of its trackers reads each state.
    place : (n, B, 3) what was read of each target; where it is missing, so may its uncertainty be.

    Raises
    ------
    InputError : an uncertainty is missing, zero or negative where the target was read.
    """
    sigma = np.full((len(gathered.run), len(setup.targets), 6), np.nan)
    for b, body in enumerate(setup.target_names):
        for quantity, columns in (("position", slice(0, 3)), ("rotation", slice(3, 6))):
            stated = gathered.signals.get(f"sigma.{quantity}.{body}")
            if stated is None:
                continue
            own = np.broadcast_to(stated, (len(stated), 3))
            # runs of other sources state none
            stating = {gathered.run[k] for k in np.flatnonzero(np.isfinite(own).any(axis=1))}
            judged = np.array([name in stating for name in gathered.run], dtype=np.bool_)
            judged &= np.isfinite(place[:, b]).all(axis=1) & np.array([not entry.code for entry in gathered.set_aside])
            wrong = np.flatnonzero(judged & ~(own > 0.0).all(axis=1))
            if wrong.size:
                run, row = gathered.run[wrong[0]], int(gathered.number[wrong[0]])
                raise InputError.at(
                    FaultCode.READING_IMPLAUSIBLE, "campaign.toml", f"run {run}, row {row}",
                    f"the uncertainty of {quantity} of {body} is {own[wrong[0]].min():g}",
                    "write a positive one, or exclude the row with [[exclude]]",
                )  # fmt: skip
            for read, placed in each_tracker(setup.trackers, tracker):
                sigma[read, b, columns] = np.sqrt(own[read] ** 2 @ (placed[:3, :3] ** 2).T)
    return sigma


def with_own_sigma(
    sigma: Floats, absolute: Booleans, targets: Sequence[str], stated: Mapping[str, tuple[float | None, float | None]]
) -> Floats:
    """Return (n, B, 6) with each target's own number in the rows of absolute runs, where the targets' are not equal.

    Equal numbers stay those of the set-up.

    Parameters
    ----------
    sigma : (n, B, 6) of `stated_row_by_row`, m and rad, base axes.
    absolute : (n,) True for rows of absolute runs.
    targets : B names.
    stated : position, m, and rotation, rad, of each target, alike on all axes; None where no number is stated.
    """
    if len(set(stated.values())) < 2:
        return sigma
    own = np.array([np.repeat(np.array(stated.get(name, (None, None)), dtype=np.float64), 3) for name in targets])
    return np.where(absolute[:, None, None] & np.isnan(sigma), own, sigma)


def with_typical_sigma(setup: MeasurementSetup, sigma: Floats, absolute: Booleans) -> MeasurementSetup:
    """Return the set-up with the root mean square of what is stated row by row as its uncertainty.

    Where rows of absolute runs alone state it, it is that of places.

    Parameters
    ----------
    setup : as the manifest gives it.
    sigma : (n, B, 6) m and rad, NaN where none is stated.
    absolute : (n,) True for rows of absolute runs.
    """
    sizes = [
        float(np.sqrt(np.mean(values[np.isfinite(values)] ** 2))) if np.isfinite(values).any() else None
        for values in (sigma[:, :, :3], sigma[:, :, 3:])
    ]
    if sizes == [None, None]:
        return setup
    translation, rotation = sizes
    if not absolute.all() and not np.isfinite(sigma[~absolute]).any():
        of_places = replace(
            setup.sigma,
            absolute_translation=translation or setup.sigma.absolute_translation,
            absolute_rotation=rotation or setup.sigma.absolute_rotation,
        )
        return replace(setup, sigma=of_places)
    stated = replace(
        setup.sigma, translation=translation or setup.sigma.translation, rotation=rotation or setup.sigma.rotation
    )
    return replace(setup, sigma=stated)
