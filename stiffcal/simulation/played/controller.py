"""A controller that corrects: in runs with ``compensation = "on"`` it moves the joints against the deflection.

As the papers' do (001, Fig. 3; 002, Fig. 5): every cycle the force is filtered, the model's deflection found for it,
and the joint reference moved by −J⁺ D; the robot stands there after a delay. The controller's model is its own: by
default the drives alone, as in 002, whatever else the robot has.

What the corrections do to a frame is found where the run is solved, at the load that acts there; in between it goes in
proportion to the load, like the deflection itself, and filter and delay act on it in time. For corrections of
millimetres that is exact to micrometres.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.measurements.load_states import Attachment, MeasurementSetup
from stiffcal.mechanics.kinematics import jacobians
from stiffcal.mechanics.low_pass import LowPass
from stiffcal.mechanics.rotations import rotation_from_vector, vector_from_rotation
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.balance.equilibrium import solve_balance
from stiffcal.simulation.played.correction import Correction
from stiffcal.simulation.played.secant import SecantSteps
from stiffcal.simulation.played.true_motion import RestSolver, ToolWeight, TrueRun, solve_true_runs
from stiffcal.simulation.settings import FILE_NAME, Controller
from stiffcal.wording import significant

# The controller runs from before any log starts until after all have stopped, s.
_MARGIN_S = 5.0
# Settled: the corrections are those for the force that they lead to, to a millionth of the largest.
_SETTLED, _MOST_ROUNDS = 1e-6, 60


def controllers_model(robot: CompliantRobot, controller: Controller) -> CompliantRobot:
    """Return the controller's model of the robot.

    Raises
    ------
    InputError : the settings name an effect or a parameter that the robot does not have.
    """
    placed = tuple(placed_effect for placed_effect in robot.placed if placed_effect.effect.name in controller.effects)
    missing = [
        name for name in controller.effects if name not in {placed_effect.effect.name for placed_effect in placed}
    ]
    if missing:
        in_model = ", ".join(sorted({placed_effect.effect.name for placed_effect in robot.placed}))
        raise InputError.at(
            FaultCode.EFFECT_ABSENT,
            FILE_NAME,
            "controller.effects",
            f"the model file contains no {missing[0]}",
            f"it contains: {in_model}",
        )
    model = replace(robot, placed=placed)
    unknown = [name for name in controller.parameters if name not in model.values()]
    if unknown:
        reason = f"the controller's model has no {unknown[0]}"
        raise InputError.at(
            FaultCode.PARAMETER_UNKNOWN,
            FILE_NAME,
            "controller.parameters",
            reason,
            f"it has: {', '.join(model.values())}",
        )
    return model.with_values(controller.parameters)


def compensated(
    robot: CompliantRobot,
    true_run: Sequence[TrueRun],
    controller: Controller,
    frames: Mapping[str, Attachment],
    tool: ToolWeight,
    settle: RestSolver | None = None,
) -> list[TrueRun]:
    """Return runs as they go with the controller correcting.

    Parameters
    ----------
    robot : as it really is.
    true_run : the runs without correction.
    controller : its model, filter and delay.
    frames, tool, settle : as in `solve_true_runs`.

    Raises
    ------
    InputError : the controller's settings do not fit the robot, or no correction agrees with the force of a guide.
    """
    if not true_run:
        return []
    model = controllers_model(robot, controller)
    planned_runs = [off.planned for off in true_run]
    offsets = _concatenate_runs(_offsets(model, off, tool) for off in true_run)
    # Where a guide pushes a displaced tool back, the correction changes the force that it is made for.
    guided = any(planned.loads.guide_N_per_m > 0.0 for planned in planned_runs)
    steps = SecantSteps(np.ones(len(offsets)), offsets.shape[1])
    for _ in range(_MOST_ROUNDS):
        corrections = _by_run(true_run, offsets)
        on_runs = solve_true_runs(robot, planned_runs, frames, tool, settle, corrections)
        left = (
            _concatenate_runs(_offsets(model, on, tool) for on in on_runs) - offsets
            if guided
            else np.zeros_like(offsets)
        )
        if np.abs(left).max(initial=0.0) <= _SETTLED * np.abs(offsets).max(initial=0.0):
            break
        offsets = steps.step(offsets, left)
    else:
        raise InputError.at(
            FaultCode.NO_CONVERGENCE, FILE_NAME, "loads.guide_N_per_m",
            f"correction and side force of the guide do not converge: "
            f"{significant(np.abs(left).max(), 2)} rad remain after "
            f"{_MOST_ROUNDS} rounds",
            "lower guide_N_per_m, or simulate these runs without a correcting controller",
        )  # fmt: skip
    return [
        replace(
            off, wrench=on.wrench, correction=_in_time(off, on, corrections[off.planned.name], list(frames), controller)
        )
        for off, on in zip(true_run, on_runs, strict=True)
    ]


def _concatenate_runs(parts: Iterable[Floats]) -> Floats:
    """Return the runs' (s, L) joint offsets one below the other."""
    return np.concatenate(list(parts))


