"""A sensor zeroed anew within a table of deflections, loaded minus unloaded."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stiffcal.campaign.loading import load_campaign
from stiffcal.errors import no_progress
from stiffcal.ingest.reading.reducing import reduce_campaign
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.mistakes.displacements.springs import joint_springs
from stiffcal.mistakes.force_zero.tables import rezeroed_table
from tests.laboratory.campaign_folders import MANIFEST, ROBOT, changed

COMPLIANCE = 1.0 / np.array([7e5, 5e5, 4e5, 6e4, 6e4, 2e4])  # rad/(N·m)
NOISE_M = 20e-6
COUNT = 60


@pytest.fixture(scope="module")
def table(tmp_path_factory: pytest.TempPathFactory) -> tuple[LoadStates, Chain]:
    """Sixty rows in as many poses, of a robot whose joints are springs."""
    folder = tmp_path_factory.mktemp("table")
    rng = np.random.default_rng(5)
    (folder / "raw").mkdir()
    (folder / "campaign.toml").write_text(changed(MANIFEST))
    (folder / "robot.toml").write_text(ROBOT)
    rows = np.hstack([rng.uniform(-60, 60, (COUNT, 6)), rng.uniform(-400, 400, (COUNT, 3)), np.zeros((COUNT, 3))])
    rows[:, 9:] = 1e-3 * rows[:, 6:9]  # a table of zeros is refused; the displacements are put in below
    lines = ["A1,A2,A3,A4,A5,A6,Fx,Fy,Fz,dx,dy,dz", *(",".join(f"{value:.6f}" for value in row) for row in rows)]
    (folder / "raw" / "table.csv").write_text("\n".join(lines) + "\n")
    campaign = load_campaign(Path(folder))
    states, chain = reduce_campaign(campaign, no_progress).states, campaign.chain
    reading, per_reading, columns = joint_springs(states, chain)
    torque = (per_reading @ reading[:, :, None])[:, :, 0]
    deflection = states.deflection.copy()
    deflection[:, 0, :3] = np.einsum("ncj,nj->nc", columns, torque * COMPLIANCE)
    deflection[:, 0, :3] += NOISE_M * rng.standard_normal((COUNT, 3))
    return replace(states, deflection=deflection), chain


@pytest.mark.parametrize(("step", "start"), [((30.0, -20.0, 15.0), 31), ((0.0, 0.0, -60.0), 12)])
def test_is_found(step: tuple[float, ...], start: int, table: tuple[LoadStates, Chain]) -> None:
    states, chain = table
    wrench = states.wrench.copy()
    wrench[start:, :3] += step
    (line,) = rezeroed_table(replace(states, wrench=wrench), chain)
    assert f"from state {states.row[start]} on" in line
    reported = np.array([float(cell) for cell in line.split("with (")[1].split(")")[0].split(",")])
    np.testing.assert_allclose(reported, step, atol=6.0)


def test_is_found_in_the_moments_alone(table: tuple[LoadStates, Chain]) -> None:
    states, chain = table
    rng = np.random.default_rng(2)
    wrench = states.wrench.copy()
    wrench[:, 3:] = 60.0 * rng.standard_normal((COUNT, 3))
    moments = replace(states, wrench=wrench)
    reading, per_reading, columns = joint_springs(moments, chain)
    deflection = states.deflection.copy()
    deflection[:, 0, :3] = np.einsum("ncj,nj->nc", columns, (per_reading @ reading[:, :, None])[:, :, 0] * COMPLIANCE)
    deflection[:, 0, :3] += NOISE_M * rng.standard_normal((COUNT, 3))
    moments = replace(moments, deflection=deflection)
    assert rezeroed_table(moments, chain) == []
    wrench = wrench.copy()
    wrench[31:, 3:] += [40.0, -25.0, 0.0]
    (line,) = rezeroed_table(replace(moments, wrench=wrench), chain)
    assert f"from state {states.row[31]} on" in line
    assert "N·m" in line


def test_nothing_is_said_of_good_tables(table: tuple[LoadStates, Chain]) -> None:
    states, chain = table
    assert rezeroed_table(states, chain) == []
    # nor of one that springs explain badly
    rng = np.random.default_rng(1)
    for size in (1e-4, 1e-3):
        other = states.deflection.copy()
        other[:, 0, :3] += size * rng.standard_normal((COUNT, 3))
        assert rezeroed_table(replace(states, deflection=other), chain) == []
