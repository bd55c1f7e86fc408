"""The field mix: campaigns as laboratories have them, in the proportions with which a stated probability must hold.

Fixed before the first judgement by it. What is hidden is drawn by what is wrong, then by how much (log-uniform, a tenth
of the noise to ten times the noise), then by how the campaign was measured: load cycles with repeats, or a spreadsheet
of single loads whose noise is stated rightly, stated wrongly or not at all. A third is played by MuJoCo, with none of
our mechanics. Each campaign follows from its seed and number alone.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Literal, TypeVar

import numpy as np

from stiffcal.identification.derivatives.observation import observe
from stiffcal.measurements.load_states import LoadStates
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.balance.equilibrium import NoBalanceError
from stiffcal.reduction.set_aside.outliers import reject_outliers
from tests.laboratory.random_robots import DrawnRobot, draw_robot
from tests.rates.faults import FAULTS, draw_faulty
from tests.rates.hiding import OF_TOTAL_TORQUE, draw_inside, draw_outside, with_effects
from tests.rates.measuring import Player, bumped, measure, move
from tests.rates.plans import cycles, spreadsheet
from tests.rates.playing import ENCODER, Ruler, geometry_off, hide_several, joint_springs

T = TypeVar("T", bound=str)
Category = Literal["nothing", "one", "several", "outside", "mistake"]
NoiseKnown = Literal["repeats", "stated", "stated wrong", "unknown"]

CATEGORIES: dict[Category, float] = {"nothing": 0.40, "one": 0.35, "several": 0.10, "outside": 0.10, "mistake": 0.05}
"""What is wrong, and how often."""
NOISE_KNOWN: dict[NoiseKnown, float] = {"repeats": 0.50, "stated": 0.20, "stated wrong": 0.15, "unknown": 0.15}
"""How the noise is known, and how often."""
SIZES = (0.1, 10.0)
"""Least and largest rms of a hidden effect over the noise, after the joint springs have absorbed what they can."""
WRONG_BY = (0.5, 2.0)
"""Stated noise over the true one, where it is stated wrongly."""
PLAYED_BY_MUJOCO = 1.0 / 3.0
FULL_POSE, FORCE_ONLY, MASSES_KNOWN, GEOMETRY_OFF, KNOCKED, ENCODER_NOISE = 0.6, 0.2, 0.7, 0.15, 0.15, 0.2
"""Shares of campaigns."""


@dataclass(frozen=True)
class FieldCampaign:
    """A campaign of the mix and what is in it."""

    number: int
    """Of the seed's campaigns."""
    category: Category
    """What is wrong."""
    noise_known: NoiseKnown
    """How the noise is known."""
    player: Player
    """What moved the robot."""
    states: LoadStates
    """As the tool gets them, bumped readings set aside as ingest does."""
    model: CompliantRobot
    """The model under test: joint springs, masses where known."""
    hidden: tuple[PlacedEffect, ...]
    """What the model lacks."""
    sizes: tuple[float, ...]
    """Rms of each over the noise, of what the joint springs cannot absorb."""
    runs: tuple[int, ...]
    """Numbers of faulty runs."""
    fault: str
    """What is wrong with them, of `tests.rates.faults.FAULTS`; empty where none is."""
    n_readings: int
    """Measured components."""
    settings: str
    """In words."""
    visible: bool = False
    """Whether an assumption of the judge is broken such that the readings can show it."""


def draw_campaign(seed: int, number: int) -> FieldCampaign:
    """Return one campaign of the mix.

    Raises
    ------
    RuntimeError : none of two hundred drawn robots found its balance.
    """
    rng = np.random.default_rng([seed, number])
    category = pick(rng, CATEGORIES)
    noise_known = pick(rng, NOISE_KNOWN)
    player: Player = "mujoco" if rng.uniform() < PLAYED_BY_MUJOCO else "balance"
    if category == "mistake":
        return _mistaken(rng, number, noise_known, player)
    for _ in range(200):
        try:
            return _drawn(rng, number, category, noise_known, player)
        except NoBalanceError:
            continue
    raise RuntimeError("no campaign found its balance")


def pick(rng: np.random.Generator, shares: Mapping[T, float]) -> T:
    """Draw a name by its share."""
    names = list(shares)
    return names[int(rng.choice(len(names), p=list(shares.values())))]


def draw_size(rng: np.random.Generator) -> float:
    """Draw the rms of a hidden effect over the noise."""
    return float(np.exp(rng.uniform(*np.log(SIZES))))


