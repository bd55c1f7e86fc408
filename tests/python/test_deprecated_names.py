"""What plugins and notebooks of version 0.1 were written with keeps working in 0.2, with a warning."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stiffcal.effects_api as api
from stiffcal.model import effect as effect_module
from stiffcal.model.catalogue import built_in_effects, find_effects
from stiffcal.model.plugin_code import PluginCode, read_plugins
from stiffcal.trust.record import open_record
from stiffcal.workflow.effects import describe_effects
from tests.laboratory.documentation import plugin_of_the_documentation
from tests.laboratory.small_campaign import write_small_campaign

ROOT = Path(__file__).parents[2]

# README.md of version 0.1, to the letter.
PLUGIN = '''"""A lab's own effect: a joint gets softer and stiffer as joint 1 turns."""

import numpy as np

from stiffcal.model.effect import RZ, DocumentedEffect, Kind, ParameterSpec, Term, joint_node


class CrossStiffness(DocumentedEffect):
    """The compliance of a joint follows the sine of 2.3 times the angle of joint 1: δ_Rz = c sin(2.3 q1) τ."""

    name = "cross-stiffness"
    kind = Kind.NODE_LAW
    place_kind = "joints"
    summary = "the joint's compliance follows joint 1's angle"
    parameters = (ParameterSpec("c", "rad/(N·m)", "amplitude of the change", -1e-3, 1e-3, 1e-7, "our cell"),)
    fingerprint = "the residual is proportional to the joint's torque, with a factor that joint 1's angle sets"
    how_to_check = "Repeat one load on the joint at several angles of joint 1."

    def terms(self, place, chain, loads, shape):
        node = joint_node(place.joints[0])
        return (Term(node, RZ, "c", np.sin(2.3 * loads.angles[0]) * loads.wrench[node, RZ]),)
