"""`import stiffcal` in a script or a notebook: the steps of a campaign, their tables, and the store they share."""

from __future__ import annotations

import hashlib
import json
import logging
import signal
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest

import stiffcal
from stiffcal.cli.app import main
from stiffcal.commands.compare import compare_campaigns
from stiffcal.commands.export import export_campaign
from stiffcal.fault_codes import FaultCode
from stiffcal.planning.campaign.request import PlanRequest
from stiffcal.planning.results import ExpectedParameter
from stiffcal.results.value_words import SHIFTED
from stiffcal.trust import record
from tests.laboratory.fits import fit_of
from tests.laboratory.plugin_campaigns import stranger
from tests.laboratory.small_campaign import STIFFNESS, write_small_campaign
from tests.test_project import HEAVY

pytestmark = pytest.mark.usefixtures("few_known_effects")
POSES = pd.DataFrame(
    [[0.0, -90.0, 20.0, 0.0, 40.0, 0.0, -300.0], [10.0, -80.0, 20.0, 0.0, 40.0, 0.0, -500.0]],
    columns=["A1", "A2", "A3", "A4", "A5", "A6", "Fz"],
)


@pytest.fixture(scope="module")
def session(validated_folder: Path) -> stiffcal.CampaignSession:
    """A campaign that no test changes."""
    return stiffcal.open(validated_folder)


@pytest.fixture(scope="module")
def fit(session: stiffcal.CampaignSession) -> stiffcal.FittedModel:
    return session.identify()


def answer(capsys: pytest.CaptureFixture[str], *words: str | Path) -> dict[str, Any]:
    """What a command prints with --json."""
    with pytest.raises(SystemExit):
        main([*map(str, words), "--json"])
    document: dict[str, Any] = json.loads(capsys.readouterr().out)
    return document


def contents(folder: Path) -> dict[str, str]:
    """The SHA-256 of every file by its name."""
    files = [file for file in folder.rglob("*") if file.is_file()]
    return {str(file.relative_to(folder)): hashlib.sha256(file.read_bytes()).hexdigest() for file in files}


# ---- the package ----------------------------------------------------------------------------------------------------


