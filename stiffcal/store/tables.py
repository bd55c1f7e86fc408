"""The tables of a store, but for those of single kinds of experiment, which stand in the kind's folder."""

from __future__ import annotations

import pyarrow as pa

from stiffcal.measurements.set_aside import OF_PASSES, SetAsideCode
from stiffcal.store.declared_table import (
    COUNT,
    NUMBER,
    TRUTH,
    WORD,
    DeclaredTable,
    cause_column,
    column,
    columns,
)

_RUN = column("run", WORD, "the run's id")
_STATE = column("state", COUNT, "index of the state in the table states; from 0")
_KINDS = {
    "measured": "the run's free offset taken out",
    "predicted": "what the model predicts",
    "residual": "measured minus predicted",
}
_OBSERVED = {
    **{
        f"<target>_d{axis}_m": ("displacement of the target since the run's reference, base axes", "m")
        for axis in "xyz"
    },
    **{
        f"<target>_r{axis}_rad": ("rotation vector of the target since the run's reference, base axes", "rad")
        for axis in "xyz"
    },
    "<gauge>_displacement_m": ("reading of the gauge since the run's reference", "m"),
    "<rod>_length_m": ("change of the rod's length since the run's reference", "m"),
    "motor<k>_angle_rad": ("what the motor of joint k turns in a clamped run, at the joint's side", "rad"),
}


def _observed(*kinds: str) -> list[pa.Field]:
    return [
        column(f"{name}_{kind}", NUMBER, f"{meaning}: {_KINDS[kind]}", unit, missing=True)
        for name, (meaning, unit) in _OBSERVED.items()
        for kind in kinds
    ]


_OF_WRENCH = "standard deviation of single readings within the hold"
_OF_STATE = "standard uncertainty of the state, of clamped runs"

STATES = DeclaredTable(
    "states",
    "The table `states`: one row per load state.",
    pa.schema(
        [
            _RUN,
            column("row", COUNT, "data row of the table of states, or the hold's number in the run; from 1"),
            column("time_s", NUMBER, "on the campaign's clock", "s", missing=True),
            column("hold_s", NUMBER, "how long the load was held", "s", missing=True),
            column("<joint>_rad", NUMBER, "joint angle as the controller shows it", "rad"),
            column("<joint>_m", NUMBER, "position of a prismatic joint as the controller shows it", "m"),
            column("<joint>_torque_Nm", NUMBER, "torque of the motor at rest, where it counts", "N·m", missing=True),
            column(
                "<joint>_approach",
                NUMBER,
                "direction of the drive's last motion, 1 or -1; of absolute runs",
                missing=True,
            ),
            *columns(
                "F{}_N",
                "xyz",
                "force on the robot by its surroundings, in the axes of the setup written next to the table",
                "N",
            ),
            *columns(
                "M{}_Nm", "xyz", "moment likewise, about the setup's point; zero where only forces are measured", "N·m"
            ),
            *columns("<target>_{}_m", "xyz", "position of the target, base axes", "m", missing=True),
            *columns("<target>_q{}", "wxyz", "unit quaternion base_from_target; w is not negative", missing=True),
            *columns("<target>_d{}_m", "xyz", "deflection where the log holds that, base axes", "m", missing=True),
            *columns("<target>_r{}_rad", "xyz", "rotation vector of that deflection, base axes", "rad", missing=True),
            *columns(
                "<target>_{}_sigma_m",
                "xyz",
                "standard uncertainty of the position where the log states it row by row",
                "m",
                missing=True,
            ),
            *columns(
                "<target>_r{}_sigma_rad",
                "xyz",
                "standard uncertainty of the turn where the log states it row by row",
                "rad",
                missing=True,
            ),
            *columns(
                "<target>_{}_scatter_m",
                "xyz",
                "standard deviation of single readings of the position within the hold",
                "m",
                missing=True,
            ),
            column(
                "<target>_markers",
                WORD,
                "names of the points that were visible, where the target's pose comes from points",
            ),
            column("<rod>_length_m", NUMBER, "reading of a rod on a link; its changes count", "m", missing=True),
            column(
                "<gauge>_displacement_m",
                NUMBER,
                "reading of a gauge along its direction, called as its source; its changes count",
                "m",
                missing=True,
            ),
            column("reference", TRUTH, "true in the run's reference state"),
            column("temperature<k>", NUMBER, "channel k of the thermometer", "K", missing=True),
            column("n_readings", COUNT, "readings averaged into the state"),
            *columns("F{}_scatter_N", "xyz", _OF_WRENCH, "N", missing=True),
            *columns("M{}_scatter_Nm", "xyz", _OF_WRENCH, "N·m", missing=True),
            column("motor_angle_sigma_rad", NUMBER, _OF_STATE, "rad", missing=True),
            *columns("F{}_sigma_N", "xyz", _OF_STATE, "N", missing=True),
            *columns("M{}_sigma_Nm", "xyz", _OF_STATE, "N·m", missing=True),
            column("set_aside", WORD, "why the state is not used; empty where it is"),
            cause_column("state", [code for code in SetAsideCode if code not in OF_PASSES]),
        ]
    ),
    optional=frozenset(
        {"motor_angle_sigma_rad", *(f"F{axis}_sigma_N" for axis in "xyz"), *(f"M{axis}_sigma_Nm" for axis in "xyz")}
    ),
)

