"""A campaign of the field mix judged: what is named, how sure, and what must not change it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stiffcal.identification.noise.reading_noise import Noise
from stiffcal.judgement import rivals
from stiffcal.judgement.ground_of_states import GroundOfStates
from stiffcal.judgement.judge import Judged
from stiffcal.judgement.priors import RobotScale
from stiffcal.judgement.reading import read_off
from stiffcal.judgement.rows_off import Off
from stiffcal.judgement.states import judge_states
from stiffcal.model.assembled.composite import PlacedEffect
from stiffcal.model.catalogue.catalogue import built_in_effects
from stiffcal.model.effect import Effect
from tests.calibration.field_mix import FieldCampaign, draw_campaign
from tests.calibration.stress.classes import draw_stress
from tests.laboratory.few_effects import FEW

pytestmark = pytest.mark.long

SEED = 9001
"""Seed of the campaigns with which the judgement was developed."""
TARGET, NOTHING, FRICTION = 0, 1, 35
"""Of them one with a target that sits elsewhere, one with nothing, and one with friction."""

CREEP_SEED, CREEP = 3, 273
"""A campaign with creep, of which the grid has a better shape than the fit."""


NEXT_TO_FRICTION = (*FEW, "friction-hysteresis", "presliding", "stribeck", "target-offset", "wrench-scale")
"""Effects for what a catalogue and a model change in the answer, whichever effects these are."""


@pytest.fixture(scope="module")
def friction() -> FieldCampaign:
    return draw_campaign(SEED, FRICTION)


@pytest.fixture(scope="module")
def judged_friction(friction: FieldCampaign) -> Judged:
    return judge_states(friction.states, friction.model, next_to_friction())


def next_to_friction() -> dict[str, Effect]:
    return {name: effect for name, effect in built_in_effects().items() if name in NEXT_TO_FRICTION}


@pytest.fixture(scope="module")
def nothing() -> tuple[FieldCampaign, Judged]:
    campaign = draw_campaign(SEED, NOTHING)
    return campaign, judge_states(campaign.states, campaign.model, built_in_effects())


def probabilities(judged: Judged) -> dict[str, float]:
    """Return the probability of each effect at its place."""
    sets = judged.weighed.probabilities()
    found: dict[str, float] = {}
    for key, p in sets.items():
        for name in {judged.members[i].name for i in key}:
            found[name] = found.get(name, 0.0) + p
    return found


def test_nothing_is_named_where_nothing_is(nothing: tuple[FieldCampaign, Judged]) -> None:
    campaign, judged = nothing
    found = read_off(judged)
    assert campaign.hidden == ()
    assert found.groups == ()
    assert found.p_nothing > 0.9


def test_what_is_hidden_is_named_and_firm() -> None:
    campaign = draw_campaign(SEED, TARGET)
    found = read_off(judge_states(campaign.states, campaign.model, built_in_effects()))
    assert [group.members[0][0] for group in found.groups] == ["target-offset setup"]
    assert found.groups[0].firm
    assert found.p_nothing < 0.01


def test_an_effect_is_taken_back_in_the_shape_that_the_fit_found() -> None:
    """About the model with it, readings lack nothing: the part of the effect is put back, whatever its best shape."""
    campaign = draw_campaign(CREEP_SEED, CREEP)
    judged = judge_states(campaign.states, campaign.model, built_in_effects())
    assert judged.settled
    assert judged.chosen == {"creep j3"}
    assert probabilities(judged)["creep j3"] > 0.9


@pytest.mark.practice
def test_the_order_of_the_catalogue_changes_nothing(friction: FieldCampaign) -> None:
    effects = built_in_effects()
    reverse: dict[str, Effect] = dict(reversed(effects.items()))
    one, other = (probabilities(judge_states(friction.states, friction.model, known)) for known in (effects, reverse))
    for name in one.keys() | other.keys():
        assert one.get(name, 0.0) == pytest.approx(other.get(name, 0.0), abs=1e-9), name


def test_what_is_in_the_model_already_is_as_probable_as_before(
    friction: FieldCampaign, judged_friction: Judged
) -> None:
    """Added by hand or found by the judgement: the same hypothesis has the same probability."""
    effects = next_to_friction()
    placed = friction.hidden[0]
    added = PlacedEffect(effects[placed.effect.name], placed.place)
    with_it = replace(friction.model, placed=(*friction.model.placed, added))
    one, other = map(probabilities, (judged_friction, judge_states(friction.states, with_it, effects)))
    name = f"{placed.effect.name} {placed.place.label}"
    assert one[name] > 0.9
    assert one[name] == pytest.approx(other[name], abs=0.02)


def test_a_second_plugin_of_the_same_law_changes_no_group(friction: FieldCampaign, judged_friction: Judged) -> None:
    effects = next_to_friction()

    class Again(type(effects["friction-hysteresis"])):  # type: ignore[misc]
        """The same law by another name."""

        name = "friction-again"
        forms = ()

    with_it: dict[str, Effect] = {**effects, "friction-again": Again()}
    one, other = map(read_off, (judged_friction, judge_states(friction.states, friction.model, with_it)))
    assert one.groups[0].probability == pytest.approx(other.groups[0].probability, abs=0.01)
    assert one.p_unknown == pytest.approx(other.p_unknown, abs=0.01)
    assert not other.groups[0].firm


OTHER_UNIT_SEED, OTHER_UNIT, ITS_RUN = 4, 1, 4
"""A campaign with nothing hidden, one run of which is in N·mm."""


def test_a_run_in_another_unit_is_set_aside_before_effects_are_compared() -> None:
    """About a fit with it, seven effects explained what it did to the others."""
    campaign = draw_campaign(OTHER_UNIT_SEED, OTHER_UNIT)
    judged = judge_states(campaign.states, campaign.model, built_in_effects())
    found = read_off(judged)
    assert campaign.runs == (ITS_RUN,)
    ((off, probability),) = found.doubted
    assert off == Off(ITS_RUN)
    assert probability > 0.999
    assert found.groups == ()
    assert not found.unexplained
    assert ITS_RUN not in judged.ground.space.data.run


EXCHANGED_SEED, EXCHANGED = 5, 156
"""A campaign with nothing hidden, the angles of two runs exchanged."""


def test_two_runs_with_exchanged_angles_are_set_aside_together() -> None:
    """Either alone explains half: about a fit with both, three effects were named for them."""
    campaign = draw_campaign(EXCHANGED_SEED, EXCHANGED)
    found = read_off(judge_states(campaign.states, campaign.model, built_in_effects()))
    assert {off for off, _ in found.doubted} == {Off(run) for run in campaign.runs}
    assert found.groups == ()
    assert not found.unexplained


def test_a_single_reading_that_is_off_is_no_step(nothing: tuple[FieldCampaign, Judged]) -> None:
    """The first state of a run, eight noises off: a step between it and the others explains it as well."""
    campaign, plain = nothing
    states = campaign.states
    run = int(states.run[len(states) // 2])
    first = int(np.flatnonzero(states.run == run)[0])
    position = states.position.copy()
    noise = plain.fit.noise
    assert isinstance(noise, Noise)
    position[first, :, 0] += 8.0 * noise.translation
    found = read_off(judge_states(replace(states, position=position), campaign.model, built_in_effects()))
    assert [off for off, _ in found.doubted] == [Off(run, first)]
    assert found.groups == ()
    assert found.p_nothing > 0.9


CYCLES_SEED, CYCLES = 9002, 1
"""A campaign of load cycles with nothing hidden."""


@pytest.mark.practice
def test_a_target_that_was_elsewhere_for_a_while_is_no_effect() -> None:
    """Knocked by a millimetre's tenth and put back: a step in time to the end of its run explains a part."""
    campaign = draw_campaign(CYCLES_SEED, CYCLES)
    states = campaign.states
    run = int(states.run[len(states) // 2])
    own = np.flatnonzero(states.run == run)
    position = states.position.copy()
    position[own[len(own) // 3 : len(own) // 2], :, 0] += 1e-4
    found = read_off(judge_states(replace(states, position=position), campaign.model, built_in_effects()))
    assert [off for off, _ in found.doubted] == [Off(run)]
    assert found.groups == ()


def test_a_force_sensor_that_was_zeroed_anew_is_no_step_of_the_target() -> None:
    """Of positions in one pose both make the same."""
    campaign = draw_stress("mistake-zeroed-anew", 1, 0)
    judged = judge_states(campaign.states, campaign.model, built_in_effects())
    found = read_off(judged)
    assert [one.kind for one in judged.mistakes.values()] == ["zero"]
    assert [off for off, _ in found.doubted] == [Off(run) for run in campaign.runs]
    assert not any(group.firm for group in found.groups)


def test_about_the_same_fit_a_set_is_as_probable_as_it_was(friction: FieldCampaign, judged_friction: Judged) -> None:
    weighed, ground, own = judged_friction.weighed, judged_friction.ground, judged_friction.own
    assert isinstance(ground, GroundOfStates)
    assert ground.present
    scale = RobotScale.of(ground.state.robot, ground.state.loads)
    about = rivals._about_own_fit(weighed, own, ground, scale, rivals.no_setting)
    # sizes of several members are sought from elsewhere
    assert about == pytest.approx(weighed.weigh(own), abs=0.05)
