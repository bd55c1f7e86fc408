"""Whether hidden effects act: one that moves nothing in the simulated runs cannot be found, and tests nothing."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.errors import Fault, raise_faults
from stiffcal.fault_codes import FaultCode
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.simulation.played.motion import MotionProgram
from stiffcal.simulation.played.true_motion import TrueRun
from stiffcal.simulation.settings import FILE_NAME

# m, rad, N·m: a hundred times what the balances are solved to, and far below what any instrument reads.
_NOTHING = 1e-10


def check_hidden(
    hidden: Sequence[str],
    robot: CompliantRobot,
    runs: Sequence[TrueRun],
    solve: Callable[[CompliantRobot], Sequence[TrueRun]],
) -> None:
    """Raise where a hidden effect changes nothing in any run.

    Parameters
    ----------
    hidden : names of effects of the robot.
    robot : with all of them.
    runs : where it really is.
    solve : returns the same of another robot.

    Raises
    ------
    InputError
        one fault for each effect that changes no place, no angle and no torque.
    """
    faults = []
    for name in hidden:
        without = replace(robot, placed=tuple(placed for placed in robot.placed if placed.effect.name != name))
        change = max(map(_largest_change, runs, solve(without)), default=0.0)
        if change < _NOTHING:
            reason = f"{name} changes nothing in the simulated runs, so that no search can find it"
            mend = (
                "give it a larger value in model.toml, or runs in which it acts"
                " (a law over temperature needs a temperature in campaign.toml and robot.warming_K_per_hour)"
            )
            faults.append(Fault(FaultCode.HIDDEN_INACTIVE, FILE_NAME, "robot.hidden", reason, mend))
    raise_faults(faults)


def _largest_change(run: TrueRun, other: TrueRun) -> float:
    """Return by how much two runs differ at most, m, rad or N·m; infinite where they were solved at other places."""
    pairs = zip(_arrays(run), _arrays(other), strict=True)
    return max((float(np.max(np.abs(a - b), initial=0.0)) if a.shape == b.shape else np.inf for a, b in pairs))


def _arrays(run: TrueRun) -> Iterator[Floats]:
    yield from run.position.values()
    yield from run.turn.values()
    yield np.zeros(0) if run.nodes is None else run.nodes
    program = run.planned.program
    if isinstance(program, MotionProgram):
        yield program.torque
        yield program.joints
