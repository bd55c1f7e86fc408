"""A chain of joint axes as rows of Denavit-Hartenberg's convention, with Hayati's β where two axes are nearly parallel.

Between the axes of joints k and k+1 stand four numbers. Axes that are not parallel have a common normal: its length a,
the twist α, and on the axis of joint k the angle θ and the distance d at which it begins (Denavit and Hartenberg 1955).
Of nearly parallel axes the common normal runs away: with axes 0.01° off it begins kilometres from the robot. There d
keeps its value, x points to where the next axis crosses the plane that d sets, and a turn β about y takes the place
of d (Hayati 1983; Hayati and Mirmirani 1985):

    "dh"            joint k:    Rz(θ_k + q_k) · Tz(d_k) · Tx(a_k) · Rx(α_k) · Ry(β_k)
    "modified-dh"   joint k+1:  Rx(α) · Tx(a) · Ry(β) · Tz(d) · Rz(θ + q), all of its row (Craig, eq. 3.6)

Both have the same numbers, in other rows.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Booleans, Floats
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.conventions import Convention
from stiffcal.mechanics.rotations import inverse_transform, rotation_from_vector, transform

NEARLY_PARALLEL = float(np.sin(np.radians(5.0)))
"""Sine of the angle below which two axes have a row with β."""


@dataclass(frozen=True)
class JointRows:
    """Rows of J joints; lengths in m, angles in rad."""

    convention: Convention
    """Of the rows."""
    a: Floats
    """(J,)."""
    alpha: Floats
    """(J,)."""
    beta: Floats
    """(J,) zero where the axes are not nearly parallel."""
    d: Floats
    """(J,)."""
    theta: Floats
    """(J,) added to the model angle."""
    base: Floats
    """(4, 4) base_from_rows: before the first row."""
    flange: Floats
    """(4, 4) after the last row, to the flange."""

    @property
    def between(self) -> slice:
        """The rows whose a, α and β lie between two joints' axes, J − 1 of them."""
        return slice(0, -1) if self.convention == "dh" else slice(1, None)

    def fixed(self) -> tuple[Floats, Floats]:
        """Return (J, 4, 4) joint to joint at a model angle of θ, and (4, 4) last joint to flange, as in a `Chain`."""
        crossings = [_crossing(*row) for row in zip(self.a, self.alpha, self.beta, strict=True)]
        lifts = [_along_z(0.0, d) for d in self.d]
        if self.convention == "modified-dh":
            steps = [crossing @ lift for crossing, lift in zip(crossings, lifts, strict=True)]
            return np.array([self.base @ steps[0], *steps[1:]]), self.flange
        steps = [lift @ crossing for crossing, lift in zip(crossings, lifts, strict=True)]
        return np.array([self.base, *steps[:-1]]), steps[-1] @ self.flange

    def in_convention(self, convention: Convention) -> JointRows:
        """Return the same robot's rows in the other convention, or these."""
        if convention == self.convention:
            return self
        a, alpha, beta = self.a.copy(), self.alpha.copy(), self.beta.copy()
        if convention == "dh":  # what lies before joint 1 goes to the base
            end, towards = _crossing(a[0], alpha[0], beta[0]), -1
        else:
            end, towards = _crossing(a[-1], alpha[-1], beta[-1]), 1
        for column in (a, alpha, beta):
            column[0 if convention == "dh" else -1] = 0.0
            column[:] = np.roll(column, towards)
        base, flange = (self.base @ end, self.flange) if convention == "dh" else (self.base, end @ self.flange)
        return JointRows(convention, a, alpha, beta, self.d, self.theta, base, flange)


@dataclass(frozen=True)
class RowsOfChain:
    """A chain as rows, and where these put the joints' frames on their links."""

    rows: JointRows
    """The rows."""
    turn: Floats
    """(J,) rad, about the joint's axis: the chain's frame of a joint to that of its row behind θ and d."""
    shift: Floats
    """(J,) m, along the joint's axis, likewise."""

    @classmethod
    def own(cls, rows: JointRows) -> RowsOfChain:
        """Return rows that a chain was built from."""
        zero = np.zeros(len(rows.d))
        return cls(rows, zero, rows.d.copy() if rows.convention == "dh" else zero)

    def in_convention(self, convention: Convention) -> RowsOfChain:
        """Return the same with rows in that convention."""
        return RowsOfChain(self.rows.in_convention(convention), self.turn, self.shift)

    def moved_frames(self) -> Floats:
        """Return (J, 4, 4) the frame of each joint in a chain built from the rows, in that of the chain they are of."""
        # of DH the chain's frame of a joint lies before d, of modified DH after it
        lifted = self.shift - (self.rows.d if self.rows.convention == "dh" else 0.0)
        return np.array([_along_z(*pair) for pair in zip(self.turn, lifted, strict=True)])


