"""Runs of a clamped robot that could be measured: fixtures, and the joint that is driven against each."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.campaign.loading import Campaign
from stiffcal.campaign.plan_file import PLAN_FILE, PlanFile
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.limits import PLANNED
from stiffcal.planning.campaign.model import PlanModel, checked_balance
from stiffcal.planning.campaign.pairs import FEWER, Candidates

# To and fro, of the largest turn of the motor: play, knees and a memory show on the way through zero and back.
CYCLE = (0.25, 0.5, 1.0, 0.5, 0.25, 0.0, -0.25, -0.5, -1.0, -0.5, -0.25, 0.0)
# No drive is turned farther against a fixture, rad.
MOST_TURN = 0.02
FIXTURES = "fixtures"


def clamped_runs(campaign: Campaign, plan: PlanFile, model: PlanModel, poses: Floats) -> Candidates:
    """Return every driven joint in every fixture, each cycle up to the largest force or moment that is allowed.

    Parameters
    ----------
    poses : (n, L) possible poses, rad: where plan.toml names no fixture, one could stand at each.

    Raises
    ------
    InputError : neither force nor moment is limited, or the moment alone limits a turn and is not; or a fixture has
        another number of joints.
    """
    load = plan.load
    if load.force_N is None and load.moment_Nm is None:
        reason, mend = "neither force nor moment at the fixture is limited", "add [load] with force_N and moment_Nm"
        raise InputError.at(FaultCode.KEY_MISSING, PLAN_FILE, "load.force_N", reason, mend)
    joints = _fixtures(campaign, plan) if plan.fixtures else poses
    cycle = np.array([*load.steps] or [*CYCLE])
    if not cycle.any():
        mend = "write shares of the largest turn, as [0.5, 1.0, 0.0, -1.0]"
        raise InputError.at(FaultCode.VALUE_INVALID, PLAN_FILE, "load.steps", "all steps are unloaded", mend)
    cycle = np.tile(cycle, load.cycles)
    jacobian, per_radian = _wrench_per_radian(model, joints)
    n, n_joints = len(joints), jacobian.shape[2]
    PLANNED.check(n * n_joints * len(cycle), PLAN_FILE, "candidates", FEWER)
    force, moment = (np.linalg.norm(per_radian[:, :, part], axis=2) for part in (slice(0, 3), slice(3, 6)))
    largest = np.full((n, n_joints), MOST_TURN)
    for limit, size in ((load.force_N, force), (load.moment_Nm, moment)):
        if limit is not None:
            largest = np.minimum(largest, limit / np.maximum(size, 1e-12))
    if load.moment_Nm is None and np.all(largest == MOST_TURN):
        reason = "no force at the fixture limits how far a motor turns: the joints load it with moments alone"
        raise InputError.at(FaultCode.KEY_MISSING, PLAN_FILE, "load.moment_Nm", reason, "add moment_Nm to [load]")
    turn = np.zeros((n, n_joints, len(cycle), n_joints))
    for joint in range(n_joints):
        turn[:, joint, :, joint] = largest[:, joint, None] * cycle
    wrench = (largest[:, :, None] * cycle)[:, :, :, None] * per_radian[:, :, None]
    return Candidates(
        np.repeat(joints, n_joints, axis=0), wrench.reshape(-1, len(cycle), 6), turn.reshape(-1, len(cycle), n_joints)
    )


def _fixtures(campaign: Campaign, plan: PlanFile) -> Floats:
    names = campaign.chain.joint_names
    for number, fixture in enumerate(plan.fixtures, start=1):
        if len(fixture.joints_deg) != len(names):
            reason = f"{len(fixture.joints_deg)} angles, and {len(names)} joints are logged"
            mend = f"write the angles of {', '.join(names)} with which the flange is clamped there"
            raise InputError.at(FaultCode.JOINT_COUNT, PLAN_FILE, f"fixtures {number}", reason, mend)
    return np.asarray(np.radians(np.array([fixture.joints_deg for fixture in plan.fixtures])), dtype=np.float64)


def _wrench_per_radian(model: PlanModel, joints: Floats) -> tuple[Floats, Floats]:
    """Return (n, 6, L) how the flange would follow the joints, and (n, L, 6) the wrench per radian of each motor.

    The motor's turn is shared by the robot's compliance C alone, the fixture being stiff: W = −C⁻¹ J Δd.
    """
    from stiffcal.compensation.prediction import cartesian_compliance
    from stiffcal.mechanics.clamped_inverse import clamped_inverse
    from stiffcal.model.balance.equilibrium import solve_balance

    chain = model.robot.chain
    springs = tuple(
        placed
        for placed in model.robot.placed
        if any(spec.compliance for spec in placed.effect.parameters) and not placed.has_memory
    )
    robot = replace(model.robot, placed=springs or model.robot.placed, deformed=False)
    angles, rest = chain.model_angles(joints), np.zeros((len(joints), 6))
    compliance = checked_balance(
        lambda: cartesian_compliance(robot, angles, rest, model.setup, solve_balance(robot, angles, rest, model.setup))
    )
    logged = np.linalg.inv(chain.drive_axes) @ chain.coupling
    jacobian = np.stack([clamped_inverse(chain, pose[None], model.setup.targets[0])[1] @ logged for pose in angles])
    # a model of fewer than six springs lets some motions go free: no wrench arises there
    per_radian = -np.linalg.pinv(compliance, rcond=1e-9, hermitian=True) @ jacobian
    return jacobian, np.swapaxes(per_radian, 1, 2)
