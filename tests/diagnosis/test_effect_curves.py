"""The evidence for an effect: what is drawn is what was hidden, and it is gone once the effect is in the model."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from stiffcal.diagnosis.refits.effect_curves import EffectEvidence, evidence_for
from stiffcal.diagnosis.scans.load_scan import scan_candidates
from stiffcal.identification.fitting.identify import Settings, fit_observations, fit_problem
from stiffcal.measurements.load_states import LoadStates, Sigma
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.rotations import rotation_from_vector
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.catalogue.catalogue import find_effects
from stiffcal.model.effect import Place
from stiffcal.model.effect_values import Covariate, NodeLoads
from tests.laboratory.clamped_bench import clamped_bench
from tests.laboratory.robots import six_axes
from tests.laboratory.simulated_states import joint_springs, medium_robot, played

NOISE = Sigma(16e-6, 30e-6, 0.5, 0.1)


def with_effect(robot: CompliantRobot, effect: str, place: Place, **values: float) -> CompliantRobot:
    return replace(robot, placed=(*robot.placed, PlacedEffect(find_effects()[effect], place, values)))


@cache
def evidence(effect: str, place: Place) -> tuple[EffectEvidence, LoadStates]:
    """Play a campaign with an effect, fit it with the effect in the model, and take the effect out again."""
    sizes = {
        "backlash": {"width": 4e-4, "band": 5.0},
        "bearing-tilt": {"x": 2e-6, "y": 2e-6},
        "tracker-frame": {"rx": 0.05, "ry": -0.05, "rz": 0.03},
    }[effect]
    states = played(with_effect(medium_robot(), effect, place, **sizes), runs=6, noise=NOISE, seed=5)
    if effect == "tracker-frame":
        # The balance plays the robot, not the tracker: what it saw is turned here.
        turn = rotation_from_vector(np.array([sizes["rx"], sizes["ry"], sizes["rz"]]))
        states = replace(states, position=states.position @ turn.T, rotation=turn @ states.rotation)
    robot = with_effect(joint_springs(six_axes()), effect, place, **{k: v for k, v in sizes.items() if k == "band"})
    fit = fit_observations(fit_problem(states, robot), robot, Settings())
    scan = scan_candidates(fit, [])
    (found,) = evidence_for(scan, {f"{effect} {place.label}"}, find_effects())
    return found, states


def test_backlash_is_read_in_its_joint() -> None:
    """The law over the torque is the gap's two flanks, times the mean lever; the residual has lost it afterwards."""
    found, states = evidence("backlash", Place("joints", (4,)))
    assert (found.covariate, found.unit) == ("torque on joint 4", "N·m")
    assert found.lever is not None
    run, seen = states.run[found.index], np.isfinite(found.before)
    gaps = []
    for number in np.unique(run):
        right, left = (seen & (run == number) & (side * found.value > 30.0) for side in (1.0, -1.0))
        if right.any() and left.any():
            gaps.append(found.law[right].mean() - found.law[left].mean())
    # Flank to flank in every pose, however far off the tool stands there.
    assert len(gaps) > 2
    assert np.allclose(gaps, 4e-4 * found.lever, rtol=0.1)
    before, after = np.nanstd(found.before), np.nanstd(found.after)
    assert after < 0.6 * before
    assert np.isfinite(found.before).sum() == np.isfinite(found.after).sum()


def test_an_effect_without_a_load_is_read_along_what_it_adds() -> None:
    """An effect that names nothing which drives it is projected; its whole error falls too."""
    found, _ = evidence("tracker-frame", Place("setup"))
    assert (found.unit, found.lever) == ("mm", None)
    assert np.isfinite(found.value[np.isfinite(found.before)]).all()
    assert (found.rms_after.translation or 0.0) < (found.rms_before.translation or 0.0)
    read = np.isfinite(found.before)
    assert found.law[read].min() >= 0.0
    assert found.before[read] @ found.value[read] > 5.0 * abs(found.after[read] @ found.value[read])


def test_a_moment_across_two_axes_is_drawn_as_a_line_with_a_sign() -> None:
    """A tilt follows its moment in proportion whatever the lever and the direction: loads of both signs, one line."""
    found, _ = evidence("bearing-tilt", Place("joints", (3,)))
    assert (found.unit, found.lever) == ("N·m", None)
    read = np.isfinite(found.before)
    value, law, before, after = (series[read] for series in (found.value, found.law, found.before, found.after))
    assert min(-value.min(), value.max()) > 0.2 * max(-value.min(), value.max())
    assert np.corrcoef(value, law)[0, 1] > 0.999
    assert np.mean(before * value > 0.0) > 0.7
    assert before @ value > 5.0 * abs(after @ value)


def test_a_state_without_one_component_is_left_out_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its load is no number, so that nothing is read there; all others are drawn as before."""
    whole, _ = evidence("bearing-tilt", Place("joints", (3,)))
    missing = int(np.flatnonzero(np.isfinite(whole.before))[0])
    own = PlacedEffect.covariate

    def without_one(self: PlacedEffect, chain: Chain, loads: NodeLoads) -> Covariate | None:
        covariate = own(self, chain, loads)
        if covariate is None or covariate.parts is None:
            return covariate
        parts = covariate.parts.copy()
        parts[1, missing] = np.nan
        return Covariate.size_of(covariate.label, covariate.unit, parts)

    monkeypatch.setattr(PlacedEffect, "covariate", without_one)
    found, _ = evidence.__wrapped__("bearing-tilt", Place("joints", (3,)))
    others = np.arange(len(whole.value)) != missing
    assert np.isnan([found.value[missing], found.before[missing], found.law[missing]]).all()
    np.testing.assert_allclose(found.value[others], whole.value[others], rtol=1e-9)
    np.testing.assert_array_equal(np.isfinite(found.before[others]), np.isfinite(whole.before[others]))


def test_runs_add_up() -> None:
    """The errors run by run make the whole error, and every state is there once."""
    found, _ = evidence("backlash", Place("joints", (4,)))
    stated = getattr(found.rms_after, found.measure)
    whole = np.sqrt(np.mean([after**2 for _, _, after in found.by_run]))
    assert whole == pytest.approx(stated, rel=0.05)
    assert len(np.unique(found.index)) == len(found.index) == len(found.value) == len(found.after)


def test_of_a_clamped_joint_the_motors_angle_is_read() -> None:
    chain = replace(six_axes(), gravity=np.zeros(3))
    states = clamped_bench(chain, np.array([[0.1, -1.0, 0.8, 0.2, 0.7, 0.1]]), (2,), 1e-9 * np.eye(6))
    springs = (PlacedEffect(find_effects()["joint-compliance"], Place("joints", (2,))),)
    robot = with_effect(CompliantRobot(chain, springs, deformed=False), "cubic-stiffness", Place("joints", (2,)))
    scan = scan_candidates(fit_observations(fit_problem(states, robot), robot, Settings()), [])
    (found,) = evidence_for(scan, {"cubic-stiffness j2"}, find_effects())
    assert found.measure == "motor_angle"
