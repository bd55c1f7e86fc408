"""Tables without a header: columns are taken where physics decides what they are, and asked for where it does not."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.measurements.load_states import Attachment
from stiffcal.mechanics.kinematics import attached_poses, jacobians
from stiffcal.propose.column_roles import Role, Roles
from stiffcal.propose.from_folder import draft_from_folder
from stiffcal.propose.from_table import chain_of_given, draft_campaign
from stiffcal.propose.table_sniffing import SniffedColumn
from stiffcal.propose.unnamed_columns import roles_by_values

CHAIN = chain_of_given(None, "kr125")
assert CHAIN is not None
FLANGE = Attachment(CHAIN.n_joints, CHAIN.flange)
LOW, HIGH = CHAIN.limits.T


def drawn(n: int, seed: int) -> tuple[np.random.Generator, Floats, Floats]:
    """Return logged angles, deg, and those of the model, rad, in poses all over the limits."""
    assert CHAIN is not None
    rng = np.random.default_rng(seed)
    logged = LOW + (0.1 + 0.8 * rng.random((n, CHAIN.n_joints))) * (HIGH - LOW)
    return rng, np.degrees(logged), CHAIN.model_angles(logged)


def loaded(seed: int = 1) -> tuple[Floats, Floats, Floats]:
    """Return angles, deg, forces, N, and displacements, mm, by springs of the joints and 0.02 mm of noise."""
    assert CHAIN is not None
    rng, logged, angles = drawn(24, seed)
    force = np.tile(np.diag([500.0, 500.0, -800.0]), (8, 1)) + rng.normal(0.0, 15.0, (24, 3))
    arm = jacobians(CHAIN, angles, FLANGE)[:, :3]
    soft = 1e-6 * np.array([0.7, 0.6, 0.8, 5.0, 6.0, 20.0])
    moved = np.einsum("npj,j,nj->np", arm, soft, np.einsum("npj,np->nj", arm, force))
    return logged, force, 1e3 * moved + rng.normal(0.0, 0.02, (24, 3))


def measured(weights: Floats, seed: int = 2) -> tuple[Floats, Floats]:
    """Return angles, deg, and the places of a target, mm, tracker frame, where joints give way under weights."""
    assert CHAIN is not None
    rng, logged, angles = drawn(len(weights), seed)
    at, turned = attached_poses(CHAIN, angles, FLANGE)
    arm = jacobians(CHAIN, angles, FLANGE)[:, :3]
    force = np.outer(weights, CHAIN.gravity)
    sag = np.einsum("npj,j,nj->np", arm, np.full(6, 1e-6), np.einsum("npj,np->nj", arm, force))
    place = at + turned @ np.array([0.08, 0.01, 0.12]) + sag
    tracker = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    return logged, 1e3 * (place @ tracker.T + [3.0, -1.0, 0.5]) + rng.normal(0.0, 0.3, place.shape)


def columns_of(*blocks: Floats) -> list[SniffedColumn]:
    table = np.column_stack(blocks)
    names = [f"column{k + 1}" for k in range(table.shape[1])]
    return [
        SniffedColumn(name, name, None, tuple(values)) for name, values in zip(names, table.T.tolist(), strict=True)
    ]


def numbers(role: Role | None) -> list[int]:
    return [] if role is None else [int(column.header.removeprefix("column")) for column in role.columns]


def test_springs_show_which_columns_are_joints_forces_and_displacements() -> None:
    logged, force, moved = loaded()
    for blocks, wanted in (
        ((logged, force, moved), ([1, 2, 3, 4, 5, 6], [7, 8, 9], [10, 11, 12])),
        ((moved, np.radians(logged), force), ([4, 5, 6, 7, 8, 9], [10, 11, 12], [1, 2, 3])),
        ((np.arange(24.0), force, moved, logged), ([8, 9, 10, 11, 12, 13], [2, 3, 4], [5, 6, 7])),
    ):
        roles = roles_by_values(columns_of(*blocks), CHAIN)
        assert (numbers(roles.joints), numbers(roles.force), numbers(roles.deflection)) == wanted
    assert roles_by_values(columns_of(logged, force, moved), None).joints is None
    mixed = np.random.default_rng(3).permutation(moved)
    assert roles_by_values(columns_of(logged, force, mixed), CHAIN).joints is None


def test_kinematics_shows_which_columns_are_joints_and_places_and_what_they_carry() -> None:
    weights = np.where(np.arange(60) % 2, 120.0, 0.0)
    logged, place = measured(weights)
    tag, temperature = np.arange(1.0, 61.0), 20.0 + np.random.default_rng(4).random(60)
    roles = roles_by_values(columns_of(tag, place, logged, weights, temperature), CHAIN)
    assert (numbers(roles.position), numbers(roles.joints)) == ([2, 3, 4], [5, 6, 7, 8, 9, 10])
    assert numbers(roles.mass) == [11]
    assert [column.header for column in roles.unused] == ["column1", "column12"]
    other = chain_of_given(None, "ur5e")
    assert roles_by_values(columns_of(tag, place, logged, weights), other).joints is None


def test_a_column_of_numbers_that_carries_nothing_is_no_weight() -> None:
    logged, place = measured(np.zeros(60))
    flag = np.where(np.arange(60) % 2, 120.0, 0.0)
    assert roles_by_values(columns_of(place, logged, flag), CHAIN).mass is None


def written(path: Path, *blocks: Floats, delimiter: str = " ") -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    np.savetxt(path, np.column_stack(blocks), fmt="%.6f", delimiter=delimiter)
    return path


def test_init_writes_what_is_decided_and_asks_for_the_rest(tmp_path: Path) -> None:
    logged, force, moved = loaded()
    temperature = 20.0 + np.random.default_rng(5).random(24)
    table = written(tmp_path / "table.txt", logged, force, moved, temperature)
    draft = draft_campaign([table], robot="kr125", tool=(0.0, 0.0, 0.0))
    source = tomllib.loads(draft.manifest)["sources"]["table"]
    assert source["joints"]["position"] == "column1..column6"
    assert source["deflection"]["translation"] == ["column10", "column11", "column12"]
    assert any("column13" in line for line in draft.guessed)
    with pytest.raises(InputError) as caught:
        draft_campaign([table])
    (fault,) = caught.value.faults
    assert fault.code is FaultCode.HEADER_MISSING
    assert ",".join("?" * 13) in fault.mend


def log_of(kind: str, n: int = 200) -> list[Floats]:
    rng = np.random.default_rng(6)
    time = np.arange(n, dtype=np.float64)
    load = np.clip(np.sin(time / 20.0), 0.0, 1.0)[:, None]
    if kind == "force":
        return [20.0 * time, load * [300.0, -50.0, -700.0] + rng.normal(0.0, 0.3, (n, 3))]
    if kind == "place":
        return [0.02 * time, np.array([862.0, 75.0, 391.0]) + load * [0.5, -0.2, -1.0] + rng.normal(0.0, 0.01, (n, 3))]
    return [0.02 * time, np.array([0.0, -70.0, 60.0, 10.0, 40.0, -30.0]) + load * 0.01 + rng.normal(0.0, 1e-3, (n, 6))]


def test_a_folder_of_logs_without_headers(tmp_path: Path) -> None:
    for k in (1, 2, 3):
        for kind in ("force", "place", "joints"):
            written(tmp_path / f"P{k}_{kind}.txt", *log_of(kind), delimiter="\t")
    for robot in ("kr125", None):
        sources = {
            source["file"]: source
            for source in tomllib.loads(draft_from_folder(tmp_path, robot=robot).manifest)["sources"].values()
        }
        assert sources["raw/{run}_force.txt"]["wrench"]["columns"] == ["column2", "column3", "column4"]
        assert sources["raw/{run}_force.txt"]["time"] == {"column": "column1", "unit": "ms"}
        assert sources["raw/{run}_place.txt"]["pose"]["position"] == ["column2", "column3", "column4"]
        assert sources["raw/{run}_place.txt"]["time"] == {"column": "column1", "unit": "s"}
        assert sources["raw/{run}_joints.txt"]["joints"]["position"] == "column2..column7"


def test_signals_of_one_log_are_cut_in_one_way_or_left_open() -> None:
    assert CHAIN is not None
    time, force = log_of("force")
    place, joints = log_of("place")[1], log_of("joints")[1]
    roles = roles_by_values(columns_of(time, joints, force, place), CHAIN)
    assert (numbers(roles.joints), numbers(roles.force)) == ([2, 3, 4, 5, 6, 7], [8, 9, 10])
    assert numbers(roles.position) == [11, 12, 13]
    small = roles_by_values(columns_of(time, 0.05 * force), CHAIN)  # N, or a displacement in mm
    assert small.force is None
    assert small.time is not None
    # six small angles are a place and a rotation vector as well
    assert roles_by_values(columns_of(time, np.radians(joints)), None) == Roles(
        time=small.time, unused=tuple(columns_of(time, np.radians(joints))[1:])
    )


@pytest.mark.parametrize("name", ["table.npy", "table.npz"])
def test_arrays_without_names_go_by_their_values_as_text_does(tmp_path: Path, name: str) -> None:
    write = np.save if name.endswith(".npy") else np.savez
    write(tmp_path / name, np.column_stack(loaded()))
    roles = draft_campaign([tmp_path / name], robot="kr125", tool=(0.0, 0.0, 0.2)).roles
    assert roles is not None
    assert numbers(roles.joints) == [1, 2, 3, 4, 5, 6]
    assert numbers(roles.deflection) == [10, 11, 12]
