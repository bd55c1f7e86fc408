"""Bumped readings, set aside once, before any model and the same for all models.

Why not by a model's residual: backlash crossings look like outliers to a model without backlash. A reading is set
aside only when nothing explains it: not the smooth course of its own direction and branch, not a repeat at like load,
not the readings just before and after it (a slip shifts all that follow), and where its neighbours jump themselves,
not a place between them. The worst goes first, then the rest is looked at again without it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, groupby, pairwise

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.measurements.load_states import LoadStates, members_of
from stiffcal.measurements.set_aside import SetAsideCode, any_code
from stiffcal.mechanics.rotations import vector_from_rotation
from stiffcal.reduction.load_cycles import UNLOADED, UNLOADING, LoadCycles, find_load_cycles, load_vector

# Natural log of the false alarms: e^-16 is 1e-7 per state for one explanation alone, and several have to fail.
ALARM_EXPONENT = 16.0
LIKE_LOAD = 0.08  # of the run's largest load, as in load_cycles
MOST_SET_ASIDE = 0.34  # of the readings of one direction and branch: more is no accident but an effect
FEW = 12  # readings of a group of which two bumped ones can hide each other
LEAST_LOADED = 0.1  # of the most loaded direction of a run: below, how it gives that way is not known
NOT_SMOOTH = 2.5  # times the noise, left by a line with a jump: then it is not that


@dataclass(frozen=True)
class _Group:
    """Readings of one run, direction and branch: indices (m,) into the states, load (m,) as a share of the largest."""

    members: Integers
    load: Floats
    loaded: bool
    direction: int


def reject_outliers(states: LoadStates) -> LoadStates:
    """Return the states with bumped readings set aside, each with its reason.

    Examples
    --------
    See ``tests/reduction/test_screening.py``.
    """
    reasons = outlier_readings(states)
    if not reasons:
        return states
    return states.with_set_aside(np.array(list(reasons)), SetAsideCode.BUMPED, list(reasons.values()))


def load_is_good(states: LoadStates) -> Booleans:
    """Return (n,) True where the load was what the state holds, whether or not its reading is used.

    A bumped reading was taken under a good load, which laws with memory (play, creep) must pass through, and so was one
    that was held too briefly; what the manifest excludes is in doubt as a whole.
    """
    good = (SetAsideCode.NONE, SetAsideCode.BUMPED, SetAsideCode.HELD_BRIEFLY)
    return any_code(states.set_aside_code, *good)


def outlier_readings(states: LoadStates) -> dict[int, str]:
    """Return the indices of readings that contradict their neighbours and repeats, and why in words."""
    readings, n_lengths = _readings(states)
    if readings.shape[1] == 0:
        return {}
    cycles = find_load_cycles(states)
    groups = _groups(states, cycles)
    readings = readings - _misalignment_effect(readings, states, cycles)
    residuals = _smooth_residuals(readings, groups)
    noise = _noise([residual for residual in residuals if residual is not None])
    if noise is None:
        return {}
    white = readings / noise
    wider = _noisier_runs(residuals, noise, groups, states.run)
    if wider:
        white /= np.array([wider.get(number, 1.0) for number in states.run.tolist()])[:, None]
    n_components = white.shape[1]
    bound = np.sqrt(n_components + 2.0 * np.sqrt(ALARM_EXPONENT * n_components) + 2.0 * ALARM_EXPONENT)
    reason_of: dict[int, str] = {}
    in_use = states.used & np.isfinite(white).all(axis=1)
    doubtful = {int(states.run[k]) for k in _far_readings(white, groups, in_use, bound)}
    for number, run_groups in _by_run(groups, states.run).items():
        if number not in doubtful:
            continue
        for k, distance in _RunReadings(white, run_groups, in_use, cycles.last_direction, bound).bumped():
            size = 1e3 * distance * wider.get(number, 1.0) * float(np.sqrt(np.mean(noise[:n_lengths] ** 2)))
            reason_of[k] = (
                f"outlier: differs by {distance:.0f} times the noise ({size:.2f} mm) from its neighbours and repeats"
            )
    return reason_of


def _readings(states: LoadStates) -> tuple[Floats, int]:
    """Return (n, k): translation and, where measured throughout, rotation of every target, base axes, in m and rad.

    And how many of the first components are lengths of the first target. Where only gauges were read, the one that a
    run reads is its component.
    """
    n = len(states)
    if states.deflection_given:
        flat = states.deflection.reshape(n, -1)
        return np.asarray(flat[:, np.isfinite(flat).any(axis=0)]), 3
    if not states.has_poses:
        measured = np.isfinite(states.displacement)
        alone = np.where(measured.any(axis=1), np.sum(np.where(measured, states.displacement, 0.0), axis=1), np.nan)
        return alone[:, None] if measured.any() else np.zeros((n, 0)), 1
    columns = [states.position.reshape(n, -1)]
    for b in range(states.rotation.shape[1]):
        if np.isfinite(states.rotation[:, b]).all():
            rotation = np.zeros((n, 3))
            for members in members_of(states.run):
                first = states.rotation[members[0], b]
                rotation[members] = vector_from_rotation(states.rotation[members, b] @ first.T)
            columns.append(rotation)
    return np.concatenate(columns, axis=1), 3


def _misalignment_effect(readings: Floats, states: LoadStates, cycles: LoadCycles) -> Floats:
    """Return (n, k): what the readings owe to forces that were not quite along their direction.

    A heavy load misaligned by half a degree moves a soft robot sideways by several times the tracker's noise. How the
    run's readings follow the force is given well enough by a straight line for this share of a hundredth.
    """
    result = np.zeros_like(readings)
    force = load_vector(states.wrench)
    good = states.used & np.isfinite(readings).all(axis=1)
    for everyone in members_of(states.run):
        members = everyone[good[everyone]]
        off = np.zeros((members.size, 3))
        for direction in np.unique(cycles.direction[members]):
            of_direction = cycles.direction[members] == direction
            along = force[members[of_direction]].sum(axis=0)
            size = float(np.linalg.norm(along))
            if direction >= 0 and size > 0.0:
                along = along / size
                off[of_direction] = (
                    force[members[of_direction]] - (force[members[of_direction]] @ along)[:, None] * along
                )
        if not off.any():
            continue
        loads = force[members] - force[members].mean(axis=0)
        centred = readings[members] - readings[members].mean(axis=0)
        # Directions in which the run was hardly loaded carry no information on how it gives there.
        result[members] = off @ (np.linalg.pinv(loads, rcond=LEAST_LOADED) @ centred)
    return result


def _groups(states: LoadStates, cycles: LoadCycles) -> list[_Group]:
    """Gather the readings of one run, direction and branch; peaks belong to loading."""
    branch = np.where(cycles.branch == UNLOADED, 0, np.where(cycles.branch == UNLOADING, 2, 1))
    key = np.where(branch == 0, -1, cycles.direction)
    groups: list[_Group] = []
    for members in members_of(states.run):
        largest = max(float(cycles.magnitude[members].max()), np.finfo(float).tiny)
        pairs = 3 * key[members] + branch[members]
        for pair in np.unique(pairs).tolist():
            of_pair = members[pairs == pair]
            groups.append(_Group(of_pair, cycles.magnitude[of_pair] / largest, pair % 3 != 0, pair // 3))
    return groups


def _smooth_residuals(readings: Floats, groups: Sequence[_Group]) -> list[Floats | None]:
    """Return, of each group, (m, k) what a smooth course over load leaves; None where too few readings are complete."""
    residuals: list[Floats | None] = [None] * len(groups)
    complete: Booleans = np.asarray(np.isfinite(readings).all(axis=1))
    for alike in _alike_courses(groups, complete):
        left, hat = alike.left(readings)
        scaled = left / np.sqrt(np.maximum(1.0 - hat, 0.1))[:, :, None]
        for number, residual in zip(alike.groups, scaled, strict=True):
            residuals[number] = residual
    return residuals


def _far_readings(white: Floats, groups: Sequence[_Group], kept: Booleans, bound: float) -> list[int]:
    """Return the readings whose studentized residual about their group's smooth course exceeds the bound."""
    far: list[int] = []
    for alike in _alike_courses(groups, kept):
        left, hat = alike.left(white)
        lengths = np.linalg.norm(left, axis=2) / np.sqrt(np.maximum(1.0 - hat, 0.05))
        far += alike.members[lengths > bound].tolist()
    return far


