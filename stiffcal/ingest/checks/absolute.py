"""What absolute places measured so far say of each joint, and what more poses are needed for."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

import numpy as np

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.ingest.checks.results import CheckedJoint, CheckedNoise
from stiffcal.propose.noise import ENOUGH_PAIRS
from stiffcal.uncertainty import NORMAL_95, is_poorly_known
from stiffcal.wording import length, percent, significant

if TYPE_CHECKING:
    from stiffcal.campaign.loading import Campaign
    from stiffcal.estimation.parameters import Parameter
    from stiffcal.identification.answers.observability import ObservabilityIndices
    from stiffcal.identification.fitting.fit import Fit
    from stiffcal.measurements.load_states import LoadStates, MeasurementSetup
    from stiffcal.model.assembled.composite import CompliantRobot
    from stiffcal.reduction.states.raw_states import RawStates

MOST_NAMED = 6
"""Parameters that a sentence lists."""
SMALL_RANGE_DEG = 60.0
"""Range of a joint below which larger motions can be advised: a sixth of a turn; most joints can do several of them."""
FEW_POSES = 4
"""Rows from which on poses that are too few for the frames are poses too much alike."""
MOST_POSES = 10000
"""More poses are no advice: a robot takes one in ten seconds, so that these fill a day."""
NO_TORQUE_NM = 1e-3
"""A torque (prismatic: force, N) below this is what rounding and the tilt of an axis leave of none: no joint gives
measurably under it.
"""
ON_THE_AXIS = 5e-3
"""m, distance below which a target counts as on an axis: what a direction known no better than assembly moves it by."""


@dataclass(frozen=True)
class CheckedPlaces:
    """What absolute places determine."""

    joints: list[CheckedJoint]
    """How well weight and payload show each joint's stiffness."""
    missing: list[str]
    """What the poses leave open, in words."""
    observability: ObservabilityIndices | None = None
    """Indices of the poses; None where nothing could be fitted."""
    remarks: tuple[str, ...] = ()
    """What no poses would determine, in words."""
    noise: CheckedNoise | None = None
    """From what the noise is known; None where nothing could be fitted."""


def joints_from_places(campaign: Campaign, states: LoadStates) -> CheckedPlaces:
    """Return what the places measured so far determine, and what they leave open."""
    from stiffcal.identification.answers.observability import observability_of
    from stiffcal.identification.fitting.identify import identify_parameters
    from stiffcal.identification.fitting.not_fitted import is_not_fitted
    from stiffcal.model.balance.equilibrium import solve_balance
    from stiffcal.model.catalogue.campaign_effects import placed_robot

    robot = placed_robot(campaign)
    used = states.select(states.used)
    too_few = _too_few(robot, used)
    if too_few is not None:
        return CheckedPlaces([], [too_few])
    try:
        fit = identify_parameters(states, robot)
        angles = campaign.chain.model_angles(used.joints)
        torque = abs(solve_balance(fit.robot, angles, used.wrench, used.setup).joint_torque).max(axis=0)
    except InputError as error:
        if not is_not_fitted(error):
            raise
        return CheckedPlaces([], [str(error)])
    joints = [
        _joint(name, float(torque[number]), fit, number + 1) for number, name in enumerate(campaign.chain.joint_names)
    ]
    missing, remarks = _open_geometry(fit)
    return CheckedPlaces(joints, missing, observability_of(fit), remarks, _noise_of(fit))


def _noise_of(fit: Fit) -> CheckedNoise:
    """Return from what the noise of places is known, and what cannot be judged where it is not."""
    from stiffcal.identification.readings.repeated_places import repeated_places

    places = fit.data.subset(fit.data.absolute)
    n_pairs = sum(len(group) - 1 for group in repeated_places(places))
    rms = fit.noise_length["translation"] if fit.noise is not None else None
    source: Literal["manifest", "repeats", "none"] = "none"
    if fit.noise is not None and rms is not None:
        stated = fit.noise.source == "manifest" or fit.noise.absolute is not None
        source = "manifest" if stated else "repeats"
    pairs = f"{n_pairs} pair{'s' * (n_pairs != 1)} of rows that repeat each other"
    distance = "" if rms is None else f"{length(rms)} rms in distance"
    words = {
        "manifest": f"sigma of campaign.toml, {distance} (√3 times the standard uncertainty of one axis)",
        "repeats": f"estimated from {pairs if places.n_states == fit.data.n_states else 'repeated loads'}: {distance}",
        "none": (
            f"not known: campaign.toml states no sigma, and {pairs} are too few. Errors can then be compared with each "
            "other, but not with the noise: whether the model is good enough cannot be judged. State sigma of the "
            f"instrument (data sheet, per axis), or measure {ENOUGH_PAIRS} poses twice"
        ),
    }
    return CheckedNoise(source=source, n_pairs=n_pairs, rms_m=rms, says=f"noise: {words[source]}")


