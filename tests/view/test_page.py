"""The page for a browser: what is packed into it, what its policy allows, what it leaves out."""

from __future__ import annotations

import base64
import getpass
import hashlib
import re
import shutil
import socket
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stiffcal.commands.diagnose import diagnose_campaign
from stiffcal.commands.history import read_history
from stiffcal.commands.view import view_campaign
from stiffcal.measurements.rms import Rms
from stiffcal.stages.steps import RunContext, up_to_date_states
from stiffcal.view import page as page_module
from stiffcal.view.gathering.sample import MOST_SHOWN
from stiffcal.view.packing import NOISE_SHARE, Packer, unpacked
from stiffcal.view.page import LIVE_SCRIPT, SCRIPTS, WATCH_SCRIPT
from stiffcal.view.shares import share_explained
from tests.laboratory.diagnosed_folders import SMALL, WITHOUT_6, diagnosed_copy
from tests.laboratory.small_campaign import write_small_campaign

FOLDER = Path(page_module.__file__).parent
REPOSITORY = Path(__file__).parents[2]
MOST_LINES, MOST_COLUMNS = 300, 160


@pytest.fixture(scope="module")
def diagnosed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return diagnosed_copy(SMALL, tmp_path_factory.mktemp("view") / "small")


@pytest.fixture(scope="module")
def text(diagnosed: Path, tmp_path_factory: pytest.TempPathFactory) -> str:
    file = tmp_path_factory.mktemp("pages") / "view.html"
    view_campaign(diagnosed, output=file)
    return file.read_text("utf-8")


