"""An outside robot: MuJoCo finds where the loaded chain settles, with none of stiffcal's mechanics.

Only the geometry and masses of a `Chain` and the frames of a `MeasurementSetup` are taken over, as data, into an MJCF
model: a hinge with a spring for every joint (its rest angle is the commanded one) and, where wanted, more springs at
any body. Static balance is not waited for by stepping time; the generalised forces that MuJoCo computes are brought to
zero:

    spring forces (``mj_passive``) + the load (``mj_applyFT``) - weight (``mj_rne`` at rest) = 0

Why a quasi-Newton iteration: the springs are far stiffer than anything that geometry adds, so the spring stiffness is a
nearly exact first Jacobian; Broyden's rank-one corrections make up for the rest within four to eight evaluations.

Conventions: wrench (force, moment) is what the surroundings do to the robot, in axes that turn with their body; several
springs on one body act one after another (turn about the joint, then the others in the given order), which differs from
one rotation vector for all of them by products of two deflections.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import mujoco
import numpy as np

from stiffcal.arrays import Floats
from stiffcal.measurements.load_states import Attachment, MeasurementSetup
from stiffcal.mechanics.chain import Chain

MASSLESS = 1e-12
"""kg and kg·m²: MuJoCo refuses moving bodies without inertia; this weighs 1e-11 N."""

MOST_FREEDOMS = 6
"""MuJoCo's, of one body."""

SETTLED = 1e-14
"""rad or m: the last step's size at which a state counts as settled."""


@dataclass(frozen=True)
class Spring:
    """One more spring on the way to a body.

    Attributes
    ----------
    body : 0 between ground and base, k = 1 … J after joint k's turn, J + 1 at the flange.
    kind : "turn" about ``axis``, "slide" along it, or "ball": alike about all axes, one rotation vector.
    stiffness : N·m/rad or N/m.
    axis : (3,) in the body's frame.
    origin : (3,) m, a point on the axis, or the ball's centre, in the body's frame.
    cubic : N·m/rad³, added to the spring's torque; hinges only.
    friction : N·m of dry friction next to the spring. reach : rad or m, stops on either side. time : s, of a damper
        next to it (stiffness × time is its damping). These three need a path (`tests.laboratory.mujoco_path`).
    """

    body: int
    kind: Literal["turn", "slide", "ball"]
    stiffness: float
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    cubic: float = 0.0
    friction: float = 0.0
    reach: float = 0.0
    time: float = 0.0

    @property
    def needs_path(self) -> bool:
        """Whether where it rests depends on how it came there, or on a stop."""
        return bool(self.friction or self.reach or self.time)


@dataclass(frozen=True)
class Cable:
    """A spring between two joints, or through space.

    Attributes
    ----------
    stiffness : N·m/rad, or N/m.
    joints : joint number to lever: the spring's length is the sum of lever times angle; slack as commanded.
    ends : body and point (m, in its frame) of either end of a spring through space, in place of ``joints``.
    slack : m, length of a spring through space up to which it does not pull.
    strut : pushes where it is shorter than that.
    """

    stiffness: float
    joints: Mapping[int, float] = field(default_factory=dict)
    ends: tuple[tuple[int, tuple[float, float, float]], ...] = ()
    slack: float = 0.0
    strut: bool = False


@dataclass(frozen=True)
class Settled:
    """Where the loaded robot stands.

    Attributes
    ----------
    position : (n, B, 3) m, base axes, of the setup's targets.
    rotation : (n, B, 3, 3) base_from_target.
    sensor_rotation : (n, 3, 3) base_from_wrench_axes.
    point : (n, 3) m, base axes, of the point that the moments refer to.
    turned : (n, J) rad, joint angle minus commanded angle.
    evaluations : (n,) force evaluations that were needed.
    """

    position: Floats
    rotation: Floats
    sensor_rotation: Floats
    point: Floats
    turned: Floats
    evaluations: Floats


