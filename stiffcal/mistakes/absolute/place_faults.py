"""Tables of absolute places that cannot be right: one line for the mistake that explains them.

Joint angles and places have to meet, but for the tracker's place and the targets' on their bodies, which are fitted to
the rows so that a few wrong ones do not count (iteratively reweighted least squares with the weights of Geman and
McClure 1985). Where no row meets, exchanged targets are looked for, then the single change of the whole table or of the
robot file that makes them meet: the sign or the zero of a joint, interchanged columns, the unit of all places, places
some rows too high or too low, the sign of a length. Where only some rows meet, those that do not are compared with the
same changes, and the rows of one mistake are one line. Nothing is corrected.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

import numpy as np

from stiffcal.campaign.loading import Campaign
from stiffcal.campaign.toml.naming import MANIFEST_FILE
from stiffcal.errors import Fault
from stiffcal.fault_changes import InputChange
from stiffcal.fault_codes import FaultCode
from stiffcal.measurements.load_states import LoadStates
from stiffcal.measurements.tracker_axes import each_tracker
from stiffcal.mistakes.absolute.agreeing_rows import agreeing
from stiffcal.mistakes.absolute.exchanged_targets import exchanged_rows
from stiffcal.mistakes.absolute.faults_of_rows import SomeRows, faults_of_rows
from stiffcal.mistakes.absolute.met_places import (
    LEAST_ROWS,
    MOST_ROUNDS,
    UNCALIBRATED_M,
    MeasuredPlaces,
    Met,
    meet,
    misses,
    orders,
    places_of,
)
from stiffcal.mistakes.absolute.places import undone
from stiffcal.mistakes.absolute.table_rows import TableRows
from stiffcal.mistakes.catalogue.positions.target_order import TargetOrder
from stiffcal.mistakes.deciding import AS_GOOD, MUCH_BETTER
from stiffcal.mistakes.inputs.mistake import AsRead, ChangeTexts, InputPart, Scored, TakenBack, TriedOn
from stiffcal.mistakes.inputs.taken_back import taken_back
from stiffcal.mistakes.references.corrections import LEAST_FREEDOM
from stiffcal.mistakes.references.match import references_of
from stiffcal.mistakes.some_rows import some_of
from stiffcal.mistakes.stated_units import stated_units
from stiffcal.mistakes.words import listed
from stiffcal.reduction.registration.registering import WORST_M
from stiffcal.wording import length

# More rows than this share are no mistakes of single rows: then rows that agree are looked for before the frames are
# believed, as half of the rows on one side shift a median.
MOST_WRONG = 0.25
# With a change that is that of the whole table, no more rows than this are far from the others: these have a second
# mistake, and are named once the first is mended.
MOST_LEFT = 0.1


def place_faults(states: LoadStates, campaign: Campaign) -> list[Fault]:
    """Return faults of a campaign's absolute places; none where there are too few rows to say.

    Parameters
    ----------
    states : all states of the campaign, places in the axes of whatever frame.
    campaign : what the manifest and the robot file state, and where the tables are.
    """
    measured = states.absolute & states.used & np.any(np.isfinite(states.position).all(axis=2), axis=1)
    if not states.setup.targets:
        return []
    by_tracker = [states.select(measured & read) for read, _ in each_tracker(states.setup.trackers, states.tracker)]
    found = (_faults_of_one_tracker(chosen, campaign) for chosen in by_tracker if len(chosen) >= LEAST_ROWS)
    return next((faults for faults in found if faults), [])


def reference_fault(states: LoadStates, campaign: Campaign) -> Fault | None:
    """Return the one change with which the unloaded states of load runs meet; None where there is none.

    For a campaign whose frames are to be found, and are not: no frames meet what was read.

    Parameters
    ----------
    states : all states of the campaign, positions in the axes of whatever frame. campaign : as of `place_faults`.
    """
    chosen = references_of(states)
    if len(np.unique(chosen.tracker)) != 1:
        return None
    places = places_of(chosen, campaign.chain)
    frames = 6 + places.offset.size
    if np.isfinite(places.measured).sum() - frames < LEAST_FREEDOM:
        return None
    typical = float(np.median(meet(places).worst(places)))
    return _of_the_table(TableRows(campaign, chosen), places, typical) if typical > UNCALIBRATED_M else None


def _faults_of_one_tracker(chosen: LoadStates, campaign: Campaign) -> list[Fault]:
    """Return faults of places that one tracker read, which stood still."""
    table, places = TableRows(campaign, chosen), places_of(chosen, campaign.chain)
    copied = _copied_targets(table, places)
    if copied is not None:
        return [copied]
    stopped = _stopped(table, places)
    if stopped is not None:
        return [stopped]
    met = meet(places)
    usual = met.usual(places)
    wrong = np.flatnonzero(misses(met, places, usual))
    if usual > UNCALIBRATED_M or len(wrong) > 1:
        # rows of one mistake each are found one by one, and these are many with the same
        fault = exchanged_rows(table, places, wrong if usual <= UNCALIBRATED_M else wrong[:0])
        if fault is not None:
            return [fault]
    typical = float(np.median(met.worst(places)))
    if typical > UNCALIBRATED_M:
        fault = _of_the_table(table, places, typical)
        if fault is not None:
            return [fault]
    many = not met.settled or typical > UNCALIBRATED_M or len(wrong) > MOST_WRONG * len(chosen)
    if many:
        found = agreeing(places)
        if found is None or found[1] > UNCALIBRATED_M:
            return [] if met.settled else [_unsettled(table)]
        met, usual, far = found
        wrong = np.flatnonzero(far)
    if wrong.size:
        return faults_of_rows(SomeRows(table, places, met, usual, wrong, many))
    return list(_exchanged_targets(places, met, chosen))


def _unsettled(table: TableRows) -> Fault:
    """Return the fault of a table of which no frames are found with which most rows meet, nor that there are none."""
    reason = (
        f"the search for frames with which joint angles and positions agree does not converge in {MOST_ROUNDS} rounds"
    )
    mend = "state the places of the tracker and of the targets in [frames], or check the columns of both"
    return Fault(FaultCode.NO_CONVERGENCE, table.file(), "joint angles and positions", reason, mend)


def _copied_targets(table: TableRows, places: MeasuredPlaces) -> Fault | None:
    """Return the fault of two targets with the same positions in every row."""
    names, measured = table.states.setup.target_names, places.measured
    for first, second in combinations(range(len(names)), 2):
        both = np.isfinite(measured[:, first]).all(axis=1) & np.isfinite(measured[:, second]).all(axis=1)
        if both.sum() >= LEAST_ROWS and (measured[both, first] == measured[both, second]).all():
            pair = f"{names[first]} and {names[second]}"
            reason = f"the positions of {pair} are the same in every row: two readings never agree exactly"
            mend = f"correct the columns of {names[second]}, or remove it"
            return Fault(FaultCode.KINEMATICS_MISMATCH, table.file(), f"columns of {pair}", reason, mend)
    return None


def _stopped(table: TableRows, places: MeasuredPlaces) -> Fault | None:
    """Return the fault of rows where a target reads zero, or the row before though the joints moved it in between."""
    expected = places.position + np.einsum("nbij,bj->nbi", places.rotation, places.offset)
    moved = np.linalg.norm(np.diff(expected, axis=0), axis=2)
    lost = (places.measured == 0.0).all(axis=2)
    lost[1:] |= (places.measured[1:] == places.measured[:-1]).all(axis=2) & (moved > UNCALIBRATED_M)
    rows = np.flatnonzero(lost.any(axis=1))
    if not rows.size:
        return None
    reason = (
        "a target's position is zero, or exactly that of the row before though the joint angles move it, in "
        f"{rows.size} of {len(places.measured)} rows ({table.listed(rows)}): it was lost, or the tracker stopped"
    )
    mend = f"measure these rows again, or exclude them with {table.exclusion(rows)}"
    file, place = table.file(int(rows[0])), table.place(rows)
    return Fault(FaultCode.READING_IMPLAUSIBLE, file, place, reason, mend, rows=table.numbers(rows))


def _of_the_table(table: TableRows, places: MeasuredPlaces, usual: float) -> Fault | None:
    """Return the one change of all rows with which they meet; None where there is none."""
    states, campaign = table.states, table.campaign
    rows = some_of(len(states))
    read = AsRead(
        TriedOn.ABSOLUTE_TABLE,
        states,
        campaign.chain,
        rows,
        stated_units(campaign),
        robot=campaign.robot,
        folder=campaign.robot_path.parent,
    )
    as_read, left = places.at(rows), list[Scored]()
    for taken in taken_back(read):
        changed = undone(read, as_read, taken)
        met = meet(changed)
        distance = float(np.median(met.worst(changed)))
        # places that shrink to a point are near to anything: what is left is held against their own spread as well
        if not met.settled or distance > min(MUCH_BETTER * min(usual, _spread(changed)), WORST_M):
            continue
        if np.mean(misses(met, changed, distance)) <= MOST_LEFT:
            left.append(Scored(distance, taken))
    if not left:
        return None
    least = min(one.score for one in left)
    # of changes that explain it alike the likeliest mistake comes first
    best, *others = [one for one in left if one.score <= AS_GOOD * least]
    texts = _texts(best.taken)
    also = f" (with {_texts(others[0].taken).words} too)" if others else ""
    missed = f"joint angles and positions differ by {length(usual)}"
    reason = f"{missed}, and with {texts.words} by {length(best.score, digits=2)}{also}"
    mistake, change = best.taken.mistake, best.taken.change
    of_angles = mistake.part is InputPart.ANGLES
    if mistake.part is InputPart.ROBOT:
        file = campaign.manifest.robot
    elif mistake.is_in_manifest(change):
        file = MANIFEST_FILE
    else:
        file = table.file(of_angles=of_angles)
    place = texts.place
    if of_angles and file == MANIFEST_FILE:
        place = f"joints: {place}" if change.names else f"joints.{place}"
    return Fault(mistake.code, file, place, reason, texts.mend, changes=(change,))


def _texts(taken: TakenBack) -> ChangeTexts:
    return taken.mistake.texts(taken.change, taken.chain)


def _spread(places: MeasuredPlaces) -> float:
    """Return the rms distance of the measured places from their mean, m."""
    return float(np.sqrt(np.nansum(np.nanvar(places.measured, axis=(0, 1)))))


def _exchanged_targets(places: MeasuredPlaces, met: Met, states: LoadStates) -> Iterator[Fault]:
    """Yield a fault where the targets are found at each other's places on the body."""
    names = states.setup.target_names
    own = np.linalg.norm(met.offset - places.offset, axis=1)
    if own.max() < UNCALIBRATED_M:
        return
    for order in orders(len(names)):
        same_body = all(np.allclose(places.position[:, a], places.position[:, b]) for a, b in enumerate(order))
        other = np.linalg.norm(met.offset - places.offset[order], axis=1)
        if same_body and other.max() < MUCH_BETTER * own.max():
            moved = [names[b] for b in range(len(names)) if order[b] != b]
            change = InputChange(TargetOrder.name, tuple(moved))
            yield Fault(
                FaultCode.KINEMATICS_MISMATCH, MANIFEST_FILE, f"poses.{moved[0]}",
                f"{listed(moved)} are interchanged: each is at the position that the manifest gives for the "
                f"other, {length(own.max())} from its own",
                "interchange their columns, or their positions on the body", changes=(change,),
            )  # fmt: skip
            return