@dataclass(frozen=True)
class _AlikeCourses:
    """Groups of equally many readings whose smooth courses have equally many columns: thousands are taken at once."""

    groups: list[int]
    """Their g numbers."""
    members: Integers
    """(g, m) the readings of each."""
    course: Floats
    """(g, m, p) as `_course` gives it."""

    def left(self, readings: Floats) -> tuple[Floats, Floats]:
        """Return (g, m, k) what the courses leave of readings (n, k), and (g, m) the diagonals of the hat matrices."""
        across, own = np.linalg.qr(self.course)[0], readings[self.members]
        left = own - across @ (np.swapaxes(across, 1, 2) @ own)
        return np.asarray(left), np.asarray((across**2).sum(axis=2))


def _alike_courses(groups: Sequence[_Group], kept: Booleans) -> Iterator[_AlikeCourses]:
    """Yield the smooth courses of all groups that have one, as `_course` gives them, alike ones together.

    Parameters
    ----------
    groups : of all runs. kept : (n,) the readings that count.
    """
    of_size: dict[tuple[int, bool], list[tuple[int, Integers, Floats]]] = {}
    for number, group in enumerate(groups):
        mask = kept[group.members]
        members = group.members[mask]
        of_size.setdefault((members.size, group.loaded), []).append((number, members, group.load[mask]))
    for (_, loaded), entries in of_size.items():
        columns = _columns_of_courses(np.stack([load for _, _, load in entries]), loaded)
        for count in np.unique(columns[columns > 0]).tolist():
            chosen = [entries[k] for k in np.flatnonzero(columns == count)]
            load = np.stack([load for _, _, load in chosen])
            course = np.stack([load**power for power in range(count - 1, -1, -1)], axis=2)
            members = np.stack([members for _, members, _ in chosen])
            yield _AlikeCourses([number for number, _, _ in chosen], members, course)


