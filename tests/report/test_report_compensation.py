"""The page of runs with and without compensation: what it says of a simulated campaign, and that it can be drawn."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stiffcal.report.blocks import Paragraph, PictureBlock, ReportSection, TableBlock
from stiffcal.report.compensation_content import WithAndWithout
from stiffcal.report.content import ReportContent
from stiffcal.report.figures.canvas import save_figure
from stiffcal.report.gathering.compensation import with_and_without
from stiffcal.report.provenance_content import ReportProvenance
from stiffcal.report.sections.compensation import section
from stiffcal.simulation.simulate import simulate_campaign
from stiffcal.stages.steps import RunContext, up_to_date_states
from tests.laboratory.simulation_folders import FRAMES, LOGS, MODEL, SETTINGS, write_folder
from tests.simulation.test_controller import SAME, TILT

FILES = 'files = {{ ft = "raw/{0}_ft.csv", tracker = "raw/{0}_tracker.h5", controller = "raw/{0}_joints.parquet" }}\n'
CLOCKS = "clock_ahead_s = { tracker = 0.0, controller = 0.0 }\n"
POSES = {"a": "[-45.8, 4.6, 38.8, -0.1, 51.8, -73.0]", "b": "[12.0, -14.0, 24.0, -55.0, 48.0, 20.0]"}
DROP = (
    "loads = { directions = [[0, 0, -1]], levels = [1.0], both_ways = false, ramp_s = 0.002, ramp_scatter = 0.0, "
    "settle_s = 0.02, hold_s = 1.5, first_hold_s = 1.5 }\n"
)


@pytest.fixture(scope="module")
def pairs(tmp_path_factory: pytest.TempPathFactory) -> WithAndWithout:
    folder = tmp_path_factory.mktemp("twice")
    manifest, runs = FRAMES + LOGS, ""
    for name, joints in POSES.items():
        for on in ("", "-on"):
            manifest += f'[[runs]]\nid = "{name}{on}"\n{FILES.format(name + on)}{CLOCKS}'
            manifest += 'compensation = "on"\n' if on else ""
            runs += f'[[runs]]\nid = "{name}{on}"\njoints_deg = {joints}\n'
    for on in ("", "-on"):
        manifest += f'[[runs]]\nid = "drop{on}"\n{FILES.format("drop" + on)}{CLOCKS}tags = ["step"]\n'
        manifest += 'compensation = "on"\n' if on else ""
        runs += f'[[runs]]\nid = "drop{on}"\njoints_deg = {POSES["a"]}\n{DROP}'
    sensors = "".join(
        f'[sensors.{name}]\nrate_hz = 100.0\nclock = "runs on"\n' for name in ("ft", "tracker", "controller")
    ).replace("rate_hz = 100.0", 'rate_hz = 100.0\npreamble = ["a", "b"]', 1)
    controller = "[controller]\ndelay_s = 0.06\n"
    one_way = "both_ways = false\nhold_s = 1.2\nfirst_hold_s = 1.5\ndirections = [[1, 0, 0], [0, 0, 1]]\n"
    settings = SETTINGS + SAME + one_way + sensors + controller + runs
    campaign, loaded = write_folder(folder / "source", manifest, settings, MODEL + TILT)
    simulate_campaign(campaign, loaded, folder / "out", 1)
    found = with_and_without(up_to_date_states(folder / "out", RunContext()))
    assert found is not None
    return found


def content(pairs: WithAndWithout | None) -> ReportContent:
    return ReportContent(ReportProvenance("twice", "robot", "2026-11-21"), (), (), with_and_without=pairs)


def test_pairs_are_found_by_pose_and_tags(pairs: WithAndWithout) -> None:
    assert [(pose.off.name, pose.on.name) for pose in pairs.poses] == [
        ("a", "a-on"),
        ("b", "b-on"),
        ("drop", "drop-on"),
    ]
    assert [(pair.off.name, pair.on.name) for pair in pairs.over_time] == [("drop", "drop-on")]


def test_errors_are_those_of_the_states_as_measured(pairs: WithAndWithout) -> None:
    for pose in pairs.poses[:2]:
        moved = np.linalg.norm(pose.off.displacement, axis=1)
        assert pose.largest_off[0] == pytest.approx(moved.max())
        assert 5e-4 < pose.error_off[0] < pose.largest_off[0] < 5e-3
        # the controller knows the drives, the bearings' share stays
        assert 0.6 < pose.gone < 0.99
        assert pose.error_on[1] < pose.error_off[1]


def test_the_delay_is_the_controllers(pairs: WithAndWithout) -> None:
    (pair,) = pairs.over_time
    # delay, one cycle, and the 10 ms between two readings
    assert pair.delay == pytest.approx(0.06, abs=0.02)
    assert pair.remaining < 0.4 * pair.uncorrected
    assert pair.off.time[0] < 0.0 < pair.off.time[-1]


def test_the_section_says_what_is_gone_and_is_drawn(pairs: WithAndWithout, tmp_path: Path) -> None:
    made = section(content(pairs))
    assert isinstance(made, ReportSection)
    answer = next(block.text for block in made.blocks if isinstance(block, Paragraph))
    assert "of the deflection is compensated" in answer
    table = next(block for block in made.blocks if isinstance(block, TableBlock))
    assert [row[0] for row in table.rows] == ["a", "b"]
    pictures = [block for block in made.blocks if isinstance(block, PictureBlock)]
    assert len(pictures) == 4
    for number, picture in enumerate(pictures):
        file = tmp_path / f"{number}.svg"
        save_figure(picture.draw(), file)
        assert file.stat().st_size > 5000
    assert "ms after load application" in pictures[-1].caption
    played = next(block.text for block in made.blocks[::-1] if isinstance(block, Paragraph))
    assert played == pairs.played
    assert "correction 60.0 ms after the reading" in played
    assert "a cycle of 4.00 ms" in played


def test_nothing_is_said_where_no_run_was_compensated() -> None:
    assert section(content(None)) is None