def _by_run(true_run: Sequence[TrueRun], offsets: Floats) -> dict[str, Floats]:
    """Return run to (s, L), the other way round."""
    ends = np.cumsum([run.node.size for run in true_run])[:-1]
    return {run.planned.name: run_offsets for run, run_offsets in zip(true_run, np.split(offsets, ends), strict=True)}


def _offsets(model: CompliantRobot, true_run: TrueRun, tool: ToolWeight) -> Floats:
    """Return (s, L) the joint offsets that the controller settles to at each solved place of a run.

    It keeps the frame that the load acts on, the tool, where the load found it.
    """
    point = true_run.planned.load_point
    setup = MeasurementSetup(
        wrench_axes=Attachment(0, np.eye(4)),
        wrench_point=point,
        targets=(point,),
        target_names=("tool",),
        moments_measured=True,
        tool_mass=tool.mass,
        tool_com=tool.com,
    )
    chain = model.chain
    wrench = true_run.wrench_at(true_run.node)
    angles = chain.model_angles(np.repeat(true_run.planned.joints[None], len(wrench), axis=0))
    displacement = solve_balance(model, angles, wrench, setup).displacement[:, 0]
    jacobian = jacobians(chain, angles[:1], point)[0] @ chain.coupling
    return np.asarray(-displacement @ np.linalg.pinv(jacobian, rcond=1e-3).T)


def _shift(off: TrueRun, on: TrueRun, frame: str) -> Floats:
    """Return (s, 6) how far the corrections move and turn a frame, base axes."""
    translation = on.position[frame] - off.position[frame]
    before, after = (
        rotation_from_vector(true_run.turn[frame]) @ true_run.unloaded[frame][:3, :3] for true_run in (off, on)
    )
    return np.concatenate([translation, vector_from_rotation(after @ np.swapaxes(before, 1, 2))], axis=1)


def _in_time(off: TrueRun, on: TrueRun, offset: Floats, names: Sequence[str], controller: Controller) -> Correction:
    """Return the correction over time: read each cycle, filtered, and carried out after the delay."""
    program = off.planned.program
    read_time = np.arange(-_MARGIN_S, program.duration + _MARGIN_S, controller.cycle_s)
    columns = np.concatenate([offset, *(_shift(off, on, name) for name in names)], axis=1)
    filtered = off.between(columns, program.path(read_time))
    if controller.filter_hz is not None:
        try:
            filtered = LowPass(controller.filter_hz, 1.0 / controller.cycle_s, filtered.shape[1]).run(filtered)
        except ValueError as error:
            raise InputError.at(
                FaultCode.VALUE_INVALID, FILE_NAME, "controller.filter_hz", str(error), "lower it, or shorten cycle_s"
            ) from error
    n_logged = offset.shape[1]
    shift = {name: filtered[:, n_logged + 6 * k : n_logged + 6 * k + 6] for k, name in enumerate(names)}
    return Correction(read_time + controller.delay_s, filtered[:, :n_logged], shift)
