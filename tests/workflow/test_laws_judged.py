"""Whether each law of a campaign without load states holds is judged by its own noise."""

from __future__ import annotations

from stiffcal.experiments.results import HeldoutSection
from stiffcal.workflow.diagnose import _fit_sentence, _law_fits


def judged(left: float, noise: float | None, count: int = 400) -> HeldoutSection:
    return HeldoutSection(
        scheme="leave one pose out",
        n_readings=count,
        rms={"torque": left},
        noise={} if noise is None else {"torque": noise},
        zero_model={"torque": 50.0},
    )


def test_what_chance_leaves_over_is_no_lack() -> None:
    # a mean square of 400 readings scatters by 7 %: 7 % above the noise is chance, 20 % is not
    assert _law_fits(judged(1.07, 1.0), None)
    assert not _law_fits(judged(1.2, 1.0), None)
    # of few readings 20 % is chance too
    assert _law_fits(judged(1.2, 1.0, count=20), None)


def test_nothing_is_judged_without_noise() -> None:
    assert _law_fits(judged(1.0, None), None) is None
    assert "too few repeats" in _fit_sentence("Friction", "at held-out speeds", None, judged(1.0, None))


def test_a_law_that_does_not_hold_is_reported_with_its_size() -> None:
    words = _fit_sentence("Torque over angle", "in poses left out", False, judged(2.0, 1.0))
    assert "its residual is 2 N·m in poses left out, 4 % of the torque, where repeats scatter 1 N·m" in words
