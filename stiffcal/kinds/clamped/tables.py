"""The tables of the store that clamped runs fill."""

from __future__ import annotations

import pyarrow as pa

from stiffcal.store.declared_table import COUNT, NUMBER, TRUTH, WORD, DeclaredTable, column, columns

READINGS = DeclaredTable(
    "clamped",
    "The table `clamped`: one row per reading of a clamped run.",
    pa.schema(
        [
            column("run", WORD, "the run's id"),
            column("time_s", NUMBER, "on the clock of the log that holds the motor angles", "s"),
            column("<joint>_rad", NUMBER, "angle of the motor at the joint's side of the gear", "rad", missing=True),
            *columns("F{}_N", "xyz", "force of the fixture on the robot, sensor axes", "N", missing=True),
            *columns("M{}_Nm", "xyz", "moment likewise", "N·m", missing=True),
            column(
                "<joint>_Nm", NUMBER, "torque of the motor at the joint's side, friction included", "N·m", missing=True
            ),
        ]
    ),
)

BRANCHES = DeclaredTable(
    "clamped_branches",
    "The table `clamped_branches`: one row per bin of angle and direction, averaged over the half sweeps of a run.",
    pa.schema(
        [
            column("run", WORD, "the run's id"),
            column("joint", COUNT, "the joint that was driven, from 1"),
            column("angle_rad", NUMBER, "mean angle of the readings in the bin", "rad"),
            column("torque_Nm", NUMBER, "mean torque on the arm", "N·m"),
            column("up", TRUTH, "true where the angle was growing"),
            column("spread_Nm", NUMBER, "standard deviation between half sweeps", "N·m", missing=True),
            column("half_sweeps", COUNT, "half sweeps that went through the bin"),
            column("law_Nm", NUMBER, "torque of the fitted law", "N·m"),
            column("residual_Nm", NUMBER, "measured less fitted", "N·m"),
        ]
    ),
)
TABLES = (READINGS, BRANCHES)
