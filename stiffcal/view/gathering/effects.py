"""Each effect of the model on the page for a browser: its part of the prediction, state by state."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.identification.fitting.identify import predict_observations
from stiffcal.identification.readings.observations import Observations, observe
from stiffcal.identification.readings.row_layout import GAUGE, MOTOR, ROTATION, TRANSLATION
from stiffcal.measurements.load_states import LoadStates
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.effect import RZ
from stiffcal.view.content import ViewEffect


def view_effects(robot: CompliantRobot, states: LoadStates, pick: Integers, width: int) -> list[ViewEffect]:
    """Return each effect of the model with its part of the prediction, over the states that are drawn.

    Parameters
    ----------
    robot : with the values of the fit. states : all load states.
    pick : states that are drawn, ascending. width : columns of the parts, 3 or 6.
    """
    data = observe(states, robot.chain)
    if not robot.has_memory:
        kept: Booleans = np.isin(data.index, pick)
        data = data.subset(kept)
    whole = predict_observations(robot, data)
    # the share is of the translations; where none was measured, of what the gauges read, or the motors
    main = next((rows for kind in (TRANSLATION, GAUGE, MOTOR) if (rows := data.kind == kind).any()), data.kind == -1)
    total = float(np.sum(np.where(data.measured_mask, whole, 0.0)[main] ** 2))
    chosen = np.flatnonzero(np.isin(data.index, pick))
    where = np.searchsorted(pick, data.index[chosen])
    effects = []
    for number, placed in enumerate(robot.placed):
        less = replace(robot, placed=robot.placed[:number] + robot.placed[number + 1 :])
        added = np.where(data.measured_mask, whole - predict_observations(less, data), 0.0)
        part = np.zeros((len(pick), width))
        part[where] = _of_first_target(data, added, width)[chosen]
        share = float(np.sum((added * whole)[main])) / total if total > 0.0 else 0.0
        joint, part_of = None, _part_of(placed)
        if placed.place.kind == "joints":
            joint = placed.place.joints[0]
        elif placed.place.kind == "links":
            joint = robot.chain.joint_of_link[placed.place.link]
        name = f"{placed.effect.name} {placed.place.label}"
        removable = placed.place.kind != "frames"
        effects.append(ViewEffect(name=name, joint=joint, part_of=part_of, removable=removable, share=share, part=part))
    return effects


def _part_of(placed: PlacedEffect) -> Literal["joint", "bearing", "link", "setup"]:
    """Return which part of the robot gives."""
    if placed.place.kind == "links":
        return "link"
    if placed.place.kind != "joints":
        return "setup"
    across = any(spec.along is not None and spec.along != RZ for spec in placed.effect.parameters)
    return "bearing" if across else "joint"


def _of_first_target(data: Observations, rows: Floats, width: int) -> Floats:
    """Return (n, width) of (m, n) rows: what they move the first target by, or the moved motor."""
    result = np.zeros((data.n_states, width))
    for row, kind in enumerate(data.kind):
        component = int(data.component[row])
        if kind in (TRANSLATION, ROTATION) and data.body[row] == 0 and component < width:
            result[:, component] = rows[row]
    translations = bool((data.kind == TRANSLATION).any())
    gauges = data.layout.gauges
    if gauges is not None and not translations:
        result[:, :3] += np.einsum("gn,gin->ni", rows[gauges.row], gauges.direction)
    if not translations and gauges is None:
        result[:, 0] += rows[data.kind == MOTOR].sum(axis=0)
    return result
