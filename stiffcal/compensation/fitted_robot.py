"""A campaign's robot with values, for the commands that use the model: predict, map, compensate."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stiffcal.campaign.loading import Campaign
from stiffcal.campaign.signals.signals import DeadWeight, Wrench
from stiffcal.errors import InputError
from stiffcal.escapes.shell import command_line
from stiffcal.fault_codes import FaultCode
from stiffcal.model.assembled.measured_frames import FramePosition, with_found_frames
from stiffcal.model.catalogue.campaign_effects import free_names, placed_robot
from stiffcal.wording import angle, length

if TYPE_CHECKING:
    from stiffcal.measurements.load_states import Attachment, MeasurementSetup
    from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
    from stiffcal.results.identify_result import IdentifyResult

# A fit that misses by so many times the noise lacks something; its own offsets draw a complete one a little below 1.
_BEYOND_NOISE = 1.2


@dataclass(frozen=True)
class FittedRobot:
    """A robot with values, and how well they are known."""

    campaign: Campaign
    """The folder's three files."""
    robot: CompliantRobot
    """Chain and effects, every parameter with a value; without frames, which ``setup`` holds."""
    setup: MeasurementSetup
    """Where the instruments sit; estimated frames where the fit has found them."""
    covariance: dict[str, dict[str, float]]
    """Of the robot's parameters that were fitted, by full names; empty where the values are the model file's."""
    source: str
    """Where the values are from, in words."""
    cautions: tuple[str, ...] = ()
    """What the fit cannot promise, in words."""
    link_compliances: dict[str, NDArray[np.float64]] = field(default_factory=dict)
    """(6, 6) by link, as the link's rods gave it, beam axes, NaN where not known; empty without rods."""
    targets: tuple[PlacedEffect, ...] = ()
    """The targets whose frames were fitted with the robot, at 0: their values are in ``setup``."""
    covariance_with_targets: dict[str, dict[str, float]] = field(default_factory=dict)
    """``covariance`` with the parameters of ``targets``."""
    known_from_below: tuple[str, ...] = ()
    """What a file of plain numbers cannot hold of stiffnesses that are not significant, in words; empty of none."""

    @property
    def warnings(self) -> tuple[str, ...]:
        """What a reader of the numbers must know."""
        sentences = []
        if self.source == "model.toml":
            sentences.append("the values are those of model.toml, taken as exact: without uncertainty")
        if not self.campaign.chain.masses_known and self.robot.deformed:
            sentences.append("robot.toml gives no masses: the sag under weight is left out")
        return (*sentences, *self.cautions)

    @property
    def load_point_notes(self) -> tuple[str, ...]:
        """Where given forces act, in words, if campaign.toml has no load that states it; else empty."""
        signals = [signal for _, _, signal in self.campaign.manifest.signals()]
        if any(isinstance(signal, Wrench | DeadWeight) for signal in signals):
            return ()
        return ("campaign.toml has no load: given forces act at the origin of the flange",)

    def frame(self, name: str, option: str) -> Attachment:
        """Return the body of the robot that a frame is fixed on, and its pose there.

        Parameters
        ----------
        name : the frame's name in campaign.toml.
        option : the command-line option that named it, for the message.

        Raises
        ------
        InputError : there is no such frame.
        """
        from stiffcal.campaign.frames.frames import resolve_frames

        if name in self.setup.target_names:
            return self.setup.targets[self.setup.target_names.index(name)]
        frames = resolve_frames(self.campaign.manifest, self.campaign.chain)
        if name not in frames:
            raise InputError.at(
                FaultCode.FRAME_UNKNOWN,
                "command line",
                option,
                f"unknown frame {name}",
                f"frames: {', '.join(frames)}",
            )
        return frames[name]

    def with_target(self, name: str) -> tuple[CompliantRobot, dict[str, dict[str, float]]]:
        """Return the robot and the covariance with the frame of a target as a parameter, where that was fitted."""
        held = tuple(placed for placed in self.targets if placed.place.frame == name)
        if not held:
            return self.robot, self.covariance
        robot = replace(self.robot, placed=(*self.robot.placed, *held))
        names = _parameter_names(robot.placed)
        whole = self.covariance_with_targets
        return robot, {a: {b: whole[a][b] for b in whole[a] if b in names} for a in whole if a in names}

    def aimed_at(self, name: str | None, option: str = "--target") -> tuple[MeasurementSetup, str]:
        """Return the set-up with a frame as its only target, and the frame's name; None: the first measured one.

        Raises
        ------
        InputError : there is no such frame, or it does not move with the robot.
        """
        if name is None:
            setup = self.setup
            return replace(setup, targets=setup.targets[:1], target_names=setup.target_names[:1]), setup.target_names[0]
        target = self.frame(name, option)
        if target.body == 0:
            raise InputError.at(
                FaultCode.FRAME_UNSUITABLE,
                "command line",
                option,
                f"{name} is fixed to the ground",
                "choose a frame on the robot",
            )
        return replace(self.setup, targets=(target,), target_names=(name,)), name


