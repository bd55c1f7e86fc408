"""The fitted model as code: C99 and Structured Text for a controller's loop."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from stiffcal import __version__
from stiffcal.campaign.checks.prismatic_checks import refuse_prismatic
from stiffcal.compensation.fitted_robot import FittedRobot
from stiffcal.compensation.option_words import pose_of_words, tool_of_words
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.trust.output_kinds import EXPORT
from stiffcal.trust.outputs import check_not_foreign, write_output

if TYPE_CHECKING:
    from stiffcal.campaign.loading import Campaign
    from stiffcal.compensation.exports.controller_model import ControllerModel
    from stiffcal.compensation.exports.step import StepSettings
    from stiffcal.measurements.load_states import Attachment, MeasurementSetup


@dataclass(frozen=True)
class ControllerOptions:
    """How the loop in the controller runs."""

    cycle_ms: float = 4.0
    """Time between two calls, ms."""
    filter_hz: float | None = None
    """Low-pass of the reading; None: none."""
    tool: str | None = None
    """"kg,x,y,z": what hangs beyond the sensor, mass and centre in the flange frame, m; None: nothing is taken out."""
    zeroed_at: str | None = None
    """"A1,A2,…" in degrees, where the sensor was zeroed with the tool on; None: never."""
    sensor: str | None = None
    """The frame whose axes and origin the reading has; None: axes and point of the campaign's forces."""
    target: str | None = None
    """The frame that is kept in place; None: the first measured one."""
    leave_out: tuple[str, ...] = ()
    """Effects that the code leaves out where they are not proportional to their load."""


@dataclass(frozen=True)
class WrittenCode:
    """What was written."""

    holds: str
    """In words."""
    warnings: list[str]
    """What a user of the code must know."""


def check_controller_code(campaign: Campaign, output: Path, *, overwrite: bool) -> None:
    """Raise InputError where the code of a campaign's robot cannot be written to a file, whatever its values."""
    from stiffcal.compensation.exports.c_code import header_name

    if output.suffix.lower() == ".c":
        check_not_foreign(output.with_name(header_name(output.stem)), EXPORT, overwrite)
    if output.suffix.lower() == ".st":
        reason = "the Structured Text turns all joints"
        refuse_prismatic(campaign.chain.prismatic_names, reason, "export C (*.c), or use stiffcal compensate --path")


def write_controller_code(
    fitted: FittedRobot, verdict: ModelVerdict, output: Path, options: ControllerOptions, *, overwrite: bool = False
) -> WrittenCode:
    """Write a robot's compensation as code; the file's ending is ``.c`` or ``.st``.

    Parameters
    ----------
    fitted : the robot with values. verdict : of the last diagnosis on its model.
    output : ``*.c``, with its header next to it, or ``*.st``. options : how the loop runs.
    overwrite : also a file that holds something stiffcal did not write.

    Raises
    ------
    InputError : an effect of the model has no form in code and `ControllerOptions.leave_out` does not name it; an
        option is wrong.
    """
    from stiffcal.compensation.exports.c_code import c_source, header_name
    from stiffcal.compensation.exports.st_code import st_source

    setup, target = reading_setup(fitted, options)
    model = _model(fitted, setup, _settings(fitted, options), options)
    head = list(head_lines(fitted, setup, target, model, verdict))
    if output.suffix.lower() == ".st":
        write_output(output, st_source(model, head, output.stem), EXPORT, overwrite)
        what = "Structured Text"
    else:
        source, header = c_source(model, head, output.stem)
        write_output(output, source, EXPORT, overwrite)
        write_output(output.with_name(header_name(output.stem)), header, EXPORT, overwrite)
        what = f"C99, with {header_name(output.stem)}"
    holds = (
        f"the compensation of {fitted.source} as {what} "
        f"({len(model.joint_names)} joints, cycle {options.cycle_ms:g} ms, model hash {model.hash[:16]}…)"
    )
    warnings = [*fitted.warnings, *fitted.known_from_below, *([] if verdict.complete else [verdict.text])]
    return WrittenCode(holds, warnings)


def reading_setup(fitted: FittedRobot, options: ControllerOptions) -> tuple[MeasurementSetup, str]:
    """Return the set-up that the loop's readings refer to, and the target's name.

    Moments always count: where the process has none, or they are not measured, the controller hands over zeros.
    """
    setup, target = fitted.aimed_at(options.target)
    setup = replace(setup, moments_measured=True)
    if options.sensor is not None:
        sensor = fitted.frame(options.sensor, "--sensor")
        setup = replace(setup, wrench_axes=sensor, wrench_point=sensor)
    return setup, target


