"""A campaign nobody has seen: a robot drawn at random, effects hidden in it at a given size, instruments with noise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.estimation.unknowns import free_columns
from stiffcal.identification.derivatives.observation import Observations, evaluate, observe
from stiffcal.identification.fitting.identify import predict_observations
from stiffcal.identification.fitting.regressors import Linearised
from stiffcal.identification.noise.projection import Projection
from stiffcal.identification.noise.reading_noise import Noise, whiten
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.rotations import rotation_from_vector
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.balance.equilibrium import NoBalanceError
from stiffcal.model.catalogue.catalogue import built_in_effects
from stiffcal.model.effect import Place
from stiffcal.model.laws.drives import drive_torque
from stiffcal.reduction.set_aside.outliers import reject_outliers
from tests.laboratory.random_robots import DrawnRobot, draw_robot
from tests.rates.hiding import (
    FAINT,
    INSIDE,
    OF_TOTAL_TORQUE,
    SEAT,
    SENSOR,
    draw_inside,
    draw_outside,
    scaled,
    with_effects,
)
from tests.rates.measuring import Player, bumped, measure, move
from tests.rates.plans import cycles, spreadsheet

# A joint's own law, backlash and friction apart, stays below what its spring gives: gears are not that bad.
MOST_OF_SPRING = 1.5
# An effect of which the springs absorb more than nine tenths would have to be ten times as large as what is seen.
MOST_ABSORBED = 10.0
# A moment in other units is a fault of the file, a sensor drawn at the wrong flange one of the drawing: both are found
# otherwise. What stays is off by less: a share, and metres.
MOST_SENSOR_ERROR = {"wrench-scale": 0.3, "wrench-origin": 0.1}
# An encoder's step of 2^-20 turn, behind a gear of 100: about a microradian.
ENCODER = 1e-6
CLASSES = (
    "none", "one 4x", "one 1x", "one 0.5x", "several", "outside 4x", "outside 1x", "seat-shift", "servo",
    "no repeats", "noise half", "noise double", "geometry off", "wrong start", "ten apart", "outside 0.7x",
    "faulty run", "faulty row",
)  # fmt: skip
# Campaigns in which nothing but a run or a row is wrong: `tests.rates.faulty`.
FAULTY = ("faulty run", "faulty row")
# The classes up to here are all played by the balance, as earlier rates were; of the others MuJoCo plays every third.
PLAYED_BY_BALANCE = CLASSES[: CLASSES.index("no repeats")]
MUJOCO_PLAYS_EVERY = 3
# Classes of measurements as they are: spreadsheets of 24 poses with two loads each and no load twice …
SPREADSHEET = {"no repeats": None, "noise half": 0.5, "noise double": 2.0}
"""… with the stated noise over the true one; None where none is stated."""
# … robots whose lengths and axes are not those of the robot file (m, rad, standard deviations per joint) …
GEOMETRY_OFF = (5e-4, 3.5e-4)
# … and how many of these campaigns hide nothing.
NOTHING_HIDDEN = 0.4


@dataclass(frozen=True)
class Hidden:
    """A campaign and what is in it.

    Attributes
    ----------
    kind : one of `CLASSES`.
    states : as the tool gets them, bumped readings set aside as ingest does.
    model : the model under test: joint springs, masses where known.
    truth : the robot with all that is hidden, fully valued.
    hidden : what the model lacks.
    sizes : rms over all measured components, over their noise, of what the joint springs cannot absorb.
    alike : per hidden effect the names of candidates with 95 % the same signature.
    noise : the tracker's, m and rad per axis.
    settings : words on poses, position only, masses, bumps.
    player : what moved the robot.
    """

    kind: str
    states: LoadStates
    model: CompliantRobot
    truth: CompliantRobot
    hidden: tuple[PlacedEffect, ...]
    sizes: tuple[float, ...]
    noise: tuple[float, float]
    settings: str
    bumped: tuple[int, ...]
    player: Player


def player_of(chosen: Player | Literal["mixed"], kind: str, number: int) -> Player:
    """Return what plays a campaign: what was chosen, or each its share."""
    if chosen != "mixed":
        return chosen
    if kind in PLAYED_BY_BALANCE or number % MUJOCO_PLAYS_EVERY:
        return "balance"
    return "mujoco"


def simulate_runs(kind: str, rng: np.random.Generator, only: str = "", player: Player = "balance") -> Hidden:
    """Draw campaigns until one finds its balance and its effects are such as machines have."""
    for _ in range(200):
        try:
            return _play(kind, rng, only, player)
        except NoBalanceError:
            continue
    raise RuntimeError("no campaign found its balance")


def _play(kind: str, rng: np.random.Generator, only: str, player: Player) -> Hidden:
    robot = draw_robot(rng)
    full_pose = bool(rng.uniform() < 0.6)
    truth = joint_springs(robot)
    force_only = only == "load-point-offset" or bool(rng.uniform() < 0.2)
    force_only = force_only and only not in SENSOR
    plain = (
        spreadsheet(rng, robot, full_pose, force_only)
        if kind in SPREADSHEET
        else cycles(rng, robot, full_pose, force_only)
    )
    noise = (robot.family.translation * rng.uniform(0.7, 1.4), robot.family.rotation * rng.uniform(0.7, 1.4))
    ruler = Ruler.of(truth, observe(plain, robot.chain), noise)
    hidden: tuple[PlacedEffect, ...]
    sizes: tuple[float, ...]
    if kind == "servo":
        size = float(rng.uniform(0.5, 4.0))
        plain, pushed = _pushed(rng, plain, ruler, size)
        hidden, sizes = (pushed,), (size,)
    else:
        hidden, sizes = _hide(kind, rng, ruler, only)
    if kind == "servo" or rng.uniform() < 0.2:
        read = plain.joints + ENCODER * rng.normal(size=plain.joints.shape)
    else:
        read = plain.joints
    whole = with_effects(truth, *hidden)
    states = measure(rng, plain, move(player, plain, truth, whole), robot, noise)
    knocked: tuple[int, ...] = ()
    if rng.uniform() < 0.25 and kind not in SPREADSHEET:
        states, knocked = bumped(rng, states)
    masses = bool(rng.uniform() < 0.7) or any(one.effect.name in OF_TOTAL_TORQUE for one in hidden)
    model = CompliantRobot(
        robot.chain if masses else robot.without_masses(),
        tuple(PlacedEffect(one.effect, one.place) for one in truth.placed),
    )
    model = _started(kind, rng, model, hidden)
    states = _stated(kind, states, noise)
    words = (
        f"{robot.family.name.split()[0]}, {len(states.runs)} poses, {'pose' if full_pose else 'position'}"
        f"{', force only' if force_only else ''}"
        f"{', compensator' if robot.chain.compensator else ''}{'' if masses else ', masses unknown'}"
        f"{', bumped' if knocked else ''}"
    )
    states = replace(states, joints=read)
    return Hidden(kind, reject_outliers(states), model, whole, hidden, sizes, noise, words, knocked, player)


def _stated(kind: str, states: LoadStates, noise: tuple[float, float]) -> LoadStates:
    """Return the states with the noise stated as the class says."""
    times = SPREADSHEET.get(kind)
    if times is None:
        return states
    sigma = replace(states.setup.sigma, translation=times * noise[0], rotation=times * noise[1])
    return replace(states, setup=replace(states.setup, sigma=sigma))


def _started(
    kind: str, rng: np.random.Generator, model: CompliantRobot, hidden: tuple[PlacedEffect, ...]
) -> CompliantRobot:
    """Return the model as somebody begins who is wrong: with an effect that is not there, or on another geometry."""
    if kind == "wrong start":
        effect = built_in_effects()["bearing-tilt"]
        places = [
            place
            for place in effect.places(model.chain)
            if all((one.effect.name, one.place) != (effect.name, place) for one in hidden)
        ]
        return replace(model, placed=(*model.placed, PlacedEffect(effect, places[int(rng.integers(len(places)))])))
    if kind in ("geometry off", "only geometry off"):
        return geometry_off(rng, model)
    return model


def geometry_off(rng: np.random.Generator, model: CompliantRobot) -> CompliantRobot:
    """Return the model on a robot file whose lengths and axes are not the robot's."""
    length, angle = GEOMETRY_OFF
    off = np.tile(np.eye(4), (len(model.chain.fixed), 1, 1))
    off[:, :3, :3] = rotation_from_vector(angle * rng.normal(size=(len(off), 3)))
    off[:, :3, 3] = length * rng.normal(size=(len(off), 3))
    return replace(model, chain=replace(model.chain, fixed=np.asarray(model.chain.fixed) @ off))


