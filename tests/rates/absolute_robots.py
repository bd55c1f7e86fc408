"""Absolute places of random robots: the set-ups of `campaigns/absolute` with poses, errors and effects drawn anew.

Targets (one, three, one with orientation), payloads and robots rotate with the campaign's number. Where a robot rests
is its finite balance; the size of an effect is the rms of what frames, geometry and springs cannot absorb.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np

from stiffcal.campaign.loading import load_campaign
from stiffcal.errors import no_progress
from stiffcal.identification.derivatives.observation import observe
from stiffcal.identification.fitting.fit import Fit
from stiffcal.identification.fitting.identify import identify_parameters
from stiffcal.identification.fitting.regressors import Linearised
from stiffcal.ingest.reading.reducing import reduce_campaign
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.rotations import rotation_from_vector
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.balance.equilibrium import NoBalanceError, solve_balance
from stiffcal.model.catalogue.campaign_effects import placed_robot
from stiffcal.model.catalogue.catalogue import built_in_effects
from stiffcal.model.effect import Values
from stiffcal.model.laws.drives import drive_torque
from stiffcal.simulation.played.true_motion import observed_shift
from tests.rates.hiding import INSIDE, Draw, draw_inside, draw_outside, scaled, with_effects
from tests.rates.playing import MOST_ABSORBED, Hidden, Ruler

CLASSES = ("absolute none", "absolute 3x", "absolute 1x", "absolute two", "absolute outside")
SOURCE = Path(__file__).parents[2] / "campaigns" / "absolute"
SETUPS = ("01", "02", "03", "05", "06", "07")
"""Of these are robot, targets and payloads; their poses and readings are not used."""
NOISE = (2e-5, 4e-5)
"""m and rad per axis."""
GEOMETRY = {"x": 2.5e-4, "y": 2.5e-4, "rx": 5e-4, "ry": 5e-4}
STIFFNESS = {"01": 5e5, "02": 2.5e6, "03": 2.5e6, "05": 6e4, "06": 2.5e6, "07": 5e5}
"""N·m/rad of joints 2 and 3, typically; wrists are a fifth of it."""
OF_TORQUE = (
    "backlash", "cubic-stiffness", "two-slope", "asymmetric-stiffness", "periodic-stiffness", "axis-coupling",
)  # fmt: skip
"""Laws of the torque of a joint, or of either of two."""
LEAST_TORQUE = 0.01
"""Least rms torque of such a joint (of two, of that with more), over that of the joint with most: weight does not turn
a vertical axis. What the sagging chain leaves there is of second order, and a law of it would have to be larger than on
any machine.
"""
FARTHEST_CENTRE = 0.3
"""m, by which a link's centre of mass is at most off."""
MOST_ALIKE = 0.7
"""Largest cosine of two hidden effects."""


def _eccentric(rng: np.random.Generator) -> Values:
    phase = float(rng.uniform(0.0, 2.0 * np.pi))
    return {"order": float(rng.integers(1, 3)), "a": float(np.cos(phase)), "b": float(np.sin(phase))}


def _displaced(rng: np.random.Generator) -> Values:
    direction = float(rng.uniform(0.0, 2.0 * np.pi))
    return {"mx": float(np.cos(direction)), "my": float(np.sin(direction))}


OF_PLACES = ("joint-eccentricity", "link-weight")
"""Effects that absolute places alone show."""
POOL: dict[str, Draw] = {
    name: INSIDE[name]
    for name in ("bearing-tilt", "link-beam", "link-springs", "axis-coupling", "backlash", "cubic-stiffness",
                 "two-slope", "asymmetric-stiffness", "periodic-stiffness", "thermal-drift")
}  # fmt: skip


@cache
def _setup(name: str) -> tuple[LoadStates, CompliantRobot]:
    campaign = load_campaign(SOURCE / name)
    return reduce_campaign(campaign, no_progress).states, placed_robot(campaign)


def draw_absolute(kind: str, rng: np.random.Generator, number: int) -> Hidden:
    """Draw a campaign of one of the classes.

    Parameters
    ----------
    kind : of `CLASSES`. number : decides on the set-up.
    """
    for _ in range(200):
        try:
            return _draw(kind, rng, SETUPS[number % len(SETUPS)])
        except NoBalanceError:
            continue
    raise RuntimeError("no campaign found its balance")


def _draw(kind: str, rng: np.random.Generator, setup: str) -> Hidden:
    template, model = _setup(setup)
    model = replace(model, placed=tuple(PlacedEffect(p.effect, p.place) for p in model.placed))
    limits = model.chain.limits
    joints = rng.uniform(limits[:, 0], limits[:, 1], template.joints.shape)
    plan = replace(template, joints=joints, wrench=template.wrench[rng.permutation(len(template))])
    truth = CompliantRobot(model.chain, tuple(_with_values(p, rng, setup) for p in model.placed), model.deformed)
    plan = _measured(plan, truth, None)
    ruler = Ruler.of(truth, observe(plan, model.chain), NOISE)
    what = kind.split(" ", 1)[1]
    hidden, sizes = _hide(what, rng, ruler)
    states = _measured(plan, with_effects(truth, *hidden), rng)
    words = f"set-up {setup}, {len(states.setup.targets)} targets{', pose' if states.has_orientation else ''}"
    whole = with_effects(truth, *hidden)
    label = "none" if what == "none" else "outside 3x" if what == "outside" else "several" if what == "two" else "one"
    return Hidden(label, states, model, whole, hidden, sizes, NOISE, words, (), "balance")


