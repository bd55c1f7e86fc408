"""Hidden campaigns played by MuJoCo: none of the product's mechanics or laws stands between the truth and the tracker.

What gives way in MuJoCo: springs at any body for whatever is linear at one body (bearings, base, tool, links), a strut
for a balancing spring, drives with laws of their own (`tests.laboratory.mujoco_laws`). A cantilever is exactly a hinge
at half its length and a slide there: under a force F and a moment M at its end, the hinge of stiffness EI/L turns by
(M + F L/2) L/EI, the slide of 12 EI/L³ gives the rest of F L³/(3 EI).

Errors of the instruments are no mechanics: turned frames, a target or a load point that is elsewhere, a drift, a slip
are those of the effects themselves.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.rotations import rotation_from_vector, vector_from_rotation
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.balance.equilibrium import NoBalanceError
from stiffcal.model.effect import Inputs, Observed, StateOrder
from tests.laboratory.mujoco_laws import CreepLaw, DriveLaw, MujocoDrives, PlayLaw, TorqueLaw
from tests.laboratory.mujoco_robot import Cable, Spring
from tests.rates.hiding import shift_of_places
from tests.rates.measuring import Motion

Vector = tuple[float, float, float]
AXES: Mapping[str, Vector] = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
Law = Callable[[Mapping[str, float], Floats, Floats, int, int], float]


def move_by_mujoco(plan: LoadStates, whole: CompliantRobot) -> Motion:
    """Return how MuJoCo's robot moves under the loads of a plan, as the tracker reads it but for noise.

    Parameters
    ----------
    whole : the robot with all that is hidden.

    Raises
    ------
    NoBalanceError : a state does not come to rest.
    ValueError : the robot has an effect that is not among `SPRINGS`, `MEMORY`, `LAWS` and `INSTRUMENTS`.
    """
    chain = whole.chain
    angles = chain.model_angles(plan.joints)
    inputs = Inputs(np.ascontiguousarray(angles.T), np.ascontiguousarray(plan.wrench.T), plan.setup)
    for one in whole.placed:
        inputs = one.adjusted(inputs)
    springs = [spring for one in whole.placed for spring in springs_of(chain, one)]
    cables = [_strut(chain, one) for one in whole.placed if one.effect.name == "gravity-compensator"]
    laws = [law for one in whole.placed for law in laws_of(chain, one)]
    drives = np.full(chain.n_joints, np.nan)
    for one in whole.placed:
        if one.effect.name == "joint-compliance":
            drives[one.place.joints[0] - 1] = 1.0 / one.values["c"]
        elif not can_be_played(one):
            raise ValueError(f"{one.effect.name} is not modelled in MuJoCo")
    row, first, loads, runs = _with_references(plan, inputs.wrench.T)
    try:
        robot = MujocoDrives(chain, drives, inputs.setup, springs, cables, laws)
        settled = robot.lead(angles[row], loads, runs, plan.time[row])
    except ArithmeticError as error:
        raise NoBalanceError(str(error)) from None
    position, rotation = settled.position[:, 0], settled.rotation[:, 0]
    still, unturned = position[first], rotation[first]
    if plan.deflection_given:
        position, rotation = position[1::2], rotation[1::2]
    turn = np.stack([vector_from_rotation(one) for one in rotation @ np.swapaxes(unturned, 1, 2)])
    moved = _as_read(whole.placed, plan, np.concatenate([position - still, turn], axis=1))
    # A target that is elsewhere is so in MuJoCo: its place needs no shift.
    frames = [one for one in whole.placed if one.effect.name == "tracker-frame"]
    still = still + shift_of_places(frames, still, np.tile(np.eye(3), (len(plan), 1, 1)))
    return Motion(still, unturned, moved)


def _with_references(plan: LoadStates, wrench: Floats) -> tuple[Integers, Integers, Floats, Integers]:
    """Return plan rows, index of each state's unloaded state, loads and runs of what MuJoCo goes through.

    Each run begins unloaded; where displacements are given, an unloaded state goes before every row.
    """
    n = len(plan)
    if not plan.deflection_given:
        return np.arange(n), np.searchsorted(plan.run, plan.run), wrench, plan.run
    row = np.repeat(np.arange(n), 2)
    loads = np.where(np.arange(2 * n)[:, None] % 2 == 0, 0.0, wrench[row])
    return row, np.arange(0, 2 * n, 2), loads, row


def _as_read(placed: Sequence[PlacedEffect], plan: LoadStates, moved: Floats) -> Floats:
    """Return (n, 6) displacements with what slips, drifts and turned frames add."""
    n = len(plan)
    unknown = np.full(n, np.nan)
    since = plan.time - plan.time[np.searchsorted(plan.run, plan.run)]
    order = StateOrder(
        plan.run, plan.time, plan.hold, np.zeros((plan.joints.shape[1], n)), unknown, since, np.arange(1, n + 1)
    )
    for one in placed:
        observed = Observed(np.ascontiguousarray(moved.T)[None], order)
        shift = one.observation_shift(observed)
        if shift is not None:
            moved = moved + shift[0].T
    return moved


def springs_of(chain: Chain, one: PlacedEffect) -> list[Spring]:
    """Return the springs by which an effect gives way; none where it acts otherwise."""
    name, values = one.effect.name, one.values
    if name == "bearing-tilt":
        joint = one.place.joints[0]
        height = (0.0, 0.0, float(chain.bearing[joint - 1]))
        return [Spring(joint, "turn", 1.0 / c, AXES[s], height) for s, c in values.items() if c]
    if name == "joint-translation":
        return [Spring(one.place.joints[0], "slide", 1.0 / c, AXES[s[1]]) for s, c in values.items() if c]
    if name in ("base-compliance", "tool-compliance"):
        body = 0 if name == "base-compliance" else chain.n_joints + 1
        kinds: Mapping[str, str] = {"r": "turn", "t": "slide"}
        return [
            Spring(body, "turn" if kinds[s[0]] == "turn" else "slide", 1.0 / c, AXES[s[1]])
            for s, c in values.items()
            if c
        ]
    if name == "link-beam":
        return _cantilever(chain, one.place.link, values)
    if name == "link-springs":
        beam, (axes, middle) = chain.beams[one.place.link], _half_way(chain, one.place.link)
        return [Spring(beam.joint, "turn", values[f"k{k + 1}"], axes[k], middle) for k in range(3)]
    return []


def _half_way(chain: Chain, link: str) -> tuple[tuple[Vector, Vector, Vector], Vector]:
    """Return a link's axes x1, x2, x3 and the point half-way along it, in its joint's frame."""
    beam = chain.beams[link]
    x1, x2, x3 = (_vector(beam.end[:3, k]) for k in range(3))
    return (x1, x2, x3), _vector(beam.end[:3, 3] - 0.5 * beam.length * beam.end[:3, 0])


def _vector(values: Floats) -> Vector:
    return float(values[0]), float(values[1]), float(values[2])


def _cantilever(chain: Chain, link: str, values: Mapping[str, float]) -> list[Spring]:
    beam, (axes, middle) = chain.beams[link], _half_way(chain, link)
    joint, length = beam.joint, beam.length
    return [
        Spring(joint, "slide", values["EA"] / length, axes[0]),
        Spring(joint, "slide", 12.0 * values["EI3"] / length**3, axes[1]),
        Spring(joint, "slide", 12.0 * values["EI2"] / length**3, axes[2]),
        Spring(joint, "turn", values["GJ"] / length, axes[0], middle),
        Spring(joint, "turn", values["EI2"] / length, axes[1], middle),
        Spring(joint, "turn", values["EI3"] / length, axes[2], middle),
    ]


def _strut(chain: Chain, one: PlacedEffect) -> Cable:
    """Return the balancing spring between its two ends, without load at joint angle zero as its rate is not stated."""
    joint, given = one.place.joints[0], chain.compensator or {}
    anchor, arm = (np.asarray(given[key], dtype=np.float64) for key in ("anchor_m", "arm_m"))
    fixed = chain.fixed[joint - 1]
    turned = rotation_from_vector(np.array([0.0, 0.0, float(chain.offset[joint - 1])])) @ arm
    at_zero = float(np.linalg.norm(fixed[:3, :3] @ turned + fixed[:3, 3] - anchor))
    ends = ((joint - 1, _vector(anchor)), (joint, _vector(arm)))
    return Cable(one.values["rate"], ends=ends, slack=at_zero, strut=True)


# The torque is that of joint a, or of the pair a, b; what turns is a joint, and of a pair b.
LAWS: Mapping[str, Law] = {
    "cubic-stiffness": lambda v, t, q, a, b: v.get("c2", 0.0) * t[a] ** 2 + v.get("c3", 0.0) * t[a] ** 3,
    "two-slope": lambda v, t, q, a, b: v["c"] * float(np.clip(t[a], -v["knee"], v["knee"])),
    "asymmetric-stiffness": lambda v, t, q, a, b: v["c"] * max(float(t[a]), 0.0),
    "backlash": lambda v, t, q, a, b: 0.5 * v["width"] * float(np.tanh(t[a] / v["band"])),
    "periodic-stiffness": lambda v, t, q, a, b: (
        (v.get("a", 0.0) * np.cos(v["order"] * q[a]) + v.get("b", 0.0) * np.sin(v["order"] * q[a])) * t[a]
    ),
    "cross-stiffness": lambda v, t, q, a, b: v["c"] * np.sin(v["order"] * q[a] + v["phase"]) * t[b],
    "torque-product": lambda v, t, q, a, b: v["c"] * abs(t[a]) * t[b],
    "quadratic-cross": lambda v, t, q, a, b: v["c"] * t[a] ** 2,
    "hertz-contact": lambda v, t, q, a, b: v["c"] * float(np.sign(t[a]) * abs(t[a]) ** (2.0 / 3.0)),
    "cable-bent": lambda v, t, q, a, b: -v["c"] * max(float(q[a]) - v["angle"], 0.0) * t[a],
    "loose-beyond": lambda v, t, q, a, b: v["c"] * t[b] * (q[a] > v["angle"]),
}


def laws_of(chain: Chain, one: PlacedEffect) -> list[DriveLaw]:
    """Return the laws that an effect puts on drives; none where it acts otherwise."""
    name, values, numbers = one.effect.name, one.values, [joint - 1 for joint in one.place.joints]
    if name == "friction-hysteresis":
        return [PlayLaw(numbers[0] + 1, values["c"], values["slip"])]
    if name == "creep":
        return [CreepLaw(numbers[0] + 1, values["c"], values["time"])]
    if name == "axis-coupling":
        return [_coupled(values["c"], *numbers)]
    if name not in LAWS:
        return []
    law = LAWS[name]
    # Waves of a joint's own are counted from the zero of its logged angle.
    zero = chain.offset if name == "periodic-stiffness" else np.zeros(chain.n_joints)
    a, b = numbers[0], numbers[-1]

    def turn(torque: Floats, angles: Floats) -> Floats:
        result = np.zeros_like(torque)
        result[b] = law(values, torque, angles - zero, a, b)
        return result

    return [TorqueLaw(turn)]


def _coupled(compliance: float, a: int, b: int) -> DriveLaw:
    def turn(torque: Floats, angles: Floats) -> Floats:
        result = np.zeros_like(torque)
        result[a], result[b] = compliance * torque[b], compliance * torque[a]
        return result

    return TorqueLaw(turn)


SPRINGS = ("bearing-tilt", "joint-translation", "base-compliance", "tool-compliance", "link-beam", "link-springs")
MEMORY = ("friction-hysteresis", "creep", "axis-coupling", "gravity-compensator")
INSTRUMENTS = (
    "thermal-drift", "tracker-frame", "wrench-frame", "target-offset", "load-point-offset", "wrench-scale",
    "wrench-origin", "seat-shift", "wander", "servo-deflection",
)  # fmt: skip


def can_be_played(one: PlacedEffect) -> bool:
    """Return whether MuJoCo's robot can have an effect."""
    return _is_played(one) or _is_of_instruments(one) or one.effect.name == "joint-compliance"


def _is_played(one: PlacedEffect) -> bool:
    return one.effect.name in (*SPRINGS, *MEMORY, *LAWS)


def _is_of_instruments(one: PlacedEffect) -> bool:
    return one.effect.name in INSTRUMENTS
