"""What the columns of the store's tables mean: unit, words, and whether a number may be missing.

Names in <…> stand for what a campaign calls its joints and targets, <k> for a number from 1. That these are the
columns which are written, neither more nor fewer, `stiffcal.schemas.tables` sees to.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class Meaning:
    """What a column holds.

    Attributes
    ----------
    text : in words.
    unit : SI unit; "" for words, counts, truth values and numbers without one.
    missing : True where a number may be missing.
    """

    text: str
    unit: str = ""
    missing: bool = False


def _each(pattern: str, axes: Iterable[str], meaning: Meaning) -> dict[str, Meaning]:
    return {pattern.format(axis): meaning for axis in axes}


_FORCE = Meaning("force on the robot by its surroundings, in the axes of the setup written beside the table", "N")
_MOMENT = Meaning("moment likewise, about the setup's point; zero where only forces are measured", "N·m")

FRICTION: Mapping[str, Meaning] = {
    "run": Meaning("the run's id"),
    "joint": Meaning("the joint that moved"),
    "velocity_radps": Meaning("as logged, mean over the pass; its sign is the direction", "rad/s"),
    "torque_Nm": Meaning("of the drive at the joint's side of the gear, mean over the stretch", "N·m"),
    "stretch": Meaning("passes of one number share a stretch of angle and a speed, and so their weight"),
    "low_rad": Meaning("where the stretch begins", "rad"),
    "high_rad": Meaning("where it ends", "rad"),
    "start_s": Meaning("the velocity was held from, on the log's clock", "s"),
    "end_s": Meaning("until", "s"),
    "n_readings": Meaning("samples averaged"),
    "torque_scatter_Nm": Meaning("standard deviation of single samples", "N·m"),
    "set_aside": Meaning("why the pass is not used; empty where it is"),
}

FREE_MOTION: Mapping[str, Meaning] = {
    "run": Meaning("the run's id"),
    "time_s": Meaning("on the log's clock", "s"),
    "<joint>_model_rad": Meaning("angle of the chain's joint, smoothed", "rad"),
    "<joint>_model_radps": Meaning("its velocity", "rad/s"),
    "<joint>_model_radps2": Meaning("its acceleration", "rad/s²"),
    "<joint>_drive_radps": Meaning("velocity of the joint's drive, at the joint's side of the gear", "rad/s"),
    "<joint>_drive_radps2": Meaning("its acceleration", "rad/s²"),
    "<joint>_drive_Nm": Meaning("its torque, at the joint's side", "N·m"),
    "<joint>_one_way": Meaning("true where the drive kept its direction for as long as the sample takes in"),
}

FRICTION_FIT: Mapping[str, Meaning] = {
    "run": Meaning("the run's id"),
    "joint": Meaning("the joint"),
    "steady": Meaning("true for a pass at constant velocity, false for a sample of other motion"),
    "velocity_radps": Meaning("of the drive, at the joint's side of the gear", "rad/s"),
    "friction_measured_Nm": Meaning("measured torque less weight, inertia and zeros as fitted", "N·m"),
    "friction_Nm": Meaning("the fitted friction", "N·m"),
    "beside_Nm": Meaning("weight, inertia and zeros as fitted", "N·m"),
    "residual_Nm": Meaning("measured less fitted", "N·m"),
}

STATES: Mapping[str, Meaning] = {
    "run": Meaning("the run's id"),
    "row": Meaning("data row of the table of states, or the hold's number in the run; from 1"),
    "time_s": Meaning("on the campaign's clock", "s", missing=True),
    "hold_s": Meaning("how long the load was held", "s", missing=True),
    "<joint>_rad": Meaning("joint angle as the controller shows it", "rad"),
    **_each("F{}_N", "xyz", _FORCE),
    **_each("M{}_Nm", "xyz", _MOMENT),
    **_each("<target>_{}_m", "xyz", Meaning("position of the target, base axes", "m", missing=True)),
    **_each("<target>_q{}", "wxyz", Meaning("unit quaternion base_from_target; w is not negative", "", missing=True)),
    **_each("<target>_d{}_m", "xyz", Meaning("deflection where the log holds that, base axes", "m", missing=True)),
    **_each("<target>_r{}_rad", "xyz", Meaning("rotation vector of that deflection, base axes", "rad", missing=True)),
    **_each(
        "<target>_{}_scatter_m",
        "xyz",
        Meaning("standard deviation of single readings of the position within the hold", "m", missing=True),
    ),
    "<target>_markers": Meaning("names of the points that were seen, where the target's pose comes from points"),
    "<rod>_length_m": Meaning("reading of a rod on a link; its changes count", "m", missing=True),
    "<gauge>_displacement_m": Meaning(
        "reading of a gauge along its direction, called as its source; its changes count", "m", missing=True
    ),
    "reference": Meaning("true in the run's reference state"),
    "temperature<k>": Meaning("channel k of the thermometer", "K", missing=True),
    "n_readings": Meaning("readings averaged into the state"),
    **_each(
        "F{}_scatter_N", "xyz", Meaning("standard deviation of single readings within the hold", "N", missing=True)
    ),
    **_each(
        "M{}_scatter_Nm", "xyz", Meaning("standard deviation of single readings within the hold", "N·m", missing=True)
    ),
    "set_aside": Meaning("why the state is not used; empty where it is"),
}

RECORDING: Mapping[str, Meaning] = {
    "time_s": Meaning("on the device's clock", "s", missing=True),
    "<joint>_rad": Meaning("joint angle, logged or commanded; named as in the log", "rad"),
    "<joint>_radps": Meaning("joint velocity", "rad/s"),
    "<joint>_Nm": Meaning("joint torque", "N·m"),
    "<joint>_A": Meaning("motor current", "A"),
    **_each("F{}_N", "xyz", Meaning("force on the robot, in the axes that the manifest gives", "N")),
    **_each("M{}_Nm", "xyz", Meaning("moment likewise; zero where only forces are measured", "N·m")),
    "mass<k>_kg": Meaning("mass of the dead weight", "kg"),
    **_each(
        "<target>_{}_m",
        "xyz",
        Meaning("position of a measured body, or of a marker on it, in the instrument's frame", "m", missing=True),
    ),
    **_each("<target>_q{}", "wxyz", Meaning("unit quaternion instrument_from_body", "", missing=True)),
    "translation<k>_m": Meaning("deflection along axis k", "m"),
    "rotation<k>_rad": Meaning("rotation vector of the deflection, axis k", "rad"),
    "<gauge>_displacement_m": Meaning("reading of a displacement gauge; it is called as its source", "m"),
    "<rod>_length_m": Meaning("length, or change of length, of a rod on a link", "m"),
    "temperature<k>_K": Meaning("channel k of the thermometer", "K"),
    "hold<k>_s": Meaning("how long the load was held", "s"),
}

_COMPONENTS = {
    "d{}_m": ("displacement of the target since the run's reference, base axes", "m"),
    "r{}_rad": ("rotation vector of the target since the run's reference, base axes", "rad"),
}
_KINDS = {
    "measured": "the run's free offset taken out",
    "predicted": "what the model says",
    "residual": "measured minus predicted",
}

OBSERVED: Mapping[str, Meaning] = {
    "state": Meaning("index of the state in the table states; from 0"),
    "run": Meaning("the run's id"),
    "row": Meaning("as in the table states"),
    **{
        f"<target>_{component.format(axis)}_{kind}": Meaning(f"{text}: {words}", unit, missing=True)
        for component, (text, unit) in _COMPONENTS.items()
        for axis in "xyz"
        for kind, words in _KINDS.items()
    },
    **{
        f"{name}_{kind}": Meaning(f"{text}: {words}", "m", missing=True)
        for name, text in (
            ("<gauge>_displacement_m", "reading of the gauge since the run's reference"),
            ("<rod>_length_m", "change of the rod's length since the run's reference"),
        )
        for kind, words in _KINDS.items()
    },
}

_READ = "in unseen poses, read in the direction in which the effect acts; m, or rad where the entry says rotation"

EVIDENCE: Mapping[str, Meaning] = {
    "effect": Meaning("the effect's name"),
    "place": Meaning("where it sits: j4, j5-j6, a link"),
    "entry": Meaning("index of the effect in the diagnosis document's evidence; from 0"),
    "state": Meaning("index of the state in the table states; from 0"),
    "run": Meaning("the run's id"),
    "branch": Meaning("loading or unloading; empty where the load only rises"),
    "driver": Meaning("what drives the effect, in the unit of the document's entry", "", missing=True),
    "before": Meaning(f"residual of the model without the effect, {_READ}", "", missing=True),
    "after": Meaning(f"residual of the model with the effect, {_READ}", "", missing=True),
    "law": Meaning("what the effect adds in that direction, since the state under weight alone", "", missing=True),
}
