"""One robot's compensation as numbers, for code that runs in its controller: what `CompensationStep` computes with."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Floats
from stiffcal.compensation.exports.step import StepSettings
from stiffcal.compensation.linear_nodes import linear_nodes, node_chain
from stiffcal.compensation.tool_weight import reading_filter, tool_in_reading
from stiffcal.measurements.load_states import MeasurementSetup
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.scalar_laws import BalancingSpring, ScalarLaw


@dataclass(frozen=True)
class ControllerModel:
    """The numbers of one robot, N nodes, J model joints, L logged angles; SI, frames as in `NodeChain`."""

    fixed: Floats
    """(N, 4, 4) from the displaced frame before to the node's own, its joint at zero."""
    joint: NDArray[np.int64]
    """(N,) joint that turns before the node, from 0; −1: none."""
    mass: Floats
    """(N,) kg."""
    mass_moment: Floats
    """(N, 3) kg·m."""
    gravity: Floats
    """(3,) m/s², base axes."""
    compliance: Floats
    """(6 N, 6 N) node axes."""
    laws: tuple[ScalarLaw, ...]
    """Their weights name nodes by their row here, 0 … N − 1."""
    springs: tuple[BalancingSpring, ...]
    """Balancing springs."""
    coupling: Floats
    """(J, L)."""
    offset: Floats
    """(J,) rad."""
    limits: Floats
    """(L, 2) rad."""
    axes_node: int
    """Node that the reading's axes move with; −1: the ground."""
    axes: Floats
    """(3, 3) node_from_reading."""
    load_node: int
    """Node that the load point moves with."""
    load_point: Floats
    """(3,) m."""
    target_node: int
    """Node that the target moves with."""
    target: Floats
    """(3,) m."""
    moments: bool
    """Whether the reading's moments count."""
    deformed: bool
    """False for the first-order form."""
    filter_b: Floats
    """(3,) numerator of the low-pass."""
    filter_a: Floats
    """(2,) its denominator after the leading 1."""
    tool: Floats
    """(6, 3) the tool's weight in the reading over gravity in the reading's axes."""
    zeroed: Floats
    """(6,) what of it was zeroed."""
    sweeps: int
    """In each call."""
    damping: float
    """m/rad."""
    largest: float
    """rad, of an offset."""
    joint_names: tuple[str, ...]
    """Of the logged angles, L of them."""
    cycle_s: float
    """s, between two calls."""
    left_out: tuple[str, ...]
    """Effects of the model that the loop does not compute."""
    prismatic: tuple[int, ...] = ()
    """Model joints, from 0, that move along their axis: their angles and offsets are m."""

    @property
    def hash(self) -> str:
        """SHA-256 of all numbers that the loop computes with, 64 hexadecimal digits."""
        digest = hashlib.sha256()
        for entry in fields(self):
            value = getattr(self, entry.name)
            if entry.name == "prismatic" and not value:
                continue  # as before there were any
            text = np.array2string(value, threshold=value.size + 1, floatmode="unique") if _is_array(value) else value
            digest.update(f"{entry.name}={text}\n".encode())
        return digest.hexdigest()


def _is_array(value: object) -> bool:
    return isinstance(value, np.ndarray)


def controller_model(
    robot: CompliantRobot, setup: MeasurementSetup, settings: StepSettings | None = None
) -> ControllerModel:
    """Return the numbers of a robot's compensation.

    Parameters
    ----------
    robot, setup, settings : as of `CompensationStep`.

    Raises
    ------
    ValueError : as of `CompensationStep`; or load point or target is fixed to the ground.
    """
    settings = settings or StepSettings()
    nodes = linear_nodes(robot, setup, settings.leave_out, with_laws=True)
    chain = robot.adjusted_chain
    row = node_chain(chain, nodes)
    sensor = nodes.setup.wrench_axes
    axes_node, axes = (-1, sensor.transform) if sensor.body == 0 else row.placed(sensor)
    load_node, load = row.placed(nodes.setup.wrench_point)
    target_node, target = row.placed(nodes.setup.targets[0])
    if load_node < 0 or target_node < 0:
        raise ValueError("the load point and the target of a compensation move with the robot; here one is fixed")
    index = {node: number for number, node in enumerate(nodes.nodes)}
    laws = tuple(
        ScalarLaw(law.form, law.numbers, tuple((index[node], axis, f) for node, axis, f in law.weights), law.joint)
        for law in nodes.laws
    )
    b, a = reading_filter(settings.cutoff_hz, settings.cycle_s)
    tool, zeroed = tool_in_reading(
        chain, nodes.setup, settings.tool_mass, np.array(settings.tool_com), settings.zeroed_at
    )
    return ControllerModel(
        fixed=row.fixed,
        joint=row.joint,
        mass=row.mass,
        mass_moment=row.mass_moment,
        gravity=chain.gravity,
        compliance=nodes.compliance,
        laws=laws,
        springs=nodes.springs,
        coupling=chain.coupling,
        offset=chain.offset,
        limits=chain.limits,
        axes_node=axes_node,
        axes=axes[:3, :3],
        load_node=load_node,
        load_point=load[:3, 3],
        target_node=target_node,
        target=target[:3, 3],
        moments=nodes.setup.moments_measured,
        deformed=nodes.deformed,
        filter_b=b,
        filter_a=a,
        tool=tool,
        zeroed=zeroed,
        sweeps=settings.sweeps,
        damping=settings.damping,
        largest=settings.largest_correction,
        joint_names=chain.joint_names,
        cycle_s=settings.cycle_s,
        left_out=nodes.left_out,
        prismatic=tuple(int(joint) for joint in np.flatnonzero(chain.prismatic)),
    )
