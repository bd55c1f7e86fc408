"""The models of `improve` step by step, from no model down to the noise."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from stiffcal.presentation.values import Bar, Bars
from stiffcal.validation.schemes import held_out
from stiffcal.wording import deviation, listing, place

if TYPE_CHECKING:
    from stiffcal.measurements.rms import Rms
    from stiffcal.results.improve_results import ImproveStep

MEASURES = ("translation", "torque", "motor_angle", "length", "rotation")
"""The first that is known of all models is drawn."""


def ladder(steps: Sequence[ImproveStep], noise: Rms | None, scheme: str | None) -> Bars:
    """Return the errors from no model down to the noise.

    Parameters
    ----------
    steps : of `improve`, the model as it was first. noise : in the same measure; None where it is not known.
    scheme : how data were held out.

    Examples
    --------
    >>> from stiffcal.measurements.rms import Rms
    >>> from stiffcal.model.summary import Where
    >>> from stiffcal.results.improve_results import ImproveStep
    >>> start = ImproveStep(
    ...     action="start", effect=None, where=Where(), noise=None,
    ...     heldout_rms=Rms(1e-4, None), zero_model=Rms(1e-3, None),
    ... )
    >>> [(one.name, one.text) for one in ladder([start], Rms(2.5e-5, None), None).bars]
    [('no model', '1.00 mm'), ('present model', '0.100 mm'), ('noise', '0.0250 mm')]
    """
    measure = drawn_measure([step.heldout_rms for step in steps if step.heldout_rms is not None])

    def size(rms: Rms | None) -> float | None:
        return None if measure is None else _size(rms, measure)

    bars = [Bar("no model", size(steps[0].zero_model), deviation(steps[0].zero_model))]
    for step in steps:
        text = deviation(step.heldout_rms) if step.heldout_rms else "not done"
        bars.append(Bar(step_in_words(step), size(step.heldout_rms), text, is_on_scale=True))
    bars.append(Bar("noise", size(noise), deviation(noise)))
    return Bars("step", f"{held_out(scheme)}, rms", tuple(bars))


def step_in_words(step: ImproveStep) -> str:
    """Return what a step did to the model."""
    if step.action == "start":
        return "present model"
    return f"{step.action} {step.effect} ({place(step.where)}){', not certain' if step.firm is False else ''}"


def drawn_measure(models: Sequence[Rms]) -> str | None:
    """Return the measure by which the errors of models are compared; None where none is known of all of them."""
    return next((name for name in MEASURES if models and all(_size(rms, name) is not None for rms in models)), None)


def gain_in_words(steps: Sequence[ImproveStep]) -> str:
    """Return what was added and by how much the error has fallen; "" where nothing was added, or it has not."""
    first, last = steps[0], steps[-1]
    added = _still_added(steps)
    if not added or first.heldout_rms is None or last.heldout_rms is None:
        return ""
    before, after = (dict(rms.items()) for rms in (first.heldout_rms, last.heldout_rms))
    # an error may fall in one measure and rise in another: the one that is drawn decides, and those that fell are named
    fallen = [name for name, now in after.items() if now is not None and now < (before.get(name) or 0.0)]
    if drawn_measure([first.heldout_rms, last.heldout_rms]) not in fallen:
        return ""
    start, end = (deviation({name: rms[name] for name in fallen}) for rms in (before, after))
    return f"Added {listing(added)}: the error in {held_out(last.scheme)} decreased from {start} to {end} rms."


def _size(rms: Rms | None, measure: str) -> float | None:
    return None if rms is None else dict(rms.items()).get(measure)


def _still_added(steps: Sequence[ImproveStep]) -> list[str]:
    """Return what was added and not taken out again, with its place."""
    added: list[str] = []
    for step in steps:
        name = f"{step.effect} ({place(step.where)})"
        if step.action == "add":
            added.append(name)
        elif step.action == "remove" and name in added:
            added.remove(name)
    return added
