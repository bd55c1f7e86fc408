"""A campaign of a stress class: what differs from the field mix is in a recipe, all else is drawn as there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from stiffcal.identification.derivatives.observation import observe
from stiffcal.identification.fitting.identify import predict_observations
from stiffcal.measurements.load_states import LoadStates
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.balance.equilibrium import NoBalanceError
from stiffcal.reduction.set_aside.outliers import reject_outliers
from tests.calibration.field_mix import (
    ENCODER_NOISE,
    FORCE_ONLY,
    FULL_POSE,
    MASSES_KNOWN,
    NOISE_KNOWN,
    PLAYED_BY_MUJOCO,
    Category,
    FieldCampaign,
    NoiseKnown,
    count_readings,
    draw_size,
    model_under_test,
    pick,
    with_stated_noise,
)
from tests.laboratory.random_robots import DrawnRobot, draw_robot
from tests.rates.faults import size_of_fault
from tests.rates.hiding import OF_TOTAL_TORQUE, draw_inside, with_effects
from tests.rates.measuring import Motion, Player, measure, move
from tests.rates.mujoco_player import can_be_played
from tests.rates.plans import cycles, spreadsheet
from tests.rates.playing import ENCODER, Ruler, joint_springs

NOTHING = 0.4
"""Share of campaigns in which no effect is hidden, where a class may hide one."""
Noise = tuple[float, float]
"""Of the tracker, m and rad per axis."""


@dataclass(frozen=True)
class Hidden:
    """What is hidden in a campaign."""

    category: Category
    placed: tuple[PlacedEffect, ...] = ()
    sizes: tuple[float, ...] = ()
    """Rms of each over the noise, of what the joint springs cannot absorb."""


@dataclass(frozen=True)
class Mistake:
    """A mistake in the data."""

    states: LoadStates
    """With it."""
    runs: tuple[int, ...]
    """Numbers of the runs that are wrong, the one that is most so first."""


def nothing_or_one(rng: np.random.Generator, ruler: Ruler, of_total_torque: bool = True) -> Hidden:
    """Hide nothing, or one effect of the catalogue.

    Parameters
    ----------
    of_total_torque : whether laws of the whole torque may be hidden; who does not know the weights does not know it.
    """
    if rng.uniform() < NOTHING:
        return Hidden("nothing")
    while True:
        drawn = draw_inside(rng, ruler.state)
        if of_total_torque or drawn.effect.name not in OF_TOTAL_TORQUE:
            size = draw_size(rng)
            return Hidden("one", (ruler.sized(drawn, size),), (size,))


def nothing(rng: np.random.Generator, ruler: Ruler) -> Hidden:
    """Hide nothing."""
    return Hidden("nothing")


def as_planned(rng: np.random.Generator, plan: LoadStates) -> LoadStates:
    """Return the plan as it is."""
    return plan


def as_measured(rng: np.random.Generator, states: LoadStates, noise: Noise) -> LoadStates:
    """Return the states as the instruments read them."""
    return states


@dataclass(frozen=True)
class Recipe:
    """What is particular about a stress class."""

    robot: Callable[[np.random.Generator], DrawnRobot] = draw_robot
    hide: Callable[[np.random.Generator, Ruler], Hidden] = nothing_or_one
    plan: Callable[[np.random.Generator, LoadStates], LoadStates] = as_planned
    """What is measured, from a plan of the mix."""
    moved: Callable[[np.random.Generator, Player, LoadStates, CompliantRobot, CompliantRobot], Motion] | None = None
    """How the robot moves under the loads of a plan, with its springs, with all that is hidden; None: `move`."""
    scatter: Callable[[np.random.Generator], np.random.Generator] | None = None
    """What the instruments' noise is drawn from; None: the Gaussian of the mix."""
    read: Callable[[np.random.Generator, LoadStates, Noise], LoadStates] = as_measured
    """What stands in the file, from what the instruments read."""
    model: Callable[[CompliantRobot], CompliantRobot] | None = None
    """What is known of the robot, masses among it, where that is wrong; None: masses known in some campaigns."""
    misread: Callable[[np.random.Generator, LoadStates], LoadStates] | None = None
    """An error of the sensor that is none of the effects: what it reads of the loads."""
    mistake: Callable[[np.random.Generator, LoadStates, float], Mistake | None] | None = None
    """A mistake in the data, of a step to be scaled; None where these states cannot have it."""
    scaled: bool = False
    """Whether the mistake follows its step, so that it can be made as large as drawn."""
    full_pose: float = FULL_POSE
    """Share of campaigns that measure rotations."""
    noise_known: NoiseKnown | None = None
    """How the noise is known; None: as in the mix."""
    mujoco: bool = True
    """Whether MuJoCo can play a third."""
    visible: bool = False
    """Whether the readings can show that an assumption is broken."""