class MujocoRobot:
    """A robot with springs in its joints, solved by MuJoCo.

    Parameters
    ----------
    chain : geometry, masses, gravity; taken over as data.
    joint_stiffness : (J,) N·m/rad, of the drives: about the joint, or about the logged axis where the coupling is
        mechanical (a fixed tendon over the joints it is made of).
    setup : where the load acts and which frames are looked at; tool mass on the flange.
    springs : further springs on the way; cables : between joints, or through space.
    weights : False leaves all weights out.
    """

    def __init__(
        self,
        chain: Chain,
        joint_stiffness: Floats,
        setup: MeasurementSetup,
        springs: Sequence[Spring] = (),
        weights: bool = True,
        cables: Sequence[Cable] = (),
    ) -> None:
        self.n_joints = chain.n_joints
        self.springs = tuple(springs)
        self.mjcf = _mjcf(chain, np.asarray(joint_stiffness, dtype=np.float64), setup, springs, weights, cables)
        self.model: Any = mujoco.MjModel.from_xml_string(self.mjcf)
        self.data: Any = mujoco.MjData(self.model)
        hinges = [self.model.joint(f"joint{k}") for k in range(1, self.n_joints + 1)]
        self._angles = np.array([int(hinge.qposadr[0]) for hinge in hinges])
        self._rest = np.array(self.model.qpos_spring)
        self._coupled = np.linalg.inv(chain.coupling)[chain.mechanical]
        self._levers = [cable.joints for cable in cables]
        self._softness = np.linalg.inv(self._stiffness_of_springs(hinges))
        self._axes = int(self.model.site("wrench_axes").id)
        self._point = int(self.model.site("wrench_point").id)
        self._targets = [int(self.model.site(f"target{b}").id) for b in range(len(setup.targets))]

    def settle(self, joints: Floats, wrench: Floats) -> Settled:
        """Find the balance of every state.

        Parameters
        ----------
        joints : (n, J) commanded model angles, rad.
        wrench : (n, 6) N, N·m on the robot, in the setup's axes about its point.

        Raises
        ------
        ArithmeticError : a state does not come to rest (a buckling load).
        """
        if any(spring.needs_path for spring in self.springs):
            raise ValueError("friction, stops and dampers rest where their path takes them: walk it (mujoco_path)")
        n = joints.shape[0]
        out = self.blank(n)
        for i in range(n):
            self.note(out, i, joints[i], self._settle_one(joints[i], wrench[i]))
        return out

    def blank(self, n: int) -> Settled:
        """Return room for n states."""
        b = len(self._targets)
        return Settled(
            position=np.empty((n, b, 3)),
            rotation=np.empty((n, b, 3, 3)),
            sensor_rotation=np.empty((n, 3, 3)),
            point=np.empty((n, 3)),
            turned=np.empty((n, self.n_joints)),
            evaluations=np.empty(n),
        )

    def note(self, out: Settled, i: int, angles: Floats, evaluations: int) -> None:
        """Write down where the robot stands at present as state i."""
        out.evaluations[i] = evaluations
        out.position[i] = self.data.site_xpos[self._targets]
        out.rotation[i] = self.data.site_xmat[self._targets].reshape(-1, 3, 3)
        out.sensor_rotation[i] = self.data.site_xmat[self._axes].reshape(3, 3)
        out.point[i] = self.data.site_xpos[self._point]
        out.turned[i] = self.data.qpos[self._angles] - angles

    def command(self, angles: Floats) -> None:
        """Set every joint to its commanded angle, no spring tense."""
        self._rest[self._angles] = angles
        self.model.qpos_spring[:] = self._rest
        drives = len(self._coupled)
        self.model.tendon_lengthspring[:drives] = (self._coupled @ angles)[:, None]
        for number, levers in enumerate(self._levers, start=drives):
            if levers:
                self.model.tendon_lengthspring[number] = sum(lever * angles[k - 1] for k, lever in levers.items())
        self.data.qpos[:] = self._rest

    def force_of(self, wrench: Floats) -> Floats:
        """Return the generalised force (nv,) of a load at the present place; kinematics are up to date."""
        model, data = self.model, self.data
        load = np.zeros(model.nv)
        axes = data.site_xmat[self._axes].reshape(3, 3)
        body = int(model.site_bodyid[self._point])
        mujoco.mj_applyFT(model, data, axes @ wrench[:3], axes @ wrench[3:], data.site_xpos[self._point], body, load)
        return load

    def _settle_one(self, angles: Floats, wrench: Floats) -> int:
        """Bring one state to rest, leaving it in ``self.data``; return the number of force evaluations."""
        model, data = self.model, self.data
        self.command(angles)
        inverse = self._softness.copy()
        force = self._unbalanced(wrench)
        for evaluation in range(2, 60):
            step = inverse @ force
            mujoco.mj_integratePos(model, data.qpos, step, 1.0)
            after = self._unbalanced(wrench)
            if np.abs(step).max() < SETTLED:
                return evaluation
            # Broyden's "good" update of the inverse Jacobian; the force falls by `force - after` along `step`.
            moved = inverse @ (force - after)
            inverse += np.outer(step - moved, step @ inverse) / (step @ moved)
            force = after
        raise ArithmeticError(f"no balance found at joint angles {angles} under {wrench}")

    def _unbalanced(self, wrench: Floats) -> Floats:
        """Generalised force (nv,) left over at the present place."""
        model, data = self.model, self.data
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_tendon(model, data)
        weight = np.zeros(model.nv)
        mujoco.mj_rne(model, data, 0, weight)
        mujoco.mj_passive(model, data)
        return np.asarray(data.qfrc_passive + self.force_of(wrench) - weight, dtype=np.float64)

    def stiffness_of_springs(self) -> Floats:
        """Return the stiffness (nv,) of the spring of every degree of freedom, cables and drives over joints apart."""
        out = np.zeros(self.model.nv)
        for joint in range(self.model.njnt):
            first = int(self.model.jnt_dofadr[joint])
            count = 3 if self.model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_BALL else 1
            out[first : first + count] = self.model.jnt_stiffness[joint]
        return out

    def _stiffness_of_springs(self, hinges: Sequence[Any]) -> Floats:
        """Stiffness (nv, nv) of the springs alone: three equal ones for a ball, sums over joints for a tendon."""
        stiffness = np.diag(self.stiffness_of_springs())
        for tendon, row in enumerate(self._coupled):
            over = np.zeros(self.model.nv)
            over[[int(hinge.dofadr[0]) for hinge in hinges]] = row
            stiffness += float(self.model.tendon_stiffness[tendon]) * np.outer(over, over)
        return stiffness


