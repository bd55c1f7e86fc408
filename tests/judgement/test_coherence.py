"""What must not change an answer: the units of readings and parameters, and what is in the model already."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.identification.derivatives.observation import observe
from stiffcal.identification.fitting.identify import Settings, fit_observations, fit_problem
from stiffcal.identification.fitting.regressors import Linearised
from stiffcal.identification.noise.projection import Projection
from stiffcal.identification.noise.reading_noise import Whitening
from stiffcal.identification.noise.weights import predict_observations
from stiffcal.judgement.covariance_kind import CovarianceKind
from stiffcal.judgement.discrepancy import Discrepancy
from stiffcal.judgement.evidence import MemberColumns, SetEvidence
from stiffcal.judgement.lingering_noise import LingeringNoise
from stiffcal.judgement.noise_scale import NoiseScale
from stiffcal.judgement.numbers import LINGERING, OF_LOADS, OF_TIME, SIZE_WEIGHTS, SIZES
from stiffcal.judgement.shared import Shared
from stiffcal.judgement.states import StatesOfCampaign, judge_states
from stiffcal.judgement.tails import Readings
from stiffcal.measurements.load_states import LoadStates, Sigma
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.catalogue.catalogue import built_in_effects
from stiffcal.model.effect import Place
from tests.laboratory.simulated_states import medium_robot, played

NOISE = Sigma(16e-6, 30e-6, 0.5, 0.1)
EFFECTS = built_in_effects()
PLAY = PlacedEffect(EFFECTS["backlash"], Place("joints", (4,)), {"width": 2e-4, "band": 5.0})
LESSER_PLAY = PlacedEffect(EFFECTS["backlash"], Place("joints", (2,)), {"width": 2e-5, "band": 5.0})
"""Of which nothing is certain."""
KNEE = PlacedEffect(EFFECTS["two-slope"], Place("joints", (3,)), {"c": 1.5e-7, "knee": 100.0})
A, B = "backlash j4", "backlash j2"
TYPICAL_OF_SPRINGS = 1e-6
"""rad/(N·m), to which they are known before."""


def with_effects(*placed: PlacedEffect) -> CompliantRobot:
    robot = medium_robot()
    return replace(robot, placed=(*robot.placed, *placed))


def gains(of_lengths: float = 1.0, of_springs: Sequence[float] = (1.0,) * 6, of_members: float = 1.0) -> Floats:
    """Return the log evidence of a play, a knee, and both, against none.

    Parameters
    ----------
    of_lengths : by which positions and their noise are multiplied.
    of_springs, of_members : units of these parameters.
    """
    data = observe(played(with_effects(PLAY), runs=3, noise=NOISE, seed=5), medium_robot().chain)
    about = Linearised.about(medium_robot(), data)
    unit = np.repeat([of_lengths, 1.0], 3)[:, None]
    sigma = np.repeat([16e-6, 30e-6], 3)[:, None] * unit
    space = Projection.of(data, Whitening(np.repeat(1.0 / sigma, data.n_states, axis=1)))
    kinds: list[tuple[CovarianceKind, float]] = [
        (Discrepancy.of_loads(space), OF_LOADS),
        (Discrepancy.of_time(space), OF_TIME),
        (LingeringNoise.of(space, data.run, np.arange(data.n_states)), LINGERING),
    ]
    springs = np.array([about.regressor(one.effect, one.place, {}).columns[0] for one in medium_robot().placed])
    known = np.diag(of_springs) / TYPICAL_OF_SPRINGS
    shared = Shared(
        space.rows(springs * np.reshape(of_springs, (-1, 1, 1)) * unit), np.column_stack([known, np.ones(6)]), kinds
    )
    members = []
    for one in (PLAY, KNEE):
        law = about.regressor(one.effect, one.place, one.shape())
        typical = one.effect.spec(law.symbols[0]).typical
        rows = space.rows(law.columns * unit * of_members)
        members.append(MemberColumns(rows, np.ones(1, dtype=np.bool_), SIZES * typical / of_members, SIZE_WEIGHTS))
    residual = space.rows((data.measured - predict_observations(medium_robot(), data))[None] * unit)[0]
    readings = Readings(shared, residual, space.free.ravel(), np.repeat(data.kind, data.n_states))
    evidence = SetEvidence.of(readings, members, NoiseScale(float(space.free.sum() - 6), 4.0))
    return np.array([evidence.of_set(one) - evidence.of_set(()) for one in ((0,), (1,), (0, 1))])


@pytest.mark.parametrize(
    "units",
    [
        {"of_lengths": 1e3},
        {"of_springs": (1.0, 1e3, 1e-3, 1.0, 1e6, 1.0)},
        {"of_members": 1e-6},
    ],
    ids=["lengths", "springs", "effects"],
)
def test_units_change_no_evidence(units: dict[str, float | Sequence[float]]) -> None:
    """Lengths in mm next to angles in rad; parameters of springs, known before, and of effects in other units."""
    plain = gains()
    assert plain[0] > 10.0
    assert gains(**units) == pytest.approx(plain, abs=1e-6)  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def with_two_plays() -> LoadStates:
    return played(with_effects(PLAY, LESSER_PLAY), runs=3, noise=NOISE, seed=5)


def without_values(*placed: PlacedEffect) -> CompliantRobot:
    return with_effects(*(PlacedEffect(one.effect, one.place) for one in placed))


def test_what_links_weigh_makes_the_same_whatever_effects_the_model_has(with_two_plays: LoadStates) -> None:
    """About a model with a play more weight moved the play's edge: it explained the play, which lost a quarter."""
    columns = []
    for model in (without_values(), without_values(PLAY, LESSER_PLAY)):
        fit = fit_observations(fit_problem(with_two_plays, model), model, Settings())
        campaign = StatesOfCampaign.of(with_two_plays, model, fit, EFFECTS, Settings(), doubt=False)
        columns.append(np.concatenate([own for _, own in campaign.weight.of_links]))
    one, other = columns
    # the spring next to the greater play is a tenth softer where that is missing
    assert np.linalg.norm(one - other) < 0.1 * np.linalg.norm(one)


@pytest.mark.practice
def test_an_effect_is_as_probable_next_to_one_that_was_added_first(with_two_plays: LoadStates) -> None:
    """p(B | A in the model) of a new diagnosis is p(A, B) / p(A) of the first; with both in the model too."""
    known = {name: EFFECTS[name] for name in ("joint-compliance", "backlash")}
    found = []
    for model in (without_values(), without_values(PLAY), without_values(PLAY, LESSER_PLAY)):
        judged = judge_states(with_two_plays, model, known)
        sets = {frozenset(judged.members[i].name for i in key): p for key, p in judged.weighed.probabilities().items()}
        first, both = (sum(p for names, p in sets.items() if wanted <= names) for wanted in ({A}, {A, B}))
        found.append(both / first)
    assert 0.5 < found[0] < 0.95
    assert found == pytest.approx([found[0]] * 3, abs=0.02)


@pytest.mark.practice
def test_several_threads_answer_the_same(with_two_plays: LoadStates) -> None:
    """To the last bit: each effect is prepared by itself."""
    known = {name: EFFECTS[name] for name in ("joint-compliance", "backlash", "two-slope")}
    one, other = (judge_states(with_two_plays, medium_robot(), known, jobs=jobs) for jobs in (1, 3))
    assert one.weighed.log == other.weighed.log
