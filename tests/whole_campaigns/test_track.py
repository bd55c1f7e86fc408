"""An arm on a track, simulated in plain numpy: places and loads, from the folder to the diagnosis and the export."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stiffcal.campaign.loading import load_campaign, load_robot
from stiffcal.campaign.robot.geometry import chain_of
from stiffcal.commands.diagnose import diagnose_campaign
from stiffcal.commands.export import export_campaign
from stiffcal.commands.identify import identify_campaign
from stiffcal.compensation.exports.row_options import row_options
from stiffcal.measurements.load_states import Attachment
from stiffcal.mechanics.kinematics import attached_poses
from stiffcal.results.identify_result import IdentifyResult
from stiffcal.stages.fitted_robot import fitted_robot
from stiffcal.stages.steps import RunContext
from tests.laboratory.gauge_free import aligned_difference
from tests.laboratory.track_simulator import COMPLIANCE, HIGH, LOW, SIGMA, Track, write_absolute, write_loads

pytestmark = pytest.mark.long  # fits and searches of whole campaigns: 5 to 15 s each
N_POSES, N_NUMBERS = 120, 41
"""Numbers: 4 · 6 + 2 of the joints, 3 · 3 of the targets, 6 springs."""


def stiffness_errors(result: IdentifyResult) -> np.ndarray:
    """Return how many standard uncertainties the compliances are off."""
    found = {p.name: p for p in result.parameters if p.effect == "joint-compliance" and p.value is not None}
    errors = []
    for joint, true in enumerate(COMPLIANCE, start=1):
        if (own := found.get(f"joint-compliance.j{joint}.c")) is not None:
            assert own.std is not None
            assert own.value is not None
            assert own.unit == ("m/N" if joint == 1 else "rad/(N·m)")
            errors.append((own.value - true) / own.std)
    return np.array(errors)


@pytest.fixture(scope="module")
def places(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Track, IdentifyResult]:
    robot = Track.drawn(1)
    folder = write_absolute(tmp_path_factory.mktemp("track") / "places", robot, 1, N_POSES)
    return folder, robot, identify_campaign(folder)


def test_places_give_the_truth_within_their_noise(places: tuple[Path, Track, IdentifyResult]) -> None:
    folder, true, result = places
    rows = 9 * N_POSES
    assert result.reduced_chi2 == pytest.approx(1.0, abs=3.0 * np.sqrt(2.0 / (rows - N_NUMBERS)))
    errors = stiffness_errors(result)
    assert len(errors) == 6
    assert float(errors @ errors) < 22.5  # χ² of six, p = 0.001
    # without gauge: predicted by the numbers over the rows, 1.5 times of that as for six axes
    fitted = fitted_robot(load_campaign(folder), RunContext())
    chain, joints = fitted.robot.adjusted_chain, np.random.default_rng(7).uniform(LOW, HIGH, (300, 7))
    found = np.stack([attached_poses(chain, chain.model_angles(joints), t)[0] for t in fitted.setup.targets], axis=1)
    rigid = Track(true.geometry, np.zeros(7))
    expected = np.array([rigid.places(q, np.zeros(3), 0.0) for q in joints])
    left = aligned_difference(found.reshape(-1, 3), expected.reshape(-1, 3))
    assert np.sqrt(np.mean(np.sum(left**2, axis=1))) < 1.5 * SIGMA * np.sqrt(3.0 * N_NUMBERS / rows)


@pytest.mark.practice
@pytest.mark.parametrize(
    ("inclined", "seeds", "most"), [(None, (1, 2), 13.8), (60.0, (1, 2, 4, 5), 18.5)], ids=["track", "60°"]
)
def test_springs_are_right_where_gravity_is_not_quite_as_stated(
    tmp_path: Path, inclined: float | None, seeds: tuple[int, ...], most: float
) -> None:
    """Axes and gravity err by 0.5 mrad; with gravity taken for known χ² is 5.5 and 2.0 times what it may be on average.

    The first spring of each robot alone, and the whole of the residuals. ``most``: χ² of so many, p = 0.001.
    """
    squares, residuals = [], []
    for seed in seeds:
        robot = Track.drawn(seed) if inclined is None else Track.arm(seed, np.radians(inclined))
        springs = ", ".join(map(str, range(1, len(robot.rows))))
        result = identify_campaign(write_absolute(tmp_path / str(seed), robot, seed, N_POSES, springs))
        first = next(p for p in result.parameters if p.name == "joint-compliance.j1.c")
        assert first.value is not None
        assert first.std is not None
        squares.append(((first.value - robot.compliance[0]) / first.std) ** 2)
        assert result.reduced_chi2 is not None
        residuals.append(result.reduced_chi2)
    assert sum(squares) < most
    assert np.mean(residuals) == pytest.approx(1.0, abs=3.3 * np.sqrt(2.0 / (len(seeds) * (9 * N_POSES - N_NUMBERS))))


@pytest.mark.practice
def test_nothing_is_named_where_nothing_is_hidden(places: tuple[Path, Track, IdentifyResult]) -> None:
    folder, _, _ = places
    result = diagnose_campaign(folder)
    assert result.adequate
    assert not result.missing
    reasons = {entry.effect: entry.needs for entry in result.not_tried}
    assert "X1 is prismatic: it has no angle" in reasons["joint-eccentricity"]


@pytest.mark.practice
def test_a_soft_drive_of_the_track_is_named(tmp_path: Path) -> None:
    """Three times what 0.02 mm of noise hides: 150 kg along an axis of 20° give 30 µm."""
    robot = Track.drawn(2)
    robot.compliance[0] = 6e-8
    folder = write_absolute(tmp_path / "places", robot, 2, N_POSES, springs="2, 3, 4, 5, 6")
    (found,) = diagnose_campaign(folder).missing
    # weight pulls the carriage one way, by two forces: other springs of that joint are the same law in these poses, and
    # a foundation that gives moves the targets alike
    names = {(found.effect, *(found.where.joints or ()))}
    names |= {(one.effect, *(one.where.joints or ())) for one in found.alternatives}
    assert ("joint-compliance", 1) in names
    assert found.where.joints == [1]
    assert {name[1:] for name in names - {("base-compliance",)}} == {(1,)}


@pytest.mark.practice
def test_loads_give_the_springs(tmp_path: Path) -> None:
    folder = write_loads(tmp_path / "loads", Track(np.zeros((7, 4))), 3)
    (folder / "robot.toml").write_text(
        (folder / "robot.toml").read_text() + "[geometry]\nlength_sigma_m = 0.0\nangle_sigma_deg = 0.0\n"
    )
    result = identify_campaign(folder)
    errors = stiffness_errors(result)
    assert len(errors) == 6  # forces at the flange turn no last axis
    assert float(errors @ errors) < 22.5
    diagnosis = diagnose_campaign(folder)
    assert not diagnosis.missing
    assert not diagnosis.unexplained


@pytest.mark.parametrize("name", ["calibrated.urdf", "dh.toml", "modified-dh.toml"])
def test_the_calibrated_file_is_the_fitted_robot(places: tuple[Path, Track, IdentifyResult], name: str) -> None:
    folder, _, _ = places
    fitted = fitted_robot(load_campaign(folder), RunContext()).robot.adjusted_chain
    convention = name.removesuffix(".toml") if name.endswith(".toml") else None
    export_campaign(folder, output=folder / name, rows=row_options(convention, strict=False))
    if convention is None:
        (folder / "urdf.toml").write_text(f'schema = "stiffcal/robot/1"\nurdf = "{name}"\nbase_link = "base"\n')
        with (folder / "urdf.toml").open("a") as file:
            file.write('tip_link = "flange"\n')
    again = chain_of(load_robot(folder / (name if convention else "urdf.toml")), folder)
    assert again.prismatic_names == {"X1"}
    joints, flange = np.random.default_rng(8).uniform(LOW, HIGH, (1000, 7)), Attachment(8, np.eye(4))
    (one, turn), (other, other_turn) = (
        attached_poses(chain, chain.model_angles(joints), flange) for chain in (fitted, again)
    )
    assert np.linalg.norm(one - other, axis=1).max() < 1e-6
    assert np.abs(turn - other_turn).max() < 1e-6
