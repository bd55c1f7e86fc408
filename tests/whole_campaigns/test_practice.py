"""The practice campaigns through the command line, against what was hidden in them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.special import chdtrc

from tests.laboratory.practice_marks import with_practice
from tests.whole_campaigns.conftest import Command

Practice = Callable[[str], Path]
Truth = dict[str, dict[str, Any]]


def stiffness_of(document: dict[str, Any]) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
    """Return compliances and their covariance, in the model's order."""
    names = [one["name"] for one in document["parameters"]]
    order = [document["free_parameters"].index(name) for name in names]
    values = np.array([one["value"] for one in document["parameters"]])
    return values, np.array(document["covariance"])[np.ix_(order, order)]


# `make campaigns` takes all twelve through all steps to their report
@pytest.mark.parametrize("name", with_practice(["01", "05", "08"], "01"))
def test_all_commands_run(name: str, practice: Practice, command: Command) -> None:
    folder = practice(name)
    # a first look by drives alone may find a joint hidden behind what else gives: then it says so and ends with 1
    checked = command("check", folder, codes=(0, 1))
    assert checked["n_states"] > 800
    assert checked["ready"] == (not checked["missing"])
    assert command("ingest", folder)["unchanged"] is False
    assert command("ingest", folder)["unchanged"] is True
    document = command("identify", folder)
    assert document["noise_source"] == "repeats"
    assert all(one["identifiable"] for one in document["parameters"])
    validation = command("validate", folder)
    # whatever is hidden, the drives explain most of the deflection
    assert validation["relative"]["translation"] < 0.3
    assert command("history", folder)["fits"][-1]["heldout_rms"] == validation["rms"]
    command("export", folder, "-o", folder / "states.csv")


@pytest.mark.parametrize("name", with_practice(["01", "08"], "01"))
def test_nothing_hidden(name: str, practice: Practice, command: Command, truth: Truth) -> None:
    folder = practice(name)
    document = command("identify", folder)
    values, covariance = stiffness_of(document)
    off = values - 1.0 / np.array(truth[name]["joint_stiffness"])
    assert chdtrc(len(off), off @ np.linalg.solve(covariance, off)) > 0.001
    validation = command("validate", folder)
    assert validation["rms"]["translation"] <= 1.05 * validation["noise"]["translation"]
    if validation["rms"]["rotation"] is not None:
        assert validation["rms"]["rotation"] <= 1.05 * validation["noise"]["rotation"]


def test_bumped_readings_are_set_aside(practice: Practice, command: Command) -> None:
    assert len(command("identify", practice("11"))["rejected"]) == 6


def test_a_hidden_effect_is_noticed(practice: Practice, command: Command) -> None:
    document = command("identify", practice("02"))
    assert document["reduced_chi2"] > 4.0
    assert any("an effect is missing in the model" in warning for warning in document["warnings"])


def test_raw_logs_have_the_true_clocks(practice: Practice, command: Command, truth: Truth) -> None:
    document = command("ingest", practice("13-raw"))
    for run in document["runs"]:
        wanted = truth["13-raw"]["clock_ahead_s_of_each_run"][run["id"]]
        assert run["clock_ahead_s"]["tracker"]["value"] == pytest.approx(wanted["tracker"], abs=0.010)
        # its joints never move, so that it shares no signal with the others
        assert run["clock_ahead_s"]["controller"]["value"] is None
        assert run["clock_ahead_s"]["controller"]["reason"]


def test_raw_logs_and_their_perfect_reduction_agree(practice: Practice, command: Command) -> None:
    raw, table = command("identify", practice("13-raw")), command("identify", practice("13-table"))
    assert raw["n_states"] == table["n_states"]
    for one, other in zip(raw["parameters"], table["parameters"], strict=True):
        tolerance = max(0.01 * other["stiffness"], other["stiffness_std"])
        assert one["stiffness"] == pytest.approx(other["stiffness"], abs=tolerance), one["name"]