@dataclass(frozen=True)
class ModelVerdict:
    """The verdict of the last diagnosis on the model."""

    complete: bool
    """False where something is missing, and where nobody has looked."""
    text: str
    """In words."""


def head_lines(
    fitted: FittedRobot, setup: MeasurementSetup, target: str, model: ControllerModel, verdict: ModelVerdict
) -> Iterator[str]:
    """Yield the lines of the comment at the head of the code, not escaped."""
    chain = fitted.campaign.chain
    yield f"Deflection compensation of {chain.name or 'a robot'}, campaign {fitted.campaign.name}, {fitted.source}"
    yield f"written by stiffcal {__version__}; model hash {model.hash}"
    yield verdict.text
    for warning in (*fitted.warnings, *fitted.known_from_below):
        yield f"caution: {warning}"
    yield ""
    yield "Units: m, rad, N, N m, s. Base axes: frame 0 of the robot file."
    yield f"Joints: {', '.join(model.joint_names)}, as the controller shows them, in rad."
    yield "Reading: force of the surroundings on the robot; change its sign if the sensor shows the force of the robot."
    yield f"  axes: {_frame(fitted, setup.wrench_axes)}"
    yield f"  about the point: {_frame(fitted, setup.wrench_point)}"
    yield f"Target, which is held in place: {target}, {_frame(fitted, setup.targets[0])}"
    yield f"Offsets: add to the commanded joints every {1e3 * model.cycle_s:g} ms."
    yield "Effects: " + ", ".join(f"{placed.effect.name} {placed.place.label}" for placed in fitted.robot.acting)
    for name in model.left_out:
        yield f"LEFT OUT, not available in this code: {name}"
    for placed in fitted.robot.acting:
        at = f"{placed.effect.name}.{placed.place.label}"
        if placed.has_memory and not placed.scalar_laws(chain):
            yield f"static form, as after a long time under the same load: {at}"


def _frame(fitted: FittedRobot, attachment: Attachment) -> str:
    chain = fitted.campaign.chain
    bodies = ("the base", *(f"link {name}" for name in chain.link_names), "the flange")
    rows = "; ".join(" ".join(f"{value + 0.0:.6g}" for value in row) for row in attachment.transform[:3])
    return f"fixed to {bodies[attachment.body]}, rows of [rotation | origin m]: {rows}"


def _settings(fitted: FittedRobot, options: ControllerOptions) -> StepSettings:
    from stiffcal.compensation.exports.step import StepSettings

    if not (np.isfinite(options.cycle_ms) and 0.0 < options.cycle_ms <= 1000.0):
        raise _wrong("--cycle-ms", f"{options.cycle_ms:g} ms is not a valid cycle time", "give 0.1 to 1000")
    rate = 1e3 / options.cycle_ms
    if options.filter_hz is not None and not 0.0 < options.filter_hz < 0.5 * rate:
        reason = f"{options.filter_hz:g} Hz is not below half of {rate:g} samples per second"
        raise _wrong("--filter", reason, "lower it, or shorten the cycle")
    settings = StepSettings(
        cycle_s=1e-3 * options.cycle_ms, cutoff_hz=options.filter_hz, leave_out=tuple(options.leave_out)
    )
    if options.tool is not None:
        mass, com = tool_of_words(options.tool)
        settings = replace(settings, tool_mass=mass, tool_com=(float(com[0]), float(com[1]), float(com[2])))
    if options.zeroed_at is not None:
        settings = replace(settings, zeroed_at=pose_of_words(options.zeroed_at, fitted.campaign.chain, "--zeroed-at"))
    return settings


def _model(
    fitted: FittedRobot, setup: MeasurementSetup, settings: StepSettings, options: ControllerOptions
) -> ControllerModel:
    from stiffcal.compensation.exports.controller_model import controller_model

    try:
        return controller_model(fitted.robot, setup, settings)
    except ValueError as error:
        mend = "leave the effect out by name (--leave-out), or change the option that does not fit"
        raise InputError.at(FaultCode.MODEL_UNSUITABLE, "model.toml", "effects", str(error), mend) from error


def _wrong(option: str, reason: str, mend: str) -> InputError:
    return InputError.at(FaultCode.OPTION_INVALID, "command line", option, reason, mend)