def _columns_of_courses(load: Floats, loaded: bool) -> Integers:
    """Return (g,) the number of columns of the smooth courses over loads (g, m): constant, line, parabola; 0: none."""
    groups, size = load.shape
    if not loaded:
        return np.full(groups, 1 if size >= 3 else 0)
    levels = 1 + (np.diff(np.sort(load, axis=1), axis=1) > LIKE_LOAD).sum(axis=1)
    columns = np.minimum(2 if size >= 6 else 1, levels - 1) + 1
    return np.where((levels < 2) | (size < 4), 0, columns)


def _basis(course: Floats) -> Floats:
    """Return (m, p) an orthonormal basis of the columns of a course (m, p): its square is the hat matrix."""
    return np.asarray(np.linalg.qr(course)[0])


def _noise(residuals: Sequence[Floats]) -> Floats | None:
    """Return (k,) the scatter between like readings: robust, from what smooth courses leave; None where too few."""
    if not residuals:
        return None
    stacked = np.abs(np.concatenate(residuals))
    noise = np.median(stacked, axis=0) / 0.6745
    floor = 1e-3 * float(np.median(noise[noise > 0.0])) if (noise > 0.0).any() else 0.0
    if len(stacked) < 12 or floor == 0.0:
        return None
    return np.asarray(np.maximum(noise, floor))


def _noisier_runs(
    residuals: Sequence[Floats | None], noise: Floats, groups: Sequence[_Group], run: Integers
) -> dict[int, float]:
    """Return runs that scatter wider than the noise as a whole, with by how much.

    A target far from the tracker or a shaky stand makes all readings of a run noisier, and none of them bumped. The
    median of n deviations is known to 1.17/√n of itself; three times that is no chance.
    """
    factor_of: dict[int, float] = {}
    of_run: dict[int, list[tuple[_Group, Floats | None]]] = {}
    for group, residual in zip(groups, residuals, strict=True):
        of_run.setdefault(int(run[group.members[0]]), []).append((group, residual))
    for number, own in sorted(of_run.items()):
        scatter = _noise([residual / noise for _, residual in own if residual is not None])
        factor = 1.0 if scatter is None else float(np.sqrt(np.mean(scatter**2)))
        if factor > 1.0 + 3.0 * 1.17 / np.sqrt(sum(group.members.size for group, _ in own) * noise.size):
            factor_of[number] = factor
    return factor_of


def _by_run(groups: list[_Group], run: Integers) -> dict[int, list[_Group]]:
    """Return the groups of each run by its number; they come run by run, and none is empty."""
    return {number: list(own) for number, own in groupby(groups, key=lambda group: int(run[group.members[0]]))}


def _course(group: _Group, kept: Booleans) -> Floats | None:
    """Return the design (m, p) of a smooth course over load: constant, line or parabola by the readings there are."""
    load = group.load[kept]
    columns = int(_columns_of_courses(load[None], group.loaded)[0])
    return np.vander(load, columns) if columns else None