def robot_with_effects(campaign: Campaign) -> CompliantRobot:
    """Return the campaign's robot with the effects of its model.

    Raises
    ------
    InputError : the model holds none.
    """
    robot = placed_robot(campaign)
    if not robot.placed:
        reason = "the model contains no compliance, so no deflection can be predicted"
        raise InputError.at(
            FaultCode.MODEL_UNSUITABLE,
            "model.toml",
            "effects",
            reason,
            command_line("add", campaign.folder, "joint-compliance", "--all"),
        )
    return robot


def robot_of_model_file(campaign: Campaign, robot: CompliantRobot) -> FittedRobot:
    """Return the robot as its model file values it.

    Raises
    ------
    InputError : a parameter has no value.
    """
    from stiffcal.campaign.frames.frames import measurement_setup, resolve_frames

    without_value, _ = free_names(robot)
    if without_value:
        reason = f"the campaign contains no measurements, and {without_value[0]} has no value"
        raise InputError.at(
            FaultCode.KEY_MISSING, "model.toml", "parameters", reason, "give it a value, or add the logs"
        )
    chain = campaign.chain
    setup = measurement_setup(campaign.manifest, chain, resolve_frames(campaign.manifest, chain))
    left_out = tuple(_left_out(robot.placed))
    return FittedRobot(campaign, robot, _with_target(setup, chain.n_joints), {}, "model.toml", left_out)


def robot_of_fit(
    campaign: Campaign, robot: CompliantRobot, setup: MeasurementSetup, identified: IdentifyResult
) -> FittedRobot:
    """Return the robot with the values of a fit.

    Parameters
    ----------
    robot : the campaign's. setup : of the states that were fitted. identified : their fit.
    """
    matrix = np.array(identified.covariance, dtype=np.float64)
    fitted_values = robot.with_values(identified.robot_values())
    frames = tuple(placed for placed in fitted_values.placed if isinstance(placed.effect, FramePosition))
    setup = _with_target(with_found_frames(fitted_values, setup), campaign.chain.n_joints)
    setup = replace(setup, load_is_weight=False)  # of the states that were measured; what is asked for is a force
    targets = tuple(replace(placed, values={}) for placed in frames if placed.place.frame in setup.target_names)
    rest = tuple(placed for placed in fitted_values.placed if not isinstance(placed.effect, FramePosition))

    def covariance_of(names: set[str]) -> dict[str, dict[str, float]]:
        # what shows in motion alone (friction) is in the fit and not in the robot at rest
        in_both = [(k, name) for k, name in enumerate(identified.free_parameters) if name in names]
        sums = {name: variance for name, variance in _variances_of_sums(identified).items() if name in names}
        alone = dict.fromkeys(sums, 0.0)
        found = {a: {b: float(matrix[i, j]) for j, b in in_both} | alone for i, a in in_both}
        return found | {a: {b: 0.0 for _, b in in_both} | alone | {a: variance} for a, variance in sums.items()}

    # null where the rods do not identify it becomes NaN
    of_links = {link.link: np.array(link.compliance, dtype=np.float64) for link in identified.links or ()}
    # of geometry some numbers are a choice: no load turns the robot about those
    gives = _parameter_names(placed for placed in rest if not placed.changes_geometry)
    return FittedRobot(
        campaign,
        replace(fitted_values, placed=rest),
        setup,
        covariance_of(_parameter_names(rest)),
        f"fit {identified.fit_id}",
        (*_cautions(identified, gives), *_left_out(rest)),
        of_links,
        targets,
        covariance_of(_parameter_names((*rest, *targets))),
        tuple(known_from_below(identified)),
    )