def draw(recipe: Recipe, rng: np.random.Generator, number: int) -> FieldCampaign:
    """Return a campaign of a class.

    Raises
    ------
    RuntimeError : none of two hundred drawn robots found its balance.
    """
    for _ in range(200):
        try:
            drawn = _drawn(recipe, rng, number)
        except NoBalanceError:
            continue
        if drawn is not None:
            return drawn
    raise RuntimeError("no campaign found its balance")


def _drawn(recipe: Recipe, rng: np.random.Generator, number: int) -> FieldCampaign | None:
    noise_known = recipe.noise_known or pick(rng, NOISE_KNOWN)
    player: Player = "mujoco" if recipe.mujoco and rng.uniform() < PLAYED_BY_MUJOCO else "balance"
    robot = recipe.robot(rng)
    full_pose, force_only = bool(rng.uniform() < recipe.full_pose), bool(rng.uniform() < FORCE_ONLY)
    plan = (cycles if noise_known == "repeats" else spreadsheet)(rng, robot, full_pose, force_only)
    plan = recipe.plan(rng, plan)
    noise = (robot.family.translation * rng.uniform(0.7, 1.4), robot.family.rotation * rng.uniform(0.7, 1.4))
    springs = joint_springs(robot)
    ruler = Ruler.of(springs, observe(plan, robot.chain), noise)
    hidden = recipe.hide(rng, ruler)
    if not all(can_be_played(one) for one in hidden.placed):
        player = "balance"
    whole = with_effects(springs, *hidden.placed)
    motion = recipe.moved(rng, player, plan, springs, whole) if recipe.moved else move(player, plan, springs, whole)
    if recipe.misread:
        plan, hidden = _misread(recipe.misread, rng, plan, ruler)
    states = measure(recipe.scatter(rng) if recipe.scatter else rng, plan, motion, robot, noise)
    if rng.uniform() < ENCODER_NOISE:
        states = replace(states, joints=states.joints + ENCODER * rng.normal(size=states.joints.shape))
    states = recipe.read(rng, with_stated_noise(rng, noise_known, states, noise), noise)
    of_torque = any(one.effect.name in OF_TOTAL_TORQUE for one in hidden.placed)
    masses = recipe.model is not None or of_torque or bool(rng.uniform() < MASSES_KNOWN)
    model = model_under_test(robot, masses)
    model = recipe.model(model) if recipe.model else model
    runs: tuple[int, ...] = ()
    if recipe.mistake:
        found = _mistaken(recipe, rng, states, whole, noise)
        if found is None:
            return None
        states, runs, hidden = found
    words = [robot.family.name.split()[0], f"{len(np.unique(states.run))} poses", "pose" if full_pose else "position"]
    words += ["force only"] * force_only + ["masses unknown"] * (not masses)
    fault = recipe.mistake.__name__.replace("_", " ") if recipe.mistake else ""
    return FieldCampaign(
        number, hidden.category, noise_known, player, reject_outliers(states), model, hidden.placed, hidden.sizes,
        runs, fault, count_readings(states, model), ", ".join(words), recipe.visible,
    )  # fmt: skip


def _misread(
    misread: Callable[[np.random.Generator, LoadStates], LoadStates],
    rng: np.random.Generator,
    plan: LoadStates,
    ruler: Ruler,
) -> tuple[LoadStates, Hidden]:
    """Return the plan with the loads as they are read, and by how much that changes what is predicted of it."""
    read = misread(rng, plan)
    as_read = predict_observations(ruler.truth, observe(read, ruler.truth.chain))
    rest = ruler.rest_of((as_read - ruler.state.predicted)[None])[0]
    return read, Hidden("outside", (), (float(np.sqrt(np.mean(rest**2))),))


def _mistaken(
    recipe: Recipe, rng: np.random.Generator, states: LoadStates, truth: CompliantRobot, noise: Noise
) -> tuple[LoadStates, tuple[int, ...], Hidden] | None:
    """Return the states with a mistake, its runs, and how large it is there; None where there is no room for it."""
    assert recipe.mistake is not None
    start = rng.bit_generator.state
    mistake = recipe.mistake(rng, states, 1.0)
    if mistake is None:
        return None
    deflection, change = size_of_fault(mistake.states, states, truth, mistake.runs, noise)
    if recipe.scaled:
        size, rng.bit_generator.state = draw_size(rng), start
        mistake = recipe.mistake(rng, states, size / change)
        assert mistake is not None
        deflection, change = size_of_fault(mistake.states, states, truth, mistake.runs, noise)
    return mistake.states, mistake.runs, Hidden("mistake", (), (min(deflection, change),))