RECORDING = DeclaredTable(
    "recording",
    "A table `recordings/RUN/SOURCE`: one row per reading, in SI and in the instrument's own axes.",
    pa.schema(
        [
            column("time_s", NUMBER, "on the device's clock", "s", missing=True),
            column("<joint>_rad", NUMBER, "joint angle, logged or commanded, named as in the log", "rad"),
            column("<joint>_m", NUMBER, "position of a prismatic joint likewise", "m"),
            column("<joint>_radps", NUMBER, "joint velocity", "rad/s"),
            column("<joint>_Nm", NUMBER, "joint torque", "N·m"),
            column("<joint>_A", NUMBER, "motor current", "A"),
            column("<joint>_sign", NUMBER, "direction of the drive's last motion"),
            *columns("F{}_N", "xyz", "force on the robot, in the axes that the manifest gives", "N"),
            *columns("M{}_Nm", "xyz", "moment likewise; zero where only forces are measured", "N·m"),
            column("mass<k>_kg", NUMBER, "mass of the dead weight", "kg"),
            *columns(
                "<target>_{}_m",
                "xyz",
                "position of a measured body, or of a marker on it, in the instrument's frame",
                "m",
                missing=True,
            ),
            *columns("<target>_q{}", "wxyz", "unit quaternion instrument_from_body", missing=True),
            column("translation<k>_m", NUMBER, "deflection along axis k", "m"),
            column("rotation<k>_rad", NUMBER, "rotation vector of the deflection, axis k", "rad"),
            column(
                "<gauge>_displacement_m", NUMBER, "reading of a displacement gauge; it is called as its source", "m"
            ),
            column("<rod>_length_m", NUMBER, "length, or change of length, of a rod on a link", "m"),
            column("temperature<k>_K", NUMBER, "channel k of the thermometer", "K"),
            column("hold<k>_s", NUMBER, "how long the load was held", "s"),
            column("<target>_sigma_m", NUMBER, "standard uncertainty of its position, of all axes", "m", missing=True),
            *columns("<target>_{}_sigma_m", "xyz", "standard uncertainty of its position", "m", missing=True),
            column(
                "<target>_r_sigma_rad", NUMBER, "standard uncertainty of its turn, of all axes", "rad", missing=True
            ),
            *columns("<target>_r{}_sigma_rad", "xyz", "standard uncertainty of its turn", "rad", missing=True),
        ]
    ),
    optional=frozenset((*(f"F{axis}_N" for axis in "xyz"), *(f"M{axis}_Nm" for axis in "xyz"))),
    beginnings=("recordings/",),
)

_FIT = [_STATE, _RUN, column("row", COUNT, "as in the table states")]

FIT = DeclaredTable(
    "fit",
    "The table `fit`: one row per load state that was fitted, with what the fitted model predicts for it.",
    pa.schema([*_FIT, *_observed(*_KINDS)]),
    beginnings=("fit-",),
)

HELDOUT_ROWS = DeclaredTable(
    "unseen",
    "The table `unseen`: one row per load state, with the residual of a fit made without its pose.",
    pa.schema(
        [
            *_FIT,
            *_observed(*_KINDS),
            column("branch", WORD, "loading or unloading; empty where unloaded, or where the load only rises"),
            column(
                "load_N",
                NUMBER,
                "size of the force less that of the run's reference, of absolute rows the whole force",
                "N",
            ),
            column("tau_<k>_Nm", NUMBER, "torque about the axis of joint k, weight included, as the fit has it", "N·m"),
        ]
    ),
    beginnings=("heldout-",),
)

REFITS = DeclaredTable(
    "refits",
    "The table `refits`: one row per refit and load state, its residual by a fit made without its pose.",
    pa.schema(
        [column("entry", COUNT, "index of the refit in the document refits; from 0"), _STATE, *_observed("residual")]
    ),
)