def joint_springs(robot: DrawnRobot) -> CompliantRobot:
    """Return the robot with its joint stiffness alone."""
    effect, chain = built_in_effects()["joint-compliance"], robot.chain
    places = [Place("joints", (k,)) for k in range(1, chain.n_joints + 1)]
    return CompliantRobot(
        chain,
        tuple(
            PlacedEffect(effect.at(place, chain), place, {"c": 1.0 / stiffness})
            for place, stiffness in zip(places, robot.stiffness, strict=True)
        ),
    )


@dataclass(frozen=True)
class Ruler:
    """Measures how large an effect is, as the issue defines it."""

    truth: CompliantRobot
    state: Linearised
    space: Projection
    basis: Floats

    @classmethod
    def of(cls, truth: CompliantRobot, data: Observations, noise: tuple[float, float]) -> Ruler:
        """Prepare for one campaign."""
        space = Projection.of(data, whiten(Noise(*noise, 0.0, 0.0, "manifest", np.inf), data, None))
        columns = np.concatenate([b.columns for b in evaluate(truth, data, free_columns(truth))], axis=2)
        rows = space.rows(columns)
        basis, triangle = np.linalg.qr(rows.T)
        seen = np.abs(np.diag(triangle)) > 1e-9 * np.abs(np.diag(triangle)).max()
        return cls(truth, Linearised.about(truth, data), space, basis[:, seen])

    def rest_of(self, stack: Floats) -> Floats:
        """Return whitened rows of what joint springs and run offsets leave of displacements (k, m, n)."""
        rows = self.space.rows(stack)
        return np.asarray(rows - (rows @ self.basis) @ self.basis.T)

    def size(self, one: PlacedEffect) -> float:
        """Return the rms over all measured components of what the joint springs cannot absorb."""
        return float(np.sqrt(np.mean(self.rest_of(self.change(one)[None])[0] ** 2)))

    def change(self, one: PlacedEffect) -> Floats:
        """Return (m, n) by how much an effect changes what is measured."""
        return predict_observations(with_effects(self.truth, one), self.state.data) - self.state.predicted

    def _spring(self, one: PlacedEffect) -> float:
        """Return the rms of what the spring of the effect's joint gives, over the noise; infinite for other places."""
        if one.place.kind != "joints" or one.effect.name in ("bearing-tilt", "joint-translation"):
            return np.inf
        spring = next(p for p in self.truth.placed if p.place == one.place)
        column = self.state.regressor(spring.effect, spring.place, {}).columns[0] * spring.amplitude("c")
        return float(np.sqrt(np.mean(self.space.rows(column[None])[0] ** 2)))

    def sized(self, one: PlacedEffect, size: float) -> PlacedEffect:
        """Scale an effect until it has the size."""
        start = self.state.regressor(one.effect, one.place, one.shape())
        amplitudes = np.array([one.amplitude(symbol) if symbol in one.values else 0.0 for symbol in start.symbols])
        linear = np.einsum("q,qmn->mn", amplitudes, start.columns)
        found = float(np.sqrt(np.mean(self.rest_of(linear[None])[0] ** 2)))
        if found <= 0.0:
            raise NoBalanceError("the effect does not show")
        one = scaled(one, size / found)
        bare = float(np.sqrt(np.mean(self.space.rows(size / found * linear[None])[0] ** 2)))
        if bare > MOST_ABSORBED * size or bare > MOST_OF_SPRING * self._spring(one):
            raise NoBalanceError("it would have to be larger than on any machine")
        _check_sensor(one)
        for _ in range(4):
            found = self.size(one)
            if abs(found / size - 1.0) < 0.01:
                break
            one = scaled(one, size / found)
        _check_sensor(one)
        return one


