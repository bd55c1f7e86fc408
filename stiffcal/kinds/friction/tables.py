"""The tables of the store that friction runs fill."""

from __future__ import annotations

import pyarrow as pa

from stiffcal.measurements.set_aside import OF_PASSES
from stiffcal.store.declared_table import COUNT, NUMBER, TRUTH, WORD, DeclaredTable, cause_column, column

_RUN = column("run", WORD, "the run's id")
_JOINT = column("joint", WORD, "the joint")
_MOVED = column("joint", WORD, "the joint that moved")
_DRIVE_VELOCITY = column("velocity_radps", NUMBER, "of the drive, at the joint's side of the gear", "rad/s")

PASSES = DeclaredTable(
    "friction",
    "The table `friction`: one row per pass of one joint at constant velocity.",
    pa.schema(
        [
            _RUN,
            _MOVED,
            column("velocity_radps", NUMBER, "as logged, mean over the pass; its sign is the direction", "rad/s"),
            column("torque_Nm", NUMBER, "of the drive at the joint's side of the gear, mean over the stretch", "N·m"),
            column("stretch", COUNT, "passes of one number share a stretch of angle and a speed, and so their weight"),
            column("low_rad", NUMBER, "where the stretch begins", "rad"),
            column("high_rad", NUMBER, "where it ends", "rad"),
            column("start_s", NUMBER, "the velocity was held from, on the log's clock", "s"),
            column("end_s", NUMBER, "until", "s"),
            column("n_readings", COUNT, "samples averaged"),
            column("torque_scatter_Nm", NUMBER, "standard deviation of single samples", "N·m"),
            column("set_aside", WORD, "why the pass is not used; empty where it is"),
            cause_column("pass", OF_PASSES),
        ]
    ),
)

SAMPLES = DeclaredTable(
    "friction_samples",
    "The table `friction_samples`: one row per mean of neighbouring samples within the passes that are used.",
    pa.schema(
        [
            _RUN,
            _MOVED,
            column("reading", COUNT, "the pass: its row in the table `friction`, from 0"),
            column("stretch", COUNT, "as in the table `friction`"),
            column("pose", COUNT, "number of the place where the other joints stood"),
            column("n_readings", COUNT, "neighbouring samples averaged"),
            column("carries_weight", TRUTH, "true where weight acts about the joint's axis"),
            column("time_s", NUMBER, "on the log's clock", "s"),
            column("velocity_radps", NUMBER, "the pass's mean as logged; its sign is the direction", "rad/s"),
            column("angle_rad", NUMBER, "of the joint as logged", "rad"),
            column("torque_Nm", NUMBER, "of the drive at the joint's side of the gear", "N·m"),
            column("load_Nm", NUMBER, "of the weight on the drive; 0 where the masses are not known", "N·m"),
            column("temperature_K", NUMBER, "the first that is logged", "K", missing=True),
            column("travel_rad", NUMBER, "since the direction of motion last changed", "rad", missing=True),
        ]
    ),
)

FREE_MOTION = DeclaredTable(
    "free_motion",
    "The table `free_motion`: one row per sample of a motion in the air that is not steady.",
    pa.schema(
        [
            _RUN,
            column("time_s", NUMBER, "on the log's clock", "s"),
            column("<joint>_model_rad", NUMBER, "angle of the chain's joint, smoothed", "rad"),
            column("<joint>_model_radps", NUMBER, "its velocity", "rad/s"),
            column("<joint>_model_radps2", NUMBER, "its acceleration", "rad/s²"),
            column("<joint>_drive_radps", NUMBER, "velocity of the joint's drive, at the joint's side", "rad/s"),
            column("<joint>_drive_radps2", NUMBER, "its acceleration", "rad/s²"),
            column("<joint>_drive_Nm", NUMBER, "its torque, at the joint's side", "N·m"),
            column(
                "<joint>_one_way", TRUTH, "true where the drive kept its direction for as long as the sample takes in"
            ),
        ]
    ),
)

FIT = DeclaredTable(
    "friction_fit",
    "The table `friction_fit`: one row per bin of passes or sample of other motion that was fitted.",
    pa.schema(
        [
            _RUN,
            _JOINT,
            column(
                "steady",
                TRUTH,
                "true for a mean within passes at constant velocity, false for a sample of other motion",
            ),
            _DRIVE_VELOCITY,
            column("friction_measured_Nm", NUMBER, "measured torque less all but friction over velocity", "N·m"),
            column("friction_Nm", NUMBER, "the fitted friction over velocity", "N·m"),
            column("beside_Nm", NUMBER, "all but friction over velocity: weight, inertia, zeros, ripple", "N·m"),
            column("residual_Nm", NUMBER, "measured less fitted", "N·m"),
        ]
    ),
    beginnings=("friction_fit-",),
)

HELDOUT = DeclaredTable(
    "friction_heldout",
    "The table `friction_heldout`: one row per bin of passes or sample of other motion that was judged.",
    pa.schema(
        [
            _RUN,
            _JOINT,
            _DRIVE_VELOCITY,
            column(
                "residual_Nm",
                NUMBER,
                "measured less predicted by a fit without this speed, or second of motion",
                "N·m",
                missing=True,
            ),
        ]
    ),
    beginnings=("friction_heldout-",),
)

TABLES = (PASSES, SAMPLES, FREE_MOTION, FIT, HELDOUT)
