"""The effects of a campaign: of its model file, for which its own code may be needed, and all that can be tried."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from stiffcal.campaign.found.experiment_kinds import any_measures
from stiffcal.campaign.toml.naming import MANIFEST_FILE
from stiffcal.errors import Fault, InputError
from stiffcal.measurements.state_measures import StateMeasure
from stiffcal.model.catalogue.catalogue import built_in_effects, find_effects
from stiffcal.model.catalogue.plugin_code import PluginCode, allow_line, read_plugins
from stiffcal.model.motion import Motion

if TYPE_CHECKING:
    from stiffcal.campaign.loading import Campaign
    from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
    from stiffcal.model.effect import Effect


@dataclass(frozen=True)
class UntrustedEffect:
    """An effect of a campaign's own code that is left out because the user has not allowed that code."""

    effect: str
    """Its name as it stands in the code, or the file's where the name is made while the code runs."""
    needs: str
    """What it takes to have it."""


def plugin_code(campaign: Campaign) -> PluginCode:
    """Read the campaign's own code; as `read_plugins`."""
    return read_plugins(campaign.folder, campaign.manifest.plugins)


def needs_plugins(campaign: Campaign) -> bool:
    """Return whether the model file holds an effect that is neither built in nor installed."""
    built_in = built_in_effects()
    return bool(campaign.manifest.plugins) and any(entry.type not in built_in for entry in campaign.model.effects)


def key_of_plugins(campaign: Campaign) -> str:
    """Return a key of the campaign's own effects that a diagnosis tries, "" where there are none."""
    if not campaign.manifest.plugins:
        return ""
    try:
        code = plugin_code(campaign)
    except InputError as error:
        return str(error)
    return f"{code.digest} {'allowed' if code.allowed() else 'not allowed'}"


def effects_with(campaign: Campaign, name: str) -> dict[str, Effect]:
    """Return the catalogue for one effect that the user names: the campaign's own code is run only where it has it.

    Raises
    ------
    InputError : the code is needed, and not trusted or broken.
    """
    if name in built_in_effects() or not campaign.manifest.plugins:
        return find_effects()
    code = plugin_code(campaign)
    if not code.allowed() and name not in [effect_name for file in code.files for effect_name in file.effect_names()]:
        return find_effects()
    return find_effects(code)


def model_effects(campaign: Campaign) -> dict[str, Effect]:
    """Return the catalogue for the model file: the campaign's code is run only where the model holds an effect of it.

    Raises
    ------
    InputError : the code is needed, and not trusted or broken.
    """
    return find_effects(plugin_code(campaign) if needs_plugins(campaign) else None)


def all_effects(campaign: Campaign) -> tuple[dict[str, Effect], list[UntrustedEffect]]:
    """Return all effects that may be tried on this campaign, and those that its own code defines and that may not.

    Raises
    ------
    InputError : the model needs the campaign's code and it is not trusted, or code that is trusted is broken.
    """
    if not campaign.manifest.plugins:
        return find_effects(), []
    if needs_plugins(campaign):
        return find_effects(plugin_code(campaign)), []
    try:
        code = plugin_code(campaign)
    except InputError as error:
        return find_effects(), [UntrustedEffect(MANIFEST_FILE, _in_words(fault)) for fault in error.faults]
    if code.allowed():
        return find_effects(code), []
    needs = (
        f"this campaign's code, which is not trusted (SHA-256 {code.digest}); to allow it: {allow_line(code.folder)}"
    )
    return find_effects(), [UntrustedEffect(name, needs) for file in code.files for name in file.effect_names()]


def _in_words(fault: Fault) -> str:
    where = f"{fault.place}: " if fault.place else ""
    return f"{where}{fault.reason}; {fault.mend}"


def placed_robot(campaign: Campaign) -> CompliantRobot:
    """Return the campaign's robot with the effects of its model file, with the values that it gives.

    Effects that show in motion alone are left out: no load state and no prediction at rest depends on them.

    Raises
    ------
    InputError : the model file names an effect, a place or a parameter that does not exist.
    """
    robot = _whole_robot(campaign)
    at_rest = tuple(placed_effect for placed_effect in robot.placed if not isinstance(placed_effect.effect, Motion))
    return replace(robot, placed=(*_frames_to_fit(campaign), *_base_tilt(campaign, at_rest), *at_rest))


def _frames_to_fit(campaign: Campaign) -> tuple[PlacedEffect, ...]:
    """Return the frames that are found together with the robot: those to be estimated, where places count."""
    from stiffcal.model.assembled.measured_frames import placed_frame, placed_load_point

    manifest = campaign.manifest
    if not any_measures((run.experiment for run in manifest.runs), StateMeasure.PLACE):
        return ()
    poses = {body: pose for source in manifest.sources.values() for body, pose in source.body_poses().items()}
    turned = {body for body, pose in poses.items() if pose.orientation is not None or pose.markers}
    found = [
        placed_frame(name, name not in poses or name in turned, frame.level)
        for name, frame in manifest.frames.items()
        if frame.estimate
    ]
    return (*found, *(placed_load_point(name) for name, frame in manifest.frames.items() if frame.sigma_m is not None))


def _base_tilt(campaign: Campaign, at_rest: tuple[PlacedEffect, ...]) -> tuple[PlacedEffect, ...]:
    """Return the turn of the base against gravity where places depend on it and nothing states it.

    That is where weight acts on a law of absolute places of a robot whose first axis is not vertical, and the tracker's
    frame, which is estimated, holds the tilt of that axis. A levelled tracker states it.
    """
    from stiffcal.model.assembled.base_tilt import first_axis_vertical, placed_base_tilt
    from stiffcal.model.effect import Kind

    manifest, chain = campaign.manifest, campaign.chain
    sources = manifest.sources.values()
    trackers = {pose.frame for source in sources for pose in source.body_poses().values()}
    stated = not any(name in trackers and frame.estimate and not frame.level for name, frame in manifest.frames.items())
    absolute = any_measures((run.experiment for run in manifest.runs), StateMeasure.PLACE)
    if stated or not absolute or first_axis_vertical(chain):
        return ()
    weighs = chain.masses_known or manifest.tool is not None or any(source.dead_weight for source in sources)
    gives = any(placed.effect.kind in (Kind.NODE_LAW, Kind.COUPLING) for placed in at_rest)
    return (placed_base_tilt(chain),) if weighs and gives else ()


def moving_effects(campaign: Campaign) -> tuple[PlacedEffect, ...]:
    """Return the effects of the model file that show in motion alone (friction of the drives), by joint."""
    in_motion = [placed for placed in _whole_robot(campaign).placed if isinstance(placed.effect, Motion)]
    return tuple(sorted(in_motion, key=lambda placed: placed.place.joints))


def _whole_robot(campaign: Campaign) -> CompliantRobot:
    from stiffcal.model.assembled.assembly import compliant_robot

    return compliant_robot(campaign.chain, campaign.model, model_effects(campaign))


def free_names(robot: CompliantRobot) -> tuple[list[str], list[str]]:
    """Return the names of the model's parameters: (those that have no value, all)."""
    names = [
        placed_effect.parameter_name(spec.symbol)
        for placed_effect in robot.placed
        for spec in placed_effect.effect.parameters
    ]
    values = robot.values()
    return [name for name in names if name not in values], names
