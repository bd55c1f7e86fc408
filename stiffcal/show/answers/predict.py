"""What `predict` shows: deflection ± 95 % and the force that a millimetre takes, state by state."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stiffcal.quantity import LENGTH, LINEAR_STIFFNESS, ShownUnit
from stiffcal.show.builder import PageBuilder, number
from stiffcal.uncertainty import NORMAL_95
from stiffcal.wording import DASH, significant

if TYPE_CHECKING:
    from collections.abc import Sequence

    from stiffcal.compensation.predict_result import PredictedState, PredictResult
    from stiffcal.document_arrays import Matrix, Vector
    from stiffcal.presentation.values import Page
    from stiffcal.show.options import ShowOptions

MOST_ROWS = 24
"""Of its tables together; with details all."""


def page(result: PredictResult, options: ShowOptions) -> Page:
    """Return deflection, stiffness with and without complementary stiffness, and each link's own part."""
    made = PageBuilder("Prediction")
    made.say(f"deflection of {result.target}, base axes; values from {result.values_from}", "target")
    n_tables = 2 + (len(result.states[0].links) if result.states else 0)
    shown = result.states if options.details else result.states[: MOST_ROWS // n_tables]
    unit = LENGTH.unit_for(float(value) for state in shown for value in state.deflection[:3])
    rows = [(f"{k}", *(_translation(state, axis, unit) for axis in range(3))) for k, state in enumerate(shown, 1)]
    made.table((number("state"), *(number(unit.in_brackets(f"d{axis}")) for axis in "xyz")), rows)
    compliances = [m for state in shown for m in (state.cartesian_compliance, state.linear_compliance)]
    hard = LINEAR_STIFFNESS.unit_for(1.0 / m[k, k] for m in compliances for k in range(3) if m[k, k] > 0.0)
    made.head(f"{hard.in_brackets('stiffness')}, with and without complementary stiffness")
    rows = [
        (f"{k}", *_stiffness(state.cartesian_compliance, hard), *_stiffness(state.linear_compliance, hard))
        for k, state in enumerate(shown, 1)
    ]
    made.table([number(title) for title in ("state", "x", "y", "z", "x without", "y without", "z without")], rows)
    _add_links(made, shown, unit)
    if len(shown) < len(result.states):
        made.say(f"{len(result.states) - len(shown)} more (predict --details, --json or -o FILE)", "more")
    if result.file is not None:
        made.say(f"wrote {result.file}", "written")
    return made.page()


def _add_links(made: PageBuilder, states: Sequence[PredictedState], unit: ShownUnit) -> None:
    """Add the deflection with and without each link's own part, side by side (000, Fig. 7)."""
    for place, link in enumerate(states[0].links if states else []):
        name, modelled, measured = link.link, link.at_target is not None, link.at_target_by_compliance is not None
        titles = ["whole", *[f"{name} rigid", f"part of {name}"] * modelled]
        titles += [f"part of {name} by its 6×6"] * measured
        rows = []
        for k, state in enumerate(states, start=1):
            deflection = state.links[place]
            cells = [_vector(state.deflection, unit)]
            if deflection.at_target is not None:
                own = deflection.at_target
                cells += [_vector(state.deflection - own, unit), _vector(own, unit)]
            if deflection.at_target_by_compliance is not None:
                cells.append(_vector(deflection.at_target_by_compliance, unit))
            rows.append((f"{k}", *cells))
        made.table((number("state"), *(number(unit.in_brackets(title)) for title in titles)), rows)


def _vector(values: Vector, unit: ShownUnit) -> str:
    # what is smaller is the solver's rounding
    kept = (value if abs(value) > LENGTH.rounding else 0.0 for value in values[:3].tolist())
    return ", ".join(significant(unit.factor * value) for value in kept)


def _translation(state: PredictedState, axis: int, unit: ShownUnit) -> str:
    value = float(state.deflection[axis])
    if abs(value) < LENGTH.rounding:
        return "0"
    half = NORMAL_95 * float(state.covariance[axis, axis]) ** 0.5
    text = significant(unit.factor * value)
    return f"{text} ± {significant(unit.factor * half, 2)}" if half else text


def _stiffness(compliance: Matrix, unit: ShownUnit) -> list[str]:
    """Return force over deflection along each axis, the other directions free to give."""
    gives = [float(compliance[k, k]) for k in range(3)]
    return [significant(unit.factor / give) if give > 0.0 else DASH for give in gives]
