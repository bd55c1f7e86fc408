"""Readings of one run that nothing explains: the worst is taken out, then the rest is looked at without it."""

from __future__ import annotations

from itertools import combinations, pairwise

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.reduction.loads.courses import LIKE_LOAD, Group, basis_of, smooth_course

MOST_SET_ASIDE = 0.34  # of the readings of one direction and branch: more is no accident but an effect
FEW = 12  # readings of a group of which two bumped ones can hide each other
NOT_SMOOTH = 2.5  # times the noise, left by a line with a jump: then it is not that


class ComparedReadings:
    """The readings of one run while bumped ones are taken out: white (n, k) over the noise, groups, what is kept."""

    def __init__(self, white: Floats, groups: list[Group], kept: Booleans, left: Integers, bound: float) -> None:
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

    def _roughness(self, group: Group, without: tuple[int, ...]) -> float:
        """Return the largest studentized residual of a group about its smooth course, some readings left out."""
        mask = self.kept[group.members] & ~np.isin(group.members, without)
        course = smooth_course(group, mask)
        if course is None or course.shape[0] <= course.shape[1]:
            return float(np.inf)
        return float(max(self._standardised_residuals(group.members[mask], course)))

    def _standardised_residuals(self, members: Integers, course: Floats) -> Floats:
        """Return (m,) studentized residuals of readings about their fit by ``course``, the (m, p) design matrix."""
        across, own = basis_of(course), self.white[members]
        residual = own - across @ (across.T @ own)
        return np.asarray(np.linalg.norm(residual, axis=1) / np.sqrt(np.maximum(1.0 - (across**2).sum(axis=1), 0.05)))

    def _course_residuals(self) -> dict[int, float]:
        """Return reading to its studentized residual about its group's smooth course."""
        lengths: dict[int, float] = {}
        for group in self.groups:
            mask = self.kept[group.members]
            course = smooth_course(group, mask)
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
            alike = self._off_repeats(neighbour)
            for j, away in off.items():
                near = min(2.0 * self.bound, 0.5 * float(np.linalg.norm(away)))
                # repeats of one and the same other cycle
                if any(i in alike and np.linalg.norm(away - alike[i]) < near for i in (j - 1, j, j + 1)):
                    return True
        return False

    def _other_branch_agrees(self, k: int) -> bool:
        """Without repeats: whether the other branch shows the same at like load, as nearly as branches do here."""
        own = self._gaps(self.group_of[k], k)
        if not own.size:
            return True  # nothing to compare with: no verdict
        if own.min() <= 2.0 * self.bound:
            return True
        others = np.concatenate([self._gaps(group, without=k) for group in self.groups if group.loaded])
        return bool(others.size and own.min() <= 3.0 * np.median(others))

    def _gaps(self, group: Group, k: int | None = None, without: int | None = None) -> Floats:
        """Return (p,) how far readings of a group are from those of the other branch at like load.

        Parameters
        ----------
        k : this reading alone; None: all that are kept. without : this reading is left out.
        """
        gaps = [np.zeros(0)]
        for other in self.groups:
            if other.direction != group.direction or other is group or not other.loaded:
                continue
            slope = self._slope(np.concatenate([group.members, other.members]))
            kept, others = group.members[self.kept[group.members]], other.members[self.kept[other.members]]
            kept = kept[kept == k] if k is not None else kept[kept != without]
            load = np.array([self.load[int(i)] for i in kept])[:, None] - np.array([self.load[int(j)] for j in others])
            i, j = np.nonzero(np.abs(load) <= LIKE_LOAD)
            away = self.white[kept[i]] - self.white[others[j]] - slope * load[i, j][:, None]
            gaps.append(np.linalg.norm(away, axis=1))
        return np.concatenate(gaps)

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
