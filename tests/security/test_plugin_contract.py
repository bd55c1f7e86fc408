"""Code of a campaign that is trusted and gives nonsense is named, with its file, in one line; nothing is computed."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from stiffcal.batch.task import run_task
from stiffcal.campaign.loading import load_campaign
from stiffcal.cli.app import main
from stiffcal.commands.ingest import ingest_campaign
from stiffcal.errors import InputError
from stiffcal.model.catalogue.campaign_effects import model_effects
from stiffcal.model.drive_motion import DriveMotion
from stiffcal.model.motion import Motion
from stiffcal.results.batch_results import BatchTask
from stiffcal.trust.record import open_record
from tests.laboratory.documentation import plugin_of_the_documentation
from tests.laboratory.plugin_campaigns import NAME, stranger, write_plugin

RETURNED = 'return (*drive_terms(chain, joint, "c", np.sin(2.3 * loads.angles[0]) * torque),)'
# What one term is made of; the names that the page's code does not import come along.
INSTEAD = """from stiffcal.effects_api import RZ, Term, joint_node
        node = joint_node(joint)
        return ({},)"""


def other_kind(kind: str, method: str) -> str:
    """Return code that makes the effect one of another kind, of which one method returns nothing."""
    constants = ("name", "place_kind", "summary", "parameters", "fingerprint", "how_to_check")
    body = "".join(f"    {one} = _Law.{one}\n" for one in constants)
    return (
        f"from stiffcal.effects_api import {kind}\n_Law = CrossStiffness\n"
        f"class CrossStiffness({kind}):\n{body}    def {method}(self, *a): return None\n"
    )


@pytest.fixture
def folder(state: Path, tmp_path: Path) -> Path:
    """A campaign whose model needs its code, which its user trusts."""
    folder = stranger(tmp_path / "stranger", further="")
    open_record().allow_folder(folder)
    return folder


@pytest.mark.parametrize(
    ("term", "words"),
    [
        ('Term(node, RZ, "c", loads.wrench[node, RZ] * np.nan)', "a term whose value is not finite"),
        ('Term(node, RZ, "c", loads.wrench[node, RZ] * 1e300)', "a term whose value holds a number beyond ±1e+100"),
        ('Term(node, RZ, "c", loads.wrench[node, RZ, :1])', "a term whose value has the shape (1,), not ("),
        ('Term(node, RZ, "c", "x")', "a term whose value is no array of real numbers: 'x'"),
        ('Term(99, RZ, "c", loads.wrench[0, RZ])', "a term at node 99, where there are nodes 0 to 13"),
        ('Term(node, 7, "c", loads.wrench[0, RZ])', "a term of component 7, which is none of 0 to 5"),
        ('Term(node, RZ, "d", loads.wrench[0, RZ])', "a term with the symbol 'd', which no parameter has"),
        ("None", "what is no Term: None"),
    ],
)
def test_terms_that_are_none_are_a_fault_of_the_file(folder: Path, term: str, words: str) -> None:
    text = plugin_of_the_documentation()
    assert RETURNED in text
    (folder / NAME).write_text(text.replace(RETURNED, INSTEAD.format(term)), encoding="utf-8")
    ingest_campaign(folder)
    outcome = run_task(BatchTask(folder=str(folder), campaign="stranger", report=False))
    assert outcome.state == "broken"
    error = outcome.error
    assert error is not None
    assert (error.file, error.place) == (NAME, "CrossStiffness.terms")
    assert error.reason.startswith(f"returns {words}")


@pytest.mark.parametrize(
    ("statement", "words"),
    [
        ("CrossStiffness.terms = lambda *a: 5", "returns no tuple of terms: 5"),
        (other_kind("Geometry", "adjusted_chain"), "returns no Chain: None"),
        (other_kind("Geometry", "adjusted"), "returns no Inputs: None"),
        (other_kind("Instrument", "adjusted"), "returns no Inputs: None"),
        (other_kind("Instrument", "observation_columns"), "returns no mapping of symbols to arrays: None"),
        ("CrossStiffness.places = lambda *a: 5", "returns no list of places of kind joints: 5"),
        ("CrossStiffness.forms = (None,)", "forms is not a tuple of effects: tuple"),
    ],
)
def test_other_answers_that_are_none_are_a_fault_of_the_file(
    folder: Path, statement: str, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    write_plugin(folder, f"\n{statement}\n")
    with pytest.raises(SystemExit) as end:
        main(["identify", str(folder), "--json"])
    assert end.value.code == 2
    error = json.loads(capsys.readouterr().out)["error"]
    assert error["file"] == NAME
    assert error["reason"].startswith(words)


@pytest.mark.parametrize(
    ("statement", "words"),
    [
        ("motion_columns = lambda *a: {'c': np.zeros(2)}", "returns a column of c that has the shape (2,), not (3,)"),
        ("motion_grid = lambda *a: {'d': np.zeros(2)}", "returns no mapping of the parameters' symbols to arrays"),
        ("motion_covariate = lambda *a: None", "returns no Covariate: None"),
        ("lacking_motion = lambda *a: 5", "returns neither a text nor None: 5"),
    ],
)
def test_answers_on_free_motion_that_are_none_are_a_fault_of_the_file(folder: Path, statement: str, words: str) -> None:
    write_plugin(folder, f"\n{other_kind('Motion', 'unused')}\nCrossStiffness.{statement}\n")
    campaign = load_campaign(folder)
    (effect,) = (effect for effect in model_effects(campaign).values() if type(effect).__name__ == "CrossStiffness")
    assert isinstance(effect, Motion)
    place, motion = effect.places(campaign.chain)[0], DriveMotion.at_velocity(np.ones(3))
    answers: dict[str, Callable[[], object]] = {
        "motion_columns": lambda: effect.motion_columns(place, campaign.chain, motion, {}),
        "motion_grid": lambda: effect.motion_grid(place, campaign.chain, motion),
        "motion_covariate": lambda: effect.motion_covariate(place, campaign.chain, motion),
        "lacking_motion": lambda: effect.lacking_motion(campaign.chain, motion),
    }
    with pytest.raises(InputError) as error:
        answers[statement.partition(" ")[0]]()
    (fault,) = error.value.faults
    assert fault.file == NAME
    assert words in fault.reason


@pytest.mark.parametrize(
    ("statement", "words"),
    [
        ("CrossStiffness.name = 5", "name is not a text"),
        ("CrossStiffness.name = 'a\\x1b[2J'", "contains U+001B"),
        ("CrossStiffness.kind = 'node law'", "kind is no Kind"),
        (
            "from stiffcal.effects_api import Effect\nclass Bare(Effect):\n    name = 'bare'",
            "none of Law, Geometry, Instrument",
        ),
        ("CrossStiffness.place_kind = 'everywhere'", "place_kind is none of joints, links, pairs, frames, setup"),
        ("CrossStiffness.parameters = 'c'", "parameters is not a tuple of ParameterSpec"),
        ("CrossStiffness.parameters *= 2", "two parameters have the symbol c"),
        ("CrossStiffness.summary = None", "summary is not a text"),
        ("CrossStiffness.terms = 3", "terms is not a method"),
        ("CrossStiffness.__eq__ = lambda *a: 5\nCrossStiffness.__hash__ = object.__hash__", "does not create an"),
        ("CrossStiffness.__new__ = lambda *a: 5", "its class does not create an effect"),
        ("CrossStiffness.__getattribute__ = lambda *a: 5", "replaces what every object has"),
    ],
)
def test_constants_that_are_no_effects_are_a_fault_of_the_file(folder: Path, statement: str, words: str) -> None:
    write_plugin(folder, f"\n{statement}\n")
    with pytest.raises(InputError) as error:
        model_effects(load_campaign(folder))
    (fault,) = error.value.faults
    assert str(fault).startswith(f"{NAME}: ")
    assert words in str(fault)


@pytest.mark.parametrize(
    "statement", ["raise E", "raise ValueError('x' * 100_000)", "class F(SyntaxError): msg = E()\nraise F"]
)
def test_what_an_exception_says_of_itself_makes_no_second_one(folder: Path, statement: str) -> None:
    write_plugin(folder, f"\nclass E(Exception):\n    def __str__(self): raise E\n{statement}\n")
    with pytest.raises(InputError, match="does not run") as error:
        model_effects(load_campaign(folder))
    assert len(str(error.value)) < 1000


def test_a_name_that_no_file_system_takes_is_one_line(folder: Path) -> None:
    manifest = folder / "campaign.toml"
    manifest.write_text(manifest.read_text("utf-8").replace(NAME, "x" * 260 + ".py"), encoding="utf-8")
    with pytest.raises(InputError, match="a file name of more than 255 bytes"):
        load_campaign(folder)


def test_a_unit_that_is_none_of_si_is_a_fault_of_the_file(folder: Path) -> None:
    text = plugin_of_the_documentation()
    (folder / NAME).write_text(text.replace('"rad/(N·m)"', '"Nm/grad"'), encoding="utf-8")
    with pytest.raises(InputError, match="the unit of the parameter c is not an SI unit: 'Nm/grad'"):
        model_effects(load_campaign(folder))


def test_effects_explains_an_effect_of_a_campaign(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Also one that asks for an angle which the lever of the picture does not have: then without a picture."""
    pages = []
    for angle in (0, 5):
        text = plugin_of_the_documentation().replace("loads.angles[0]", f"loads.angles[{angle}]")
        (folder / NAME).write_text(text, encoding="utf-8")
        with pytest.raises(SystemExit) as end:
            main(["effects", "cross-stiffness", "--from", str(folder)])
        assert end.value.code == 0
        pages.append(capsys.readouterr().out)
    assert all("\n  Repeat one load on the joint at several angles of joint 1." in page for page in pages)
    assert ["\nPicture\n" in page for page in pages] == [True, False]
