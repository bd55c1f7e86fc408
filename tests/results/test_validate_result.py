"""What `validate` answers: every key of its document is read back, and nothing passes before it is judged."""

from __future__ import annotations

from dataclasses import replace

from stiffcal.documents import document_of
from stiffcal.kinds.results import ExperimentValidation, HeldoutSection
from stiffcal.measurements.rms import Rms
from stiffcal.stages.experiments import merge_experiment_validations, validate_without_states
from stiffcal.validation.results import ErrorSlice, ThresholdCheck, Verdict
from tests.laboratory.fits import validation_of


def check(held: bool | None, says: str) -> ThresholdCheck:
    return ThresholdCheck("max_rms_m", "", 1e-4, 2e-4, "m", held, says)


def part(label: str, torque: float) -> ErrorSlice:
    return ErrorSlice(label=label, low=None, high=None, n=3, rms=Rms(None, None, torque=torque), max=Rms(None, None))


def of_kind(name: str, torque: float) -> ExperimentValidation:
    measured: dict[str, float | None] = {"torque": torque}
    return ExperimentValidation(
        name=name,
        scheme="each run left out",
        rms=measured,
        max=measured,
        noise={},
        relative=measured,
        zero_model=measured,
        by={"run": [part(f"run of {name}", torque)], "joint": [part("A1", torque)]},
        warnings=[f"warning of {name}"],
    )


def test_nothing_passes_before_it_is_judged() -> None:
    assert not validation_of().passed
    judged = validation_of().judged(Verdict([check(True, "yes"), check(None, "unknown")], {"max_rms_m": 1e-4}))
    assert (judged.passed, judged.failed, judged.not_judged) == (True, [], ["unknown"])
    judged = judged.judged(Verdict([check(False, "no")], {}))
    assert (judged.passed, judged.failed, judged.thresholds) == (False, ["no"], {})


def test_a_validation_is_read_back_as_it_was_written() -> None:
    result = validation_of(
        rms={"translation": 1e-4, "rotation": None, "length": None},
        by_body=[document_of(replace(part("leds", 0.5), zero_model=Rms(1e-3, None)))],
        fit_id="3",
        passed=True,
    )
    document = document_of(result)
    assert document["rms"] == {"translation": 1e-4, "rotation": None, "length": None}
    assert document["by_body"][0]["zero_model"] == {"translation": 1e-3, "rotation": None}
    assert not {"by_joint", "clamped", "model_of", "origin"} & document.keys()
    assert document_of(validation_of(**document)) == document


def test_of_a_measure_of_two_kinds_the_larger_error_stands() -> None:
    result = validate_without_states([of_kind("clamped", 0.5), of_kind("friction", 0.2)])
    assert (result.rms.torque, result.rms.translation, result.noise) == (0.5, None, None)
    assert result.scheme == "clamped: each run left out; friction: each run left out"
    assert [slice_of_runs.label for slice_of_runs in result.by_run] == ["run of clamped", "run of friction"]
    assert [slice_of_joint.label for slice_of_joint in result.by_joint or []] == ["A1", "A1"]
    assert result.warnings == ["warning of clamped", "warning of friction"]
    friction = result.section("friction")
    assert friction is not None
    assert friction.rms == {"torque": 0.2}


def test_a_further_kind_of_experiment_has_a_key_of_its_own() -> None:
    loads = validation_of(scheme="leave-one-pose-out", n_states=4, rms={"translation": 1e-4, "rotation": None})
    result = merge_experiment_validations(loads, [of_kind("probing", 0.2)])
    assert isinstance(result.section("probing"), HeldoutSection)
    assert result.scheme == "leave-one-pose-out; probing: each run left out"
    assert document_of(result)["probing"]["rms"] == {"torque": 0.2}
    assert (result.rms.translation, result.rms.torque) == (1e-4, 0.2)