def poses_still_needed(campaign: Campaign, gathered: RawStates, error: InputError) -> list[str] | None:
    """Return what a campaign that is still being measured lacks, in words; None where `error` is a mistake in it.

    Parameters
    ----------
    gathered : the load states as they were read. error : what placing them was refused for.
    """
    from stiffcal.model.catalogue.campaign_effects import placed_robot

    if error.code is not FaultCode.POSES_TOO_FEW:
        return None
    measured = poses_without_frames(campaign, gathered)
    used = measured.select(measured.used & (measured.absolute | measured.reference))
    if len(used) >= FEW_POSES:  # enough rows, so that they are too much alike
        return None
    needed = [f"{error.place}: {error.reason}; {error.mend}"]
    too_few = _too_few(placed_robot(campaign), used) if used.absolute.any() else None
    return needed + ([too_few] if too_few is not None else [])


def poses_without_frames(campaign: Campaign, gathered: RawStates) -> LoadStates:
    """Return load states with the frames as the manifest has them, whether they are to be estimated or not."""
    from stiffcal.campaign.frames.frames import measurement_setup, resolve_frames
    from stiffcal.reduction.states.load_states import load_states

    setup = measurement_setup(campaign.manifest, campaign.chain, resolve_frames(campaign.manifest, campaign.chain))
    return load_states(gathered, campaign.manifest, campaign.chain, setup)


def _too_few(robot: CompliantRobot, used: LoadStates) -> str | None:
    """Return in words that the readings are fewer than the numbers that poses can determine; None where they are not.

    Twice as many readings as numbers are what is asked for; with fewer readings than numbers nothing is fitted.
    """
    from stiffcal.identification.fitting.gauge import redundant_geometry
    from stiffcal.identification.readings.observations import observe

    conventions = redundant_geometry(robot, observe(used, robot.chain), frozenset())
    n_numbers = sum(
        not spec.discrete and placed.parameter_name(spec.symbol) not in conventions
        for placed in robot.placed
        for spec in placed.effect.parameters
    )
    n_readings = int(np.isfinite(used.position).sum()) + 3 * int(np.isfinite(used.rotation).all(axis=(2, 3)).sum())
    if n_readings >= n_numbers:
        return None
    per_pose = n_readings / max(len(used), 1) or 3.0
    n_poses = f"{len(used)} pose{'s are' if len(used) != 1 else ' is'}"
    least = math.ceil(2.0 * n_numbers / per_pose)
    kept = f" ({len(conventions)} more are conventions and not estimated)" if conventions else ""
    return f"{n_poses} too few for the {n_numbers} numbers of the model{kept}: measure {least} or more"


def _joint(name: str, torque: float, fit: Fit, number: int) -> CheckedJoint:
    """Return what is known of a joint's compliance about its axis, of a prismatic joint along it."""
    chain = fit.robot.chain
    prismatic = bool(chain.prismatic[number - 1])
    load, axis = ("force", "along its axis") if prismatic else ("torque", "about its axis")
    own = [
        parameter
        for parameter in fit.parameters
        if parameter.spec.compliance
        and parameter.place.joints == (number,)
        and parameter.spec.along == chain.drive_components[number - 1]
    ]
    if not own:
        relative, text = None, f"the model contains no compliance {axis}"
    elif own[0].value is None:
        what = (
            f"weight produces no {load} on it"
            if fit.data.absolute.all()
            else f"neither weight nor load produces {load} on it"
        )
        if torque > NO_TORQUE_NM:
            what = f"what its {load} does cannot be distinguished from errors of geometry and frames"
        relative, text = None, f"{what} in these poses: its stiffness cannot be identified from them"
    elif not own[0].value or own[0].std is None:
        relative, text = None, "no compliance shows in these poses"
    else:
        relative = own[0].std / own[0].value
        half_width = 100.0 * NORMAL_95 * relative
        known = f"expected uncertainty about ± {significant(half_width, 2)} % (95 %)"
        text = f"poorly determined, ± {half_width:.0f} % (95 %)" if is_poorly_known(1.0, relative) else known
    if own and fit.data.absolute.all() and (relative is None or is_poorly_known(1.0, relative)):
        text += _what_would_show(fit, number, own[0], relative)
    return CheckedJoint(
        joint=name,
        largest_torque_Nm=torque,
        expected_relative_std=relative,
        says=text,
        prismatic=True if prismatic else None,
    )


