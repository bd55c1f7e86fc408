"""A base that is moved between two rows of absolute places: found by its row, and not where there is none."""

from __future__ import annotations

import shutil
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.special import chdtrc, ndtri

from stiffcal.arrays import Floats
from stiffcal.effects.joint_compliance import JointCompliance
from stiffcal.effects.link_geometry import LinkGeometry
from stiffcal.identification.identify import identify_parameters
from stiffcal.identification.moved_base import MovedBase, moved_base
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.rotations import rotation_from_vector
from stiffcal.model.composite import CompliantRobot
from stiffcal.model.measured_frames import placed_frame
from stiffcal.workflow.diagnose import diagnose_campaign
from tests.laboratory.absolute_places import SIGMA, TARGET, absolute_states, measured_by, on_all_joints
from tests.laboratory.robots import SIX_STIFFNESS, six_axes

N, ROW = 80, 50
CAMPAIGN = Path(__file__).parents[2] / "campaigns" / "absolute" / "01"


@cache
def measured(seed: int) -> LoadStates:
    """Return rows of a robot whose links are off and whose joints give."""
    rng, chain = np.random.default_rng([3, seed]), six_axes()
    errors = [dict(zip(("x", "y", "rx", "ry"), 4e-4 * rng.normal(size=4), strict=True)) for _ in range(6)]
    springs = [{"c": 1.0 / float(stiffness)} for stiffness in SIX_STIFFNESS]
    true = (*on_all_joints(LinkGeometry(), 6, errors), *on_all_joints(JointCompliance(), 6, springs))
    return measured_by(CompliantRobot(chain, true), absolute_states(chain, N, seed), 100 + seed)


def found(states: LoadStates, change: Floats, turn: Floats | None = None) -> MovedBase | None:
    """Return the move in rows whose places are changed by (n, 3) m, and turned by a rotation vector from `ROW` on."""
    model = (
        placed_frame("tracker", True), placed_frame(TARGET, False),
        *on_all_joints(LinkGeometry(), 6), *on_all_joints(JointCompliance(), 6),
    )  # fmt: skip
    position = states.position.copy()
    if turn is not None:
        centre = position[ROW:].mean(axis=0)
        position[ROW:] = (position[ROW:] - centre) @ rotation_from_vector(turn).T + centre
    states = replace(states, position=position + change[:, None])
    return moved_base(identify_parameters(states, CompliantRobot(six_axes(), model)), states)


def from_row_on(shift: tuple[float, float, float]) -> Floats:
    return np.where(np.arange(N)[:, None] >= ROW, shift, 0.0)


def test_a_shift_is_named_with_its_row_and_size() -> None:
    shift = (6e-5, -8e-5, 0.0)
    move = found(measured(1), from_row_on(shift))
    assert move is not None
    assert move.state == ROW
    # thirty rows after it, known to 20 µm each
    assert move.shift == pytest.approx(shift, abs=5.0 * SIGMA / np.sqrt(N - ROW) + 1e-5)
    assert move.standard_errors > 5.0
    assert np.flatnonzero(move.leave_out).tolist() == list(range(ROW, N))


def test_a_turn_is_one_too() -> None:
    move = found(measured(2), np.zeros((N, 3)), np.array([0.0, 0.0, 1e-4]))
    assert move is not None
    assert abs(move.state - ROW) <= 1
    assert move.turn[2] == pytest.approx(1e-4, abs=3e-5)


def test_there_is_none_where_nothing_moved() -> None:
    assert [seed for seed in range(1, 11) if found(measured(seed), np.zeros((N, 3))) is not None] == []


def test_a_drift_is_no_move() -> None:
    for seed in (1, 2, 3):
        drift = np.linspace(0.0, 2e-4, N)[:, None] * np.array([1.0, -0.5, 0.3])
        assert found(measured(seed), drift) is None
        settling = 2e-4 * (1.0 - np.exp(-np.arange(N) / 25.0))[:, None] * np.array([0.4, 1.0, -0.2])
        assert found(measured(seed), settling) is None


def model_error(rng: np.random.Generator, alike: float) -> Floats:
    """Return (n, 3) m of an error ten times the noise, rows a share ``alike`` of the one before it."""
    error = 10.0 * SIGMA * rng.standard_normal((N, 3))
    for k in range(1, N):
        error[k] = alike * error[k - 1] + np.sqrt(1.0 - alike**2) * error[k]
    return error


def test_errors_that_neighbouring_rows_share_are_no_move() -> None:
    """Rows of a path through the workspace: the model's error changes slowly along it."""
    for seed in range(1, 11):
        assert found(measured(1), model_error(np.random.default_rng([7, seed]), 0.9)) is None


def test_a_move_is_found_next_to_an_error_of_the_model() -> None:
    """Rows in poses that follow no order: neighbours share nothing, and nothing is taken off."""
    for seed in (1, 2, 3):
        change = model_error(np.random.default_rng([7, seed]), 0.0) + from_row_on((8e-4, -8e-4, 4e-4))
        move = found(measured(1), change)
        assert move is not None
        assert abs(move.state - ROW) <= 1
        assert move.standard_errors > 5.0


def test_the_diagnosis_judges_the_longer_side(tmp_path: Path) -> None:
    folder = Path(shutil.copytree(CAMPAIGN, tmp_path / "moved", ignore=shutil.ignore_patterns("store")))
    file = folder / "raw" / "poses.csv"
    head, *rows = file.read_text(encoding="utf-8").splitlines()
    column = head.split(",").index("X1")
    for k in range(ROW, len(rows)):
        cells = rows[k].split(",")
        cells[column] = f"{float(cells[column]) + 0.3:.6f}"
        rows[k] = ",".join(cells)
    file.write_text("\n".join([head, *rows]) + "\n", encoding="utf-8")
    diagnosis = diagnose_campaign(folder)
    assert diagnosis.missing == []
    (suspect,) = diagnosis.suspects or []
    assert (suspect.run, suspect.row) == ("poses", ROW + 1)
    assert f"rows = {list(range(ROW + 1, len(rows) + 1))}" in suspect.exclude
    # with them the model does not suffice, and no effect of the catalogue accounts for a move
    assert diagnosis.with_suspects is not None
    assert diagnosis.with_suspects.missing == []
    assert diagnosis.with_suspects.unexplained
    assert diagnosis.unexplained is False


def test_all_rows_are_allowed_for(monkeypatch: pytest.MonkeyPatch) -> None:
    """The largest of 80 falls is 80 times as probable by chance as one of them (Bonferroni)."""
    of_one: list[float] = []

    def recorded(dof: float, fall: float) -> float:
        of_one.append(float(chdtrc(dof, fall)))
        return of_one[-1]

    monkeypatch.setattr("stiffcal.identification.moved_base.chdtrc", recorded)
    move = found(measured(1), from_row_on((6e-5, -8e-5, 0.0)))
    assert move is not None
    assert move.standard_errors == pytest.approx(-ndtri(N * of_one[-1] / 2.0), rel=1e-9)
