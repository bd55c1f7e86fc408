"""What the columns of the store's tables mean: unit, words, and whether a number may be missing.

Names in <…> stand for what a campaign calls its joints and targets, <k> for a number from 1. That these are the
columns which are written, neither more nor fewer, `stiffcal.schemas.tables` ensures.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from stiffcal.measurements.set_aside import OF_PASSES, SetAsideCode
from stiffcal.measurements.table_specimens import ColumnDescription, cause_column


def _each(pattern: str, axes: Iterable[str], meaning: ColumnDescription) -> dict[str, ColumnDescription]:
    return {pattern.format(axis): meaning for axis in axes}


_FORCE = ColumnDescription(
    "force on the robot by its surroundings, in the axes of the setup written next to the table", "N"
)
_MOMENT = ColumnDescription("moment likewise, about the setup's point; zero where only forces are measured", "N·m")

STATES: Mapping[str, ColumnDescription] = {
    "run": ColumnDescription("the run's id"),
    "row": ColumnDescription("data row of the table of states, or the hold's number in the run; from 1"),
    "time_s": ColumnDescription("on the campaign's clock", "s", missing=True),
    "hold_s": ColumnDescription("how long the load was held", "s", missing=True),
    "<joint>_rad": ColumnDescription("joint angle as the controller shows it; of prismatic joints <joint>_m, m", "rad"),
    **_each("F{}_N", "xyz", _FORCE),
    **_each("M{}_Nm", "xyz", _MOMENT),
    **_each("<target>_{}_m", "xyz", ColumnDescription("position of the target, base axes", "m", missing=True)),
    **_each(
        "<target>_q{}",
        "wxyz",
        ColumnDescription("unit quaternion base_from_target; w is not negative", "", missing=True),
    ),
    **_each(
        "<target>_d{}_m", "xyz", ColumnDescription("deflection where the log holds that, base axes", "m", missing=True)
    ),
    **_each(
        "<target>_r{}_rad",
        "xyz",
        ColumnDescription("rotation vector of that deflection, base axes", "rad", missing=True),
    ),
    **_each(
        "<target>_{}_sigma_m",
        "xyz",
        ColumnDescription("standard uncertainty of the position where the log states it row by row", "m", missing=True),
    ),
    **_each(
        "<target>_r{}_sigma_rad",
        "xyz",
        ColumnDescription("standard uncertainty of the turn where the log states it row by row", "rad", missing=True),
    ),
    **_each(
        "<target>_{}_scatter_m",
        "xyz",
        ColumnDescription("standard deviation of single readings of the position within the hold", "m", missing=True),
    ),
    "<target>_markers": ColumnDescription(
        "names of the points that were visible, where the target's pose comes from points"
    ),
    "<rod>_length_m": ColumnDescription("reading of a rod on a link; its changes count", "m", missing=True),
    "<gauge>_displacement_m": ColumnDescription(
        "reading of a gauge along its direction, called as its source; its changes count", "m", missing=True
    ),
    "reference": ColumnDescription("true in the run's reference state"),
    "temperature<k>": ColumnDescription("channel k of the thermometer", "K", missing=True),
    "n_readings": ColumnDescription("readings averaged into the state"),
    **_each(
        "F{}_scatter_N",
        "xyz",
        ColumnDescription("standard deviation of single readings within the hold", "N", missing=True),
    ),
    **_each(
        "M{}_scatter_Nm",
        "xyz",
        ColumnDescription("standard deviation of single readings within the hold", "N·m", missing=True),
    ),
    "set_aside": ColumnDescription("why the state is not used; empty where it is"),
    "set_aside_code": cause_column("state", [code for code in SetAsideCode if code not in OF_PASSES]),
}

RECORDING: Mapping[str, ColumnDescription] = {
    "time_s": ColumnDescription("on the device's clock", "s", missing=True),
    "<joint>_rad": ColumnDescription(
        "joint angle, logged or commanded, named as in the log; prismatic: <joint>_m", "rad"
    ),
    "<joint>_radps": ColumnDescription("joint velocity", "rad/s"),
    "<joint>_Nm": ColumnDescription("joint torque", "N·m"),
    "<joint>_A": ColumnDescription("motor current", "A"),
    **_each("F{}_N", "xyz", ColumnDescription("force on the robot, in the axes that the manifest gives", "N")),
    **_each("M{}_Nm", "xyz", ColumnDescription("moment likewise; zero where only forces are measured", "N·m")),
    "mass<k>_kg": ColumnDescription("mass of the dead weight", "kg"),
    **_each(
        "<target>_{}_m",
        "xyz",
        ColumnDescription(
            "position of a measured body, or of a marker on it, in the instrument's frame", "m", missing=True
        ),
    ),
    **_each("<target>_q{}", "wxyz", ColumnDescription("unit quaternion instrument_from_body", "", missing=True)),
    "translation<k>_m": ColumnDescription("deflection along axis k", "m"),
    "rotation<k>_rad": ColumnDescription("rotation vector of the deflection, axis k", "rad"),
    "<gauge>_displacement_m": ColumnDescription("reading of a displacement gauge; it is called as its source", "m"),
    "<rod>_length_m": ColumnDescription("length, or change of length, of a rod on a link", "m"),
    "temperature<k>_K": ColumnDescription("channel k of the thermometer", "K"),
    "hold<k>_s": ColumnDescription("how long the load was held", "s"),
}

_COMPONENTS = {
    "d{}_m": ("displacement of the target since the run's reference, base axes", "m"),
    "r{}_rad": ("rotation vector of the target since the run's reference, base axes", "rad"),
}
_KINDS = {
    "measured": "the run's free offset taken out",
    "predicted": "what the model predicts",
    "residual": "measured minus predicted",
}

OBSERVED: Mapping[str, ColumnDescription] = {
    "state": ColumnDescription("index of the state in the table states; from 0"),
    "run": ColumnDescription("the run's id"),
    "row": ColumnDescription("as in the table states"),
    **{
        f"<target>_{component.format(axis)}_{kind}": ColumnDescription(f"{text}: {words}", unit, missing=True)
        for component, (text, unit) in _COMPONENTS.items()
        for axis in "xyz"
        for kind, words in _KINDS.items()
    },
    **{
        f"{name}_{kind}": ColumnDescription(f"{text}: {words}", "m", missing=True)
        for name, text in (
            ("<gauge>_displacement_m", "reading of the gauge since the run's reference"),
            ("<rod>_length_m", "change of the rod's length since the run's reference"),
        )
        for kind, words in _KINDS.items()
    },
    **{
        f"motor<k>_angle_rad_{kind}": ColumnDescription(
            f"what the motor of joint k turns in a clamped run, at the joint's side: {words}", "rad", missing=True
        )
        for kind, words in _KINDS.items()
    },
}

HELDOUT: Mapping[str, ColumnDescription] = {
    **OBSERVED,
    "branch": ColumnDescription("loading or unloading; empty where unloaded, or where the load only rises"),
    "load_N": ColumnDescription(
        "size of the force less that of the run's reference, of absolute rows the whole force", "N"
    ),
    "tau_<k>_Nm": ColumnDescription("torque about the axis of joint k, weight included, as the fit has it", "N·m"),
}

_READ = "in held-out poses, read in the direction in which the effect acts; m, or rad for rotations"

EVIDENCE: Mapping[str, ColumnDescription] = {
    "effect": ColumnDescription("the effect's name"),
    "place": ColumnDescription("where it sits: j4, j5-j6, a link"),
    "entry": ColumnDescription("index of the effect in the diagnosis document's evidence; from 0"),
    "state": ColumnDescription("index of the state in the table states; from 0"),
    "run": ColumnDescription("the run's id"),
    "branch": ColumnDescription("loading or unloading; empty where the load only rises"),
    "driver": ColumnDescription("what drives the effect, in the unit of the document's entry", "", missing=True),
    "before": ColumnDescription(f"residual of the model without the effect, {_READ}", "", missing=True),
    "after": ColumnDescription(f"residual of the model with the effect, {_READ}", "", missing=True),
    "law": ColumnDescription(
        "what the effect adds in that direction, since the state under weight alone", "", missing=True
    ),
    **{f"along_{axis}": ColumnDescription(f"{axis} of that direction, base axes", "1", missing=True) for axis in "xyz"},
}

ROW_REFITS: Mapping[str, ColumnDescription] = {
    "entry": ColumnDescription("index of the refit in the document refits; from 0"),
    "row": ColumnDescription(
        "index of the bin of passes, or sample of other motion, among all of the campaign; from 0"
    ),
    "residual": ColumnDescription("measured less predicted by a fit without this speed, or second of motion", "N·m"),
}

REFITS: Mapping[str, ColumnDescription] = {
    "entry": ColumnDescription("index of the refit in the document refits; from 0"),
    "state": ColumnDescription("index of the state in the table states; from 0"),
    **{name: description for name, description in OBSERVED.items() if name.endswith("_residual")},
}