def rows_of_chain(
    chain: Chain, planned: RowsOfChain, *, first_held: bool = True, last_held: bool = True, strict: bool = False
) -> RowsOfChain:
    """Return a chain's axes as rows: the same robot, base to flange, at every angle.

    Parameters
    ----------
    chain : whose geometry it is.
    planned : rows of the robot as planned, and their frames on its links: they decide which axes are nearly parallel,
        to which side x points, and d where it is kept.
    first_held, last_held : θ and d of the first and the last joint keep their values, and the transform before the
        first and after the last row take the rest; otherwise these transforms keep what is theirs.
    strict : no β; a row has one only where its axes are parallel within rounding, and then it is 0.
    """
    nominal = planned.rows
    last = chain.n_joints - 1
    parallel = nearly_parallel(nominal)
    turn, shift = planned.turn.copy(), planned.shift.copy()
    # where on its axis the rows arrive, against the chain's frame of the joint
    start_turn, start_shift = np.zeros(last + 1), np.zeros(last + 1)
    a, alpha, beta = nominal.a.copy(), nominal.alpha.copy(), nominal.beta.copy()
    theta, d = nominal.theta.copy(), nominal.d.copy()
    before = _before_first(nominal)
    base = chain.fixed[0] @ inverse_transform(before)
    if not first_held:
        base, start_turn[0], start_shift[0] = _base_by_line(chain, nominal, before)
    for k, row in enumerate(np.arange(last + 1)[nominal.between]):
        ahead = chain.fixed[k + 1]
        reference = np.array([np.cos(planned.turn[k]), np.sin(planned.turn[k]), 0.0])
        if _same_axis(ahead) or (parallel[k] and not strict):
            if k > 0 or not first_held:
                shift[k] = start_shift[k] + d[k]
            turn[k], a[row], twist, beta[row] = _hayati(ahead, shift[k], reference)
        else:
            turn[k], shift[k], a[row], twist = _common_normal(ahead, reference)
            beta[row] = 0.0
        alpha[row] = _near(twist, nominal.alpha[row])
        if k == 0 and first_held:
            start_turn[0], start_shift[0] = chain.offset[0] + turn[0] - theta[0], shift[0] - d[0]
            base = chain.fixed[0] @ _along_z(start_turn[0], start_shift[0]) @ inverse_transform(before)
        theta[k] = _near(chain.offset[k] + turn[k] - start_turn[k], nominal.theta[k])
        d[k] = shift[k] - start_shift[k]
        arrived = inverse_transform(ahead) @ _along_z(turn[k], shift[k]) @ _crossing(a[row], alpha[row], beta[row])
        start_turn[k + 1], start_shift[k + 1] = np.arctan2(arrived[1, 0], arrived[0, 0]), arrived[2, 3]
    # what is kept, without the rounding of its way through the frames
    if first_held:
        theta[0], d[0] = nominal.theta[0], nominal.d[0]
    if not strict:
        d[parallel] = nominal.d[parallel]
    if last_held:
        turn[last], shift[last] = theta[last] - chain.offset[last] + start_turn[last], d[last] + start_shift[last]
    else:
        theta[last] = _near(chain.offset[last] + turn[last] - start_turn[last], nominal.theta[last])
        d[last] = shift[last] - start_shift[last]
    after = np.eye(4)
    if nominal.convention == "dh":
        after = _crossing(a[last], alpha[last], beta[last])
    flange = inverse_transform(_along_z(turn[last], shift[last]) @ after) @ chain.flange
    return RowsOfChain(JointRows(nominal.convention, a, alpha, beta, d, theta, base, flange), turn, shift)


def rows_as_planned(chain: Chain, convention: Convention) -> RowsOfChain:
    """Return rows of a robot that was not described by rows: θ and d of the first and last joint are 0."""
    n = chain.n_joints
    zero = np.zeros(n)
    numbers = np.arange(n)[slice(0, -1) if convention == "dh" else slice(1, None)]
    alpha = zero.copy()
    # the angle between the axes alone: it decides which rows have a β
    alpha[numbers] = np.arccos(np.clip(chain.fixed[1:, 2, 2], -1.0, 1.0))
    start = JointRows(convention, zero, alpha, zero, zero, zero, np.eye(4), np.eye(4))
    found = rows_of_chain(chain, RowsOfChain(start, zero, zero))
    # x points so that a is positive, or α where there is no a
    lengths, twists = found.rows.a[numbers], found.rows.alpha[numbers]
    flipped = (lengths < -1e-9) | ((np.abs(lengths) <= 1e-9) & (twists < 0.0))
    turn = found.turn.copy()
    turn[:-1][flipped] += np.pi
    return rows_of_chain(chain, RowsOfChain(start, turn, zero))


