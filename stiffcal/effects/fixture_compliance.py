"""Give of the fixture that holds a clamped robot."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.measurements.load_states import LoadStates, members_of
from stiffcal.mechanics.chain import Chain
from stiffcal.model.effect import Instrument, Observed, ParameterSpec, Place, Values
from stiffcal.model.held_frame import HeldFrame, held_frame

_SOURCE = "a welded steel stand: some 100 N/µm and 10⁷ N·m/rad"
# What of the fixture's columns joint compliance leaves over, as a share: less is the same thing.
LEAST_DIFFERENT = 0.01


class FixtureCompliance(Instrument):
    """The fixture of a clamped robot is compliant, and the motors rotate by a corresponding additional angle.

    Law: D = −C W, the motion of the held frame, with W what the fixture does to the robot and C = diag(translation,
    rotation), each the same along and about all three axes, about the origin of the held frame. The closed chain of
    clamped motors then reads J (Δd_motor + δ) = −C W (Lehmann et al. 2013 take the fixture as rigid). It comes on top
    of what the manifest gives as the run's fixture_compliance.

    Assumes one fixture for all clamped runs, without play.

    Limits: it turns the motors in proportion to the load, as joint-compliance does. They differ where several joints
    load the same fixture, or one joint loads it with different lever arms.
    """

    name = "fixture-compliance"
    place_kind = "setup"
    in_drive = True
    summary = "compliance of the fixture of a clamped robot"
    parameters = (
        ParameterSpec(
            "translation", "m/N", "compliance along each axis", 0.0, 1e-3, 1e-8, _SOURCE, compliance=True
        ),
        ParameterSpec(
            "rotation", "rad/(N·m)", "compliance about each axis", 0.0, 1e-2, 1e-7, _SOURCE, compliance=True
        ),
    )  # fmt: skip
    needs = ("clamped runs of several joints, or of one joint in poses with different lever arms",)
    looks_like = ("joint-compliance", "base-compliance", "tool-compliance")
    fingerprint = "all joints appear softer in clamped runs, more so with a longer lever arm to the fixture"
    how_to_check = "Mount a dial indicator between fixture and floor, and read it while a joint pushes back and forth."

    def lacking(self, chain: Chain, states: LoadStates) -> str | None:
        """Clamped runs in which it does something else than the joints' compliance."""
        held = held_frame(chain, states)
        if held is None:
            return "clamped runs: there is no fixture in other runs"
        if _is_joint_compliance(chain, states, held):
            return (
                "clamped runs of several joints, or with different lever arms: in these it cannot be separated "
                "from joint-compliance"
            )
        return None

    def observation_columns(self, place: Place, observed: Observed, shape: Values) -> dict[str, Floats]:
        """Return the share of the held frame's motion that the fixture takes up, per unit of each compliance."""
        columns = {symbol: np.zeros_like(observed.displacement) for symbol in ("translation", "rotation")}
        held = observed.held
        if held is not None:
            # The rows count what gives between motor and flange, J δ = −J Δd_motor − C_given W: D = −C W adds C W.
            wrench = np.nan_to_num(held.wrench)
            columns["translation"][held.target, :3] = wrench[:3]
            columns["rotation"][held.target, 3:] = wrench[3:]
        return columns


def _is_joint_compliance(chain: Chain, states: LoadStates, held: HeldFrame) -> bool:
    """Return whether drive by drive the fixture's columns are a constant times the drive's torque."""
    clamped = np.flatnonzero(states.clamped)
    wrench = np.nan_to_num(held.wrench)
    drives = np.einsum("ijn,jk->ikn", held.jacobian, np.linalg.inv(chain.coupling) @ chain.drive_axes)
    torque = np.einsum("ikn,in->kn", drives, wrench)[:, clamped]
    for axes in (slice(0, 3), slice(3, 6)):
        column = np.einsum("kin,in->kn", held.inverse[:, axes], wrench[axes])[:, clamped]
        for members in members_of(states.run[clamped]):
            # Each run has an offset of its own.
            column[:, members] -= column[:, members].mean(axis=1, keepdims=True)
        for members in members_of(states.run[clamped]) if axes.start == 0 else ():
            torque[:, members] -= torque[:, members].mean(axis=1, keepdims=True)
        share = (column * torque).sum(axis=1) / np.maximum((torque**2).sum(axis=1), 1e-300)
        different = column - share[:, None] * torque
        if np.sum(different**2) > LEAST_DIFFERENT**2 * np.sum(column**2):
            return False
    return True