def _mistaken(rng: np.random.Generator, number: int, noise_known: NoiseKnown, player: Player) -> FieldCampaign:
    """Return a campaign of joint springs alone with a fault in a run or a row."""
    form = "cycles" if noise_known == "repeats" else str(rng.choice(["rows", "pairs"]))
    faults = [fault for fault in FAULTS if form == "rows" or fault != "bad row"]
    faulty = draw_faulty(rng, form, str(rng.choice(faults)), player=player)
    size = min(faulty.change, faulty.deflection)
    readings = count_readings(faulty.states, faulty.model)
    return FieldCampaign(
        number, "mistake", noise_known, player, faulty.states, faulty.model, (), (size,), faulty.runs,
        faulty.fault, readings,
        f"{faulty.fault}; {faulty.settings}",
    )  # fmt: skip


def _drawn(
    rng: np.random.Generator, number: int, category: Category, noise_known: NoiseKnown, player: Player
) -> FieldCampaign:
    robot = draw_robot(rng)
    full_pose, force_only = bool(rng.uniform() < FULL_POSE), bool(rng.uniform() < FORCE_ONLY)
    repeats = noise_known == "repeats"
    plan = (cycles if repeats else spreadsheet)(rng, robot, full_pose, force_only)
    noise = (robot.family.translation * rng.uniform(0.7, 1.4), robot.family.rotation * rng.uniform(0.7, 1.4))
    truth = joint_springs(robot)
    hidden, sizes = _hidden(rng, category, Ruler.of(truth, observe(plan, robot.chain), noise))
    whole = with_effects(truth, *hidden)
    states = measure(rng, plan, move(player, plan, truth, whole), robot, noise)
    if repeats and rng.uniform() < KNOCKED:
        states, _ = bumped(rng, states)
    if rng.uniform() < ENCODER_NOISE:
        states = replace(states, joints=states.joints + ENCODER * rng.normal(size=states.joints.shape))
    states = with_stated_noise(rng, noise_known, states, noise)
    masses = bool(rng.uniform() < MASSES_KNOWN) or any(one.effect.name in OF_TOTAL_TORQUE for one in hidden)
    off = bool(rng.uniform() < GEOMETRY_OFF)
    model = model_under_test(robot, masses)
    words = [robot.family.name.split()[0], f"{len(states.runs)} poses", "pose" if full_pose else "position"]
    words += ["force only"] * force_only + ["masses unknown"] * (not masses) + ["geometry off"] * off
    return FieldCampaign(
        number, category, noise_known, player, reject_outliers(states), geometry_off(rng, model) if off else model,
        hidden, sizes, (), "", count_readings(states, model), ", ".join(words),
    )  # fmt: skip


def model_under_test(robot: DrawnRobot, masses: bool) -> CompliantRobot:
    """Return the robot with joint springs without values, its masses known or not."""
    springs = joint_springs(robot)
    chain = robot.chain if masses else robot.without_masses()
    return CompliantRobot(chain, tuple(PlacedEffect(one.effect, one.place) for one in springs.placed))


def _hidden(
    rng: np.random.Generator, category: Category, ruler: Ruler
) -> tuple[tuple[PlacedEffect, ...], tuple[float, ...]]:
    if category == "nothing":
        return (), ()
    if category == "several":
        return hide_several(rng, ruler, [draw_size(rng) for _ in range(2 if rng.uniform() < 0.7 else 3)])
    drawn = draw_outside(rng, ruler.state) if category == "outside" else draw_inside(rng, ruler.state)
    size = draw_size(rng)
    return (ruler.sized(drawn, size),), (size,)


def with_stated_noise(
    rng: np.random.Generator, noise_known: NoiseKnown, states: LoadStates, noise: tuple[float, float]
) -> LoadStates:
    """Return the states with what the manifest says of their noise."""
    if noise_known in ("repeats", "unknown"):
        return states
    times = float(rng.choice(WRONG_BY)) if noise_known == "stated wrong" else 1.0
    sigma = replace(states.setup.sigma, translation=times * noise[0], rotation=times * noise[1])
    return replace(states, setup=replace(states.setup, sigma=sigma))


def count_readings(states: LoadStates, model: CompliantRobot) -> int:
    """Return how many components were measured."""
    return int(np.count_nonzero(observe(states, model.chain).measured_mask))
