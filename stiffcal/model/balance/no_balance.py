"""The fault of a robot that finds no balance: in which pose, under what, and which number is the likely cause.

A chain without balance is nearly always one number in the wrong unit: forces a thousand times too large, masses in g,
a centre of mass or a length in mm, a stiffness per mrad. What exceeds the largest robots there are is named; the
largest excess first.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.errors import Fault, InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.effect import Inputs
from stiffcal.wording import significant

# Beyond the largest robots that are built (2.3 t of payload, 12 t of own mass, 5 m of reach, links below 3 m).
FORCE_N = 1e5
MOMENT_NM = 1e5
LINK_MASS_KG = 1e4
LINK_LENGTH_M = 5.0
CENTRE_M = 3.0
# A joint that gives more than 1 rad under a wrist's own torque is no drive.
SOFTEST_NM_PER_RAD = 100.0


@dataclass(frozen=True)
class LikelyCause:
    """A number that is larger than on any robot."""

    excess: float
    """How many times larger."""
    file: str
    """The file that holds the number."""
    place: str
    """Its line or key in that file."""
    found: str
    """The number in words."""
    mend: str
    """What to write."""


class NoBalanceError(InputError):
    """The chain finds no rest: the load is beyond what the springs can hold (buckling), or a number has another unit.

    Attributes
    ----------
    state : index of the state that settles least, among those handed in.
    where : that state in words: a run, or the pose.
    """

    def __init__(self, reason: str, state: int = 0, where: str = "", suspect: LikelyCause | None = None) -> None:
        self.state = state
        self.where = where
        self._reason = reason
        self._suspect = suspect
        if suspect is None:
            mend = "check the stiffness in model.toml, the masses in robot.toml, and the unit of the forces"
            fault = Fault(FaultCode.NO_BALANCE, "model.toml", "effects", self._words, mend)
        else:
            fault = Fault(
                FaultCode.NO_BALANCE, suspect.file, suspect.place, f"{self._words}; {suspect.found}", suspect.mend
            )
        super().__init__(fault)

    @property
    def _words(self) -> str:
        where = f" in {self.where}" if self.where else ""
        return f"no equilibrium of the robot exists{where}, {self._reason}"

    def at_state(self, state: int, where: str = "") -> NoBalanceError:
        """Return the same fault with the state counted, and called, as the caller's user does."""
        return NoBalanceError(self._reason, state, where or self.where, self._suspect)

    def of_load(self, file: str, place: str, mend: str) -> InputError:
        """Return the fault of a load that the user has given elsewhere than in the logs.

        Where a mass, a length or a stiffness is the likely cause, that stays the fault.

        Parameters
        ----------
        file, place : where the load was given.
        mend : what to do about it.
        """
        if self._suspect is not None and self._suspect.place != "wrench":
            return self
        return InputError.at(FaultCode.NO_BALANCE, file, place, self._words, mend)


def no_balance(robot: CompliantRobot, inputs: Inputs, displacement: Floats, change: Floats) -> NoBalanceError:
    """Return the fault of states that do not settle.

    Parameters
    ----------
    robot : chain and effects.
    inputs : angles (J, n), wrench (6, n), set-up.
    displacement : (2J + 2, 6, n) of the nodes after the last sweep.
    change : (n,) by the last sweep, rad and m.
    """
    state = int(np.argmax(np.where(np.isfinite(change), change, np.inf)))
    force, moment = (
        float(np.linalg.norm(components)) for components in (inputs.wrench[:3, state], inputs.wrench[3:, state])
    )
    load_text = "under its weight alone"
    if inputs.wrench[:, state].any():
        load_text = f"under {significant(force)} N" + (
            f" and {significant(moment)} N·m" if inputs.setup.moments_measured else ""
        )
    turn = float(np.max(np.abs(displacement[:, 3:, state]), initial=0.0))
    turn_text = f"it rotates by {significant(turn)} rad" if np.isfinite(turn) else "its deflection grows without limit"
    # offsets, signs and couplings of joints stand between these and what a controller shows
    pose = robot.chain.position_words(inputs.angles[:, state])
    causes = list(_likely_causes(robot, inputs, force, moment))
    worst = max(causes, key=lambda suspect: suspect.excess, default=None)
    return NoBalanceError(f"{load_text}: {turn_text}", state, f"the pose ({pose}; positions of the model)", worst)


def _likely_causes(robot: CompliantRobot, inputs: Inputs, force: float, moment: float) -> Iterator[LikelyCause]:
    """Yield numbers that are larger than on any robot: loads, masses, lengths, compliances."""
    chain = robot.chain
    if inputs.loaded:
        if force > FORCE_N:
            mend = "if the log is in N or kN, state it in units.force; else correct the load"
            yield LikelyCause(
                force / FORCE_N,
                "campaign.toml",
                "wrench",
                f"{significant(force)} N exceeds the load of any robot",
                mend,
            )
        if moment > MOMENT_NM and inputs.setup.moments_measured:
            mend = "state the unit of the log in units.moment, e.g. N*mm; else correct the load"
            yield LikelyCause(
                moment / MOMENT_NM,
                "campaign.toml",
                "wrench",
                f"{significant(moment)} N·m exceeds the load of any robot",
                mend,
            )
    for k, joint in enumerate(chain.joint_names):
        place, mass, centre = f"joints ({joint})", float(chain.link_mass[k]), float(np.linalg.norm(chain.link_com[k]))
        length = float(np.linalg.norm(chain.fixed[k, :3, 3]))
        if mass > LINK_MASS_KG:
            mend = f"if it is in g, write {mass / 1e3:.6g}"
            yield LikelyCause(
                mass / LINK_MASS_KG, "robot.toml", f"{place}.link.mass_kg", f"{mass:.6g} kg in one link", mend
            )
        if centre > CENTRE_M:
            mend = "if com_m is in mm, divide it by 1000"
            evidence = f"the centre of mass is {significant(centre, 4)} m from the joint"
            yield LikelyCause(centre / CENTRE_M, "robot.toml", f"{place}.link.com_m", evidence, mend)
        if length > LINK_LENGTH_M:
            mend = "if the lengths are in mm, divide them by 1000"
            yield LikelyCause(
                length / LINK_LENGTH_M,
                "robot.toml",
                place,
                f"the link before it is {significant(length, 4)} m long",
                mend,
            )
    tool = inputs.setup.tool_mass
    if tool > LINK_MASS_KG:
        mend = f"if it is in g, write {tool / 1e3:.6g}"
        yield LikelyCause(tool / LINK_MASS_KG, "campaign.toml", "tool.mass_kg", f"{tool:.6g} kg of tool", mend)
    for placed in robot.placed:
        for parameter in placed.effect.parameters:
            if parameter.unit not in ("rad/(N·m)", "N·m/rad"):
                continue
            value = abs(placed.amplitude(parameter.symbol))
            if value > 1.0 / SOFTEST_NM_PER_RAD:
                name = placed.parameter_name(parameter.symbol)
                evidence = f"its stiffness is only {significant(1.0 / value)} N·m/rad"
                mend = "check its value, or the units of the deflections and loads that it was fitted to"
                yield LikelyCause(value * SOFTEST_NM_PER_RAD, "model.toml", f"parameters.{name}", evidence, mend)
