"""Campaigns in which a run or a row is faulty, drawn as robots and instruments of `tests.rates.playing` are."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.identification.derivatives.observation import observe
from stiffcal.identification.fitting.identify import predict_observations
from stiffcal.measurements.load_states import LoadStates, RunInfo, Sigma
from stiffcal.mechanics.rotations import rotation_from_vector
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.balance.equilibrium import NoBalanceError
from stiffcal.model.catalogue.catalogue import built_in_effects
from stiffcal.model.effect import Place
from stiffcal.reduction.set_aside.outliers import reject_outliers
from tests.laboratory.mujoco_robot import Spring
from tests.laboratory.mujoco_states import NOISE, Plan, simulate_campaign
from tests.laboratory.random_robots import DrawnRobot, draw_robot, draw_setup
from tests.laboratory.robots import SIX_STIFFNESS
from tests.rates.hiding import draw_inside, with_effects
from tests.rates.measuring import Player, move
from tests.rates.playing import Ruler, joint_springs, simulate_runs

FORMS = ("rows", "pairs", "cycles", "mujoco")
"""One row per load, displacement given; an unloaded and two loaded states per pose; whole load cycles; and such cycles
of a robot that MuJoCo plays, with none of our mechanics.
"""
UNITS = ("kgf", "lbf", "N·mm", "m", "rad")
FAULTS = ("mislabelled", "copied angles", "sign", "unit", "exchanged loads", "exchanged places", "bump", "bad row")
POSES, LOADS = 24, 2
MOST_IN_FEW = 0.7


@dataclass(frozen=True)
class Faulty:
    """A campaign with a fault, or without one.

    Attributes
    ----------
    form, fault : of `FORMS` and `FAULTS`; "" without a fault.
    states : as the tool gets them.
    model : joint springs without values.
    runs : numbers of the runs that are faulty.
    kinds : any of these is the right kind.
    deflection : rms of the faulty run's true displacement over its noise.
    change : rms of what the fault does to the run's misfit, over its noise, the parameters known.
    settings : in words.
    """

    form: str
    fault: str
    states: LoadStates
    model: CompliantRobot
    runs: tuple[int, ...]
    kinds: tuple[str, ...]
    deflection: float
    change: float
    settings: str


def draw_faulty(
    rng: np.random.Generator, form: str, fault: str, hidden: str = "", player: Player = "balance"
) -> Faulty:
    """Draw campaigns until one finds its balance.

    Parameters
    ----------
    hidden : "" for joint springs alone, "anywhere" for an effect that the model lacks at four times the noise,
        "few poses" for one that has `MOST_IN_FEW` of its squares in a quarter of the runs.
    player : what moves the robot; the form "mujoco" is always MuJoCo's.
    """
    for _ in range(2000):
        try:
            campaign = _drawn(rng, form, fault, hidden, player)
        except NoBalanceError:
            continue
        return campaign
    raise RuntimeError("no campaign found its balance")


def _drawn(rng: np.random.Generator, form: str, fault: str, hidden: str, player: Player) -> Faulty:
    if form == "mujoco":
        states, truth, noise, words = _by_mujoco(rng, hidden)
        model = CompliantRobot(truth.chain, tuple(PlacedEffect(one.effect, one.place) for one in truth.placed))
    elif form == "cycles":
        played = simulate_runs("one 4x" if hidden else "none", rng, player=player)
        states, truth, noise = played.states, played.truth, played.noise
        words, model = played.settings, played.model
        if hidden == "few poses":
            _refuse_unless_in_few(truth, played.hidden, states, noise)
    else:
        robot = draw_robot(rng)
        truth, noise = joint_springs(robot), (robot.family.translation, robot.family.rotation)
        full_pose, stated = bool(rng.uniform() < 0.5), bool(rng.uniform() < 0.7)
        plan = _table_plan(rng, robot, full_pose, form)
        words = f"{robot.family.name.split()[0]}, {'pose' if full_pose else 'position'}, sigma {stated}"
        if hidden:
            effect = _sized_effect(rng, truth, plan, robot, noise)
            if hidden == "few poses":
                _refuse_unless_in_few(with_effects(truth, effect), (effect,), plan, noise)
            words += f", hidden {effect.effect.name} {effect.place.label}"
            truth = with_effects(truth, effect)
        states = _table_measured(rng, plan, truth, robot, noise, full_pose, player)
        if stated:
            sigma = Sigma(noise[0], noise[1] if full_pose else None, *_wrench_noise(robot))
            states = replace(states, setup=replace(states.setup, sigma=sigma))
        model = CompliantRobot(
            robot.chain, tuple(PlacedEffect(placed.effect, placed.place) for placed in joint_springs(robot).placed)
        )
    if not fault:
        return Faulty(form, fault, states, model, (), (), 0.0, 0.0, words)
    faulty, runs, kinds, what = _with_fault(rng, states, fault)
    deflection, change = size_of_fault(faulty, states, truth, runs, noise)
    return Faulty(form, fault, reject_outliers(faulty), model, runs, kinds, deflection, change, f"{words}; {what}")


def _sized_effect(
    rng: np.random.Generator, truth: CompliantRobot, plan: LoadStates, robot: DrawnRobot, noise: tuple[float, float]
) -> PlacedEffect:
    ruler = Ruler.of(truth, observe(_counted(plan), robot.chain), noise)
    return ruler.sized(draw_inside(rng, ruler.state), 4.0)


def _refuse_unless_in_few(
    truth: CompliantRobot, hidden: tuple[PlacedEffect, ...], states: LoadStates, noise: tuple[float, float]
) -> None:
    """Raise NoBalanceError, as for other draws that do not serve, where the effect shows in more than a few runs."""
    springs = CompliantRobot(truth.chain, tuple(one for one in truth.placed if one not in hidden))
    ruler = Ruler.of(springs, observe(states, truth.chain), noise)
    change = predict_observations(truth, ruler.state.data) - ruler.state.predicted
    squares = np.sum(ruler.rest_of(change[None])[0].reshape(change.shape) ** 2, axis=0)
    per_run = np.sort(np.bincount(ruler.state.data.run, weights=squares))[::-1]
    few = max(len(np.unique(ruler.state.data.run)) // 4, 1)
    if per_run[:few].sum() < MOST_IN_FEW * per_run.sum():
        raise NoBalanceError("the effect shows in many runs")


def _by_mujoco(rng: np.random.Generator, hidden: str) -> tuple[LoadStates, CompliantRobot, tuple[float, float], str]:
    """Return states of a robot that MuJoCo plays, with a tilting bearing where an effect is hidden."""
    poses, full_pose, stated = int(rng.integers(8, 15)), bool(rng.uniform() < 0.6), bool(rng.uniform() < 0.7)
    springs: tuple[Spring, ...] = ()
    words = f"mujoco, {poses} poses, {'pose' if full_pose else 'position'}, sigma {stated}"
    if hidden:
        joint = int(rng.integers(1, 6))
        axis = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))[int(rng.integers(2))]
        stiffness = float(SIX_STIFFNESS[joint - 1] * rng.uniform(1.0, 4.0))
        springs = (Spring(joint, "turn", stiffness, axis=axis),)
        words += f", bearing {joint} tilts"
    plan = Plan(poses=poses, directions=int(rng.integers(2, 4)), full_pose=full_pose, sigma_stated=stated)
    played = simulate_campaign(rng, plan, springs)
    effect = built_in_effects()["joint-compliance"]
    placed = tuple(
        PlacedEffect(effect, Place("joints", (joint,)), {"c": float(compliance)})
        for joint, compliance in enumerate(played.joint_compliance, start=1)
    )
    noise = (float(NOISE.translation or 0.0), float(NOISE.rotation or 0.0))
    return played.states, CompliantRobot(played.chain, placed), noise, words


def _counted(plan: LoadStates) -> LoadStates:
    """Return the plan with displacements of zero where they are given: which components are measured."""
    return plan


def _wrench_noise(robot: DrawnRobot) -> tuple[float, float]:
    force = 1.5e-3 * robot.family.force
    return force, 0.15 * force


def _table_plan(rng: np.random.Generator, robot: DrawnRobot, full_pose: bool, form: str) -> LoadStates:
    """Return the loads of 24 poses with two loads each, as rows of their own or with an unloaded state before them."""
    family = robot.family
    angles = family.draw_joints(rng, POSES)
    point = np.array([0.02, 0.0, rng.uniform(0.1, 0.16)])
    setup = draw_setup(rng, robot.chain, point, force_only=False)
    direction = rng.normal(size=(POSES, LOADS, 3))
    direction /= np.linalg.norm(direction, axis=2, keepdims=True)
    force = direction * family.force * rng.uniform(0.5, 1.0, (POSES, LOADS, 1))
    wrench = np.concatenate([force, np.cross(point, force)], axis=2)
    if form == "rows":
        per_run, run = 1, np.arange(POSES * LOADS)
        pose, wrench = np.repeat(np.arange(POSES), LOADS), wrench.reshape(-1, 6)
    else:
        per_run, run = LOADS + 1, np.repeat(np.arange(POSES), LOADS + 1)
        pose = run
        wrench = np.concatenate([np.zeros((POSES, 1, 6)), wrench], axis=1).reshape(-1, 6)
    n, given = len(run), form == "rows"
    components = np.where(np.arange(6) < (6 if full_pose else 3), 0.0, np.nan)
    return LoadStates(
        runs=tuple(RunInfo(f"run{k + 1:02d}") for k in range(n // per_run)),
        run=run,
        time=np.full(n, np.nan),
        hold=np.full(n, np.nan),
        joints=angles[pose],
        wrench=wrench,
        position=np.full((n, 1, 3), np.nan) if given else np.zeros((n, 1, 3)),
        rotation=np.tile(np.eye(3), (n, 1, 1, 1)) if full_pose and not given else np.full((n, 1, 3, 3), np.nan),
        deflection=np.tile(components, (n, 1, 1)) if given else np.full((n, 1, 6), np.nan),
        reference=np.concatenate([[not given], (np.diff(run) != 0) & (not given)]),
        temperature=np.zeros((n, 0)),
        row=np.arange(1, n + 1),
        n_readings=np.ones(n, dtype=np.int64),
        wrench_scatter=np.full((n, 6), np.nan),
        position_scatter=np.full((n, 1, 3), np.nan),
        set_aside=np.full(n, "", dtype=np.str_),
        setup=setup,
    )


def _table_measured(
    rng: np.random.Generator,
    plan: LoadStates,
    truth: CompliantRobot,
    robot: DrawnRobot,
    noise: tuple[float, float],
    full_pose: bool,
    player: Player,
) -> LoadStates:
    motion = move(player, plan, joint_springs(robot), truth)
    moved = motion.moved if full_pose else motion.moved[:, :3]
    n = len(plan)
    force, moment = _wrench_noise(robot)
    wrench = plan.wrench + np.repeat([force, moment], 3) * rng.normal(size=(n, 6)) * (plan.wrench != 0.0).any(
        axis=1, keepdims=True
    )
    off = np.repeat([noise[0], noise[1]], 3) * rng.normal(size=(n, 6))
    if plan.deflection_given:
        deflection = plan.deflection.copy()
        deflection[:, 0, : moved.shape[1]] = moved + off[:, : moved.shape[1]]
        return replace(plan, wrench=wrench, deflection=deflection)
    wander = rng.normal(size=(len(plan.runs), 3)) * 3e-4
    position = motion.position + wander[plan.run] + moved[:, :3] + off[:, :3]
    rotation = plan.rotation
    if full_pose:
        turned = rotation_from_vector(off[:, 3:]) @ rotation_from_vector(moved[:, 3:]) @ motion.rotation
        rotation = turned[:, None]
    return replace(plan, wrench=wrench, position=position[:, None], rotation=rotation)


def _with_fault(
    rng: np.random.Generator, states: LoadStates, fault: str
) -> tuple[LoadStates, tuple[int, ...], tuple[str, ...], str]:
    """Return the states with a fault in one run, or in two that are exchanged; its runs, right kinds, and words."""
    members = states.members()
    run = int(rng.integers(len(members)))
    own = members[run]
    unlike = [
        k for k, there in enumerate(members)
        if len(there) == len(own) and not np.allclose(states.joints[there[0]], states.joints[own[0]])
    ]  # fmt: skip
    other = int(rng.choice(unlike))
    there = members[other]
    if fault == "mislabelled":
        return exchanged(states, own, there, ("joints",)), (run, other), ("mislabelled",), f"angles {run} {other}"
    if fault == "copied angles":
        joints = states.joints.copy()
        joints[own] = joints[there]
        return replace(states, joints=joints), (run,), ("mislabelled",), f"angles {run} are those of {other}"
    if fault == "exchanged loads":
        return exchanged(states, own, there, ("wrench",)), (run, other), ("exchanged",), f"loads {run} {other}"
    if fault == "exchanged places":
        names = ("position", "rotation", "deflection")
        # Angles and loads of the one with places of the other: where the loads are alike, that is angles mixed up.
        right = ("exchanged", "mislabelled")
        return exchanged(states, own, there, names), (run, other), right, f"places {run} {other}"
    if fault == "sign":
        return _wrong_sign(rng, states, run, own)
    if fault == "unit":
        return _wrong_unit(rng, states, run, own)
    size = float(rng.uniform(6.0, 40.0)) * 18e-6
    direction = rng.normal(size=3)
    step = size * direction / np.linalg.norm(direction)
    first = own[0] if states.deflection_given else own[int(rng.integers(1, len(own)))]
    picked = own[own >= first] if fault == "bump" and not states.deflection_given else np.array([first])
    return moved_by(states, picked, step), (run,), ("bump", "unknown"), f"{fault} of {1e3 * size:.2f} mm in {run}"


def exchanged(states: LoadStates, own: Integers, there: Integers, names: tuple[str, ...]) -> LoadStates:
    """Return the states with fields (of `LoadStates`) of as many states here and there exchanged."""
    changed = {}
    for name in names:
        values = getattr(states, name).copy()
        values[own], values[there] = getattr(states, name)[there], getattr(states, name)[own]
        changed[name] = values
    return replace(states, **changed)


def moved_by(states: LoadStates, picked: Integers, step: Floats) -> LoadStates:
    """Return the states with the target of some moved by a step (3,), m, base axes."""
    if states.deflection_given:
        deflection = states.deflection.copy()
        deflection[picked, 0, :3] += step
        return replace(states, deflection=deflection)
    position = states.position.copy()
    position[picked, 0] += step
    return replace(states, position=position)


def _wrong_sign(
    rng: np.random.Generator, states: LoadStates, run: int, own: Integers
) -> tuple[LoadStates, tuple[int, ...], tuple[str, ...], str]:
    what = int(rng.integers(3 if states.deflection_given else 2))
    if what == 0:
        wrench, component = states.wrench.copy(), int(rng.integers(3))
        wrench[own, component] *= -1.0
        return replace(states, wrench=wrench), (run,), ("sign",), f"F{'xyz'[component]} of {run}"
    if what == 1:
        wrench = states.wrench.copy()
        wrench[own] *= -1.0
        return replace(states, wrench=wrench), (run,), ("sign",), f"load of {run}"
    deflection, component = states.deflection.copy(), int(rng.integers(3))
    deflection[own, :, component] *= -1.0
    return replace(states, deflection=deflection), (run,), ("sign",), f"d{'xyz'[component]} of {run}"


def _wrong_unit(
    rng: np.random.Generator, states: LoadStates, run: int, own: Integers
) -> tuple[LoadStates, tuple[int, ...], tuple[str, ...], str]:
    unit = str(rng.choice(UNITS if states.deflection_given else UNITS[:3]))
    if unit == "m":
        deflection = states.deflection.copy()
        deflection[own, :, :3] *= 1e-3
        return replace(states, deflection=deflection), (run,), ("unit",), f"displacement of {run} in m"
    if unit == "rad":
        joints = states.joints.copy()
        joints[own] *= np.pi / 180.0
        return replace(states, joints=joints), (run,), ("unit",), f"angles of {run} in rad"
    wrench = states.wrench.copy()
    if unit == "N·mm":
        wrench[own, 3:] *= 1e3
    else:
        wrench[own, :3] /= 9.80665 if unit == "kgf" else 4.4482216152605
    return replace(states, wrench=wrench), (run,), ("unit",), f"{unit} in {run}"


def size_of_fault(
    faulty: LoadStates, right: LoadStates, truth: CompliantRobot, runs: tuple[int, ...], noise: tuple[float, float]
) -> tuple[float, float]:
    """Return rms of the faulty run's true displacement and of what the fault adds to its misfit, over the noise."""
    own: Booleans = np.isin(right.run, runs[:1])
    try:
        misfits = []
        for states in (right, faulty):
            data = observe(states.select(own), truth.chain)
            kinds = np.array([noise[0], noise[1], 1.0, 1.0, 1.0])[data.kind][:, None]
            misfits.append((data, kinds, data.measured - predict_observations(truth, data)))
    except NoBalanceError:
        return np.inf, np.inf
    data, kinds, _ = misfits[0]
    change = (misfits[1][2] - misfits[0][2]) / kinds
    if data.free_offset:
        change = change - change.mean(axis=1, keepdims=True)
    return float(np.sqrt(np.mean((data.measured / kinds) ** 2))), float(np.sqrt(np.mean(change**2)))