def _mjcf(
    chain: Chain,
    stiffness: Floats,
    setup: MeasurementSetup,
    springs: Sequence[Spring],
    weights: bool,
    cables: Sequence[Cable],
) -> str:
    """Write the robot as MJCF: nested bodies ground › base › links › flange, sites for the frames."""
    sites = _sites(setup, cables)
    n = chain.n_joints
    tool = _inertia(setup.tool_mass, setup.tool_com)
    inner = _body("flange", chain.flange, _extra(springs, n + 1), tool, sites, n + 1)
    for k in range(n, 0, -1):
        own = 0.0 if chain.mechanical[k - 1] else float(stiffness[k - 1])
        hinge = f'<joint name="joint{k}" type="hinge" axis="0 0 1" stiffness="{own!r}"/>'
        mass = _inertia(float(chain.link_mass[k - 1]), chain.link_com[k - 1])
        inner = _body(f"link{k}", chain.fixed[k - 1], [hinge, *_extra(springs, k)], mass, sites, k, inner)
    base = _body("base", np.eye(4), _extra(springs, 0), _inertia(0.0, np.zeros(3)), {}, 0, inner)
    gravity = _numbers(chain.gravity if weights else np.zeros(3))
    return (
        # Armature (rotor inertia) changes nothing at rest; it keeps MuJoCo's inertia matrix regular where two springs
        # share an axis, which it would otherwise warn of.
        f'<mujoco><compiler angle="radian"/><option gravity="{gravity}"/><default><joint armature="1"/></default>'
        f"<worldbody>{sites.get(0, '')}{base}</worldbody>"
        f"<tendon>{_tendons(chain, stiffness)}{_cables(cables)}</tendon></mujoco>"
    )


def _tendons(chain: Chain, stiffness: Floats) -> str:
    """Write the drives that sit on logged axes: logged angle = inverse of the coupling times the joints' angles."""
    text = ""
    for k in np.flatnonzero(chain.mechanical):
        row = np.linalg.inv(chain.coupling)[k]
        parts = [f'<joint joint="joint{j + 1}" coef="{float(row[j])!r}"/>' for j in np.flatnonzero(row)]
        text += f'<fixed name="drive{k + 1}" stiffness="{float(stiffness[k])!r}">{"".join(parts)}</fixed>'
    return text