def _what_would_show(fit: Fit, number: int, own: Parameter, relative: float | None) -> str:
    """Return how many such poses, or which payload, give a joint's compliance to 20 %, as the end of a line.

    Parameters
    ----------
    own : the joint's compliance about its axis. relative : its standard uncertainty, of its value; None: not known.
    """
    from stiffcal.validation.elasticity import KNOWN, expected_compliance, payload_that_shows

    mass = payload_that_shows(fit, number, expected_compliance(own, fit))
    ways = []
    if relative is not None:
        poses = fit.data.n_measured * (KNOWN * relative) ** 2
        ways += [f"about {significant(poses, 2)} such poses in all"] if poses <= MOST_POSES else []
    ways += [f"{significant(mass, 2)} kg at the flange in half of the poses"] if mass is not None else []
    return f"; {' or '.join(ways)} would give ± {percent(NORMAL_95 / KNOWN)} or better" if ways else ""


def _open_geometry(fit: Fit) -> tuple[list[str], tuple[str, ...]]:
    """Return what poses leave open that other poses would determine, and what the target's place on the axis does.

    Each is one line, or none. What a target on the last axis leaves open belongs to the frames, as the last zero does:
    a turn of the axis and a shift are one motion of such a target, in whatever pose.
    """
    from stiffcal.identification.fitting.gauge import held_frames, redundant_geometry

    held = held_frames(fit.robot, fit.data, frozenset())
    redundant = held | redundant_geometry(fit.robot, fit.data, held)
    of_frames = redundant_geometry(fit.robot, replace(fit.data, setup=_on_the_axis(fit)), held)
    # compliances have lines of their own, as what takes part in a set with one is known but for it; and what is known
    # beforehand is needed no better
    elsewhere = {p.name for p in fit.parameters if p.spec.compliance or p.spec.prior is not None}
    open_names: list[str] = []
    on_the_axis: list[str] = []
    for ambiguity in fit.ambiguities:
        names = list(ambiguity.names)
        left = [name for name in names if name not in of_frames]
        if not elsewhere.isdisjoint(names) or (len(names) == 1 and names[0] in redundant):
            continue
        if len(left) > 1 or left == names:
            open_names += names
        elif not redundant.issuperset(names):
            on_the_axis.append(" and ".join(names))
    missing = []
    open_names = list(dict.fromkeys(open_names))
    if open_names:
        more = f" and {len(open_names) - MOST_NAMED} more" if len(open_names) > MOST_NAMED else ""
        names_text = f"{', '.join(open_names[:MOST_NAMED])}{more}"
        missing = [f"these poses do not determine {names_text}: {_how_to_determine(fit)}"]
    last = fit.robot.chain.n_joints
    remark = (
        f"the target is on the axis of joint {last}: no poses separate {', '.join(on_the_axis)}. They are included in "
        f"the frames, as the last zero is; only a target away from that axis separates them"
    )
    return missing, (remark,) if on_the_axis else ()


def _how_to_determine(fit: Fit) -> str:
    """Return what to do about geometry that is open: larger motions only of joints whose ranges are small."""
    spans = np.rad2deg(np.ptp(fit.data.angles, axis=1))
    turning = [k for k in range(fit.robot.chain.n_joints) if k + 1 not in fit.robot.chain.prismatic_joints]
    small = [f"joint {k + 1} (now {spans[k]:.0f}°)" for k in turning if spans[k] < SMALL_RANGE_DEG]
    if small:
        return f"measure poses with larger motions of {', '.join(small)}"
    return "fix them in model.toml, value = 0.0 with fixed = true, or add another target"


def _on_the_axis(fit: Fit) -> MeasurementSetup:
    """Return the set-up with targets that are within assembly tolerance of the last joint's axis put on it."""
    chain, setup = fit.robot.chain, fit.data.setup
    moved = []
    for target in setup.targets:
        from_joint = {chain.n_joints: np.eye(4), chain.n_joints + 1: chain.flange}.get(target.body)
        place = None if from_joint is None else from_joint @ target.transform
        if from_joint is None or place is None or np.hypot(*place[:2, 3]) > ON_THE_AXIS:
            moved.append(target)
            continue
        place[:2, 3] = 0.0
        moved.append(replace(target, transform=np.linalg.solve(from_joint, place)))
    return replace(setup, targets=tuple(moved))