def _check_sensor(one: PlacedEffect) -> None:
    """Raise where a sensor's gain or origin would have to be further off than on any bench."""
    most = MOST_SENSOR_ERROR.get(one.effect.name, np.inf)
    if any(abs(one.amplitude(symbol)) > most for symbol in one.values):
        raise NoBalanceError("no sensor is so far off")


def _pushed(rng: np.random.Generator, plan: LoadStates, ruler: Ruler, size: float) -> tuple[LoadStates, PlacedEffect]:
    """Return the plan with one motor pushed off in proportion to its torque, by so much that it has the size."""
    chain, state = ruler.truth.chain, ruler.state
    joint = int(rng.integers(1, chain.n_joints + 1))
    torque = np.asarray(drive_torque(chain, state.loads.wrench, joint))
    # In proportion to the torque alone it would count as compliance: loops integrate, here more, there less.
    torque = torque * rng.uniform(0.2, 1.8, len(plan.runs))[plan.run]
    first = np.searchsorted(plan.run, plan.run)
    one = PlacedEffect(built_in_effects()["servo-deflection"], Place("joints", (joint,)))

    def with_motion(rate: float) -> LoadStates:
        joints = plan.joints.copy()
        joints[:, joint - 1] += rate * (torque - torque[first])
        return replace(plan, joints=joints)

    rate = 1e-7
    for _ in range(3):
        moved = with_motion(rate)
        found = replace(ruler, state=Linearised.about(ruler.truth, observe(moved, chain))).size(one)
        if found <= 0.0:
            raise NoBalanceError("the motor carries nothing")
        rate *= size / found
    return with_motion(rate), one


