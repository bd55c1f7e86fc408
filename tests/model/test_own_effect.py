"""The effect that the documentation shows: tried by the diagnosis like the rest, and named where it is hidden."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from stiffcal.errors import InputError
from stiffcal.judgement.diagnosed import diagnose_states
from stiffcal.measurements.load_states import Sigma
from stiffcal.model.assembled.composite import PlacedEffect
from stiffcal.model.catalogue.catalogue import find_effects
from stiffcal.model.catalogue.plugin_code import PluginCode, read_plugins
from stiffcal.model.effect import Place
from stiffcal.trust.record import open_record
from tests.laboratory.documentation import plugin_of_the_documentation
from tests.laboratory.few_effects import FEW
from tests.laboratory.named_effects import named
from tests.laboratory.robots import six_axes
from tests.laboratory.simulated_states import joint_springs, medium_robot, played


@pytest.fixture
def plugin(tmp_path: Path) -> PluginCode:
    """The file from the documentation."""
    (tmp_path / "cross_stiffness.py").write_text(plugin_of_the_documentation(), encoding="utf-8")
    return allowed(tmp_path, "cross_stiffness.py")


def allowed(folder: Path, *names: str) -> PluginCode:
    """Read a campaign's own code, which its user trusts."""
    open_record().allow_folder(folder)
    return read_plugins(folder, names)


@pytest.mark.long
def test_an_own_effect_is_named(plugin: PluginCode) -> None:
    """Hidden in joint 2, found in joint 2; without the file the same data are unexplained."""
    known = {name: find_effects()[name] for name in FEW}
    catalogue = {**known, "cross-stiffness": find_effects(plugin)["cross-stiffness"]}
    hidden = PlacedEffect(catalogue["cross-stiffness"], Place("joints", (2,)), {"c": 4e-7})
    robot = medium_robot()
    truth = replace(robot, placed=(*robot.placed, hidden))
    states = played(truth, runs=10, noise=Sigma(16e-6, 30e-6), load_scatter=0.03, seed=4, full_pose=False)
    found = diagnose_states(states, joint_springs(six_axes()), catalogue)
    assert named(found) == ["cross-stiffness j2"]
    value = found.last.fit.parameter("cross-stiffness.j2.c").value
    assert value == pytest.approx(4e-7, rel=0.05)
    assert diagnose_states(states, joint_springs(six_axes()), known).unexplained


def test_a_broken_file_is_one_clear_line(tmp_path: Path) -> None:
    """A plugin that does not run, or defines nothing, is the user's input and not a traceback."""
    (tmp_path / "broken.py").write_text("1 / 0\n", encoding="utf-8")
    (tmp_path / "empty_file.py").write_text("x = 1\n", encoding="utf-8")
    for name, words in (
        ("broken.py", "line 1: does not run: ZeroDivisionError"),
        ("empty_file.py", "defines no effect"),
    ):
        with pytest.raises(InputError, match=words):
            find_effects(allowed(tmp_path, name))
