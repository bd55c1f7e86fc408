"""How large the error in unseen poses is, and where it sits."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.identification.fit import Fit
from stiffcal.identification.noise import reading_rows, rms_by_measure
from stiffcal.identification.readings import Observations
from stiffcal.identification.rows import MEASURES, ROTATION, TRANSLATION
from stiffcal.measurements.load_states import LoadStates, members_of
from stiffcal.mechanics.kinematics import stacked_bodies
from stiffcal.model.composite import CompliantRobot
from stiffcal.reduction.load_cycles import BRANCH_NAMES, find_load_cycles, load_vector
from stiffcal.validation.heldout import HeldoutResiduals, heldout_residuals

HOW_MANY_WORST = 10
LOAD_BINS = 5
ANGLE_BINS = 4


@dataclass(frozen=True)
class Slice:
    """The error in a part of the data."""

    label: str
    """What part, in words."""
    low: float
    high: float
    """``low``, ``high``: the part's range, NaN where it has none."""
    n: int
    """States."""
    rms: dict[str, float | None]
    largest: dict[str, float | None]
    """``rms``, ``largest``: {"translation", "rotation"} of the residual's length, m and rad; with rods "length", m."""
    zero_model: dict[str, float | None] | None = None
    """The displacement itself, likewise; None where it is not asked for."""


@dataclass(frozen=True)
class Validation:
    """The model in unseen poses."""

    heldout: HeldoutResiduals
    """Residuals state by state."""
    rms: dict[str, float | None]
    largest: dict[str, float | None]
    noise: dict[str, float | None]
    relative: dict[str, float | None]
    zero_model: dict[str, float | None]
    """``rms``, ``largest``, ``noise``, ``relative``, ``zero_model``: {"translation", "rotation"}, with rods "length"
    too.
    """
    by: dict[str, list[Slice]]
    """"run", "direction", "load", "branch", "joint_angle" to slices; "body" too where several bodies are tracked."""
    worst: list[tuple[int, float]]
    """Indices of the states with the largest residual, worst first (into the campaign's load states), with its length
    in m.
    """


def lengths(values: Floats, data: Observations, measure: str = "translation") -> Floats:
    """Return (n,) the length of the residual vector in one measure, of several the longest; NaN where none was seen.

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


def _largest_of(values: Floats, data: Observations) -> dict[str, float | None]:
    largest: dict[str, float | None] = {}
    for name in rms_of(values, data):
        length = lengths(values, data, name)
        largest[name] = float(np.nanmax(length)) if np.isfinite(length).any() else None
    return largest


def _slice(label: str, low: float, high: float, members: Booleans | Integers, heldout: HeldoutResiduals) -> Slice:
    data = heldout.data.subset(members)
    values = heldout.residual[:, members]
    return Slice(label, low, high, data.n_measured, rms_of(values, data), _largest_of(values, data))


def validate_fit(states: LoadStates, fit: Fit, heldout: HeldoutResiduals | None = None) -> Validation:
    """Judge a fit in unseen poses and find where it fails.

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
    length = np.nan_to_num(lengths(residuals.residual, data), nan=-1.0)
    worst = [(int(data.index[i]), float(length[i])) for i in np.argsort(-length)[:HOW_MANY_WORST]]
    by = {
        "run": _by_run(states, residuals),
        "direction": _by_direction(states, residuals, fit.robot),
        "load": _by_load(states, residuals),
        "branch": _by_branch(states, residuals),
        "joint_angle": _by_joint_angle(states, residuals),
    }
    if len(data.setup.targets) > 1:
        by["body"] = _by_body(residuals)
    return Validation(
        residuals, rms, _largest_of(residuals.residual, data), fit.noise_length, relative, zero, by, worst
    )


def _by_run(states: LoadStates, heldout: HeldoutResiduals) -> list[Slice]:
    return [
        _slice(states.runs[heldout.data.run[members[0]]].name, np.nan, np.nan, members, heldout)
        for members in members_of(heldout.data.run)
    ]


def _by_body(heldout: HeldoutResiduals) -> list[Slice]:
    """Judge every tracked body by itself, from the tool inwards."""
    slices = []
    for number, name in enumerate(heldout.data.setup.target_names):
        poses = np.isin(heldout.data.kind, (TRANSLATION, ROTATION)) & (heldout.data.body == number)
        data = replace(heldout.data, measured_mask=heldout.data.measured_mask & poses[:, None])
        if data.measured_mask.any():
            own = np.where(data.measured_mask, heldout.residual, 0.0)
            displacement_rms = rms_of(np.where(data.measured_mask, heldout.displacement, 0.0), data)
            largest = _largest_of(own, data)
            slices.append(Slice(name, np.nan, np.nan, data.n_measured, rms_of(own, data), largest, displacement_rms))
    return slices


def load_in_base(data: Observations, robot: CompliantRobot) -> Floats:
    """Return (n, 3) the force in base axes, N (the moment where no force was applied), undeformed chain."""
    axes = data.setup.wrench_axes
    rotation = stacked_bodies(robot.chain, data.angles)[axes.body].moved(axes.transform).rotation
    vector = load_vector(data.wrench.T)
    return np.asarray(np.einsum("ijn,nj->ni", rotation, vector))


def _by_direction(states: LoadStates, heldout: HeldoutResiduals, robot: CompliantRobot) -> list[Slice]:
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
                slices.append(_slice(f"mostly {sign}{name}", np.nan, np.nan, members, heldout))
    if (~loaded).any():
        slices.append(_slice("unloaded", np.nan, np.nan, ~loaded, heldout))
    return slices


def _by_load(states: LoadStates, heldout: HeldoutResiduals) -> list[Slice]:
    magnitude = find_load_cycles(states).magnitude[heldout.data.index]
    return _binned(magnitude, np.linspace(0.0, float(magnitude.max(initial=0.0)), LOAD_BINS + 1), "N", "", 1.0, heldout)


def _binned(
    values: Floats, edges: Floats, unit: str, prefix: str, factor: float, heldout: HeldoutResiduals
) -> list[Slice]:
    slices = []
    for low, high in itertools.pairwise(edges):
        members = (values >= low) & ((values < high) | (high == edges[-1]))
        if members.any():
            label = f"{prefix}{low * factor:.4g} to {high * factor:.4g} {unit}"
            slices.append(_slice(label, float(low), float(high), members, heldout))
    return slices


def _by_branch(states: LoadStates, heldout: HeldoutResiduals) -> list[Slice]:
    branch = find_load_cycles(states).branch[heldout.data.index]
    return [
        _slice(name, np.nan, np.nan, branch == number, heldout)
        for number, name in enumerate(BRANCH_NAMES)
        if np.any(branch == number)
    ]


def _by_joint_angle(states: LoadStates, heldout: HeldoutResiduals) -> list[Slice]:
    slices: list[Slice] = []
    for joint in range(states.joints.shape[1]):
        angle = states.joints[heldout.data.index, joint]
        low, high = float(angle.min()), float(angle.max())
        if high - low < np.radians(1.0):
            continue
        edges = np.linspace(low, high, ANGLE_BINS + 1)
        slices.extend(_binned(angle, edges, "°", f"joint {joint + 1}: ", 180.0 / np.pi, heldout))
    return slices
