"""The tables of friction runs for their schemas: a specimen of each, and what its columns mean."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from stiffcal.kinds.friction.answers.documents import friction_fit_columns, heldout_columns
from stiffcal.kinds.friction.fitting.joint_fits import FrictionFit
from stiffcal.kinds.friction.fitting.torque_rows import steady_rows
from stiffcal.kinds.friction.logs.readings import FreeMotion, SteadyReadings, motion_table, steady_table
from stiffcal.kinds.friction.logs.samples import PassSamples, samples_table
from stiffcal.measurements.columns import table_of
from stiffcal.measurements.load_states import RunInfo
from stiffcal.measurements.set_aside import OF_PASSES
from stiffcal.measurements.table_specimens import ColumnDescription, TableSpecimen, cause_column

_ONE = np.zeros(1)
_FIRST = np.zeros(1, dtype=np.int64)

FRICTION: Mapping[str, ColumnDescription] = {
    "run": ColumnDescription("the run's id"),
    "joint": ColumnDescription("the joint that moved"),
    "velocity_radps": ColumnDescription("as logged, mean over the pass; its sign is the direction", "rad/s"),
    "torque_Nm": ColumnDescription("of the drive at the joint's side of the gear, mean over the stretch", "N·m"),
    "stretch": ColumnDescription("passes of one number share a stretch of angle and a speed, and so their weight"),
    "low_rad": ColumnDescription("where the stretch begins", "rad"),
    "high_rad": ColumnDescription("where it ends", "rad"),
    "start_s": ColumnDescription("the velocity was held from, on the log's clock", "s"),
    "end_s": ColumnDescription("until", "s"),
    "n_readings": ColumnDescription("samples averaged"),
    "torque_scatter_Nm": ColumnDescription("standard deviation of single samples", "N·m"),
    "set_aside": ColumnDescription("why the pass is not used; empty where it is"),
    "set_aside_code": cause_column("pass", OF_PASSES),
}

FRICTION_SAMPLES: Mapping[str, ColumnDescription] = {
    "run": ColumnDescription("the run's id"),
    "joint": ColumnDescription("the joint that moved"),
    "reading": ColumnDescription("the pass: its row in the table `friction`, from 0"),
    "stretch": ColumnDescription("as in the table `friction`"),
    "pose": ColumnDescription("number of the place where the other joints stood"),
    "n_readings": ColumnDescription("neighbouring samples averaged"),
    "carries_weight": ColumnDescription("true where weight acts about the joint's axis"),
    "time_s": ColumnDescription("on the log's clock", "s"),
    "velocity_radps": ColumnDescription("the pass's mean as logged; its sign is the direction", "rad/s"),
    "angle_rad": ColumnDescription("of the joint as logged", "rad"),
    "torque_Nm": ColumnDescription("of the drive at the joint's side of the gear", "N·m"),
    "load_Nm": ColumnDescription("of the weight on the drive; 0 where the masses are not known", "N·m"),
    "temperature_K": ColumnDescription("the first that is logged; not a number where none is", "K"),
    "travel_rad": ColumnDescription(
        "since the direction of motion last changed; not a number where that is not logged", "rad"
    ),
}

FREE_MOTION: Mapping[str, ColumnDescription] = {
    "run": ColumnDescription("the run's id"),
    "time_s": ColumnDescription("on the log's clock", "s"),
    "<joint>_model_rad": ColumnDescription("angle of the chain's joint, smoothed", "rad"),
    "<joint>_model_radps": ColumnDescription("its velocity", "rad/s"),
    "<joint>_model_radps2": ColumnDescription("its acceleration", "rad/s²"),
    "<joint>_drive_radps": ColumnDescription("velocity of the joint's drive, at the joint's side of the gear", "rad/s"),
    "<joint>_drive_radps2": ColumnDescription("its acceleration", "rad/s²"),
    "<joint>_drive_Nm": ColumnDescription("its torque, at the joint's side", "N·m"),
    "<joint>_one_way": ColumnDescription("true where the drive kept its direction for as long as the sample takes in"),
}

FRICTION_FIT: Mapping[str, ColumnDescription] = {
    "run": ColumnDescription("the run's id"),
    "joint": ColumnDescription("the joint"),
    "steady": ColumnDescription(
        "true for a mean within passes at constant velocity, false for a sample of other motion"
    ),
    "velocity_radps": ColumnDescription("of the drive, at the joint's side of the gear", "rad/s"),
    "friction_measured_Nm": ColumnDescription("measured torque less all but friction over velocity", "N·m"),
    "friction_Nm": ColumnDescription("the fitted friction over velocity", "N·m"),
    "beside_Nm": ColumnDescription("all but friction over velocity: weight, inertia, zeros, ripple", "N·m"),
    "residual_Nm": ColumnDescription("measured less fitted", "N·m"),
}

FRICTION_HELDOUT: Mapping[str, ColumnDescription] = {
    "run": ColumnDescription("the run's id"),
    "joint": ColumnDescription("the joint"),
    "velocity_radps": ColumnDescription("of the drive, at the joint's side of the gear", "rad/s"),
    "residual_Nm": ColumnDescription(
        "measured less predicted by a fit without this speed, or second of motion", "N·m", missing=True
    ),
}


def friction_specimens() -> dict[str, TableSpecimen]:
    """Return the tables of friction runs with one row each."""
    joints = ("<joint>",)
    return {
        "friction": TableSpecimen(
            "The table `friction`: one row per pass of one joint at constant velocity.",
            steady_table(_passes(), joints),
            FRICTION,
        ),
        "friction_samples": TableSpecimen(
            "The table `friction_samples`: one row per mean of neighbouring samples within the passes that are used.",
            samples_table(_samples(), joints),
            FRICTION_SAMPLES,
        ),
        "free_motion": TableSpecimen(
            "The table `free_motion`: one row per sample of a motion in the air that is not steady.",
            motion_table(_motion(), joints),
            FREE_MOTION,
        ),
        "friction_fit": TableSpecimen(
            "The table `friction_fit`: one row per bin of passes or sample of other motion that was fitted.",
            table_of(friction_fit_columns(_friction_fit(), joints)),
            FRICTION_FIT,
        ),
        "friction_heldout": TableSpecimen(
            "The table `friction_heldout`: one row per bin of passes or sample of other motion that was judged.",
            table_of(heldout_columns(steady_rows(_samples()), _ONE, joints)),
            FRICTION_HELDOUT,
        ),
    }


def _passes() -> SteadyReadings:
    first = np.ones(1, dtype=np.int64)
    return SteadyReadings(
        runs=(RunInfo("run"),), run=_FIRST, joint=first, velocity=_ONE, torque=_ONE, stretch=_FIRST, low=_ONE,
        high=_ONE, start=_ONE, end=_ONE, n_readings=first, scatter=_ONE, set_aside=np.array([""]),
        set_aside_code=np.array([""]),
    )  # fmt: skip


def _samples() -> PassSamples:
    first = np.ones(1, dtype=np.int64)
    return PassSamples(
        runs=(RunInfo("run"),), run=_FIRST, joint=first, reading=_FIRST, stretch=_FIRST, pose=_FIRST, time=_ONE,
        velocity=_ONE, angle=_ONE, torque=_ONE, load=_ONE, carries_weight=np.ones(1, dtype=np.bool_),
        temperature=_ONE, travel=_ONE, n_readings=first, logged_travel={1: (0.0, 0.0)}, first_temperature={1: 0.0},
    )  # fmt: skip


def _motion() -> FreeMotion:
    zero = np.zeros((1, 1))
    return FreeMotion(
        (RunInfo("run"),), _FIRST, _ONE, zero, zero, zero, zero, zero, zero, np.ones((1, 1), dtype=np.bool_)
    )


def _friction_fit() -> FrictionFit:
    rows = steady_rows(_samples())
    return FrictionFit((), rows, _ONE, _ONE, _ONE, _ONE, _ONE, _ONE, 0, None, 1.0, False, (), ())
