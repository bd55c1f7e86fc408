"""campaigns/max100: paper 000's experiment, Table 2's eight poses alone (the rest would take a minute)."""

from __future__ import annotations

import shutil
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from stiffcal.campaign.loading import load_campaign
from stiffcal.commands.edit_model import edit_model
from stiffcal.commands.identify import identify_campaign
from stiffcal.commands.ingest import stored_states
from stiffcal.commands.simulate import simulate_campaign
from stiffcal.commands.validate import validate_campaign
from stiffcal.documents import document_of
from stiffcal.identification.answers.coupling import without_rods
from stiffcal.identification.bodies.measured_links import measure_links
from stiffcal.identification.readings.observations import observe
from stiffcal.judgement.diagnosed import diagnose_states
from stiffcal.measurements.load_states import LoadStates
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.catalogue.campaign_effects import placed_robot
from stiffcal.model.catalogue.catalogue import find_effects
from tests.laboratory.named_effects import named, named_with_alike

FOLDER = Path(__file__).parents[2] / "campaigns" / "max100"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Simulate Table 2's runs: the manifest and simulate.toml without what lies beyond the paper."""
    source = tmp_path_factory.mktemp("max100") / "robot"
    source.mkdir()
    for name in ("robot.toml", "model.toml"):
        shutil.copyfile(FOLDER / name, source / name)
    manifest, _, beyond = (FOLDER / "campaign.toml").read_text(encoding="utf-8").partition("# Beyond the paper")
    assert beyond
    (source / "campaign.toml").write_text(manifest, encoding="utf-8")
    head, *runs = (FOLDER / "simulate.toml").read_text(encoding="utf-8").split("[[runs]]")
    kept = [run for run in runs if f'"{tomllib.loads(run)["id"]}"' in manifest]
    assert len(kept) == 8
    (source / "simulate.toml").write_text("[[runs]]".join([head, *kept]), encoding="utf-8")
    out = source.parent / "demo"
    simulate_campaign(source, out)
    return out


@pytest.fixture(scope="module")
def states(folder: Path) -> LoadStates:
    return stored_states(folder)


@pytest.fixture(scope="module")
def fitted(folder: Path, states: LoadStates) -> dict[str, Any]:
    return document_of(identify_campaign(folder))


def test_the_swings_stiffness_is_that_of_its_section() -> None:
    section = load_campaign(FOLDER, check_files=False).chain.beams["swing"].section
    assert section is not None
    valued = tomllib.loads((FOLDER / "model.toml").read_text(encoding="utf-8"))["effects"][1]["parameters"]
    for symbol in ("EI2", "EI3", "GJ", "EA"):
        assert valued[f"link-beam.swing.{symbol}"]["value"] == pytest.approx(getattr(section, symbol), rel=1e-4)


def slopes(states: LoadStates) -> Any:
    """Return (8, 5) how much each rod changes per newton of the device, run by run."""
    found = []
    for run in range(8):
        members = (states.run == run) & states.used
        force = states.wrench[members][:, :3]
        along = force @ np.linalg.svd(force - force.mean(axis=0))[2][0]
        lengths = states.lengths[members]
        found.append(((along - along.mean()) @ (lengths - lengths.mean(axis=0))) / np.sum((along - along.mean()) ** 2))
    return np.array(found)


def test_pairs_on_opposite_sides_mirror_each_other_and_shorter_rods_read_less(states: LoadStates) -> None:
    per_newton = slopes(states)
    for one, other in ((1, 2), (3, 4)):
        largest = np.max(np.abs(per_newton[:, [one, other]]), axis=1)
        # what does not mirror is the swing's tension
        assert np.all(np.abs(per_newton[:, one] + per_newton[:, other]) < 0.2 * largest + 2e-10)
    shorter = np.abs(per_newton[:, [3, 4]]).mean(axis=1) < np.abs(per_newton[:, [1, 2]]).mean(axis=1)
    # in pose 4 both bendings partly cancel on the long rods' diagonal
    assert shorter.tolist() == [True, True, True, False, True, True, True, True]


