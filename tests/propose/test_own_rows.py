"""Logs whose signals have rows of their own, and force sensors that log counts."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

from stiffcal.propose.lines import DEFAULT_NAMES
from stiffcal.propose.log_kind import LogKind, log_kind

NET_FT = "Force Units:,N\nCounts per Unit Force:,{force}\nTorque Units:,Nm\nCounts per Unit Torque:,{torque}\n"


def kind_of(path: Path, text: str) -> LogKind:
    path.write_text(text, encoding="utf-8")
    return log_kind(path, path.name, DEFAULT_NAMES)


def test_a_slower_signal_of_the_same_clock_takes_its_rows(tmp_path: Path) -> None:
    """Every time of the tracker is one of the force's: its rows are some of theirs."""
    rows = [f"{k / 100:.2f},{k},1.5,-2.5," + (f"862.{k},75.4,391.8" if k % 5 == 0 else ",,") for k in range(40)]
    kind = kind_of(tmp_path / "union.csv", "\n".join(["t [s],Fx [N],Fy [N],Fz [N],X [mm],Y [mm],Z [mm]", *rows]))
    sources = [kind, *kind.further]
    conditions = [part.rows and tomllib.loads(part.rows.toml)["rows"] for part in sources]
    assert [part.name for part in sources] == ["ft", "tracker"]
    # below the rows looked at the tracker may go on alone
    assert conditions == ["`Fx [N]` != ''", "`X [mm]` != ''"]


@pytest.mark.parametrize(("force", "torque", "units"), [
    (1_000_000, 1_000_000, {"force": "uN", "moment": "uN*m"}), (1_000, 1_000, {"force": "mN", "moment": "mN*m"}),
    (204_800, 1_000_000, {"force": "N", "moment": "N*m"}),
])  # fmt: skip
def test_counts_are_a_unit_where_they_can(force: int, torque: int, units: dict[str, str], tmp_path: Path) -> None:
    head = NET_FT.format(force=force, torque=torque) + "RDT Sequence,F/T Sequence,Fx,Fy,Fz,Tx,Ty,Tz\n"
    rows = "".join(f"{k},{k},{300 * force + k},{k},-5,{k},{torque},7\n" for k in range(9))
    kind = kind_of(tmp_path / "force.csv", head + rows)
    lines = [line.toml for line in kind.signals if line.toml]
    assert tomllib.loads(lines[0])["wrench"]["units"] == units
    questions = [line.doubt for line in kind.signals if not line.toml and line.doubt]
    assert bool(questions) == (units["force"] == "N")


@pytest.mark.parametrize("first", [0, 1])
def test_elements_of_arrays_are_components(first: int, tmp_path: Path) -> None:
    """As numpy, HDF5 and bags hold them: three of one kind; six of a wrench, three forces before three moments."""
    arrays = {"wrench": 6, "position": 3, "velocity": 3}
    names = [f"{stem}[{first + k}]" for stem, count in arrays.items() for k in range(count)]
    rows = "".join(f"{k / 10}," + ",".join(str(n + k / 7) for n in range(12)) + "\n" for k in range(9))
    roles = kind_of(tmp_path / "log.csv", f"t,{','.join(names)}\n{rows}").roles
    found = [
        role and [column.header for column in role.columns] for role in (roles.force, roles.moment, roles.position)
    ]
    assert found == [names[:3], names[3:6], names[6:9]]
    assert [column.header for column in roles.unused] == names[9:]