def _with_values(placed: PlacedEffect, rng: np.random.Generator, setup: str) -> PlacedEffect:
    """Return an effect of the model with what the robot has; frames are where registration puts them."""
    if placed.effect.name == "joint-compliance":
        wrist = 0.2 if placed.place.joints[0] > 3 else 1.0
        return replace(placed, values={"c": 1.0 / (STIFFNESS[setup] * wrist * float(rng.uniform(0.6, 1.6)))})
    if placed.effect.name == "link-geometry":
        return replace(placed, values={name: size * float(rng.standard_normal()) for name, size in GEOMETRY.items()})
    return replace(placed, values={spec.symbol: 0.0 for spec in placed.effect.parameters})


def _measured(plan: LoadStates, robot: CompliantRobot, rng: np.random.Generator | None) -> LoadStates:
    """Return the plan with the places in which the robot rests, with noise where ``rng`` is given."""
    order = observe(plan, robot.chain).order
    rest = solve_balance(robot, robot.chain.model_angles(plan.joints), plan.wrench, plan.setup, order)
    shift = observed_shift(robot, rest.displacement, order)
    position = rest.target_position + shift[..., :3]
    rotation = rotation_from_vector(shift[..., 3:]) @ rest.target_rotation
    if rng is not None:
        position = position + NOISE[0] * rng.standard_normal(position.shape)
        rotation = rotation_from_vector(NOISE[1] * rng.standard_normal(position.shape)) @ rotation
    return replace(plan, position=position, rotation=rotation if plan.has_orientation else plan.rotation)


def _hide(what: str, rng: np.random.Generator, ruler: Ruler) -> tuple[tuple[PlacedEffect, ...], tuple[float, ...]]:
    if what == "none":
        return (), ()
    if what == "outside":
        return (_sized(ruler, draw_outside(rng, ruler.state), 3.0),), (3.0,)
    if what != "two":
        size = float(what.removesuffix("x"))
        return (_sized(ruler, _draw_effect(rng, ruler.state), size),), (size,)
    pair = tuple(_sized(ruler, _draw_effect(rng, ruler.state), 3.0) for _ in range(2))
    if (pair[0].effect.name, pair[0].place) == (pair[1].effect.name, pair[1].place):
        raise NoBalanceError("these two are one")
    rows = np.array([ruler.rest_of(ruler.change(one)[None])[0] for one in pair])
    first, second = rows / np.linalg.norm(rows, axis=1)[:, None]
    if abs(float(first @ second)) > MOST_ALIKE:
        raise NoBalanceError("nobody could separate these two")
    return pair, (3.0, 3.0)


def _draw_effect(rng: np.random.Generator, state: Linearised) -> PlacedEffect:
    """Draw an effect; eccentricities and weights as often as any other."""
    pick = rng.uniform() * (len(OF_PLACES) + len(POOL))
    if pick >= len(OF_PLACES):
        drawn = draw_inside(rng, state, POOL)
        if drawn.effect.name in OF_TORQUE:
            chain, loads = state.robot.chain, state.loads.wrench
            torque = [np.std(drive_torque(chain, loads, joint + 1)) for joint in range(chain.n_joints)]
            if max(torque[joint - 1] for joint in drawn.place.joints) < LEAST_TORQUE * max(torque):
                raise NoBalanceError("weight does not turn this joint")
        return drawn
    name = OF_PLACES[int(pick)]
    effect = built_in_effects()[name]
    places = effect.places(state.robot.chain)
    values = _eccentric(rng) if name == "joint-eccentricity" else _displaced(rng)
    return PlacedEffect(effect, places[int(rng.integers(len(places)))], values)


def _sized(ruler: Ruler, one: PlacedEffect, size: float) -> PlacedEffect:
    """Scale an effect until what the model cannot absorb has the size, in units of the noise."""
    # a first guess so small that the robot rests
    one = scaled(one, 1e-8)
    for _ in range(8):
        found = ruler.size(one)
        if found <= 0.0:
            raise NoBalanceError("the effect does not show")
        if abs(found / size - 1.0) < 0.01:
            break
        one = scaled(one, size / found)
    else:
        raise NoBalanceError("no size is found")
    bare = float(np.sqrt(np.mean(ruler.space.rows(ruler.change(one)[None])[0] ** 2)))
    if bare > MOST_ABSORBED * size:
        raise NoBalanceError("it would have to be larger than on any machine")
    if one.effect.name == "link-weight":
        chain = ruler.state.robot.chain
        mass = chain.link_mass[chain.joint_of_link[one.place.link] - 1]
        if np.hypot(one.values["mx"], one.values["my"]) > FARTHEST_CENTRE * mass:
            raise NoBalanceError("its centre would have to be farther off than on any machine")
    return one


def oracle_of(campaign: Hidden) -> Fit:
    """Fit the true effects to the readings, amplitudes from zero and shapes from their true values."""
    truly = tuple(PlacedEffect(one.effect, one.place, one.shape()) for one in campaign.hidden)
    return identify_parameters(campaign.states, with_effects(campaign.model, *truly))