def test_the_swing_from_its_rods(fitted: dict[str, Any]) -> None:
    truth = tomllib.loads((FOLDER / "model.toml").read_text(encoding="utf-8"))["effects"][1]["parameters"]
    found = {one["name"]: one for one in fitted["parameters"]}
    for symbol in ("EI2", "EI3"):
        name = f"link-beam.swing.{symbol}"
        assert found[name]["value"] == pytest.approx(truth[name]["value"], abs=4.0 * found[name]["std"])
        assert found[name]["std"] < 0.01 * found[name]["value"]
    (link,) = fitted["links"]
    assert link["faults"] == []
    assert link["torsion"]["identifiable"] is False
    assert link["torsion"]["bound"] < 2e-3
    assert link["compliance_structure"] == "beam"


def test_adding_the_link_lowers_the_error_on_held_out_poses(
    folder: Path, fitted: dict[str, Any], tmp_path: Path
) -> None:
    gears = tmp_path / "gears"
    shutil.copytree(folder, gears)
    edit_model(gears, "remove", "link-beam", where={"links": "swing"})
    with_link, without = validate_campaign(folder), validate_campaign(gears)
    assert with_link.noise is not None
    error = with_link.rms.translation or np.inf
    assert error < 0.5 * (without.rms.translation or 0.0)
    assert error < 1.2 * (with_link.noise.translation or 0.0)


def test_diagnosis_with_rods_and_without(folder: Path, states: LoadStates) -> None:
    """On gears alone: with rods the swing's bending is named; without them only the set that looks alike.

    Table 2's eight slopes less six gears leave two numbers, which whatever has two parameters makes.
    """
    kinds = (
        "joint-compliance", "bearing-tilt", "joint-translation", "link-beam", "link-springs", "tool-compliance",
    )  # fmt: skip
    catalogue = {name: find_effects()[name] for name in kinds}
    robot = placed_robot(load_campaign(folder))
    gears = replace(robot, placed=tuple(one for one in robot.placed if one.place.kind == "joints"))
    with_rods = diagnose_states(states, gears, catalogue)
    assert named(with_rods) == ["link-beam swing"]
    assert with_rods.found[0].alternatives == ()
    assert not with_rods.unexplained
    tool_alone = diagnose_states(without_rods(states), gears, catalogue)
    assert not any(one.group.firm for one in tool_alone.found)
    (names,) = named_with_alike(tool_alone)
    assert {"link-beam swing", "link-springs swing", "bearing-tilt j2"} <= names


def spoilt(states: LoadStates, fault: str) -> LoadStates:
    """Change the rods' readings as a fault on the machine would."""
    lengths = states.lengths.copy()
    if fault == "swapped-sign":
        lengths[:, 1] *= -1.0
    elif fault == "drifting":
        lengths[:, 4] += 0.15e-6 * (states.time - states.time.min())
    elif fault == "loose":
        lengths[:, 2] = lengths[0, 2] + 0.3 * (lengths[:, 2] - lengths[0, 2])
    return replace(states, lengths=lengths)


@pytest.mark.parametrize(("fault", "rod"), [("swapped-sign", "ids2"), ("drifting", "ids5"), ("loose", "ids3")])
def test_a_wrong_rod_is_named(states: LoadStates, fault: str, rod: str) -> None:
    chain = load_campaign(FOLDER, check_files=False).chain
    (link,) = measure_links(observe(spoilt(states, fault), chain), CompliantRobot(chain, ()))
    assert [(one.kind, one.rods) for one in link.faults] == [(fault, (rod,))]


def test_two_exchanged_rods_are_named_from_the_logs_on(folder: Path, tmp_path: Path) -> None:
    wrong = tmp_path / "wrong"
    shutil.copytree(folder, wrong, ignore=shutil.ignore_patterns("store"))
    for log in sorted((wrong / "raw").glob("*_ids.h5")):
        with h5py.File(log, "r+") as file:
            one, other = file["ids"]["ids1"][...], file["ids"]["ids4"][...]
            file["ids"]["ids1"][...], file["ids"]["ids4"][...] = other, one
    fit = identify_campaign(wrong)
    assert fit.links is not None
    (link,) = fit.links
    assert [(fault.kind, set(fault.rods)) for fault in link.faults] == [("exchanged", {"ids1", "ids4"})]