def nearly_parallel(rows: JointRows) -> Booleans:
    """Return (J,) True for joints whose axis is within 5° of the next one's, either way round; the last is False."""
    result = np.zeros(len(rows.a), dtype=np.bool_)
    numbers = np.arange(len(rows.a))[rows.between]
    cosine = np.cos(rows.alpha[numbers]) * np.cos(rows.beta[numbers])
    result[:-1] = 1.0 - cosine**2 < NEARLY_PARALLEL**2
    return result


def _before_first(nominal: JointRows) -> Floats:
    """Return the part of the first row before θ and d."""
    if nominal.convention == "dh":
        return np.eye(4)
    return _crossing(nominal.a[0], nominal.alpha[0], nominal.beta[0])


def _base_by_line(chain: Chain, nominal: JointRows, before: Floats) -> tuple[Floats, float, float]:
    """Return the transform before the rows that takes the planned first axis to the chain's, and where they arrive.

    The change is a shift across and a tilt alone; then turn and shift on that axis, against the chain's frame.
    """
    planned = nominal.fixed()[0][0]
    change = inverse_transform(planned) @ chain.fixed[0]
    axis, place = change[:3, 2], change[:3, 3]
    across = np.hypot(axis[0], axis[1])
    angle = np.arctan2(across, axis[2])
    pole = np.array([-axis[1], axis[0], 0.0]) / (across or 1.0)
    line = transform(rotation_from_vector(angle * pole), place - axis * (place[2] / axis[2]))
    arrived = inverse_transform(change) @ line @ inverse_transform(planned) @ nominal.base @ before
    return (
        planned @ line @ inverse_transform(planned) @ nominal.base,
        float(np.arctan2(arrived[1, 0], arrived[0, 0])),
        float(arrived[2, 3]),
    )


def _common_normal(ahead: Floats, reference: Floats) -> tuple[float, float, float, float]:
    """Return the turn and the shift of the common normal on this axis, its length and the twist."""
    axis, place = ahead[:3, 2], ahead[:3, 3]
    normal = np.array([-axis[1], axis[0], 0.0]) / np.hypot(axis[0], axis[1])
    if normal @ reference < 0.0:
        normal = -normal
    across = np.array([-normal[1], normal[0], 0.0])
    along = -float(across @ place) / float(across @ axis)
    twist = float(np.arctan2(-(across @ axis), axis[2]))
    return float(np.arctan2(normal[1], normal[0])), float(place[2] + along * axis[2]), float(normal @ place), twist


def _hayati(ahead: Floats, shift: float, reference: Floats) -> tuple[float, float, float, float]:
    """Return the turn of x towards where the next axis crosses the plane at ``shift``, the distance, and both tilts."""
    axis, place = ahead[:3, 2], ahead[:3, 3]
    crossing = place + axis * ((shift - place[2]) / axis[2])
    size = float(np.hypot(crossing[0], crossing[1]))
    x = np.array([crossing[0], crossing[1], 0.0]) / size if size > 1e-12 else reference
    if x @ reference < 0.0:
        x, size = -x, -size
    y = np.array([-x[1], x[0], 0.0])
    return (
        float(np.arctan2(x[1], x[0])),
        size,
        float(np.arctan2(-(y @ axis), axis[2])),
        float(np.arcsin(np.clip(x @ axis, -1.0, 1.0))),
    )


def _same_axis(ahead: Floats) -> bool:
    """Return whether two axes are parallel within rounding."""
    return bool(np.hypot(ahead[0, 2], ahead[1, 2]) < 1e-12)


def _near(angle: float, reference: float) -> float:
    """Return the angle with the whole turns that bring it nearest to a reference."""
    return float(angle - 2.0 * np.pi * np.round((angle - reference) / (2.0 * np.pi)))


def _crossing(a: float, alpha: float, beta: float) -> Floats:
    """Return Tx(a) · Rx(α) · Ry(β)."""
    ca, sa, cb, sb = np.cos(alpha), np.sin(alpha), np.cos(beta), np.sin(beta)
    rotation = np.array([[cb, 0.0, sb], [sa * sb, ca, -sa * cb], [-ca * sb, sa, ca * cb]])
    return transform(rotation, np.array([a, 0.0, 0.0]))


def _along_z(turn: float, shift: float) -> Floats:
    cosine, sine = np.cos(turn), np.sin(turn)
    rotation = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    return transform(rotation, np.array([0.0, 0.0, shift]))