def _variances_of_sums(identified: IdentifyResult) -> dict[str, float]:
    """Return name to variance of what stands in a fit for a combination that is known, that of the others left out."""
    found = {}
    for group in identified.not_identifiable:
        for name in group.parameters:
            in_fit = identified.parameter(name).in_fit
            if in_fit is not None and group.value and group.std is not None:
                # the others of the combination are 0 in the fit
                found[name] = (group.std * in_fit / group.value) ** 2
    return found


def known_from_below(identified: IdentifyResult) -> Iterator[str]:
    """Yield which compliances of a fit are not significant, for files that hold plain numbers; nothing without any."""
    names = [
        parameter.name
        for parameter in identified.parameters
        if parameter.is_compliance and parameter.above_noise is False
    ]
    if names:
        yield (
            f"not significant (below 3σ), in the file as plain numbers: {', '.join(names)}; of these stiffnesses only "
            "a lower limit is known"
        )


def _parameter_names(placed: Iterable[PlacedEffect]) -> set[str]:
    return {one.parameter_name(spec.symbol) for one in placed for spec in one.effect.parameters}


def _left_out(placed: Iterable[PlacedEffect]) -> Iterator[str]:
    """Yield what depends on how the robot came to a pose, which no pose or load states."""
    for one in placed:
        for spec in one.effect.parameters:
            half = 0.5 * one.values.get(spec.symbol, 0.0)
            if spec.reversal and half:
                yield (
                    f"joint {one.place.joints[0]} rests {angle(half, digits=2)} to the one or the "
                    f"other side of what is "
                    f"stated, depending on the direction of its last motion ([{spec.symbol}] of {one.effect.name}): "
                    "the middle is stated"
                )


def _cautions(identified: IdentifyResult, names: set[str]) -> Iterator[str]:
    """Yield what no stated uncertainty of a fit holds: what the data do not identify, and what the model lacks."""
    known, of_sums = set(identified.values()), set[str]()
    for group in identified.not_identifiable:
        # where one stands for what is known of all, the others are part of that
        if any(identified.parameter(name).in_fit is not None for name in group.parameters):
            of_sums |= set(group.parameters) & (names - known)
    unknown = {name for group in identified.not_identifiable for name in group.parameters} & (names - known) - of_sums
    if of_sums:
        yield (
            f"these data do not identify {', '.join(sorted(of_sums))} one by one: what is predicted is what they make "
            "together in the poses and loads that were measured; in others it may differ, and the stated uncertainty "
            "does not include that"
        )
    if unknown:
        yield (
            f"these data do not identify {', '.join(sorted(unknown))}: taken as rigid; a load that turns it moves the "
            "robot further than is stated here, and the stated uncertainty does not include that"
        )
    missed, noise = identified.rms.translation, None if identified.noise is None else identified.noise.translation
    if missed is not None and noise is not None and missed > _BEYOND_NOISE * noise:
        yield (
            f"this model misses the readings it was fitted to by {length(missed)} rms, their noise being "
            f"{length(noise)}: something is missing in it (stiffcal diagnose), and no stated uncertainty "
            "includes that"
        )


def _with_target(setup: MeasurementSetup, n_joints: int) -> MeasurementSetup:
    """Return the set-up with the flange as its target where no target was measured, as on a clamped robot."""
    from stiffcal.measurements.load_states import Attachment

    if setup.targets:
        return setup
    return replace(setup, targets=(Attachment(n_joints + 1, np.eye(4)),), target_names=("flange",))
