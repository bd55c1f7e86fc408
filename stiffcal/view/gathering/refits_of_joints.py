"""Refits of single joints on the page for a browser: each with what the present fit leaves of all other joints."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from stiffcal.arrays import Booleans, Floats
from stiffcal.diagnosis.refits.refits import LEADING
from stiffcal.measurements.rms import Rms
from stiffcal.view.content import ViewModel, ViewShare, ViewValue


def is_of_one_joint(refit: ViewModel, present: ViewModel, used: Booleans) -> bool:
    """Return whether a refit is of one joint's states alone: those of each drive are searched by themselves."""
    if refit.residual_heldout is None or present.residual_heldout is None:
        return False
    by_joint = refit.heldout_rms is not None and refit.heldout_rms.translation is None
    known = np.isfinite(present.residual_heldout[:, 0])
    return by_joint and bool((used & known & np.isnan(refit.residual_heldout[:, 0])).any())


def of_all_joints(
    refits: Sequence[ViewModel],
    present: ViewModel,
    used: Booleans,
    share_of: Callable[[Floats | None], list[ViewShare]],
) -> list[ViewModel]:
    """Return refits of single joints with what the present fit leaves of all others; the best of them.

    Errors are of all states then, as those of the fits. What is missing of each joint becomes one model with all of it.
    Of candidates of one name, which several joints' searches ranked, the best is kept, and of all the ten best.

    Parameters
    ----------
    refits, present : over all n states. used : (n,) states that are judged.
    share_of : what explains a residual.
    """
    whole: dict[tuple[str, str], ViewModel] = {}
    for refit in [*_all_missing(refits), *(refit for refit in refits if refit.kind != "all")]:
        if refit.residual_heldout is None or present.residual_heldout is None or refit.heldout_rms is None:
            continue
        left = np.where(np.isnan(refit.residual_heldout), present.residual_heldout, refit.residual_heldout)
        size = float(np.sqrt(np.nanmean(np.sum(left[used] ** 2, axis=1))))
        measure = "torque" if refit.heldout_rms.torque is not None else "motor_angle"
        rms = Rms.of({"translation": None, "rotation": None, measure: size})
        names = {value.name for value in refit.values}
        others = [] if not names else [value for value in present.values if value.name not in names]
        model = replace(
            refit,
            heldout_rms=rms,
            values=[*refit.values, *others],
            residual_heldout=left,
            shares=share_of(left),
        )
        key = (refit.kind, refit.effect)
        if key not in whole or size < _size(whole[key]):
            whole[key] = model
    ordered = sorted(whole.values(), key=_size)
    return [
        *[model for model in ordered if model.kind == "all"],
        *[model for model in ordered if model.kind == "with"][: 2 * LEADING],
        *[model for model in ordered if model.kind == "without"],
    ]


def _all_missing(refits: Sequence[ViewModel]) -> list[ViewModel]:
    """Return one model with what is missing of every joint, as a list; empty where nothing is missing."""
    parts = [refit for refit in refits if refit.kind == "all" and refit.residual_heldout is not None]
    if not parts:
        return []
    residual = parts[0].residual_heldout
    values: dict[str, ViewValue] = {}
    for part in parts:
        if residual is not None and part.residual_heldout is not None:
            residual = np.where(np.isnan(residual), part.residual_heldout, residual)
        values |= {value.name: value for value in part.values}
    names = ", ".join(part.effect for part in parts)
    return [
        replace(
            parts[0],
            label=f"with all that is missing: {names}",
            effect=names,
            values=list(values.values()),
            residual_heldout=residual,
        )
    ]


def _size(model: ViewModel) -> float:
    """Return the error of a model of rows or clamped states."""
    rms = model.heldout_rms
    value = None if rms is None else rms.torque if rms.torque is not None else rms.motor_angle
    return np.inf if value is None else value