ROW_REFITS = DeclaredTable(
    "row_refits",
    "The table `row_refits`: one row per refit and row of torque, of friction runs without load states.",
    pa.schema(
        [
            column("entry", COUNT, "index of the refit in the document refits; from 0"),
            column(
                "row", COUNT, "index of the bin of passes, or sample of other motion, among all of the campaign; from 0"
            ),
            column(
                "residual", NUMBER, "measured less predicted by a fit without this speed, or second of motion", "N·m"
            ),
        ]
    ),
)

_READ = "in held-out poses, read in the direction in which the effect acts; m, or rad for rotations"

EVIDENCE = DeclaredTable(
    "evidence",
    "The table `evidence`: one row per effect and load state, the residual against what drives the effect.",
    pa.schema(
        [
            column("effect", WORD, "the effect's name"),
            column("place", WORD, "where it sits: j4, j5-j6, a link"),
            column("entry", COUNT, "index of the effect in the diagnosis document's evidence; from 0"),
            _STATE,
            _RUN,
            column("branch", WORD, "loading or unloading; empty where the load only rises"),
            column("driver", NUMBER, "what drives the effect, in the unit of the document's entry", missing=True),
            column("before", NUMBER, f"residual of the model without the effect, {_READ}", missing=True),
            column("after", NUMBER, f"residual of the model with the effect, {_READ}", missing=True),
            column(
                "law",
                NUMBER,
                "what the effect adds in that direction, since the state under weight alone",
                missing=True,
            ),
            *(
                column(f"along_{axis}", NUMBER, f"{axis} of that direction, base axes", "1", missing=True)
                for axis in "xyz"
            ),
        ]
    ),
    optional=frozenset(f"along_{axis}" for axis in "xyz"),  # not in stores of stiffcal 0.1
)

_READ_AGAIN = "stiffcal's own, and may change with any version"

READ_RUNS = DeclaredTable(
    "read/runs",
    f"The table `read/runs`: one row per run whose logs were read; {_READ_AGAIN}.",
    pa.schema(
        [
            _RUN,
            column("table", WORD, "the source whose rows hold the run; empty where it has logs of its own"),
            column("key", WORD, "hash of all that its readings depend on"),
            column("n_states", COUNT, "its rows in the table read/states"),
            column("text", WORD, "what else was read, as JSON"),
        ]
    ),
)

READ_STATES = DeclaredTable(
    "read/states",
    f"The table `read/states`: one row per load state before anything of other runs counts; {_READ_AGAIN}.",
    pa.schema(
        [
            column("number", COUNT, "as `row` of the table states"),
            column("time_s", NUMBER, "on the campaign's clock", "s", missing=True),
            column("hold_s", NUMBER, "how long the load was held", "s", missing=True),
            column("n_readings", COUNT, "readings averaged into the state"),
            column("set_aside", WORD, "why the state is not used; empty where it is"),
            column("set_aside_code", WORD, "the cause in one word"),
            column("mean <signal>", NUMBER, "mean of a channel of a signal, SI", missing=True),
            column("scatter <signal>", NUMBER, "standard deviation of its single readings, SI", missing=True),
        ]
    ),
)

READ_SOURCES = DeclaredTable(
    "read/sources",
    f"The table `read/sources`: one row per log, as it was when it was read; {_READ_AGAIN}.",
    pa.schema(
        [
            column("file", WORD, "its path in the campaign's folder"),
            column("bytes", COUNT, "its size"),
            column("modified_ns", COUNT, "when it was last changed, nanoseconds since 1970"),
            column("sha256", WORD, "its hash"),
            column("state", WORD, "what shows without its hash that it is the same"),
        ]
    ),
)

READ_LOG = DeclaredTable(
    "read/log",
    f"A table `read/logs/RUN/SOURCE`: one row per block of a log of a run without load states; {_READ_AGAIN}.",
    pa.schema(
        [
            column("time_s", NUMBER, "mean of the block, on the device's clock", "s"),
            column("start_s", NUMBER, "its first reading", "s"),
            column("end_s", NUMBER, "its last reading", "s"),
            column("count", COUNT, "its readings"),
            column("mean <signal>", NUMBER, "mean of a channel of a signal, SI", missing=True),
            column("variance <signal>", NUMBER, "variance of its single readings, SI", missing=True),
        ]
    ),
    beginnings=("read/logs/",),
)

TABLES = (
    STATES,
    RECORDING,
    FIT,
    HELDOUT_ROWS,
    REFITS,
    ROW_REFITS,
    EVIDENCE,
    READ_RUNS,
    READ_STATES,
    READ_SOURCES,
    READ_LOG,
)