class _RunReadings:
    """The readings of one run while bumped ones are taken out: white (n, k) over the noise, groups, what is kept."""

    def __init__(self, white: Floats, groups: list[_Group], kept: Booleans, left: Integers, bound: float) -> None:
        self.last_direction = left  # the direction that was loaded last
        self.white, self.groups, self.kept, self.bound = white, groups, kept.copy(), bound
        self.group_of = {int(k): group for group in groups for k in group.members}
        self.load = {int(k): float(x) for group in groups for k, x in zip(group.members, group.load, strict=True)}
        self.counts = {id(group): 0 for group in groups}

    def bumped(self) -> list[tuple[int, float]]:
        """Take out the worst unexplained reading, look again, until all are explained."""
        bumps: list[tuple[int, float]] = []
        while True:
            lengths = self._course_residuals()
            suspects = sorted((k for k in lengths if lengths[k] > self.bound), key=lambda k: -lengths[k])
            worst = next((k for k in suspects if self._may_go(k) and self._is_unexplained(k)), None)
            if worst is None:
                return bumps
            worst = self._instead(worst, lengths)
            self.kept[worst] = False
            self.counts[id(self.group_of[worst])] += 1
            bumps.append((worst, lengths[worst]))

    def _may_go(self, k: int) -> bool:
        group = self.group_of[k]
        return self.counts[id(group)] + 1 <= max(MOST_SET_ASIDE * group.members.size, 1.0)

    def _instead(self, worst: int, lengths: dict[int, float]) -> int:
        """Return the reading to take out first: with two bumped ones among few, a good one may stand out most.

        Where taking out the worst leaves the group rough and some two leave it smooth, it is the worse of these two.
        """
        group = self.group_of[worst]
        members = [int(k) for k in group.members if self.kept[k]]
        if self.counts[id(group)] + 2 > MOST_SET_ASIDE * group.members.size or len(members) > FEW:
            return worst
        if self._roughness(group, (worst,)) <= self.bound:
            return worst
        roughness, two = min((self._roughness(group, two), two) for two in combinations(members, 2))
        able = roughness <= self.bound and worst not in two and all(self._is_unexplained(k) for k in two)
        return max(two, key=lambda k: lengths[k]) if able else worst

    def _roughness(self, group: _Group, without: tuple[int, ...]) -> float:
        """Return the largest studentized residual of a group about its smooth course, some readings left out."""
        mask = self.kept[group.members] & ~np.isin(group.members, without)
        course = _course(group, mask)
        if course is None or course.shape[0] <= course.shape[1]:
            return float(np.inf)
        return float(max(self._standardised_residuals(group.members[mask], course)))

    def _standardised_residuals(self, members: Integers, course: Floats) -> Floats:
        """Return (m,) studentized residuals of readings about their fit by ``course``, the (m, p) design matrix."""
        across, own = _basis(course), self.white[members]
        residual = own - across @ (across.T @ own)
        return np.asarray(np.linalg.norm(residual, axis=1) / np.sqrt(np.maximum(1.0 - (across**2).sum(axis=1), 0.05)))

    def _course_residuals(self) -> dict[int, float]:
        """Return reading to its studentized residual about its group's smooth course."""
        lengths: dict[int, float] = {}
        for group in self.groups:
            mask = self.kept[group.members]
            course = _course(group, mask)
            if course is None:
                continue
            members = group.members[mask]
            lengths |= {
                int(k): float(x) for k, x in zip(members, self._standardised_residuals(members, course), strict=True)
            }
        return lengths

    def _others(self, k: int) -> Integers:
        members = self.group_of[k].members
        return np.asarray(members[self.kept[members] & (members != k)])

    def _is_unexplained(self, k: int) -> bool:
        """Return whether neither repeats, nor neighbours in time, nor a jump between neighbours explain a reading."""
        if not self.group_of[k].loaded:
            return self._far_unloaded(k) and not self._is_slip(k)
        off = self._off_repeats(k)
        if off:
            if min(np.linalg.norm(away) for away in off.values()) <= np.sqrt(2.0) * self.bound:
                return False
        elif self._other_branch_agrees(k):
            return False
        return not self._is_slip(k) and not self._at_a_jump(k)

    def _far_unloaded(self, k: int) -> bool:
        """Return whether an unloaded reading is far from the others.

        One that was reached the same way is enough to agree with; of the rest it takes two, since two may be bumped.
        """
        repeats = self._others(k)
        close_repeats = repeats[np.linalg.norm(self.white[repeats] - self.white[k], axis=1) <= self.bound]
        same_history = (self.last_direction[close_repeats] == self.last_direction[k]) | (self.last_direction[k] < 0)
        return not same_history.any() and close_repeats.size < (2 if repeats.size >= 5 else 1)

    def _off_repeats(self, k: int) -> dict[int, Floats]:
        """Return the difference of a reading from each repeat at like load, brought to its own load."""
        repeats = self._others(k)
        if not self.group_of[k].loaded:
            return {int(j): self.white[k] - self.white[j] for j in repeats}
        slope = self._slope(repeats)
        load_difference = {int(j): abs(self.load[int(j)] - self.load[k]) for j in repeats}
        # Loads are never hit exactly: a peak that missed its mark may have no repeat as near as others have.
        similar_load = [j for j in load_difference if load_difference[j] <= LIKE_LOAD] or [
            j for j in load_difference if load_difference[j] <= 2.0 * LIKE_LOAD
        ]
        return {j: self.white[k] - self.white[j] - slope * (self.load[k] - self.load[j]) for j in similar_load}

    def _slope(self, repeats: Integers) -> Floats:
        """Return (k,) the readings' change per load: median over pairs that lie well apart (Theil and Sen)."""
        at = np.array([self.load[int(j)] for j in repeats])
        first, two = np.triu_indices(at.size, 1)
        well_separated = np.abs(at[first] - at[two]) > 2.0 * LIKE_LOAD
        if not well_separated.any():
            return np.zeros(self.white.shape[1])
        first, two = first[well_separated], two[well_separated]
        change = (self.white[repeats[first]] - self.white[repeats[two]]) / (at[first] - at[two])[:, None]
        return np.asarray(np.median(change, axis=0))

    def _is_slip(self, k: int) -> bool:
        """Return whether the reading before or after is off its own repeats alike: a slip or a drift, not a bump."""
        off = self._off_repeats(k)
        for neighbour in (k - 1, k + 1):
            if neighbour not in self.group_of or not self.kept[neighbour]:
                continue
            for j, away in off.items():
                for i, alike in self._off_repeats(neighbour).items():
                    # repeats of one and the same other cycle
                    if abs(i - j) <= 1 and np.linalg.norm(away - alike) < min(
                        2.0 * self.bound, 0.5 * float(np.linalg.norm(away))
                    ):
                        return True
        return False

    def _other_branch_agrees(self, k: int) -> bool:
        """Without repeats: whether the other branch shows the same at like load, as nearly as branches do here."""
        gaps: list[float] = []
        own: list[float] = []
        for group in self.groups:
            if not group.loaded:
                continue
            for other_group in self.groups:
                if other_group.direction != group.direction or other_group is group or not other_group.loaded:
                    continue
                slope = self._slope(np.concatenate([group.members, other_group.members]))
                for i in group.members[self.kept[group.members]]:
                    for j in other_group.members[self.kept[other_group.members]]:
                        load_difference = self.load[int(i)] - self.load[int(j)]
                        if abs(load_difference) > LIKE_LOAD:
                            continue
                        gap = float(np.linalg.norm(self.white[i] - self.white[j] - slope * load_difference))
                        (own if int(i) == k else gaps).append(gap)
        if not own:
            return True  # nothing to compare with: no verdict
        return min(own) <= max(2.0 * self.bound, 3.0 * float(np.median(gaps)) if gaps else 0.0)

    def _at_a_jump(self, k: int) -> bool:
        """Return whether the other readings jump at this load, and this one lies on one side or within the jump."""
        repeats = self._others(k)
        at = np.array([self.load[int(j)] for j in repeats])
        values = self.white[repeats]
        cuts = np.unique(np.sort(at))
        for low, high in pairwise(cuts):
            if not low - LIKE_LOAD <= self.load[k] <= high + LIKE_LOAD:
                continue
            design = np.stack([np.ones_like(at), at, (at > 0.5 * (low + high)).astype(np.float64)], axis=1)
            if design.shape[0] <= design.shape[1]:
                continue
            fit = np.linalg.lstsq(design, values, rcond=None)[0]
            free = (design.shape[0] - design.shape[1]) * values.shape[1]
            if np.sqrt(np.sum((values - design @ fit) ** 2) / free) > NOT_SMOOTH:
                continue
            away, step = self.white[k] - fit[0] - fit[1] * self.load[k], fit[2]
            share = float(np.clip(away @ step / max(float(step @ step), 1e-300), 0.0, 1.0))
            if np.linalg.norm(away - share * step) < np.sqrt(2.0) * self.bound:
                return True
        return False


__all__ = ["load_is_good", "outlier_readings", "reject_outliers"]
