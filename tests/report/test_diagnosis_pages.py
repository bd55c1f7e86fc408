"""The pages of diagnosis: answer first, evidence drawn for each effect, look-alikes named, nothing invented."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stiffcal.diagnosis.answers.results import (
    DiagnoseResult,
    EffectEvidenceSummary,
    ExcludedSizeAt,
    Finding,
    LawCurveAt,
    LookAlike,
    ProposedEffect,
    ResidualDependence,
    RunErrors,
    SearchPace,
    SeparatingMeasurement,
    UnknownLaw,
    UntestableEffect,
)
from stiffcal.estimate import Estimate
from stiffcal.identification.answers.before_after import BeforeAfter
from stiffcal.identification.answers.fit_results import IdentifiedParameter
from stiffcal.measurements.rms import Rms, VarianceRatio
from stiffcal.measurements.state_measures import StateMeasure
from stiffcal.model.summary import EffectAt, EffectInModel, ModelSummary, Where
from stiffcal.report.blocks import (
    Items,
    LeftOut,
    NumbersBlock,
    Paragraph,
    PictureBlock,
    ReportSection,
    SubheadingBlock,
    TableBlock,
    VerdictBlock,
)
from stiffcal.report.content import EffectPicture, EvidenceFigure, ReportContent
from stiffcal.report.figures.canvas import save_figure
from stiffcal.report.figures.evidence import draw_evidence
from stiffcal.report.figures.ladder import ladder_rungs
from stiffcal.report.sections import diagnosis, evidence, next_measurement, ranking, stiffness, summary
from stiffcal.report.sections.stiffness import short_stiffness_table
from stiffcal.results.history_results import HistoryEntry
from stiffcal.results.model_words import model_change
from stiffcal.results.value_words import SHIFTED
from tests.laboratory.report_content import made_up_content

BACKLASH = EffectAt(effect="backlash", where=Where(joints=[4]))
HYSTERESIS = EffectAt(effect="friction-hysteresis", where=Where(joints=[4]))
ALIKE = LookAlike(effect=HYSTERESIS.effect, where=HYSTERESIS.where, probability=0.3)


def proposed(*alternatives: LookAlike) -> ProposedEffect:
    return ProposedEffect(
        effect=BACKLASH.effect, where=BACKLASH.where, alternatives=list(alternatives), probability=0.99,
        member_probability=0.7, firm=False,
    )  # fmt: skip


def finding() -> Finding:
    return Finding(
        effect=BACKLASH.effect, where=BACKLASH.where, verdict="supported", explains=0.98, size_m=1.1e-4, p_value=1e-30,
        confidence=None, probability=0.7, heldout_rms_before=Rms(1.2e-4, None), heldout_rms_after=Rms(2.9e-5, None),
        heldout_rms_after_choosing=Rms(3e-5, None), parameters=[], alternatives=[HYSTERESIS],
    )  # fmt: skip


def diagnosed(**changes: Any) -> DiagnoseResult:
    return replace(
        DiagnoseResult(
            summary="Missing: backlash of joint 4 (0.116 mm in held-out poses, noise 0.0286 mm).", adequate=False,
            noise=Rms(2.86e-5, None), rms=Rms(1.16e-4, None),
            lack_of_fit=VarianceRatio(statistic=16.0, dof=[3456.0, 1386.0], p_value=1e-40),
            missing=[proposed(ALIKE)], could_be=[], findings=[finding()],
            next_measurement=SeparatingMeasurement(
                pose_deg=[10.0, -20.0, 30.0], load=[100.0, 0.0, 0.0, 0.0, 0.0, 0.0], gain=12.0,
                separates=[BACKLASH, HYSTERESIS], difference_m=3.4e-4,
            ),
            not_tried=[UntestableEffect("joint-friction", "friction runs")], unexplained=False, structure=[],
            heldout_rms_with_missing=Rms(2.9e-5, None), explained_by_missing=0.99, n_candidates=87,
            heldout_rms_after_choosing=Rms(3e-5, None), parameters_with_missing=[], superfluous=[], evidence=[],
            pace=SearchPace(models=1, candidates=87, signatures=87, seconds=1.0, candidates_per_second=87.0),
            warnings=[], fit_id="1", key="",
        ),
        **changes,
    )  # fmt: skip


def shown(**changes: Any) -> EvidenceFigure:
    """Return a figure, with changes of its own fields and of those of what it shows."""
    torque = np.linspace(-100.0, 100.0, 41)
    before = 1e-4 * np.sign(torque) - 1e-6 * torque
    before[3] = np.nan
    x = np.linspace(-1.0, 1.0, 21)
    picture = EffectPicture("backlash", "force [N]", "deflection [mm]", x, x, x + np.sign(x), x < -2.0, "What it does.")
    errors = [("pose01", 1e-4, 3e-5), ("pose02", 1.2e-4, 2.8e-5)]
    evidence = EffectEvidenceSummary(
        effect="backlash", where=BACKLASH.where, status="missing", driver="torque on joint 4", unit="N·m",
        component="translation", lever=0.19, heldout_rms_before=Rms(1.16e-4, None), heldout_rms_after=Rms(2.9e-5, None),
        by_run=[RunErrors(label=run, before=without, after=with_it) for run, without, with_it in errors],
    )  # fmt: skip
    width = IdentifiedParameter(
        name="backlash.j4.width", effect="backlash", where=BACKLASH.where, value=1.8e-3, std=9e-6, interval=None,
        unit="rad", fixed=False, identifiable=True,
    )  # fmt: skip
    own = {name: value for name, value in changes.items() if name in ("picture", "path_run")}
    return replace(
        EvidenceFigure(
            evidence=replace(evidence, **{name: value for name, value in changes.items() if name not in own}),
            value=torque, before=before, after=0.1 * before, run=np.full(41, "pose01"),
            branch=np.where(torque > 0.0, "loading", "unloading"), summary="lost motion", seen="It jumps.",
            alternatives=(HYSTERESIS,), picture=picture,
            parameters=(width,),
        ),
        **own,
    )  # fmt: skip


def content(**changes: Any) -> ReportContent:
    return replace(made_up_content(n_runs=1), diagnose=diagnosed(**changes), evidence=(shown(),))


def words(made: ReportSection | LeftOut | None) -> str:
    assert isinstance(made, ReportSection)
    parts: list[str] = []
    for block in made.blocks:
        parts += [block.text] if isinstance(block, SubheadingBlock) else []
        parts += [block.text] if isinstance(block, Paragraph) else []
        parts += block.texts if isinstance(block, Items) else []
        parts += [" ".join(row) for row in block.rows] if isinstance(block, TableBlock) else []
        parts += [block.caption] if isinstance(block, PictureBlock | TableBlock) else []
    return "\n".join(parts).replace("\u202f", " ")


@pytest.mark.parametrize("module", [diagnosis, evidence, ranking, next_measurement])
def test_without_a_diagnosis_pages_are_left_out_with_the_reason(module: Any) -> None:
    stale = replace(made_up_content(n_runs=1), not_diagnosed="the last diagnosis is stale: run stiffcal diagnose")
    for made in (module.section(made_up_content(n_runs=1)), module.section(stale)):
        assert isinstance(made, LeftOut)
        assert "run stiffcal diagnose" in made.reason


def test_evidence_without_a_state_that_it_can_be_read_of_has_no_picture() -> None:
    figure = shown()
    made = evidence.section(replace(content(), evidence=(replace(figure, before=np.full(41, np.nan)),)))
    assert isinstance(made, ReportSection)
    # the errors by run alone
    assert [type(block) for block in made.blocks].count(PictureBlock) == 1
    whole = evidence.section(content())
    assert isinstance(whole, ReportSection)
    assert len(whole.blocks) == len(made.blocks) + 1


def test_answer_and_look_alikes() -> None:
    text = words(diagnosis.section(content()))
    assert text.startswith("Missing: backlash of joint 4")
    assert "Missing: backlash (joint 4): 99.0 % that it or one of those below is, 69 % that it is, not certain" in text
    assert "friction-hysteresis (joint 4) 30 %" in text


def test_nothing_missing_and_nothing_known() -> None:
    fine = words(diagnosis.section(content(adequate=True, missing=[], summary="Nothing is missing.")))
    assert "None of them is probably missing" in fine
    assert "cannot be judged" in words(diagnosis.section(content(adequate=None, missing=[], noise=None)))


def test_none_of_these_says_what_the_remainder_follows() -> None:
    follows = [ResidualDependence(follows="joint angle", share=0.97, seen="another factor from pose to pose")]
    made = diagnosis.section(content(missing=[], unexplained=True, structure=follows))
    text = words(made)
    assert "No effect is named" in text
    assert "listed below" in text
    assert "The joint angles (97.0 % of it): another factor from pose to pose" in text


LAW = UnknownLaw(
    follows="another joint's angle", where=Where(joints=[2]), of="joint 2", probability=0.97,
    curve=LawCurveAt(
        over="angle:1", unit="rad", value_unit="rad/(N*m)", at=[-np.pi / 2, np.pi / 2], value=[-7e-8, 7e-8]
    ),
)  # fmt: skip
"""A law that no catalogue holds."""


def test_a_law_of_its_own_is_drawn_as_its_curve() -> None:
    text = words(diagnosis.section(content(missing=[], unexplained=True, unknown=[LAW])))
    assert "law of joint 2 that no catalogue holds [µrad/(N·m)] over angle of joint 1 [°]" in text
    bare = replace(LAW, curve=None)
    assert "no catalogue holds" not in words(diagnosis.section(content(missing=[], unexplained=True, unknown=[bare])))


def test_the_load_that_decides_is_stated_where_nothing_is_found() -> None:
    size = ExcludedSizeAt(where=Where(joints=[3]), of="joint 3", size_m=1e-4, effect="creep", deciding_force_N=640.0)
    text = words(diagnosis.section(content(adequate=True, missing=[], excluded_sizes=[size])))
    assert "640 N (joint 3)" in text
    small = replace(size, deciding_force_N=None)
    assert "640" not in words(diagnosis.section(content(adequate=True, missing=[], excluded_sizes=[small])))


def test_a_remainder_that_follows_nothing_has_no_list() -> None:
    text = words(diagnosis.section(content(missing=[], unexplained=True, adequate=False, structure=[])))
    assert "follows none of the variables" in text
    assert "listed below" not in text


def test_a_probable_law_is_what_a_remainder_follows() -> None:
    law = replace(LAW, follows="its speed", curve=None)
    rest: dict[str, Any] = {"missing": [], "unexplained": True, "adequate": False, "structure": []}
    made = content(**rest, unknown=[law])
    assert "a law of joint 2 that no effect describes, of its speed (97.0 %)" in words(diagnosis.section(made))
    assert "what is left is probably a law of joint 2" in str(summary.section(made))
    doubtful = content(**rest, unknown=[replace(law, probability=0.1)])
    assert "follows none of the variables" in words(diagnosis.section(doubtful))


def test_errors_of_moving_joints_are_of_no_poses() -> None:
    torque: dict[str, Any] = {
        "rms": Rms(None, None, torque=1.02),
        "heldout_rms_with_missing": Rms(None, None, torque=0.3),
    }
    made = diagnosis.section(content(**torque))
    assert isinstance(made, ReportSection)
    assert "held-out poses" not in str(made.blocks[1:])
    assert "1.02 N·m rms in held-out data" in str(made.blocks).replace("\u202f", " ")


def test_ranking_holds_every_number_with_its_unit() -> None:
    text = words(ranking.section(content()))
    for word in (
        "supported",
        "0.0290 mm",
        "99 %",
        "70 %",
        "0.110 mm",
        "<\u00a010⁻⁶",
        "friction-hysteresis (joint 4)",
    ):
        assert word in text, word
    assert "joint-friction (needs friction runs)" in text


def test_next_measurement_names_pose_load_and_gain() -> None:
    made = next_measurement.section(content())
    assert isinstance(made, ReportSection)
    assert "cannot distinguish backlash (joint 4) from friction-hysteresis (joint 4)" in words(made)
    none = next_measurement.section(content(next_measurement=None))
    assert isinstance(none, LeftOut)
    assert "no load of this campaign’s size" in none.reason
    assert next_measurement.section(content(next_measurement=None, missing=[proposed()])) is None


def test_evidence_page() -> None:
    text = words(evidence.section(content()))
    for word in (
        "It jumps.",
        "0.116 mm rms without it, 0.0290 mm with it",
        "mean lever arm of 0.190 m",
        "1 of 41",
    ):
        assert word in text, word
    assert isinstance(evidence.section(replace(content(), evidence=())), LeftOut)


@pytest.mark.parametrize(
    "change", [{}, {"picture": None, "path_run": "pose01", "component": "rotation", "lever": None}]
)
def test_evidence_is_drawn_the_same_every_time(tmp_path: Path, change: dict[str, Any]) -> None:
    """Before and after share one scale; the example stands next to them on its own."""
    figure = draw_evidence(shown(**change))
    without, with_it = figure.axes[:2]
    assert without.get_ylim() == with_it.get_ylim()
    assert without.get_ylabel().replace("\n", " ") == f"residual along the effect [{'mrad' if change else 'mm'}]"
    assert len(figure.axes) == (2 if change else 3)
    for name in ("one.svg", "two.svg"):
        save_figure(draw_evidence(shown(**change)), tmp_path / name)
    assert (tmp_path / "one.svg").read_bytes() == (tmp_path / "two.svg").read_bytes()


def test_rungs_say_what_the_model_gained() -> None:
    springs, error = EffectInModel("joint-compliance", joints=[1, 2, 3]), Rms(1e-4, None)
    models = [[springs], [springs, EffectInModel("backlash", joints=[2])], [springs]]
    fits = [
        HistoryEntry(
            id=str(number),
            time="2026-11-21T10:02:11Z",
            model=ModelSummary("deformed", effects),
            heldout_rms=None if number == 2 else error,
            fit_rms=error,
            noise=None,
        )
        for number, effects in enumerate(models, 1)
    ]
    labels = [rung.label for rung in ladder_rungs(fits, Rms(1e-3, None), "translation")]
    assert labels == [
        "no model", "fit 1: joint-compliance (joints 1–3)", "fit 2: + backlash (joint 2)",
        "fit 3: − backlash (joint 2)",
    ]  # fmt: skip
    assert model_change(fits[0].model, fits[0].model) == ""


def first_page(of: ReportContent) -> dict[type, Any]:
    """Return the first block of each kind on the first page."""
    made = summary.section(of)
    assert isinstance(made, ReportSection)
    return {type(block): block for block in reversed(made.blocks)}


def test_the_first_page_states_the_level_and_the_error_without_and_with_what_is_missing() -> None:
    page = first_page(content())
    assert page[VerdictBlock].level == "attention"
    assert [value for _, value in page[NumbersBlock].numbers] == ["0.116 mm", "0.0290 mm", "0.0286 mm"]
    good = diagnosed(adequate=True, missing=[], summary="Nothing is missing.")
    assert first_page(replace(content(), diagnose=good))[VerdictBlock].level == "ok"
    validation = content().validate
    assert validation is not None
    useless = replace(content(), validate=replace(validation, relative=Rms(1.1, None)))
    assert first_page(useless)[VerdictBlock].level == "not usable"


def test_values_that_a_missing_effect_shifts_are_grey_with_the_value_after() -> None:
    fit = content().identify
    assert fit is not None
    spring = next(one for one in fit.parameters if one.is_compliance)
    values = [Estimate(value=value, interval=[0.9 * value, 1.1 * value]) for value in (2.0e5, 3.0e5)]
    change = BeforeAfter(
        name=spring.name, effect=spring.effect, where=spring.where, unit="N·m/rad", before=values[0], after=values[1],
        relative=0.5, outside_interval=True,
    )  # fmt: skip
    table = first_page(content(before_after=[change]))[TableBlock]
    row = fit.parameters.index(spring)
    assert table.doubtful == ((row, 2),)
    assert "3.00" in table.rows[row][3]
    assert first_page(content())[TableBlock].doubtful == ()
    # and in the section on stiffness, which has no column with the value after
    for made, marked in ((content(before_after=[change]), [spring.name]), (content(missing=[]), [])):
        shown = stiffness.shown_estimates(made)
        assert [name for name, one in shown.items() if one.is_shifted] == marked
        section = stiffness.section(made)
        assert isinstance(section, ReportSection)
        of_springs = next(block for block in section.blocks if isinstance(block, TableBlock))
        assert of_springs.doubtful == (((row, 2),) if marked else ())
        assert (SHIFTED in of_springs.rows[row]) == bool(marked)


@pytest.mark.parametrize(
    ("after", "fixed", "listed", "cell"),
    [
        (Estimate(value=2.0e5, interval=[1.9e5, 2.1e5]), False, True, "stays within ±"),
        (Estimate(value=None, interval=None), False, True, "not identifiable"),
        (Estimate(value=None, interval=[4.0e4, None]), False, True, "above 4.00·10⁴"),
        (None, False, True, "not in the model"),
        (Estimate(value=2.0e5, interval=None), True, True, ""),
        (Estimate(value=2.0e5, interval=[1.9e5, 2.1e5]), False, False, ""),
    ],
)
def test_a_value_stays_within_only_where_it_is_known_before_and_after(
    after: Estimate | None, fixed: bool, listed: bool, cell: str
) -> None:
    made = content()
    fit = made.identify
    assert fit is not None
    springs = [one for one in fit.parameters if one.is_compliance][:2]
    spring = replace(springs[0], fixed=fixed)
    before = Estimate(value=2.0e5, interval=[1.8e5, 2.2e5])
    other = BeforeAfter(
        name=springs[1].name, effect=spring.effect, where=springs[1].where, unit="N·m/rad", before=before,
        after=before, relative=0.0, outside_interval=False,
    )  # fmt: skip
    change = replace(other, name=spring.name, where=spring.where, after=after, relative=None)
    table = short_stiffness_table(
        [spring, springs[1]], frozenset(), made.joint_names, changes=[*[change] * listed, other]
    )
    assert table is not None
    assert [row[3] for row in table.rows] == [cell, "stays within ±"]
    assert table.doubtful == ()


def test_the_errors_on_the_first_page_are_all_named_as_errors() -> None:
    def names(of: ReportContent) -> list[str]:
        return [name for name, _ in first_page(of)[NumbersBlock].numbers]

    good = diagnosed(adequate=True, missing=[], summary="Nothing is missing.")
    assert all(name.startswith("error ") for name in names(content())[:2])
    assert names(replace(content(), diagnose=good))[0] == "error without a model"
    runs = tuple(replace(run, measures=StateMeasure.PLACE) for run in content().runs)
    assert names(replace(content(), diagnose=good, runs=runs))[0] == "error of the nominal robot"


def test_one_number_stands_for_what_the_missing_effect_explains() -> None:
    made = content(explained_by_missing=0.971)
    assert "97 %" in words(ranking.section(made))
    assert "98 %" not in words(ranking.section(made))
    assert "98 %" in words(ranking.section(content(explained_by_missing=0.971, missing=[])))


def test_once_in_the_model_an_effect_keeps_its_probability_and_its_look_alikes_on_page_1() -> None:
    before = str(summary.section(content()))
    after = str(summary.section(content(missing=[], in_model=[proposed(ALIKE)])))
    for page in (before, after):
        assert "backlash (joint 4), or friction-hysteresis (joint 4): 99.0 %" in page
    assert "('in the model'" in after
