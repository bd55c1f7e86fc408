"""A fit and a batch begin with how they stand; rates of drift are printed by what they follow."""

from __future__ import annotations

from io import StringIO
from types import SimpleNamespace
from typing import Any

import pytest

from stiffcal.cli.console import AnswerConsole
from stiffcal.cli.pages import draw_blocks, draw_page
from stiffcal.diagnosis.answers.heldout_results import ErrorAsValidated
from stiffcal.diagnosis.answers.results import ProposedEffect
from stiffcal.identification.answers.before_after import (
    EstimatedParameter,
    values_before_and_after,
)
from stiffcal.identification.answers.fit_results import IdentifiedParameter
from stiffcal.measurements.rms import Rms
from stiffcal.model.summary import Where
from stiffcal.quantity import DriftFollows, ShownUnit
from stiffcal.show.answers.diagnose import _add_with_all_missing, add_missing
from stiffcal.show.answers.identify import fit_verdict
from stiffcal.show.before_after import add_moved
from stiffcal.show.builder import PageBuilder
from stiffcal.show.parameters import add_parameters, names_and_units

GROUP = [SimpleNamespace(parameters=["a", "b"])]


def fit(
    noise: Rms | None, not_identifiable: list[Any], values: tuple[float | None, ...] = (1.0, None), rms: float = 1e-5
) -> Any:
    """Return a fit of 10 µm rms."""
    parameters = [SimpleNamespace(value=value) for value in values]
    return SimpleNamespace(
        rms=Rms(rms, None), noise=noise, expected_rms=None, noise_source="repeats", not_identifiable=not_identifiable,
        parameters=parameters, geometry=None,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("fitted", "level", "words"),
    [
        (fit(Rms(1e-5, None), []), "pass", "all parameters are identifiable from these data"),
        (fit(Rms(2e-6, None), []), "warn", "noise 0.00200 mm (from repeats)"),
        (fit(Rms(9e-6, None), [], rms=8e-6), "pass", "fit 8.00 µm rms, noise 9.00 µm"),
        (fit(None, []), "warn", "noise not known"),
        (fit(Rms(1e-5, None), GROUP), "warn", "2 parameters are not identifiable from these data"),
        (fit(Rms(1e-5, None), GROUP, values=(None, None)), "fail", "no parameter is identifiable"),
    ],
)
def test_a_fit_passes_within_the_noise_where_all_is_identifiable(fitted: Any, level: str, words: str) -> None:
    found, text = fit_verdict(fitted)
    assert found == level
    assert words in text


@pytest.mark.parametrize(("follows", "printed"), [("time", "180.0 ± 7.2   µm/h"), ("temperature", "0.0500 ± 0.0020")])
def test_a_drift_is_printed_per_hour_or_per_kelvin(follows: DriftFollows, printed: str) -> None:
    drift = IdentifiedParameter(
        name="thermal-drift.x", effect="thermal-drift", where=Where(), value=5e-8, std=1e-9, interval=[4.8e-8, 5.2e-8],
        unit="m/s or m/K", fixed=False, identifiable=True, drift_follows=follows,
    )  # fmt: skip
    with StringIO() as text:
        made = PageBuilder("")
        add_parameters(made, [drift])
        draw_page(AnswerConsole(file=text, width=120), made.page())
        assert printed in text.getvalue()
        assert ("µm/h" in text.getvalue()) == (follows == "time")
        assert ("µm/K" in text.getvalue()) == (follows == "temperature")


def test_the_error_with_all_that_is_missing_is_printed_where_several_effects_are() -> None:
    friction = SimpleNamespace(effect="friction-hysteresis", where=Where(joints=[2]))
    drift = SimpleNamespace(effect="thermal-drift", where=Where())
    by_region = ErrorAsValidated(scheme="poses-region", rms=Rms(9e-5, None), with_missing=Rms(4e-5, None))
    for missing, noise, validated, printed in (
        ([friction, drift], Rms(3.1e-5, None), None, "noise 0.0310 mm"),
        ([friction, drift], Rms(3.1e-5, None), by_region, "0.0400 mm in held-out regions, noise 0.0310 mm"),
        ([friction, drift], None, None, "noise not known"),
        ([friction], Rms(3.1e-5, None), None, ""),
    ):
        result: Any = SimpleNamespace(
            missing=missing, noise=noise, heldout_rms_with_missing=Rms(3.08e-5, None), as_validated=validated
        )
        with StringIO() as text:
            made = PageBuilder("")
            _add_with_all_missing(made, result)
            draw_blocks(AnswerConsole(file=text, width=40), made.page().blocks)
            line = f"with friction-hysteresis (joint 2) and thermal-drift: 0.0308 mm in held-out poses, {printed}\n"
            assert text.getvalue() == (line if printed else "")


@pytest.mark.parametrize(
    ("at_bound", "width_words"), [(False, "2.00 ± 0.20 mrad"), (True, "2.00 ± 0.20 mrad, at its limit")]
)
def test_a_missing_effect_is_printed_with_its_refitted_values(at_bound: bool, width_words: str) -> None:
    width, spring = (
        EstimatedParameter(
            name=name, effect=name.partition(".")[0], where=Where(joints=[4]), unit=unit, value=value,
            interval=[0.9 * value, 1.1 * value], at_bound=at_bound,
        )
        for name, unit, value in (("backlash.j4.width", "rad", 2e-3), ("joint-compliance.j4.c", "N·m/rad", 2e5))
    )  # fmt: skip
    missing = ProposedEffect(
        effect="backlash", where=Where(joints=[4]), alternatives=[], probability=0.99, member_probability=1.0, firm=True
    )
    # not in the ranking: it was found next to another effect
    result: Any = SimpleNamespace(
        missing=[missing, missing], before_after=values_before_and_after([spring], [spring, width]),
        finding_of=lambda effect: None,
    )  # fmt: skip
    with StringIO() as text:
        made = PageBuilder("")
        add_missing(made, result, missing, details=True)
        draw_blocks(AnswerConsole(file=text, width=120), made.page().blocks)
        assert text.getvalue() == (
            "\nmissing: backlash (joint 4): 99.0 %, certain\n"
            f"  Refitted with all that is missing, ± 95 %: width {width_words}.\n"
        )


def test_values_of_several_units_that_moved_have_their_unit_behind_the_number() -> None:
    def fitted(factor: float) -> list[EstimatedParameter]:
        named = (("backlash.j4.width", "rad", 2e-3), ("joint-compliance.j4.c", "N·m/rad", 2e5))
        return [
            EstimatedParameter(
                name=name, effect=name.partition(".")[0], where=Where(joints=[4]), unit=unit, value=factor * value,
                interval=[0.9 * factor * value, 1.1 * factor * value], at_bound=factor > 1.0,
            )
            for name, unit, value in named
        ]  # fmt: skip

    with StringIO() as text:
        made = PageBuilder("")
        add_moved(made, values_before_and_after(fitted(1.0), fitted(2.0)), "moved")
        draw_blocks(AnswerConsole(file=text, width=120), made.page().blocks)
        assert "4.00 ± 0.40 mrad, at its limit" in text.getvalue()


def test_values_of_two_frames_keep_their_full_names() -> None:
    names = ["setup.tracker.x", "setup.target1.x"]
    named = names_and_units([("setup", Where(), name, "m", ShownUnit("mm", 1e3)) for name in names])
    assert named.names == names