def test_the_import_loads_nothing_heavy_and_offers_every_public_name() -> None:
    code = (
        "import stiffcal, sys, json; loaded = sorted(sys.modules); assert set(stiffcal.__all__) <= set(dir(stiffcal));"
        "[getattr(stiffcal, name) for name in stiffcal.__all__]; print(json.dumps(loaded))"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = set(json.loads(run.stdout))
    assert not loaded & {*HEAVY, "pydantic", "typer", "rich", "stiffcal.errors", "typing"}


def test_a_name_that_is_not_public_is_missed() -> None:
    name = "opened"
    with pytest.raises(AttributeError, match="'stiffcal' has no attribute 'opened'"):
        getattr(stiffcal, name)


def test_an_error_of_input_has_code_file_place_reason_and_mend(tmp_path: Path) -> None:
    with pytest.raises(stiffcal.InputError) as caught:
        stiffcal.open(tmp_path / "nowhere")
    error = caught.value
    assert (error.code, error.reason) == ("file-missing", "no such folder")
    assert error.file == str(tmp_path / "nowhere")
    assert error.place == ""
    assert "stiffcal init" in error.mend


# ---- the fit --------------------------------------------------------------------------------------------------------


def test_parameters_are_those_of_the_command_one_a_row(
    fit: stiffcal.FittedModel, validated_folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    listed = answer(capsys, "identify", validated_folder)["parameters"]
    table = fit.parameters
    assert table.index.tolist() == [entry["name"] for entry in listed]
    assert table["value"].tolist() == [entry["value"] for entry in listed]
    assert table[["low_95", "high_95"]].to_numpy().tolist() == [entry["interval"] for entry in listed]
    assert table["stiffness"].tolist() == [entry["stiffness"] for entry in listed]
    assert set(table["stiffness_unit"]) == {"N·m/rad"}
    assert table["place"].tolist() == ["j1", "j2", "j3", "j4", "j5", "j6"]
    known = (table["stiffness"] - np.array(STIFFNESS)).abs() < 4.0 * table["stiffness_std"]
    assert known.all()


def test_correlation_is_the_covariance_over_the_standard_uncertainties(fit: stiffcal.FittedModel) -> None:
    matrix = fit.correlation
    assert np.diag(matrix.to_numpy()) == pytest.approx(np.ones(6))
    for pair in fit.to_dict()["correlation"]:
        assert matrix.loc[pair["parameters"][0], pair["parameters"][1]] == pytest.approx(pair["correlation"])


def test_a_fit_shows_itself_as_text_and_in_a_notebook(fit: stiffcal.FittedModel) -> None:
    lines = fit.summary().splitlines()
    assert lines[0] == "joint-compliance: 100 load states in 4 runs"
    assert sum("N·m/rad" in line for line in lines) == 6
    assert repr(fit) == fit.summary()
    shown = fit._repr_html_()
    assert shown.count("<tr>") == 1 + 6
    assert shown.count("N·m/rad") == 6


def test_the_pictures_of_the_command_stand_in_a_notebook(session: stiffcal.CampaignSession) -> None:
    plots = session.plot
    for picture in (plots.load_deformation(), plots.against("load", "pose2"), plots.of_fit("normal")):
        assert picture._repr_html_().startswith("<svg")
        assert picture.title in repr(picture)
    with pytest.raises(stiffcal.InputError, match="unknown quantity speed"):
        plots.against("speed")


def test_a_fit_without_load_states_counts_its_readings_and_pure_numbers_have_no_unit() -> None:
    where = {"joints": [1]}
    of_friction = {"effect": "joint-friction", "where": where, "std": 0.1, "fixed": False, "identifiable": True}
    exponent = {"name": "joint-friction.j1.exponent", "value": 1.59, "interval": [1.39, 1.79], "unit": "1"}
    velocity = {"name": "joint-friction.j1.velocity", "value": None, "interval": None, "unit": "rad/s"}
    result = fit_of(
        n_readings=24,
        n_runs=2,
        rms={"translation": None, "rotation": None, "torque": 0.728},
        parameters=[of_friction | exponent, of_friction | velocity | {"std": None}],
    )
    assert stiffcal.FittedModel(result, "", "joint-friction").summary().splitlines() == [
        "joint-friction: 24 readings in 2 runs",
        "  joint-friction.j1.exponent: 1.59 ± 0.20",
        "  joint-friction.j1.velocity: not identifiable",
        "fit 0.728 N·m rms, noise not known",
    ]


def test_nothing_is_fitted_twice(
    campaign: Path, caplog: pytest.LogCaptureFixture, capsys: pytest.CaptureFixture[str]
) -> None:
    """The session finds what the command has fitted, and the command what the session has."""
    with caplog.at_level(logging.INFO, logger="stiffcal"):
        before = stiffcal.open(campaign).identify()
    assert [record.message for record in caplog.records] == ["nothing has changed since fit 1"]
    (campaign / "model.toml").write_text((campaign / "model.toml").read_text().replace("4, 5, 6]", "4, 5]"))
    after = stiffcal.open(campaign).identify()
    assert len(after.parameters) == len(before.parameters) - 1
    found = answer(capsys, "identify", campaign, "--no-update")
    assert found == after.to_dict()


# ---- states and residuals -------------------------------------------------------------------------------------------


def test_states_are_the_table_of_the_store(session: stiffcal.CampaignSession, validated_folder: Path) -> None:
    stored = pd.read_parquet(validated_folder / "store" / "current" / "states.parquet")
    pd.testing.assert_frame_equal(session.states, stored, check_dtype=False)


@pytest.mark.parametrize(("heldout", "table"), [(True, "unseen"), (False, "fit")])
def test_residuals_have_all_that_a_picture_needs(
    heldout: bool, table: str, session: stiffcal.CampaignSession, validated_folder: Path
) -> None:
    stored = pd.read_parquet(validated_folder / "store" / "current" / f"{table}.parquet")
    frame = session.residuals(heldout)
    named = ["run", "row", "branch", "load_N", *(f"tau_{k}_Nm" for k in range(1, 7)), "A1_rad", "noise_m"]
    assert set(named) <= set(frame.columns)
    for component in ("dx_m", "dy_m", "dz_m", "rx_rad"):
        name = f"target_{component}"
        assert frame[f"{name}_residual"].tolist() == stored[f"{name}_residual"].tolist()
        left = frame[f"{name}_measured"] - frame[f"{name}_predicted"]
        assert left.to_numpy() == pytest.approx(frame[f"{name}_residual"].to_numpy(), abs=1e-15)
    assert frame["noise_m"].unique() == pytest.approx([session.identify().to_dict()["noise"]["translation"]])


def test_loads_of_the_fit_s_states_are_those_of_the_same_states_held_out(session: stiffcal.CampaignSession) -> None:
    """They stand in one table of the store and are computed for the other."""
    names = ["state", "branch", "load_N", "tau_2_Nm", "tau_5_Nm"]
    pd.testing.assert_frame_equal(session.residuals(False)[names], session.residuals(True)[names])


# ---- validate, predict, plot ----------------------------------------------------------------------------------------


def test_validation_in_tables(session: stiffcal.CampaignSession) -> None:
    validation = session.validate()
    assert validation.errors.loc["translation", "rms"] == validation.to_dict()["rms"]["translation"]
    assert validation.by("run")["label"].tolist() == ["pose1", "pose2", "pose3", "pose4"]
    assert validation.passed is validation.to_dict()["passed"]
    assert "held-out poses" in validation.summary()
    with pytest.raises(stiffcal.InputError, match="unknown part colour; choose run"):
        validation.by("colour")


def test_prediction_of_a_table_is_that_of_the_file(session: stiffcal.CampaignSession, tmp_path: Path) -> None:
    POSES.to_csv(tmp_path / "poses.csv", index=False)
    of_file = session.predict(tmp_path / "poses.csv")
    radians = POSES.drop(columns="A2").assign(**{"A2 [rad]": np.radians(POSES["A2"].to_numpy())})
    of_table = session.predict(radians)
    pd.testing.assert_frame_equal(of_file.deflection, of_table.deflection)
    stiffness = of_table.stiffness(1)
    assert stiffness is not None
    assert stiffness @ of_table.result.states[1].cartesian_compliance == pytest.approx(np.eye(6), abs=1e-6)


@pytest.mark.parametrize(
    ("poses", "line"),
    [
        (POSES.drop(columns="A3"), r"poses: columns: no column A3; .*\[column-missing\]"),
        (POSES.assign(Fz=[0.0, np.nan]), r"poses: row 2, column Fz: not a finite number.*\[number-invalid\]"),
        (POSES.assign(fz=POSES["Fz"]), r"poses: .*\[column-duplicate\]"),
    ],
    ids=["joint", "nan", "two of one meaning"],
)
def test_poses_that_cannot_be_right_are_named(
    poses: pd.DataFrame, line: str, session: stiffcal.CampaignSession
) -> None:
    with pytest.raises(stiffcal.InputError, match=line):
        session.predict(poses)


def test_a_picture_of_the_residual_on_axes_of_one_s_own(session: stiffcal.CampaignSession) -> None:
    from matplotlib.figure import Figure

    axes = Figure().subplots()
    assert session.plot.residual("tau_4", component="dz", color="A1_deg", ax=axes) is axes
    frame = session.residuals()
    (points,) = axes.collections
    drawn = np.asarray(points.get_offsets())
    assert drawn[:, 0].tolist() == frame["tau_4_Nm"].tolist()
    assert drawn[:, 1] == pytest.approx(1e3 * frame["target_dz_m_residual"].to_numpy())
    assert np.asarray(points.get_array()) == pytest.approx(np.degrees(frame["A1_rad"].to_numpy()))
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("tau_4 [N·m]", "residual dz [mm]")
    with pytest.raises(stiffcal.InputError, match=r"residuals: tau_9: there is no such column; columns: state, run"):
        session.plot.residual("tau_9", ax=axes)
    with pytest.raises(stiffcal.InputError, match="unknown component x; choose dx, dy, dz, rx, ry, rz"):
        session.plot.residual("tau_4", component="x", ax=axes)


# ---- a trial --------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def with_play(tmp_path_factory: pytest.TempPathFactory) -> stiffcal.CampaignSession:
    """A robot whose joint 4 has backlash, which its model does not hold."""
    values = '"backlash.j4.width" = { value = 1.5e-3 }, "backlash.j4.band" = { value = 2.0 }'
    hidden = f'\n[[effects]]\ntype = "backlash"\njoints = [4]\nparameters = {{ {values} }}\n'
    return stiffcal.open(write_small_campaign(tmp_path_factory.mktemp("play") / "small", hidden=hidden))


def test_a_trial_is_a_campaign_with_another_model_and_leaves_all_files_as_they_are(
    with_play: stiffcal.CampaignSession,
) -> None:
    fit = with_play.identify()
    before = contents(with_play.folder)
    trial = with_play.with_effect("backlash", joints=[4])
    better = trial.identify()
    assert better.parameters.loc["backlash.j4.width", "value"] == pytest.approx(1.5e-3, rel=0.1)
    assert trial.validate().errors.loc["translation", "rms"] < 0.6 * fit.to_dict()["expected_rms"]["translation"]
    assert "backlash.j4.width" not in with_play.identify().parameters.index
    assert trial.residuals().shape == with_play.with_effect("backlash", joints=["A4"]).residuals().shape
    assert trial.predict(POSES).deflection.shape == (2, 24)
    # what the last two computed of the campaign's own model lies in its store
    assert {name: contents(with_play.folder)[name] for name in before if "store" not in name} == {
        name: digest for name, digest in before.items() if "store" not in name
    }
    assert contents(with_play.folder) == before
    wider = trial.with_effect("bearing-tilt", joints=[2])
    assert {"backlash", "bearing-tilt"} <= set(wider.identify().parameters["effect"])


def test_a_trial_is_compared_with_the_fit(with_play: stiffcal.CampaignSession) -> None:
    fit = with_play.identify()
    comparison = stiffcal.compare(fit, with_play.with_effect("backlash", joints=[4]))
    errors = comparison.errors
    assert errors.index.tolist() == ["joint-compliance", "joint-compliance + backlash"]
    assert errors["heldout_m"].iloc[1] < 0.6 * errors["heldout_m"].iloc[0]
    table: Any = comparison.parameters
    assert np.isnan(table.loc["backlash.j4.width", "before"])
    assert table.loc["backlash.j4.width", ["effect", "place", "unit"]].tolist() == ["backlash", "j4", "rad"]
    changed = table.loc["joint-compliance.j4.c"]
    assert changed["after"] - changed["before"] == changed["change"]
    assert table["p_value"].isna().all()  # the same readings: no two independent fits


def test_pictures_of_two_models_show_the_same_component_in_the_same_unit(with_play: stiffcal.CampaignSession) -> None:
    from matplotlib.figure import Figure

    trial = with_play.with_effect("backlash", joints=[4])
    labels = {one.plot.residual("tau_4", ax=Figure().subplots()).get_ylabel() for one in (with_play, trial)}
    assert len(labels) == 1
    assert "[mm]" in labels.pop()


def test_a_comparison_shows_the_stiffness_before_and_after(with_play: stiffcal.CampaignSession) -> None:
    values = stiffcal.compare(with_play.identify(), with_play.with_effect("backlash", joints=[4])).before_after
    spring = values.loc["joint-compliance.j4.c"]
    assert spring["unit"] == "N·m/rad"
    assert spring["before_low_95"] < spring["before"] < spring["before_high_95"]
    assert spring["outside_interval"] == (not spring["before_low_95"] <= spring["after"] <= spring["before_high_95"])
    assert np.isnan(values.loc["backlash.j4.width"]["before"])


def test_fits_of_two_campaigns_are_compared_as_the_command_does(
    fit: stiffcal.FittedModel, validated_folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    other = write_small_campaign(tmp_path / "later", seed=2)
    comparison = stiffcal.compare(fit, stiffcal.open(other))
    listed = answer(capsys, "compare", validated_folder, other)["parameters"]
    assert comparison.parameters["p_value"].tolist() == [entry["p_value"] for entry in listed]
    with pytest.raises(stiffcal.InputError, match="compare: after: dict is not a fit"):
        stiffcal.compare(fit, {})  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("effect", "joints", "line"),
    [
        ("backlash", [9], "unknown joint 9"),
        ("blacklash", [4], r"did you mean backlash\?"),
        ("backlash", [], "backlash acts at joints, and none is given"),
    ],
)
def test_a_trial_that_cannot_be_is_named(
    effect: str, joints: list[int], line: str, session: stiffcal.CampaignSession
) -> None:
    with pytest.raises(stiffcal.InputError, match=line):
        session.with_effect(effect, joints=joints)


def test_diagnosis_in_tables(with_play: stiffcal.CampaignSession, tmp_path: Path) -> None:
    diagnosis = with_play.diagnose()
    assert diagnosis.adequate is False
    assert diagnosis.missing[["effect", "place"]].to_numpy().tolist() == [["backlash", "j4"]]
    (missing,) = diagnosis.to_dict()["missing"]
    assert diagnosis.missing["alternatives"].iloc[0].count(";") == max(len(missing["alternatives"]) - 1, 0)
    best = diagnosis.ranking.iloc[0]
    assert (best["effect"], best["place"], best["verdict"]) == ("backlash", "j4", "supported")
    assert best["after_m"] < best["before_m"]
    evidence = diagnosis.evidence("backlash", "j4")
    assert len(evidence) == 100
    assert evidence["after"].std() < evidence["before"].std()
    with pytest.raises(stiffcal.InputError, match="there is no evidence for creep; choose backlash"):
        diagnosis.evidence("creep")
    assert diagnosis.summary() in diagnosis._repr_html_().replace("&#x27;", "'")
    # the fit that was diagnosed marks what the missing effect shifts
    moved = {one.name for one in diagnosis.result.before_after if one.outside_interval}
    fit = with_play.identify()
    assert moved == set(fit.to_dict()["shifted"])
    assert fit.summary().count(SHIFTED) == len(moved) > 0
    assert set(fit.parameters.index[fit.parameters["shifted"]]) == moved
    exported = export_campaign(with_play.folder, output=tmp_path / "model.json")
    assert json.loads((tmp_path / "model.json").read_text())["shifted"] == sorted(moved)
    assert all(name in exported.warnings[0] for name in moved)
    compared = compare_campaigns(with_play.folder, with_play.folder)
    assert {one.name for one in compared.before_after if one.after is not None and one.after.is_shifted} == moved


# ---- what is read, written and planned ------------------------------------------------------------------------------


def test_history_report_and_plan_are_those_of_the_commands(
    session: stiffcal.CampaignSession, validated_folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fits = session.history()
    assert fits.fits["heldout_m"].notna().any()
    assert len(fits.summary().splitlines()) == len(fits.fits) == len(fits.to_dict()["fits"])
    asked: list[tuple[Path | None, bool, bool]] = []

    def written(folder: Path, context: Any, output: Path | None, is_short: bool) -> Any:
        asked.append((output, is_short, context.overwrite))
        return SimpleNamespace(file=str(output))

    monkeypatch.setattr("stiffcal.commands.report.report_campaign", written)
    assert session.report(tmp_path / "two.pdf", short=True, overwrite=True) == tmp_path / "two.pdf"
    assert asked == [(tmp_path / "two.pdf", True, True)]
    known = ExpectedParameter(
        name="a.j1.c", unit="rad/(N·m)", value=1e-6, assumed=False, half_width=1e-8, relative=0.01, from_geometry=None,
        identified=True,
    )  # fmt: skip
    run = SimpleNamespace(id="p1", joints=np.zeros(2), wrench=np.zeros((3, 6)), minutes=2.0, rank=1)
    planned = SimpleNamespace(runs=[run], parameters=[known])

    def plan(folder: Path, context: Any, request: PlanRequest) -> Any:
        assert (folder, request.runs, request.force, request.rivals) == (validated_folder, 2, 300.0, ("a j1", "b j2"))
        return planned

    monkeypatch.setattr("stiffcal.commands.plan.plan_campaign", plan)
    answer = session.plan(runs=2, force=300.0, tell=["a j1", "b j2"])
    assert answer.runs[["loads", "rank"]].to_numpy().tolist() == [[3, 1]]
    assert answer.parameters.loc["a.j1.c", "half_width"] == 1e-8
    assert answer.summary().splitlines() == ["1 run", "  a.j1.c: ± 1.00 %"]


@pytest.mark.parametrize("step", ["report", "history", "plan", "improve"])
def test_a_model_that_is_tried_has_no_step_that_would_write(step: str, session: stiffcal.CampaignSession) -> None:
    trial = session.with_effect("backlash", joints=[4])
    with pytest.raises(stiffcal.InputError) as refused:
        getattr(trial, step)()
    assert refused.value.code is FaultCode.OPTION_INVALID
    assert refused.value.place == step


# ---- how it runs ----------------------------------------------------------------------------------------------------


def test_notes_go_to_the_logger_and_nothing_is_printed(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, capfd: pytest.CaptureFixture[str]
) -> None:
    folder = write_small_campaign(tmp_path / "small", poses=2)
    reported: list[str] = []
    with caplog.at_level(logging.INFO, logger="stiffcal"):
        stiffcal.open(folder, progress=lambda text, fraction: reported.append(text)).validate()
    assert [record.message for record in caplog.records] == [
        "running ingest: nothing is ingested yet",
        "running identify: nothing is fitted yet",
    ]
    assert "fitting without each pose" in reported
    assert capfd.readouterr() == ("", "")


def test_without_update_a_missing_step_is_refused(tmp_path: Path) -> None:
    folder = write_small_campaign(tmp_path / "small", poses=2)
    with pytest.raises(stiffcal.InputError, match="nothing is ingested yet") as caught:
        stiffcal.open(folder, update=False).identify()
    assert caught.value.code == "store-outdated"
    assert not (folder / "store").exists()


def test_the_store_may_lie_elsewhere(campaign: Path, tmp_path: Path) -> None:
    before = contents(campaign)
    fit = stiffcal.open(campaign, store=tmp_path / "elsewhere").identify()
    assert contents(campaign) == before
    assert (tmp_path / "elsewhere" / "current" / "identify.json").exists()
    assert len(fit.parameters) == 6


def test_ctrl_c_ends_a_step_and_the_next_call_goes_on(tmp_path: Path) -> None:
    folder = write_small_campaign(tmp_path / "small", poses=2)

    def interrupt(text: str, fraction: float | None = None) -> None:
        if text == "fitting without each pose":
            signal.raise_signal(signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        stiffcal.open(folder, progress=interrupt).validate()
    assert stiffcal.open(folder, update=False).identify().to_dict()["fit_id"] == "1"
    assert stiffcal.open(folder).validate().to_dict()["rms"]["translation"] > 0.0


@pytest.mark.usefixtures("state")
def test_code_of_the_folder_runs_only_where_it_is_trusted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(record, "_allowed_in_process", set())
    folder = stranger(tmp_path / "stranger")
    with pytest.raises(stiffcal.InputError) as caught:
        stiffcal.open(folder).identify()
    assert caught.value.code == "plugin-untrusted"
    with pytest.raises(stiffcal.InputError, match="'abc' is not a SHA-256"):
        stiffcal.open(folder, trust="abc")
    fit = stiffcal.open(folder, trust=True).identify()
    assert "cross-stiffness" in set(fit.parameters["effect"])
    assert {entry.kind for entry in record.open_record().entries()} == {"generation"}  # its own stores alone
