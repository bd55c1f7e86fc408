"""Tables of absolute places that cannot be right: one line for the mistake that explains them.

Joint angles and places have to meet, but for the tracker's place and the targets' on their bodies, which are fitted to
the rows so that a few wrong ones do not count (iteratively reweighted least squares with the weights of Geman and
McClure 1985). Where no row meets, exchanged targets or another unit of many rows are looked for, then the single change
of the whole table that makes them meet: the sign or the zero of a joint, the unit of all places, places some rows too
high or too low. Where most rows meet, those that do not are looked at one by one: another unit, exchanged targets,
angles of another row. Nothing is corrected.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from stiffcal.arrays import Integers
from stiffcal.errors import Fault
from stiffcal.fault_codes import FaultCode
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.reduction.faults_of_rows import LENGTH_FACTORS, OTHER_UNIT, exchanged_rows, rows_in_another_unit
from stiffcal.reduction.met_places import MeasuredPlaces, Met, meet, meets, misses, orders, places_of

MANIFEST = "campaign.toml"
# An uncalibrated robot misses by millimetres: below this a table as a whole is not doubted.
DOUBTED_M = 5e-3
# A change that explains the distance leaves less than this share of it.
MUCH_BETTER = 0.3
# Changes that leave no more than so many times the least explain it alike.
AS_GOOD = 1.5
# More rows than this share are no mistakes of single rows.
MOST_WRONG = 0.25
# Fewer rows than this do not determine the frames well enough to doubt one.
LEAST_ROWS = 10
# Of more rows so many are looked at for a change of the whole table.
MOST_ROWS = 300
MOST_NAMED = 4
# By so many rows at most the places of a table are taken to be moved against the joint angles.
MOST_ROWS_MOVED = 3
ANGLE_FACTORS = {np.pi / 180.0: "degrees", 180.0 / np.pi: "radians"}
TURNS = {np.pi / 2: "90°", -np.pi / 2: "−90°", np.pi: "180°"}


def place_faults(states: LoadStates, chain: Chain) -> list[Fault]:
    """Return faults of a campaign's absolute places; none where there are too few rows to say.

    Parameters
    ----------
    states : all states of the campaign, places in the axes of whatever frame.
    chain : the robot's kinematics as the robot file has it.
    """
    rows = np.flatnonzero(states.absolute & states.used & np.any(np.isfinite(states.position).all(axis=2), axis=1))
    if len(rows) < LEAST_ROWS or not states.setup.targets:
        return []
    chosen = states.select(rows)
    places = places_of(chosen, chain)
    met = meet(places)
    usual = met.usual(places)
    wrong = np.flatnonzero(misses(met, places, usual))
    if usual > DOUBTED_M or len(wrong) > 1:
        # rows of one mistake each are found one by one, and these are many with the same
        fault = exchanged_rows(chosen, places, wrong if usual <= DOUBTED_M else wrong[:0])
        if fault is None and (usual > DOUBTED_M or len(wrong) > MOST_WRONG * len(rows)):
            fault = rows_in_another_unit(chosen, places)
        if fault is not None:
            return [fault]
    if usual > DOUBTED_M:
        fault = _of_the_table(chosen, chain, places, usual)
        if fault is not None:
            return [fault]
    if 0 < len(wrong) <= MOST_WRONG * len(rows):
        found = [_of_a_row(chosen, chain, places, met, usual, int(k)) for k in wrong]
        named = [fault for fault in found if fault is not None]
        left = len(named) - MOST_NAMED
        if left > 0:
            named = [*named[:MOST_NAMED], Fault(FaultCode.MORE_FAULTS, MANIFEST, "", f"{left} more rows", "as above")]
        if named:
            return named
    return list(_exchanged_targets(places, met, states.setup.target_names, states.setup.targets))


@dataclass(frozen=True)
class _Change:
    """A change of the whole table."""

    code: FaultCode
    place: str
    words: str
    """As in "with … they miss by less"."""
    mend: str
    places: MeasuredPlaces
    """With the change."""


def _of_the_table(states: LoadStates, chain: Chain, places: MeasuredPlaces, usual: float) -> Fault | None:
    """Return the one change of all rows with which they meet; None where there is none."""
    some = np.unique(np.linspace(0, len(states) - 1, min(len(states), MOST_ROWS)).astype(np.int64))
    changes = [*_changes_of_the_table(states.select(some), chain, places.at(some)), *_moved_places(places, some)]
    left = [(meet(change.places).usual(change.places), change) for change in changes]
    # places that shrink to a point are near to anything: what is left is held against their own spread as well
    left = [(distance, change) for distance, change in left if distance <= MUCH_BETTER * _spread(change.places)]
    least = min((distance for distance, _ in left), default=np.inf)
    if least > MUCH_BETTER * usual:
        return None
    # of changes that explain it alike the likeliest mistake comes first
    (distance, change), *others = [entry for entry in left if entry[0] <= AS_GOOD * least]
    also = f" (with {others[0][1].words} too)" if others else ""
    missed = f"joint angles and positions differ by {1e3 * usual:.3g} mm"
    reason = f"{missed}, and with {change.words} by {1e3 * distance:.2g} mm{also}"
    return Fault(change.code, MANIFEST, change.place, reason, change.mend)


def _spread(places: MeasuredPlaces) -> float:
    """Return the rms distance of the measured places from their mean, m."""
    return float(np.sqrt(np.nansum(np.nanvar(places.measured, axis=(0, 1)))))


def _changes_of_the_table(states: LoadStates, chain: Chain, places: MeasuredPlaces) -> Iterator[_Change]:
    """Yield the changes that are tried, the likeliest mistakes first."""

    def turned(joint: int, sign: float, turn: float) -> MeasuredPlaces:
        joints = states.joints.copy()
        joints[:, joint] = sign * joints[:, joint] + turn
        return places_of(replace(states, joints=joints), chain)

    code = FaultCode.KINEMATICS_MISMATCH
    for joint, name in enumerate(chain.joint_names):
        mend = f"change the sign of direction of joint {name} in robot.toml, or of the column of its angle"
        yield _Change(code, f"joint {name}", f"the sign of joint {name} changed", mend, turned(joint, -1.0, 0.0))
    for turn, words in TURNS.items():
        for joint, name in enumerate(chain.joint_names):
            mend = f"correct theta_deg of joint {name} in robot.toml by {words}, or the column of its angle"
            what = f"the zero of joint {name} moved by {words}"
            yield _Change(code, f"joint {name}", what, mend, turned(joint, 1.0, turn))
    for factor, words in ANGLE_FACTORS.items():
        yield _Change(
            FaultCode.UNIT_IMPLAUSIBLE, "joints.units.position", f"joint angles read as {words}",
            f"all joint angles are in {words}: correct units of the joints",
            places_of(replace(states, joints=factor * states.joints), chain),
        )  # fmt: skip
    for factor, words in LENGTH_FACTORS.items():
        yield _Change(
            FaultCode.UNIT_IMPLAUSIBLE, "units.position", f"places multiplied by {factor:.4g}",
            f"all positions are {words}: correct units of the position",
            replace(places, measured=factor * places.measured),
        )  # fmt: skip


def _moved_places(places: MeasuredPlaces, some: Integers) -> Iterator[_Change]:
    """Yield the table with all places moved up or down by some rows against the joint angles.

    Parameters
    ----------
    places : of all rows. some : those that are looked at.
    """
    for n in range(1, min(MOST_ROWS_MOVED, len(places.measured) - 1) + 1):
        rows = "one row" if n == 1 else f"{n} rows"
        for direction in ("down", "up"):
            moved = np.full_like(places.measured, np.nan)
            if direction == "down":
                moved[n:] = places.measured[:-n]
            else:
                moved[:-n] = places.measured[n:]
            yield _Change(
                FaultCode.KINEMATICS_MISMATCH, "the order of the rows", f"all places moved {direction} by {rows}",
                f"move the columns of the places {direction} by {rows} against those of the joint angles",
                replace(places, measured=moved).at(some),
            )  # fmt: skip


def _of_a_row(states: LoadStates, chain: Chain, places: MeasuredPlaces, met: Met, usual: float, k: int) -> Fault | None:
    """Return what explains a row that misses; None where nothing does, and it is left to the fit."""
    row, info = places.at(np.array([k])), states.runs[int(states.run[k])]
    where = f"run {info.of or info.name}, row {int(states.row[k])}"
    mend = "correct the row, or exclude it with [[exclude]]"
    missed = float(np.nanmax(met.distance(row)))
    names = states.setup.target_names
    # of all targets, or of one
    scaled = [np.ones((len(names), 1), dtype=np.bool_), *np.eye(len(names), dtype=np.bool_)[:, :, None]]
    for which in scaled if len(names) > 1 else scaled[:1]:
        for factor, words in LENGTH_FACTORS.items():
            if meets(met, replace(row, measured=np.where(which, factor, 1.0) * row.measured), usual):
                what = "its position" if which.all() else f"the position of {names[int(which.argmax())]}"
                reason = f"{what} is {words}{OTHER_UNIT.get(factor, '')}"
                return Fault(FaultCode.UNIT_IMPLAUSIBLE, MANIFEST, where, reason, mend)
    for order in orders(len(names)):
        if meets(met, replace(row, measured=row.measured[:, order]), usual):
            moved = [names[b] for b in range(len(names)) if order[b] != b]
            reason = f"the positions of {' and '.join(moved)} are interchanged"
            return Fault(FaultCode.KINEMATICS_MISMATCH, MANIFEST, where, reason, mend)
    twins = np.flatnonzero(
        (np.abs(states.joints - states.joints[k]).max(axis=1) == 0.0) & (np.arange(len(states)) != k)
    )
    if twins.size:
        reason = (
            f"it has exactly the joint angles of row {int(states.row[twins[0]])}, but its position is "
            f"{1e3 * missed:.3g} mm away"
        )
        return Fault(FaultCode.KINEMATICS_MISMATCH, MANIFEST, where, reason, mend)
    alone = states.select(np.array([k]))
    for factor, words in ((np.pi / 180.0, "degrees"), (180.0 / np.pi, "radians")):
        if meets(met, places_of(replace(alone, joints=factor * alone.joints), chain), usual):
            other = "radians" if words == "degrees" else "degrees"
            reason = f"its joint angles are in {words} where the other rows' are in {other}"
            return Fault(FaultCode.UNIT_IMPLAUSIBLE, MANIFEST, where, reason, mend)
    for joint, name in enumerate(chain.joint_names):
        joints = alone.joints.copy()
        joints[:, joint] *= -1.0
        if meets(met, places_of(replace(alone, joints=joints), chain), usual):
            reason = f"the angle of joint {name} has the wrong sign"
            return Fault(FaultCode.KINEMATICS_MISMATCH, MANIFEST, where, reason, mend)
    reason = (
        f"its position is {1e3 * missed:.3g} mm from where its joint angles put it, the others' {1e3 * usual:.2g} mm"
    )
    return Fault(FaultCode.KINEMATICS_MISMATCH, MANIFEST, where, reason, mend)


def _exchanged_targets(
    places: MeasuredPlaces, met: Met, names: tuple[str, ...], targets: tuple[object, ...]
) -> Iterator[Fault]:
    """Yield a fault where the targets are found at each other's places on the body."""
    own = np.linalg.norm(met.offset - places.offset, axis=1)
    if own.max() < DOUBTED_M:
        return
    for order in orders(len(names)):
        same_body = all(np.allclose(places.position[:, a], places.position[:, b]) for a, b in enumerate(order))
        other = np.linalg.norm(met.offset - places.offset[order], axis=1)
        if same_body and other.max() < MUCH_BETTER * own.max():
            moved = [names[b] for b in range(len(names)) if order[b] != b]
            yield Fault(
                FaultCode.KINEMATICS_MISMATCH, MANIFEST, f"poses.{moved[0]}",
                f"{' and '.join(moved)} are interchanged: each is at the position that the manifest gives for the "
        f"other, {1e3 * own.max():.3g} mm from its own",
                "interchange their columns, or their positions on the body",
            )  # fmt: skip
            return
