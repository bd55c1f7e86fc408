"""What the report shows of several tracked bodies: each joint's displacements with the lines fitted to them."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.identification.bodies.body_results import JointByItself
from stiffcal.identification.bodies.joint_lines import COMPONENTS
from stiffcal.identification.bodies.joint_motion import JointMotion, joint_motions
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.balance.rest import law_terms, node_displacements
from stiffcal.model.catalogue.campaign_effects import placed_robot
from stiffcal.model.effect import Kind, NodeLoads, joint_node, tool_node
from stiffcal.report.joint_curves import JointCurve, JointPicture
from stiffcal.results.identify_result import IdentifyResult
from stiffcal.stages.steps import Ingested

LAW_POINTS = 241


def joint_pictures(data: Ingested, identified: IdentifyResult) -> tuple[JointPicture, ...]:
    """Return the joints that the present `identify` document looks at by themselves; none with one tracked body."""
    by_joint = {joint.joint: joint for joint in identified.joints_by_themselves or ()}
    if not by_joint:
        return ()
    names = data.joint_names
    robot = placed_robot(data.campaign).with_values(identified.robot_values())
    return tuple(
        _picture(
            data, motion, by_joint[motion.joint], identified, robot, f"joint {motion.joint} ({names[motion.joint - 1]})"
        )
        for motion in joint_motions(data.states, data.campaign.chain)
        if motion.joint in by_joint
    )


def _picture(
    data: Ingested,
    motion: JointMotion,
    result: JointByItself,
    identified: IdentifyResult,
    robot: CompliantRobot,
    name: str,
) -> JointPicture:
    numbers, run = np.unique(motion.run, return_inverse=True)
    curves = []
    for axis, line in enumerate(result.lines):
        displacement = motion.displacement[:, axis].copy()
        curve = tuple(math.nan if value is None else float(value) for value in line.curve)
        fitted = sum(c * motion.wrench[:, axis] ** (k + 1) for k, c in enumerate(curve) if math.isfinite(c))
        for number in range(len(numbers)):
            in_run = (run == number) & np.isfinite(displacement)
            if in_run.any():
                weight = motion.std[in_run, axis] ** -2
                displacement[in_run] -= np.average((displacement - fitted)[in_run], weights=weight)
        curves.append(
            JointCurve(line=line, load=motion.wrench[:, axis], displacement=displacement, run=run.astype(np.int64))
        )
    runs = tuple(data.states.runs[int(number)].name for number in numbers)
    between = (result.between[0], result.between[1])
    pairs = None if result.matrix is None else tuple((moved_axis, load) for moved_axis, load in result.couplings)
    laws: dict[str, tuple[Floats, Floats]] = {
        line.component: law
        for axis, line in enumerate(result.lines)
        if (law := _law(robot, motion.joint, axis, motion.wrench[:, axis])) is not None
    }
    return JointPicture(name, between, runs, tuple(curves), _together(identified, robot, motion.joint), pairs, laws)


def _law(robot: CompliantRobot, joint: int, axis: int, load: Floats) -> tuple[Floats, Floats] | None:
    """Return loads and what the model's laws at the joint answer along the same axis, from no load on; None: nothing.

    Laws with a memory have no one line, nor has one that follows the joint's angle: these are left out.
    """
    node = joint_node(joint)
    at = np.linspace(min(float(load.min()), 0.0), max(float(load.max()), 0.0), LAW_POINTS)
    wrench = np.zeros((tool_node(robot.chain) + 1, 6, LAW_POINTS))
    wrench[node, axis] = at
    laws = tuple(
        placed_effect
        for placed_effect in robot.placed
        if placed_effect.effect.kind is Kind.NODE_LAW and not placed_effect.has_memory
    )
    alone = replace(
        robot, placed=tuple(placed_effect for placed_effect in laws if placed_effect.place.joints == (joint,))
    )
    nothing = np.zeros_like(wrench)
    lines = []
    for angle in (0.0, 1.0):
        angles = np.full((robot.chain.n_joints, LAW_POINTS), angle)
        terms = law_terms(alone, NodeLoads(wrench, angles, None, nothing))
        displacement = node_displacements(alone, terms, LAW_POINTS)[node, axis]
        lines.append(displacement - np.interp(0.0, at, displacement))
    return (at, lines[0]) if lines[0].any() and np.allclose(*lines) else None


def _together(identified: IdentifyResult, robot: CompliantRobot, joint: int) -> dict[str, tuple[float, float, bool]]:
    """Return component to (compliance, standard uncertainty, above the noise) by the fit of all joints at once."""
    by_name = {parameter.name: parameter for parameter in identified.parameters}
    result: dict[str, tuple[float, float, bool]] = {}
    for placed in robot.placed:
        for spec in placed.effect.parameters if placed.place.joints == (joint,) else ():
            parameter = by_name.get(placed.parameter_name(spec.symbol)) if spec.along is not None else None
            if spec.along is None or parameter is None or parameter.value is None or parameter.std is None:
                continue
            fitted = (parameter.value, parameter.std, bool(parameter.above_noise))
            result[COMPONENTS[spec.along]] = fitted
    return result