@pytest.fixture(scope="module")
def friction(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = diagnosed_copy("joints/07", tmp_path_factory.mktemp("friction") / "07")
    view_campaign(folder)
    return folder


def content_of(text: str) -> tuple[dict[str, Any], dict[int, Any]]:
    found = re.search(r'<script type="text/plain" id="data">([^<]*)</script>', text)
    assert found is not None
    return unpacked(found[1])


def array(reference: Any, arrays: dict[int, Any]) -> Any:
    return arrays[reference["$"]["at"]]


def test_arrays_come_back_within_half_a_step() -> None:
    values = np.array([[0.0, 1.25e-3], [np.nan, -2.5e-3], [7e-6, 0.3]])
    packer = Packer()
    small, large = packer.add(values, 1e-5), packer.add(values, 1e-9)
    document, arrays = unpacked(packer.packed({"a": small, "b": [large]}))
    assert (document["a"]["$"]["width"], document["b"][0]["$"]["width"]) == (2, 4)
    for reference, step in ((document["a"], 1e-5), (document["b"][0], 1e-9)):
        assert np.array_equal(np.isnan(array(reference, arrays)), np.isnan(values))
        assert np.nanmax(np.abs(array(reference, arrays) - values)) <= 0.5 * step * (1 + 1e-9)


def test_residuals_are_rounded_below_one_percent_of_the_noise(diagnosed: Path, text: str) -> None:
    document, arrays = content_of(text)
    data = up_to_date_states(diagnosed, RunContext())
    exact = data.store.read_table("fit").column("target_dx_m_residual").to_numpy()
    (present,) = [model for model in document["models"] if model["present"]]
    packed = array(present["residual_fit"][0], arrays)[:, 0]
    per_axis = document["noise"]["translation"] / np.sqrt(3.0)
    where = data.store.read_table("fit").column("state").to_numpy()
    assert 0.0 < np.nanmax(np.abs(packed[where] - exact)) <= 0.5 * NOISE_SHARE * per_axis * (1 + 1e-6)


def test_errors_are_those_of_history_and_of_the_packed_residuals(diagnosed: Path, text: str) -> None:
    document, arrays = content_of(text)
    fits = {f"fit{fit.id}": fit for fit in read_history(diagnosed).fits}
    used = array(document["states"]["used"], arrays) != 0
    for model in document["models"]:
        if model["kind"] == "fit":
            assert fits[model["id"]].heldout_rms == Rms(
                **{k: v for k, v in model["heldout_rms"].items() if k != "kind_"}
            )
        # what the page draws has the error that it states, to the rounding
        residual = array(model["residual_heldout"][0], arrays)[used]
        rms = float(np.sqrt(np.nanmean(np.sum(residual**2, axis=1))))
        assert rms == pytest.approx(model["heldout_rms"]["translation"], rel=0.02)
    assert {model["kind"] for model in document["models"]} == {"fit", "with", "without"}


@pytest.mark.long
@pytest.mark.parametrize("number", ["01", "02"])
def test_absolute_places_are_judged_states_and_their_frames_are_parameters(number: str, tmp_path: Path) -> None:
    folder = tmp_path / "absolute"
    shutil.copytree(REPOSITORY / "campaigns" / "absolute" / number, folder)
    diagnose_campaign(folder)
    view_campaign(folder)
    document, arrays = content_of((folder / "view.html").read_text("utf-8"))
    used = array(document["states"]["used"], arrays) != 0
    assert used.sum() > 20
    candidates = [model for model in document["models"] if model["kind"] == "with"]
    assert candidates
    for model in document["models"]:
        residual = array(model["residual_heldout"][0], arrays)[used]
        rms = float(np.sqrt(np.nanmean(np.sum(residual**2, axis=1))))
        assert rms == pytest.approx(model["heldout_rms"]["translation"], rel=0.02)
    units = {value["name"]: value["unit"] for value in candidates[0]["values"]}
    assert (units["frame.tracker.x"], units["frame.tracker.rx"]) == ("mm", "mrad")
    # what rounding leaves of a torque that no weight makes is nothing that a residual may follow
    torques = [v for v in document["variables"] if v["name"].startswith("torque")]
    assert torques
    assert min(np.ptp(array(torque["values"], arrays)) for torque in torques) > 1e-6
    # frames come with the measurement: no page offers to take them out
    for effect in document["effects"]:
        assert effect["removable"] == (not effect["name"].startswith("frame ")), effect["name"]


@pytest.mark.long
def test_a_clamped_page_draws_the_motor_of_the_fit_and_of_candidates(tmp_path: Path) -> None:
    folder = tmp_path / "clamped"
    shutil.copytree(REPOSITORY / "campaigns" / "joints" / "05", folder)
    diagnose_campaign(folder)
    view_campaign(folder)
    document, arrays = content_of((folder / "view.html").read_text("utf-8"))
    assert document["measure"] == "motor_angle"
    used = array(document["states"]["used"], arrays) != 0
    drawn = [model for model in document["models"] if model["residual_heldout"]]
    assert {model["kind"] for model in drawn} >= {"fit", "with"}
    for model in drawn:
        residual = array(model["residual_heldout"][0], arrays)[used]
        assert rms_of(residual) == pytest.approx(model["heldout_rms"]["motor_angle"], rel=0.02)
        assert np.nanmax(np.abs(residual[:, 1:])) == 0.0
    assert sum(effect["share"] for effect in document["effects"]) == pytest.approx(1.0, abs=0.02)
    # a state names the rows of the log that it was averaged over: their mean time is its time
    states, run = document["states"], document["runs"][0]
    time = np.genfromtxt(folder / run["files"][0], delimiter=",", names=True)["t"]
    first, last, of_run = (array(states[name], arrays).astype(int) for name in ("first_row", "last_row", "run"))
    state_time = array(document["readings"]["time_s"], arrays)
    for k in np.flatnonzero(of_run == 0)[5:-5:20]:
        assert time[first[k] - 1 : last[k]].mean() == pytest.approx(state_time[k], abs=1.5 * (time[1] - time[0]))
        assert states["lines"][k].startswith(f"{time[(first[k] + last[k]) // 2 - 1]:.2f}")
    # candidates with a form of their own have units
    units = {value["name"]: value["unit"] for model in document["models"] for value in model["values"]}
    assert units["encoder-drift.j1.rad_per_K"] == "rad/K"
    assert document["pages"]


def test_a_friction_page_draws_the_torque_of_the_fit_and_of_candidates(friction: Path) -> None:
    document, arrays = content_of((friction / "view.html").read_text("utf-8"))
    (fit,) = read_history(friction).fits
    assert document["measure"] == "torque"
    assert fit.heldout_rms is not None
    assert document["models"][0]["heldout_rms"]["torque"] == fit.heldout_rms.torque
    used = array(document["states"]["used"], arrays) != 0
    # with what is missing, with each of the four other candidates, and without the one effect of the model
    assert [model["kind"] for model in document["models"]] == ["fit", "all", *["with"] * 4, "without"]
    for model in document["models"]:
        residual = array(model["residual_heldout"][0], arrays)[used]
        assert rms_of(residual) == pytest.approx(model["heldout_rms"]["torque"], rel=1e-3)
    (named,) = [model for model in document["models"] if model["effect"] == "stribeck j1"]
    assert named["heldout_rms"]["torque"] < 1.05 * document["noise"]["torque"]
    # measured is the parts of the effects and the residual of the fit
    part = sum(array(effect["part"][0], arrays) for effect in document["effects"])
    residual = array(document["models"][0]["residual_fit"][0], arrays)
    measured = array(document["states"]["measured"][0], arrays)
    assert np.abs(measured - part - residual)[used].max() < 0.05 * document["noise"]["torque"]


def test_the_fits_of_friction_before_the_present_one_stay_drawable(friction: Path, tmp_path: Path) -> None:
    folder = tmp_path / "friction"
    shutil.copytree(friction, folder)
    model = folder / "model.toml"
    model.write_text(model.read_text("utf-8") + '\n[[effects]]\ntype = "stribeck"\njoints = [1]\n', encoding="utf-8")
    diagnose_campaign(folder)
    view_campaign(folder)
    document, arrays = content_of((folder / "view.html").read_text("utf-8"))
    earlier, present = (entry for entry in document["models"] if entry["kind"] == "fit")
    assert present["present"]
    assert (document["change"]["before"], document["change"]["added"]) == (earlier["id"], ["stribeck j1"])
    first = earlier["shares"][0]
    assert (document["change"]["variable"], document["change"]["component"]) == (first["variable"], first["component"])
    # the refit without the added effect is the earlier fit, the earlier refit with it nearly the present one
    (without,) = [
        entry for entry in document["models"] if entry["effect"] == "stribeck j1" and entry["kind"] == "without"
    ]
    assert without["heldout_rms"]["torque"] == pytest.approx(earlier["heldout_rms"]["torque"], rel=1e-3)
    before, _ = content_of((friction / "view.html").read_text("utf-8"))
    (named,) = [entry for entry in before["models"] if entry["effect"] == "stribeck j1"]
    refitted = {entry["name"]: entry["value"] for entry in named["values"]}
    fitted = {entry["name"]: entry["value"] for entry in present["values"]}
    for name in ("joint-friction.j1.coulomb", "joint-friction.j1.viscous"):
        assert refitted[name] == pytest.approx(fitted[name], rel=0.03)
    used = array(document["states"]["used"], arrays) != 0
    for model_of in (earlier, present):
        residual = array(model_of["residual_heldout"][0], arrays)[used]
        assert rms_of(residual) == pytest.approx(model_of["heldout_rms"]["torque"], rel=1e-3)


@pytest.mark.long
def test_the_page_opens_on_what_was_added_last(tmp_path: Path) -> None:
    folder = diagnosed_copy(WITHOUT_6, tmp_path / "small")
    model = folder / "model.toml"
    whole = model.read_text("utf-8").replace("4, 5]", "4, 5, 6]")
    view_campaign(folder)
    assert content_of((folder / "view.html").read_text("utf-8"))[0]["change"] is None
    # no diagnosis of the new model: the directions are those that the last one read of the same states
    model.write_text(whole, encoding="utf-8")
    view_campaign(folder)
    document, _ = content_of((folder / "view.html").read_text("utf-8"))
    (evidence,) = document["evidence"]
    assert (evidence["name"], evidence["standing"]) == ("joint-compliance j6", "added")
    change = document["change"]
    assert (change["before"], change["added"]) == ("fit1", ["joint-compliance j6"])
    assert (change["variable"], change["component"]) == (evidence["variable"], "e1")
    # an effect less is no addition
    model.write_text(whole.replace("4, 5, 6]", "4, 6]"), encoding="utf-8")
    view_campaign(folder)
    assert content_of((folder / "view.html").read_text("utf-8"))[0]["change"] is None
    # what was in the model earlier, was taken out and came back is what was added last
    model.write_text(whole, encoding="utf-8")
    view_campaign(folder)
    change = content_of((folder / "view.html").read_text("utf-8"))[0]["change"]
    assert (change["before"], change["added"]) == ("fit3", ["joint-compliance j5"])


def test_raw_rows_are_those_of_the_file(diagnosed: Path, text: str) -> None:
    document, arrays = content_of(text)
    (run, *_) = document["runs"]
    file = (diagnosed / run["files"][0]).read_text("utf-8").splitlines()
    states = document["states"]
    numbers = array(states["line_number"], arrays)
    assert numbers.min() > 1
    for state in (0, len(numbers) // 2, len(numbers) - 1):
        assert states["lines"][state] == file[int(numbers[state]) - 1]
    assert run["columns"] == file[0].split(",")


def rms_of(residual: Any) -> float:
    return float(np.sqrt(np.nanmean(np.sum(residual**2, axis=1))))


def test_taking_the_part_of_an_effect_out_is_the_prediction_without_it(diagnosed: Path, text: str) -> None:
    document, arrays = content_of(text)
    (first,) = [effect for effect in document["effects"] if effect["name"] == "joint-compliance j1"]
    assert sum(effect["share"] for effect in document["effects"]) == pytest.approx(1.0, abs=0.02)
    assert np.abs(array(first["part"][0], arrays)).max() > 0.0


def test_the_policy_allows_our_script_and_style_alone(text: str) -> None:
    policy = re.search(r'Content-Security-Policy" content="([^"]*)"', text)
    style, script = re.search(r"<style>(.*?)</style>", text, re.S), re.findall(r"<script>(.*?)</script>", text, re.S)
    assert policy is not None
    assert style is not None
    assert len(script) == 1
    rules = dict(rule.strip().split(" ", 1) for rule in policy[1].split(";"))
    assert rules["default-src"] == "'none'"
    for rule, content in (("script-src", script[0]), ("style-src", style[1])):
        digest = base64.b64encode(hashlib.sha256(content.encode()).digest()).decode()
        assert rules[rule] == f"'sha256-{digest}'"
    # the name of SVG is written into pictures that are saved; nothing is fetched from there
    assert "http://" not in text.replace("http://www.w3.org/2000/svg", "")
    assert "https://" not in text


def test_every_file_of_the_code_is_used_and_holds_one_idea() -> None:
    assert {file.name for file in FOLDER.glob("*.js")} == {*SCRIPTS, LIVE_SCRIPT, WATCH_SCRIPT}
    texts = {name: read(name).splitlines() for name in (*SCRIPTS, LIVE_SCRIPT, WATCH_SCRIPT)}
    assert max(len(lines) for lines in texts.values()) <= MOST_LINES
    assert [name for name, lines in texts.items() if max(map(len, lines)) > MOST_COLUMNS] == []
    for forbidden in (
        "innerHTML",
        "outerHTML",
        "insertAdjacentHTML",
        "document.write",
        "eval(",
        "new Function",
        "fetch(",
    ):
        assert not [name for name in SCRIPTS if forbidden in read(name)], forbidden


def read(name: str) -> str:
    return (FOLDER / name).read_text("utf-8")


def test_the_same_store_gives_the_same_bytes_without_names_of_places(
    diagnosed: Path, text: str, tmp_path: Path
) -> None:
    again = tmp_path / "again.html"
    view_campaign(diagnosed, output=again)
    assert again.read_text("utf-8") == text
    document, _ = content_of(text)
    whole = text.replace(re.search(r'id="data">([^<]*)', text)[1], "") + repr(document)  # type: ignore[index]
    for private in (str(diagnosed), str(tmp_path.parent), f"/{getpass.getuser()}/", socket.gethostname()):
        assert private not in whole


def test_without_raw_there_are_no_readings_and_no_names_of_logs(diagnosed: Path, text: str, tmp_path: Path) -> None:
    view_campaign(diagnosed, output=tmp_path / "view.html", raw=False)
    (with_raw, _), (without, _) = content_of(text), content_of((tmp_path / "view.html").read_text("utf-8"))
    assert with_raw["readings"]
    assert any(run["files"] for run in with_raw["runs"])
    assert not without["readings"]
    assert not any(without["states"]["lines"])
    assert not any(run["files"] or run["source"] for run in without["runs"])
    assert "raw/" not in repr(without)


def test_view_fits_nothing(diagnosed: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: Any, **__: Any) -> None:
        raise AssertionError("a fit")

    monkeypatch.setattr("stiffcal.identification.fitting.identify.identify_parameters", refuse)
    monkeypatch.setattr("stiffcal.judgement.diagnosed.judge", refuse)
    result = view_campaign(diagnosed, RunContext(update=False), output=tmp_path / "view.html")
    assert result.n_shown == result.n_states <= MOST_SHOWN


def test_of_many_states_a_sample_holds_all_large_residuals(
    diagnosed: Path, text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("stiffcal.view.gathering.sample.MOST_SHOWN", 40)
    result = view_campaign(diagnosed, output=tmp_path / "view.html")
    assert (result.n_shown, result.n_states > 40) == (40, True)
    (every, all_arrays), (some, arrays) = content_of(text), content_of((tmp_path / "view.html").read_text("utf-8"))
    present, sampled = (next(m for m in document["models"] if m["present"]) for document in (every, some))
    largest = np.sort(np.nansum(array(present["residual_heldout"][0], all_arrays) ** 2, axis=1))[-4:]
    drawn = np.nansum(array(sampled["residual_heldout"][0], arrays) ** 2, axis=1)
    assert np.sort(drawn)[-4:] == pytest.approx(largest, rel=1e-6)
    # errors and shares are of all states
    assert sampled["heldout_rms"] == present["heldout_rms"]
    assert sampled["shares"] == present["shares"]


def test_share_explained_is_that_of_a_known_law() -> None:
    generator = np.random.default_rng(3)
    x = generator.uniform(-1.0, 1.0, 4000)
    law, noise = np.sin(3.0 * x), generator.normal(size=4000)
    expected = np.var(law) / (np.var(law) + 1.0)
    assert share_explained(x, law + noise, levels=False) == pytest.approx(expected, abs=0.03)
    assert share_explained(generator.uniform(size=4000), noise, levels=False) < 0.01
    assert share_explained(np.repeat([0.0, 1.0], 2000), np.repeat([1.0, -1.0], 2000), levels=True) == 1.0


def test_hostile_names_stand_in_the_packed_data_alone(tmp_path: Path) -> None:
    folder = write_small_campaign(tmp_path / "small", poses=3)
    manifest = folder / "campaign.toml"
    hostile = "</script><script>alert(1)</script>\\\"'"
    lines = [line for line in manifest.read_text("utf-8").splitlines() if not line.startswith("name = ")]
    at = 1 + next(number for number, line in enumerate(lines) if line.startswith("schema"))
    manifest.write_text("\n".join([*lines[:at], f'name = "{hostile}"', *lines[at:]]) + "\n", encoding="utf-8")
    view_campaign(folder, output=tmp_path / "view.html")
    text = (tmp_path / "view.html").read_text("utf-8")
    assert content_of(text)[0]["campaign"].startswith("</script><script>alert(1)")
    assert "alert" not in text
    assert text.count("</script>") == 2
