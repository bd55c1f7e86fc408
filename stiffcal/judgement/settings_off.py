"""Settings that the data may contradict: a parameter that is held, the first-order balance, a frame, a tool left out.

Each is a member as an effect is: what the readings would change by if it were otherwise. A fixed parameter may be off
by as much as parameters of its kind differ between robots, a frame by as much as frames are registered to.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.diagnosis.answers.setting_results import SettingKind
from stiffcal.identification.derivatives.observation import Observations
from stiffcal.identification.noise.weights import predict_observations
from stiffcal.judgement.evidence import MemberColumns
from stiffcal.judgement.ground import columns_of
from stiffcal.judgement.ground_of_states import GroundOfStates
from stiffcal.judgement.numbers import DIFFERENCE_STEP, LEVER_OF_TOOL, SIZE_WEIGHTS, SIZES, TOOL_SIZES
from stiffcal.judgement.priors import RobotScale
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.assembled.measured_frames import placed_frame
from stiffcal.model.balance.no_balance import NoBalanceError


@dataclass(frozen=True)
class SettingOff:
    """A setting that may be wrong."""

    kind: SettingKind
    """What is set."""
    name: str
    """Full name of the fixed parameter, ``frame.NAME`` of a frame; "" of the balance."""

    @property
    def label(self) -> str:
        """In words, unlike all others."""
        return f"{self.kind.value} {self.name}".rstrip()


@dataclass(frozen=True)
class GivenSettings:
    """What a model file and a manifest set."""

    fixed: dict[str, float]
    """Amplitudes of fixed parameters by full name."""
    first_order: bool
    """Whether loads act on the undeformed robot."""
    frames: tuple[PlacedEffect, ...]
    """Frames of tracker and targets that are given and not estimated."""
    of_tool: Floats | None = None
    """(4, m, n) how the readings change with mass and first moment of the link that carries the tool; None where every
    hypothesis has its weight, and where a tool is stated."""

    @classmethod
    def of(cls, model: CompliantRobot, fixed: frozenset[str], data: Observations) -> GivenSettings:
        """Return those of a model."""
        amplitudes = {
            placed.parameter_name(spec.symbol): placed.amplitude(spec.symbol)
            for placed in model.placed
            for spec in placed.effect.parameters
            if spec.symbol in placed.values
        }
        known = {name: amplitudes[name] for name in sorted(fixed) if name in amplitudes}
        return cls(known, not model.deformed, given_frames(model, data))

    def listed(self) -> Iterator[SettingOff]:
        """Give each setting."""
        for name in self.fixed:
            yield SettingOff(SettingKind.FIXED, name)
        if self.first_order:
            yield SettingOff(SettingKind.BALANCE, "")
        for frame in self.frames:
            yield SettingOff(SettingKind.FRAME, frame_name(frame))
        if self.of_tool is not None:
            yield SettingOff(SettingKind.TOOL, "")


def frame_name(frame: PlacedEffect) -> str:
    """Return ``frame.NAME``."""
    return f"{frame.effect.name}.{frame.place.frame}"


def given_frames(robot: CompliantRobot, data: Observations) -> tuple[PlacedEffect, ...]:
    """Return the frames of tracker and targets that the manifest gives, as parts of a model of absolute places.

    None where load states are fitted too: their displacements depend on the tracker's turn, which its frame leaves out.
    The position of a single target on the flange is target-offset.
    """
    if not data.absolute.all():
        return ()
    found, setup = {placed.place.frame for placed in robot.placed}, data.setup
    turned = {int(body) for body in data.body[data.rotational]}
    targets = {name: number in turned for number, name in enumerate(setup.target_names)}
    if len(targets) == 1 and not turned and setup.targets[0].body == robot.chain.n_joints + 1:
        targets = {}
    names = {tracker.frame: True for tracker in setup.trackers if tracker.frame} | targets
    return tuple(placed_frame(name, with_turn) for name, with_turn in names.items() if name not in found)


def setting_columns(
    ground: GroundOfStates, setting: SettingOff, given: GivenSettings, scale: RobotScale
) -> MemberColumns | None:
    """Return what the readings change by if a setting were otherwise, in typical sizes; None where they do not.

    Parameters
    ----------
    ground : of a model, in which the setting may have been changed.
    given : all settings. scale : of the robot.
    """
    robot, data = ground.state.robot, ground.space.data
    if setting.kind is SettingKind.FRAME:
        frame = next(one for one in given.frames if frame_name(one) == setting.name)
        columns = columns_of(ground, ground.state.regressor(frame.effect, frame.place, {}), scale)
        return replace(columns, any_of_them=True) if columns.rows.any() else None
    if setting.kind is SettingKind.TOOL:
        return _of_tool(ground, given)
    try:
        if setting.kind is SettingKind.BALANCE:
            straight, bent = (predict_observations(replace(robot, deformed=bent), data) for bent in (False, True))
            rows = ground.space.rows((bent - straight)[None])
            one = np.ones(1)
            present = one if robot.deformed else np.zeros(0)
            return MemberColumns(rows, np.ones(1, dtype=np.bool_), one, one, present=present) if rows.any() else None
        return _of_parameter(ground, setting.name, given.fixed[setting.name], scale)
    except NoBalanceError:
        return None


def _of_tool(ground: GroundOfStates, given: GivenSettings) -> MemberColumns | None:
    """Return what a tool that is not stated makes, of up to the weight that the largest force is."""
    assert given.of_tool is not None
    gravity = float(np.linalg.norm(ground.state.robot.chain.gravity))
    payload = np.abs(ground.space.data.wrench[:3]).max(initial=0.0) / max(gravity, 1e-3)
    rows = ground.space.rows(given.of_tool * payload) * np.array([1.0, *[LEVER_OF_TOOL] * 3])[:, None]
    even = np.full(len(TOOL_SIZES), 1.0 / len(TOOL_SIZES))
    # what is carried has no negative mass
    positive = np.array([True, False, False, False])
    return MemberColumns(rows, positive, TOOL_SIZES, even) if rows.any() else None


def _of_parameter(ground: GroundOfStates, name: str, fixed_at: float, scale: RobotScale) -> MemberColumns | None:
    robot, data = ground.state.robot, ground.space.data
    placed, spec = next(
        (placed, spec)
        for placed in robot.placed
        for spec in placed.effect.parameters
        if placed.parameter_name(spec.symbol) == name
    )
    now, typical = placed.amplitude(spec.symbol), scale.typical(placed.effect, placed.place, spec.symbol)
    other = robot.with_values({name: spec.value_of(now + DIFFERENCE_STEP * typical)})
    moved: Floats = (predict_observations(other, data) - predict_observations(robot, data)) / DIFFERENCE_STEP
    rows = ground.space.rows(moved[None])
    if not rows.any():
        return None
    present = np.array([(now - fixed_at) / typical]) if now != fixed_at else np.zeros(0)
    return MemberColumns(rows, np.zeros(1, dtype=np.bool_), SIZES, SIZE_WEIGHTS, present=present)


def changed_model(robot: CompliantRobot, settings: tuple[SettingOff, ...], given: GivenSettings) -> CompliantRobot:
    """Return a robot with some settings changed; parameters are freed in how fits are made."""
    kinds = {one.kind for one in settings}
    names = {one.name for one in settings if one.kind is SettingKind.FRAME}
    frames = tuple(frame for frame in given.frames if frame_name(frame) in names)
    deformed = robot.deformed or SettingKind.BALANCE in kinds
    return replace(robot, placed=(*frames, *robot.placed), deformed=deformed)


def freed(settings: tuple[SettingOff, ...]) -> frozenset[str]:
    """Return the full names of parameters that are no longer fixed."""
    return frozenset(one.name for one in settings if one.kind is SettingKind.FIXED)