'''
# A plugin with every name of `stiffcal.model.effect` that was another one in version 0.1.
RENAMED = (
    PLUGIN.replace("import RZ,", "import RZ, Driver, Sort,").replace(
        '1e-7, "our cell"),)',
        '1e-7, "our cell"),\n        ParameterSpec("f", "1", "factor", 1.0, 4.0, 2.3, "our cell", sort=Sort.SHAPE),)',
    )
    + """
    def shape_grid(self, place, chain, loads):
        found = super().shape_grid(place, chain, loads)
        assert [spec.symbol for spec in self.parameters if spec.sort is Sort.SHAPE] == list(found)
        return {"f": np.array([2.0, 2.3])}

    def driver(self, place, chain, loads):
        assert super().driver(place, chain, loads) is None
        return Driver("torque", "N·m", loads.wrench[joint_node(place.joints[0]), RZ])
"""
)
NOTEBOOK = """
from pathlib import Path
from stiffcal.workflow.identify import identify_campaign
from stiffcal.workflow.validate import validate_campaign

folder = Path("campaigns/fanuc-r2000ic")
fit = identify_campaign(folder)
{one["name"]: one["stiffness"] for one in fit["parameters"]}
validate_campaign(folder)["rms"]
"""
LOOP = """
from pathlib import Path

import numpy as np

from stiffcal.campaign.loading import load_campaign
from stiffcal.compensation.step import CompensationStep, StepSettings
from stiffcal.workflow.steps import Means
from stiffcal.workflow.valued import valued_campaign

robot = valued_campaign(load_campaign(Path("campaigns/irb4400"), check_files=False), Means())
step = CompensationStep(robot.robot, robot.setup, StepSettings(cycle_s=0.004, cutoff_hz=20.0))
joints, reading = np.radians([0.0, 10.0, 30.0, 0.0, 60.0, 0.0]), np.array([100.0, 0.0, -300.0, 0.0, 0.0, 0.0])
offsets = step(joints, reading)  # rad, to be added to the commanded joints; the same array each time
"""


def allowed(folder: Path, text: str) -> PluginCode:
    """Write a plugin that its user trusts."""
    (folder / "own.py").write_text(text, encoding="utf-8")
    open_record().allow_folder(folder)
    return read_plugins(folder, ["own.py"])


def loads(chain: api.Chain, n: int = 3) -> api.NodeLoads:
    return api.NodeLoads(np.ones((2 * chain.n_joints + 2, 6, n)), np.full((chain.n_joints, n), 0.3))


@pytest.mark.usefixtures("state")
def test_the_plugin_of_the_readme_of_0_1_runs_and_warns_of_its_import(tmp_path: Path, chain: api.Chain) -> None:
    code = allowed(tmp_path, PLUGIN)
    with pytest.warns(DeprecationWarning, match=r"stiffcal\.model\.effect is not a public module") as caught:
        effect = find_effects(code)["cross-stiffness"]
    assert {Path(warning.filename).name for warning in caught} == {"own.py"}
    (term,) = effect.terms(api.Place("joints", (2,)), chain, loads(chain), {})
    assert term.value == pytest.approx(np.sin(2.3 * 0.3))


@pytest.mark.usefixtures("state")
def test_the_plugin_of_the_documentation_of_today_gives_no_warning(tmp_path: Path) -> None:
    text = plugin_of_the_documentation()
    assert "cross-stiffness" in find_effects(allowed(tmp_path, text))  # a warning would be an error


@pytest.mark.usefixtures("state")
def test_every_renamed_name_of_the_interface_of_effects_works_in_a_plugin(tmp_path: Path, chain: api.Chain) -> None:
    code = allowed(tmp_path, RENAMED)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        effect = find_effects(code)["cross-stiffness"]
        place = api.Place("joints", (2,))
        grid = effect.nonlinear_grid(place, chain, loads(chain))
        covariate = effect.covariate(place, chain, loads(chain))
    assert effect.spec("f").role is api.ParameterRole.NONLINEAR
    assert grid["f"].tolist() == [2.0, 2.3]
    assert isinstance(covariate, api.Covariate)
    assert covariate.value.tolist() == [1.0, 1.0, 1.0]
    words = {str(warning.message).partition(";")[0] for warning in caught}
    assert words == {
        "stiffcal.model.effect is not a public module: import from stiffcal.effects_api",
        "stiffcal.model.effect.Driver is called Covariate",
        "stiffcal.model.effect.Sort is called ParameterRole",
        "the field sort of ParameterSpec is called role",
        "the method shape_grid of an effect is called nonlinear_grid (CrossStiffness)",
        "the method driver of an effect is called covariate (CrossStiffness)",
        "the method shape_grid of an effect is called nonlinear_grid",
        "the method driver of an effect is called covariate",
    }


def test_a_class_that_nothing_uses_any_more_can_still_be_imported() -> None:
    with pytest.warns(DeprecationWarning, match=r"^stiffcal\.model\.effect\.Evidence is not used any more; "):
        from stiffcal.model.effect import Evidence
    assert Evidence("text", "meaning", "check").text == "text"
    assert "Evidence" not in api.__all__


def test_built_in_effects_answer_to_the_old_names_of_their_methods(chain: api.Chain) -> None:
    place, given = api.Place("joints", (2,)), loads(chain)
    backlash: Any = built_in_effects()["backlash"]
    with pytest.warns(DeprecationWarning, match="driver of an effect is called covariate"):
        old = backlash.driver(place, chain, given)
    assert old.value.tolist() == backlash.covariate(place, chain, given).value.tolist()


def test_a_name_that_never_was_is_missed_as_ever() -> None:
    name = "Drivers"
    with pytest.raises(AttributeError, match="has no attribute 'Drivers'"):
        getattr(effect_module, name)


def test_all_names_of_the_interface_of_effects_are_public() -> None:
    """What `stiffcal.model.effect` defines for plugins, `stiffcal.effects_api` has."""
    defined = {
        name
        for name, value in vars(effect_module).items()
        if getattr(value, "__module__", None) == effect_module.__name__ and not name.startswith("_")
    }
    assert defined <= set(api.__all__)
    assert all(hasattr(api, name) for name in api.__all__)


@pytest.fixture
def chain(validated_folder: Path) -> api.Chain:
    from stiffcal.campaign.loading import load_campaign

    return load_campaign(validated_folder).chain


def test_the_notebook_of_the_readme_of_0_1_runs_and_warns(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_small_campaign(tmp_path / "campaigns" / "fanuc-r2000ic", poses=2)  # in the place of measurements of others
    monkeypatch.chdir(tmp_path)
    *lines, last = NOTEBOOK.strip().splitlines()
    names: dict[str, Any] = {}
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        exec("\n".join(lines), names)
        stiffness = eval(lines[-1], names)
        rms = eval(last, names)
    assert stiffness.keys() == {f"joint-compliance.j{k}.c" for k in range(1, 7)}
    assert rms["translation"] > 0.0
    words = "IdentifyResult is no longer a dict: read its attributes, or its to_document()"
    assert f"{words}; the old way goes with stiffcal 0.3" in {str(warning.message) for warning in caught}


def test_a_result_that_was_a_document_is_read_by_key_with_a_warning(validated_folder: Path) -> None:
    result: Any = describe_effects("backlash")
    with pytest.warns(DeprecationWarning, match="EffectsResult is no longer a dict: read its attributes") as caught:
        entries = result["effects"]
    assert entries == result.to_document()["effects"]
    assert [Path(warning.filename).name for warning in caught] == ["test_deprecated_names.py"]
    with warnings.catch_warnings(record=True) as caught_all:
        warnings.simplefilter("always")
        assert "effects" in result
        assert result.get("colour", "none") == "none"
        assert dict(result) == result.to_document()
        assert {key for key, _ in result.items()} == set(result)
    assert {Path(warning.filename).name for warning in caught_all} == {"test_deprecated_names.py"}


@pytest.mark.parametrize("text", [LOOP], ids=["loop"])
def test_examples_of_the_readme_of_0_1_run_and_warn(text: str, tmp_path: Path) -> None:
    (tmp_path / "example.py").write_text(text, encoding="utf-8")
    for name in re.findall(r'"campaigns/([^"]+)"', text):
        shutil.copytree(
            ROOT / "campaigns" / name, tmp_path / "campaigns" / name, ignore=shutil.ignore_patterns("store")
        )
    run = subprocess.run(
        [sys.executable, "-W", "default", "example.py"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )
    assert run.returncode == 0, run.stderr
    assert "DeprecationWarning" in run.stderr
    assert "example.py" in run.stderr