def _hide(
    kind: str, rng: np.random.Generator, ruler: Ruler, only: str
) -> tuple[tuple[PlacedEffect, ...], tuple[float, ...]]:
    if kind in ("none", "only geometry off"):
        return (), ()
    if kind.startswith("outside"):
        size = float(kind.split()[1].removesuffix("x"))
        return (ruler.sized(draw_outside(rng, ruler.state), size),), (size,)
    if kind == "seat-shift":
        size = float(rng.uniform(0.5, 1.5))
        return (ruler.sized(draw_inside(rng, ruler.state, SEAT), size),), (size,)
    if kind == "several":
        return hide_several(rng, ruler)
    if kind == "ten apart":
        return hide_several(rng, ruler, sizes=(4.0, 0.4))
    if kind in (*SPREADSHEET, "geometry off", "wrong start"):
        if rng.uniform() < NOTHING_HIDDEN:
            return (), ()
        one, size = draw_inside(rng, ruler.state, only=only), float(np.exp(rng.uniform(0.0, np.log(4.0))))
        size = min(size, 1.5) if one.effect.name in FAINT else size
        return (ruler.sized(one, size),), (size,)
    one = draw_inside(rng, ruler.state, only=only)
    size = {"one 4x": 4.0, "one 1x": 1.0, "one 0.5x": 0.5}[kind]
    if one.effect.name in FAINT:
        size = float(rng.uniform(0.5, 1.5)) if kind != "one 0.5x" else 0.5
    return (ruler.sized(one, size),), (size,)


def hide_several(
    rng: np.random.Generator, ruler: Ruler, sizes: Sequence[float] = ()
) -> tuple[tuple[PlacedEffect, ...], tuple[float, ...]]:
    """Hide two or three at once with regressors of their own, of given sizes or one to four times the noise."""
    given = sizes
    while True:
        count = len(given) or (2 if rng.uniform() < 0.7 else 3)
        drawn = [draw_inside(rng, ruler.state) for _ in range(count)]
        sizes = given or [
            float(rng.uniform(0.5, 1.5) if d.effect.name in FAINT else rng.uniform(1.0, 4.0)) for d in drawn
        ]
        placed = [ruler.sized(one, size) for one, size in zip(drawn, sizes, strict=True)]
        rows = []
        for one in placed:
            change = predict_observations(with_effects(ruler.truth, one), ruler.state.data) - ruler.state.predicted
            row = ruler.rest_of(change[None])[0]
            rows.append(row / np.linalg.norm(row))
        overlap = np.abs(np.array(rows) @ np.array(rows).T - np.eye(count)).max()
        apart = len({(one.effect.name, one.place) for one in placed}) == count
        if overlap < 0.7 and apart:
            return tuple(placed), tuple(sizes)


def nearly_the_same(ruler: Ruler, one: PlacedEffect) -> tuple[str, ...]:
    """Return the candidates that make up 95 % of an effect's signature, joint springs absorbing what they can."""
    catalogue = built_in_effects()
    change = predict_observations(with_effects(ruler.truth, one), ruler.state.data) - ruler.state.predicted
    row = ruler.rest_of(change[None])[0]
    found = []
    for name in (*INSIDE, *SENSOR):
        for place in catalogue[name].places(ruler.truth.chain):
            for shape in ruler.state.shapes(catalogue[name], place):
                regressor = ruler.state.regressor(catalogue[name], place, shape)
                if not regressor.symbols:
                    continue
                basis, _ = np.linalg.qr(ruler.rest_of(regressor.columns).T)
                if np.linalg.norm(basis.T @ row) >= 0.95 * np.linalg.norm(row):
                    found.append(f"{name} {place.label}")
                    break
    return tuple(found)
