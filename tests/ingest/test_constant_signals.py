"""Signals and channels that never change are named; none ends as a fit."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.campaign.loading import load_campaign
from stiffcal.commands.identify import identify_campaign
from stiffcal.errors import Fault, InputError, no_progress
from stiffcal.fault_codes import FaultCode
from stiffcal.ingest.quality.constant_signals import constant_signals
from stiffcal.ingest.reading.reducing import reduce_campaign
from stiffcal.reduction.logs.plausibility import LogQuality
from stiffcal.reduction.logs.summary import LogSummary
from tests.laboratory.displacement_table import DISPLACEMENTS, FORCES, JOINTS, Columns, write_displacement_campaign

COUNT = 24
RANDOM = np.random.default_rng(1)


def seen(signals: dict[str, Floats], columns: dict[str, tuple[str, ...]], file: str = "raw/a.csv") -> LogSummary:
    log = LogQuality(file, "line {}".format, False, columns)
    n = next(iter(signals.values())).shape[1]
    log.update(np.arange(1, n + 1), np.full(n, np.nan), signals)
    return log.summary()


def judged(**signals: tuple[Floats, tuple[str, ...]]) -> tuple[list[Fault], list[str]]:
    names = {name.replace("__", "."): value for name, value in signals.items()}
    names.setdefault("joints", (RANDOM.uniform(-1.0, 1.0, (6, COUNT)), JOINTS))
    log = seen({name: values for name, (values, _) in names.items()}, {name: of for name, (_, of) in names.items()})
    return constant_signals({("table", "raw/a.csv", ""): log})


def noise(channels: int = 3) -> Floats:
    return 1e-4 * RANDOM.standard_normal((channels, COUNT))


DEAD: dict[str, tuple[str, Floats, tuple[str, ...]]] = {
    "displacements": ("translation", np.zeros((3, COUNT)), DISPLACEMENTS),
    "displacements that stand still": ("translation", np.full((3, COUNT), 1e-4), DISPLACEMENTS),
    "rotations": ("rotation", np.zeros((3, COUNT)), ("rx", "ry", "rz")),
    "absolute positions": ("position.tool", np.ones((3, COUNT)), ("X", "Y", "Z")),
    "orientations": ("quaternion.tool", np.eye(4)[:, :1] * np.ones((1, COUNT)), ("q0", "qx", "qy", "qz")),
    "a gauge": ("displacement.gauge", np.zeros((1, COUNT)), ("gauge",)),
    "a rod": ("lengths.rod1", np.zeros((1, COUNT)), ("rod1",)),
    "torques": ("joints.torque", np.zeros((6, COUNT)), ("T1", "T2", "T3", "T4", "T5", "T6")),
    "currents": ("joints.current", np.zeros((6, COUNT)), ("I1", "I2", "I3", "I4", "I5", "I6")),
}


@pytest.mark.parametrize("name", DEAD)
def test_a_signal_that_never_changes_is_a_fault_with_its_columns(name: str) -> None:
    signal, values, columns = DEAD[name]
    faults, _ = judged(**{signal.replace(".", "__"): (values, columns)})
    assert [fault.code for fault in faults] == [FaultCode.READING_IMPLAUSIBLE]
    assert all(column in faults[0].place for column in columns)
    live = values + noise(len(values))
    assert judged(**{signal.replace(".", "__"): (live, columns)}) == ([], [])


def test_one_channel_of_a_signal_is_a_warning_with_its_column() -> None:
    for value in (0.0, 2e-4):
        displacement = noise()
        displacement[2] = value
        faults, (warning,) = judged(translation=(displacement, DISPLACEMENTS))
        assert faults == []
        assert "column dz" in warning
        assert "dx" not in warning


def test_one_rod_of_several_is_a_warning() -> None:
    faults, (warning,) = judged(lengths__a=(noise(1), ("a",)), lengths__b=(np.zeros((1, COUNT)), ("b",)))
    assert faults == []
    assert "column b" in warning


def test_all_rods_are_one_fault() -> None:
    zero = np.zeros((1, COUNT))
    (fault,), _ = judged(lengths__a=(zero, ("a",)), lengths__b=(zero, ("b",)))
    assert fault.place == "columns a, b"


def test_joints_that_stand_still_while_the_target_moves_are_a_fault() -> None:
    position = RANDOM.uniform(-1.0, 1.0, (3, COUNT))
    joints = np.full((6, COUNT), 0.3)
    (fault,), _ = judged(joints=(joints, JOINTS), position__tool=(position, ("X", "Y", "Z")))
    assert fault.code == FaultCode.READING_IMPLAUSIBLE
    assert "A1" in fault.place
    # one pose under loads is a campaign
    assert judged(joints=(joints, JOINTS), position__tool=(1e-3 * position, ("X", "Y", "Z"))) == ([], [])


def test_moments_of_zero_next_to_forces_are_named() -> None:
    force = 1e6 * noise(6)
    force[3:] = 0.0
    faults, (warning,) = judged(wrench=(force, (*FORCES, "Mx", "My", "Mz")))
    assert faults == []
    assert "Mx, My, Mz" in warning
    assert judged(wrench=(np.concatenate([force[:3], 0.0 * force[:3]]), FORCES)) == ([], [])


def test_what_changes_in_another_log_of_the_campaign_is_alive() -> None:
    names: dict[str, tuple[str, ...]] = {"translation": DISPLACEMENTS, "wrench": FORCES}
    first = seen({"translation": np.zeros((3, COUNT)), "wrench": 1e6 * noise()}, names, "a.csv")
    second = seen({"translation": noise(), "wrench": 1e6 * noise()}, names, "b.csv")
    assert constant_signals({("table", "a.csv", "a"): first, ("table", "b.csv", "b"): second}) == ([], [])


def test_rows_of_one_state_need_not_change() -> None:
    joints = (np.full((6, COUNT), 0.3), JOINTS)
    assert judged(joints=joints, position__tool=(np.ones((3, COUNT)), ("X", "Y", "Z"))) == ([], [])


def zeros(*names: str) -> Callable[[Columns], None]:
    def change(columns: Columns) -> None:
        columns.update({name: 0.0 * columns[name] for name in names})

    return change


@pytest.mark.parametrize("names", [DISPLACEMENTS, FORCES, (*FORCES, *DISPLACEMENTS)])
def test_no_fit_is_made_of_zeros(names: tuple[str, ...], tmp_path: Path) -> None:
    folder = write_displacement_campaign(tmp_path / "cell", change=zeros(*names))
    with pytest.raises(InputError) as refused:
        identify_campaign(folder)
    assert [fault.code for fault in refused.value.faults] == [FaultCode.READING_IMPLAUSIBLE]


def test_joint_angles_of_zero_are_remarked(tmp_path: Path) -> None:
    folder = write_displacement_campaign(tmp_path / "cell", change=zeros(*JOINTS))
    warnings = reduce_campaign(load_campaign(folder), no_progress).result.warnings
    assert sum("all joint angles are zero" in warning for warning in warnings) == 1