def _cables(cables: Sequence[Cable]) -> str:
    """Write further springs between joints and through space."""
    text = ""
    for number, cable in enumerate(cables):
        named = f'name="cable{number}" stiffness="{float(cable.stiffness)!r}"'
        if cable.ends:
            ends = "".join(f'<site site="cable{number}_{end}"/>' for end in range(len(cable.ends)))
            length = (cable.slack if cable.strut else 0.0, cable.slack)
            text += f'<spatial {named} springlength="{_numbers(length)}">{ends}</spatial>'
        else:
            parts = [f'<joint joint="joint{k}" coef="{float(lever)!r}"/>' for k, lever in cable.joints.items()]
            text += f"<fixed {named}>{''.join(parts)}</fixed>"
    return text


def _body(
    name: str, placed: Floats, joints: Sequence[str], inertia: str, sites: dict[int, str], number: int, inner: str = ""
) -> str:
    """Write one body with what hangs on it, or several one in the other where six freedoms are not enough."""
    count = 0
    while count < len(joints) and _freedoms(joints[: count + 1]) <= MOST_FREEDOMS:
        count += 1
    own, more = "".join(joints[:count]), joints[count:]
    if more:
        nested = _body(f"{name}_", np.eye(4), more, inertia, sites, number, inner)
        return f'<body name="{name}" {_place(placed)}>{own}{_inertia(0.0, np.zeros(3))}{nested}</body>'
    return f'<body name="{name}" {_place(placed)}>{own}{inertia}{sites.get(number, "")}{inner}</body>'


def _freedoms(joints: Sequence[str]) -> int:
    return sum(3 if 'type="ball"' in joint else 1 for joint in joints)


def _sites(setup: MeasurementSetup, cables: Sequence[Cable]) -> dict[int, str]:
    """Write the setup's frames and the cables' ends as sites, by the body they ride on; body 0 is the ground."""
    named: list[tuple[str, Attachment]] = [("wrench_axes", setup.wrench_axes), ("wrench_point", setup.wrench_point)]
    named += [(f"target{b}", target) for b, target in enumerate(setup.targets)]
    sites: dict[int, str] = {}
    for name, frame in named:
        sites[frame.body] = sites.get(frame.body, "") + f'<site name="{name}" {_place(frame.transform)}/>'
    for number, cable in enumerate(cables):
        for end, (body, point) in enumerate(cable.ends):
            site = f'<site name="cable{number}_{end}" pos="{_numbers(point)}"/>'
            sites[body] = sites.get(body, "") + site
    return sites


def _extra(springs: Sequence[Spring], body: int) -> list[str]:
    """Write the further springs of one body."""
    return [_spring(spring) for spring in springs if spring.body == body]


def _spring(spring: Spring) -> str:
    """Write one spring, what acts next to it included."""
    kind = {"turn": "hinge", "slide": "slide", "ball": "ball"}[spring.kind]
    text = f'<joint type="{kind}" pos="{_numbers(spring.origin)}" stiffness="{float(spring.stiffness)!r}'
    text += f' 0 {float(spring.cubic)!r}"' if spring.cubic else '"'
    if spring.kind != "ball":
        text += f' axis="{_numbers(spring.axis)}"'
    if spring.friction:
        text += f' frictionloss="{float(spring.friction)!r}"'
    if spring.reach:
        text += f' limited="true" range="{_numbers((-spring.reach, spring.reach))}"'
    if spring.time:
        text += f' damping="{float(spring.stiffness * spring.time)!r}"'
    return text + "/>"


def _inertia(mass: float, com: Floats) -> str:
    """Write a point-like mass; at rest only mass and centre matter."""
    inertia = max(mass, MASSLESS)
    return f'<inertial pos="{_numbers(com)}" mass="{inertia!r}" diaginertia="{_numbers([inertia] * 3)}"/>'


def _place(transform: Floats) -> str:
    """Write a rigid transform as position and quaternion."""
    quaternion = np.empty(4)
    mujoco.mju_mat2Quat(quaternion, np.ascontiguousarray(transform[:3, :3]).ravel())
    return f'pos="{_numbers(transform[:3, 3])}" quat="{_numbers(quaternion)}"'


def _numbers(values: Floats | Sequence[float]) -> str:
    """Write numbers so that they are read back unchanged."""
    return " ".join(repr(float(value)) for value in values)
