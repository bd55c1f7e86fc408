"""Robots and tables on which orientation does not vary: what is open is a convention, fixed and named, not refused."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stiffcal.campaign.loading import load_campaign
from stiffcal.commands.identify import identify_campaign
from stiffcal.commands.ingest import ingest_campaign, stored_states
from stiffcal.documents import document_of
from stiffcal.errors import InputError
from stiffcal.estimation.undetermined import Undetermined
from stiffcal.fault_codes import FaultCode
from stiffcal.ingest.checks.loaded import check_campaign
from stiffcal.measurements.state_measures import StateMeasure
from stiffcal.reduction.registration.frames import RegistrationSummary
from stiffcal.reduction.registration.registering import in_instrument_axes, register_frames
from tests.laboratory.constant_orientation import ROBOTS, SIGMA, TRACKER, write_campaign

OPEN = {"scara": ["z"], "palletiser": ["z"], "table of one orientation": ["x", "y", "z"]}


def held_of_target(registration: RegistrationSummary | None) -> list[str]:
    assert registration is not None
    frame = registration.frames["target1"]
    assert registration.frames["tracker"].by_convention is None
    assert frame.cannot_be_separated_from == (["tracker"] if frame.by_convention else None)
    return list(frame.by_convention or [])


@pytest.mark.parametrize("name", ROBOTS)
def test_the_convention_is_named_and_the_rest_is_fitted_to_the_noise(tmp_path: Path, name: str) -> None:
    folder = write_campaign(tmp_path / "cell", name)
    found = check_campaign(folder)
    assert (found.ready, found.missing) == (True, [])
    assert held_of_target(found.registration) == OPEN[name]
    result = identify_campaign(folder)
    assert held_of_target(result.registration) == OPEN[name]
    causes = [entry for entry in result.not_identifiable if entry.cause is Undetermined.ONE_ORIENTATION]
    held = {parameter for entry in causes for parameter in entry.parameters}
    assert held == {f"frame.target1.{axis}" for axis in OPEN[name]}
    # as well as plain least squares on all would do: no direction that the places know is held
    assert result.dof
    assert result.reduced_chi2 == pytest.approx(1.0, abs=4.0 * np.sqrt(2.0 / result.dof))
    values = {parameter.name: parameter.value for parameter in result.parameters}
    assert {name for name in held if values[name] is not None} == set()
    document = document_of(result)
    assert document["registration"]["frames"]["target1"]["by_convention"] == OPEN[name]


def test_orientations_of_a_table_that_are_rounded_say_nothing_of_the_target(tmp_path: Path) -> None:
    """Angles to a hundredth of a degree let the orientation vary by 0.1 mrad, which determines the target to metres."""
    folder = write_campaign(tmp_path / "cell", "table of one orientation")
    table = folder / "raw" / "poses.csv"
    header, *rows = table.read_text("utf-8").splitlines()
    cells = np.array([row.split(",") for row in rows], dtype=float)
    cells[:, :6] = np.round(cells[:, :6], 2)
    table.write_text("\n".join([header, *(",".join(map(str, row)) for row in cells)]) + "\n", "utf-8")
    assert held_of_target(check_campaign(folder).registration) == OPEN["table of one orientation"]


def test_poses_on_a_line_are_refused_as_before(tmp_path: Path) -> None:
    """A turn of the instrument about the line is no convention: other places show it."""
    folder = write_campaign(tmp_path / "cell", "scara", n=30)
    table = folder / "raw" / "poses.csv"
    header, *rows = table.read_text("utf-8").splitlines()
    cells = np.array([row.split(",") for row in rows], dtype=float)
    quill = 5.0 * np.arange(30)  # mm, 30 poses, and the other joints stand
    cells[:] = cells[0]
    cells[:, 2] += quill
    cells[:, 4:] += np.outer(quill, TRACKER[:3, :3].T @ [0.0, 0.0, -1.0])
    table.write_text("\n".join([header, *(",".join(map(str, row)) for row in cells)]) + "\n", "utf-8")
    with pytest.raises(InputError) as caught:
        check_campaign(folder)
    assert caught.value.code is FaultCode.REGISTRATION_IMPOSSIBLE


def test_a_given_target_leaves_nothing_open(tmp_path: Path) -> None:
    folder = write_campaign(tmp_path / "cell", "scara", n=30)
    manifest = folder / "campaign.toml"
    before, after = manifest.read_text("utf-8").split("[frames.target1]")
    manifest.write_text(f"{before}[frames.target1]{after.replace('estimate = true', '', 1)}", "utf-8")
    registration = check_campaign(folder).registration
    assert registration is not None
    assert registration.frames["tracker"].by_convention is None
    assert float(registration.rms_m) < 100 * SIGMA


def test_where_displacements_are_measured_too_the_target_has_to_be_given(tmp_path: Path) -> None:
    """What a load does depends on where the target is: there it is no convention."""
    folder = write_campaign(tmp_path / "cell", "scara", n=30)
    ingest_campaign(folder)
    campaign, states = load_campaign(folder), stored_states(folder)
    runs = (
        tuple(replace(run, experiment="load", measures=StateMeasure.DISPLACEMENT) for run in states.runs[:15])
        + states.runs[15:]
    )
    readings = in_instrument_axes(replace(states, runs=runs))
    with pytest.raises(InputError) as caught:
        register_frames(readings, campaign.manifest, campaign.chain, ("tracker", "target1"))
    assert caught.value.code is FaultCode.REGISTRATION_IMPOSSIBLE
    assert caught.value.place == "frames.target1.estimate"
