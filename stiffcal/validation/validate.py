"""How large the error in held-out poses is, and where it sits."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.identification.fitting.fit import Fit
from stiffcal.identification.noise.reading_noise import reading_rows, rms_by_measure
from stiffcal.identification.readings.observations import Observations
from stiffcal.identification.readings.row_layout import MEASURES, ROTATION, TRANSLATION
from stiffcal.identification.readings.state_kinds import measured_kinds
from stiffcal.measurements.load_states import LoadStates, members_of
from stiffcal.measurements.rms import Rms
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.kinematics import stacked_bodies
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.quantity import of_joint
from stiffcal.reduction.loads.cycles import BRANCH_NAMES, find_load_cycles, load_unit, load_vector
from stiffcal.validation.heldout import HeldoutResiduals, heldout_residuals
from stiffcal.validation.results import ErrorSlice, SliceBy

HOW_MANY_WORST = 10
LOAD_BINS = 5
ANGLE_BINS = 4


@dataclass(frozen=True)
class Validation:
    """The model in held-out poses."""

    heldout: HeldoutResiduals
    """Residuals state by state."""
    rms: Rms
    """Of the residual."""
    max: Rms
    """The largest residual."""
    noise: Rms
    """What the instruments scatter."""
    relative: Rms
    """Residual over displacement, a share in each measure."""
    zero_model: Rms
    """The displacement itself."""
    by: dict[SliceBy, list[ErrorSlice]]
    """"run", "direction", "load", "branch", "joint_angle" to slices; "body" too where several bodies are tracked, and
    "experiment" where several kinds of experiment are fitted together.
    """
    worst: list[tuple[int, Rms]]
    """Indices of the states with the largest residual, worst first (into the campaign's load states), with its length
    in the one measure that they are ranked by.
    """


def lengths(values: Floats, data: Observations, measure: str = "translation") -> Floats:
    """Return (n,) the length of the residual vector in one measure, of several the longest; NaN where none is.

    Parameters
    ----------
    measure : "translation" (gauges included), "rotation", or "length" (of rods).
    """
    longest = np.full(data.n_states, np.nan)
    for rows in reading_rows(data, np.isin(data.kind, MEASURES[measure])):
        squares = np.sum(np.where(data.measured_mask[rows], values[rows] ** 2, 0.0), axis=0)
        longest = np.fmax(longest, np.where(data.measured_mask[rows].any(axis=0), np.sqrt(squares), np.nan))
    return longest


def rms_of(values: Floats, data: Observations) -> dict[str, float | None]:
    """Return the rms length of translation and rotation, and of rods where there are some."""
    return rms_by_measure(values**2, data)


def _largest_of(values: Floats, data: Observations) -> Rms:
    largest: dict[str, float | None] = {}
    for name in rms_of(values, data):
        length = lengths(values, data, name)
        largest[name] = float(np.nanmax(length)) if np.isfinite(length).any() else None
    return Rms.of(largest)


def _slice(
    label: str,
    members: Booleans | Integers,
    heldout: HeldoutResiduals,
    low: float | None = None,
    high: float | None = None,
) -> ErrorSlice:
    data = heldout.data.subset(members)
    values = heldout.residual[:, members]
    return ErrorSlice(
        label=label,
        low=low,
        high=high,
        n=data.n_measured,
        rms=Rms.of(rms_of(values, data)),
        max=_largest_of(values, data),
    )


def validate_fit(states: LoadStates, fit: Fit, heldout: HeldoutResiduals | None = None) -> Validation:
    """Judge a fit in held-out poses and find where it fails.

    Parameters
    ----------
    states : the campaign's load states.
    fit : what is judged.
    heldout : residuals to judge, where they are already known.
    """
    residuals = heldout if heldout is not None else heldout_residuals(states, fit)
    data = residuals.data
    rms, zero = rms_of(residuals.residual, data), rms_of(residuals.displacement, data)
    relative = {
        kind: value / reference if value is not None and (reference := zero[kind]) else None
        for kind, value in rms.items()
    }
    by: dict[SliceBy, list[ErrorSlice]] = {
        "run": _by_run(states, residuals),
        "direction": _by_direction(states, residuals, fit.robot),
        "load": _by_load(states, residuals),
        "branch": _by_branch(states, residuals),
        "joint_angle": _by_joint_angle(states, fit.robot.chain, residuals),
    }
    if len(data.setup.targets) > 1:
        by["body"] = _by_body(residuals)
    kinds = measured_kinds(data)
    if len(kinds) > 1:
        by["experiment"] = [_slice(kind.name, members, residuals) for kind, members in kinds]
    return Validation(
        heldout=residuals,
        rms=Rms.of(rms),
        max=_largest_of(residuals.residual, data),
        noise=Rms.of(fit.noise_length),
        relative=Rms.of(relative),
        zero_model=Rms.of(zero),
        by=by,
        worst=_worst_states(residuals, rms),
    )


def _worst_states(heldout: HeldoutResiduals, rms: Mapping[str, float | None]) -> list[tuple[int, Rms]]:
    """Return the worst states by the tool's displacement, and by the motor's angle where that alone was measured.

    Between the two the residual counts as a multiple of its measure's rms.
    """
    data = heldout.data
    size = {name: lengths(heldout.residual, data, name) for name in ("translation", "motor_angle")}
    displaced = np.isfinite(size["translation"])
    chosen = np.where(displaced, "translation", "motor_angle")
    value = np.where(displaced, size["translation"], size["motor_angle"])
    whole = {name: rms.get(name) or np.inf for name in size}
    rank = np.nan_to_num(value / np.where(displaced, whole["translation"], whole["motor_angle"]), nan=-1.0)
    worst = [int(i) for i in np.argsort(-rank)[:HOW_MANY_WORST] if rank[i] >= 0.0]
    none: dict[str, float | None] = {"translation": None, "rotation": None}
    return [(int(data.index[i]), Rms.of({**none, str(chosen[i]): float(value[i])})) for i in worst]


def _by_run(states: LoadStates, heldout: HeldoutResiduals) -> list[ErrorSlice]:
    # rows of an absolute run are runs of their own; people ask for the run
    names = [info.of or info.name for info in states.runs]
    listed = {name: number for number, name in enumerate(dict.fromkeys(names))}
    number = np.array([listed[names[run]] for run in heldout.data.run], dtype=np.int64)
    return [_slice(names[heldout.data.run[members[0]]], members, heldout) for members in members_of(number)]


def _by_body(heldout: HeldoutResiduals) -> list[ErrorSlice]:
    """Judge every tracked body by itself, from the tool inwards."""
    slices = []
    for number, name in enumerate(heldout.data.setup.target_names):
        poses = np.isin(heldout.data.kind, (TRANSLATION, ROTATION)) & (heldout.data.body == number)
        data = replace(heldout.data, measured_mask=heldout.data.measured_mask & poses[:, None])
        if data.measured_mask.any():
            body_residual = np.where(data.measured_mask, heldout.residual, 0.0)
            displacement = np.where(data.measured_mask, heldout.displacement, 0.0)
            slices.append(
                ErrorSlice(
                    label=name,
                    low=None,
                    high=None,
                    n=data.n_measured,
                    rms=Rms.of(rms_of(body_residual, data)),
                    max=_largest_of(body_residual, data),
                    zero_model=Rms.of(rms_of(displacement, data)),
                )
            )
    return slices


def load_in_base(data: Observations, robot: CompliantRobot) -> Floats:
    """Return (n, 3) the force in base axes, N (the moment where no force was applied), undeformed chain."""
    axes = data.setup.wrench_axes
    rotation = stacked_bodies(robot.chain, data.angles)[axes.body].moved(axes.transform).rotation
    vector = load_vector(data.wrench.T)
    return np.asarray(np.einsum("ijn,nj->ni", rotation, vector))


def _by_direction(states: LoadStates, heldout: HeldoutResiduals, robot: CompliantRobot) -> list[ErrorSlice]:
    """Sort loads by the base axis that they point along most."""
    data = heldout.data
    load = load_in_base(data, robot)
    loaded = find_load_cycles(states).direction[data.index] >= 0
    axis = np.argmax(np.abs(load), axis=1)
    positive = load[np.arange(len(load)), axis] > 0.0
    slices = []
    for number, name in enumerate("xyz"):
        for sign, is_positive in (("+", True), ("−", False)):
            members = loaded & (axis == number) & (positive == is_positive)
            if members.any():
                slices.append(_slice(f"near {sign}{name}", members, heldout))
    if (~loaded).any():
        slices.append(_slice("unloaded", ~loaded, heldout))
    return slices


def _by_load(states: LoadStates, heldout: HeldoutResiduals) -> list[ErrorSlice]:
    magnitude = find_load_cycles(states).magnitude[heldout.data.index]
    if heldout.data.absolute.all() and not magnitude.any():
        return []  # weight alone
    edges = np.linspace(0.0, float(magnitude.max(initial=0.0)), LOAD_BINS + 1)
    return _binned(magnitude, edges, load_unit(states.wrench), "", 1.0, heldout)


def _binned(
    values: Floats, edges: Floats, unit: str, prefix: str, factor: float, heldout: HeldoutResiduals
) -> list[ErrorSlice]:
    slices = []
    for low, high in itertools.pairwise(edges):
        members = (values >= low) & ((values < high) | (high == edges[-1]))
        if members.any():
            label = f"{prefix}{low * factor:.4g} to {high * factor:.4g} {unit}"
            slices.append(_slice(label, members, heldout, float(low), float(high)))
    return slices


def _by_branch(states: LoadStates, heldout: HeldoutResiduals) -> list[ErrorSlice]:
    branch = find_load_cycles(states).branch[heldout.data.index]
    return [
        _slice(name, branch == number, heldout) for number, name in enumerate(BRANCH_NAMES) if np.any(branch == number)
    ]


def _by_joint_angle(states: LoadStates, chain: Chain, heldout: HeldoutResiduals) -> list[ErrorSlice]:
    slices: list[ErrorSlice] = []
    for joint in range(states.joints.shape[1]):
        angle = states.joints[heldout.data.index, joint]
        low, high = float(angle.min()), float(angle.max())
        if high - low < np.radians(1.0):
            continue
        edges = np.linspace(low, high, ANGLE_BINS + 1)
        unit = of_joint(bool(chain.prismatic[joint])).usual
        angle_slices = _binned(angle, edges, unit.name, f"joint {joint + 1}: ", unit.factor, heldout)
        slices.extend(replace(slice_of_angle, joint=joint + 1) for slice_of_angle in angle_slices)
    return slices
