"""Rows of one kind of experiment as readings that are judged: torque over motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from stiffcal.diagnosis.of_rows.row_candidates import row_candidates
from stiffcal.diagnosis.scans.candidates import Candidate
from stiffcal.errors import Progress, no_progress
from stiffcal.estimation.bins import Bins
from stiffcal.judgement.ground_of_rows import GroundOfRows
from stiffcal.judgement.judge import Judged, JudgedReadings, is_member, judge, name_of, weighed_about
from stiffcal.judgement.members import Member, list_members
from stiffcal.judgement.motion_sizes import MotionSizes
from stiffcal.judgement.numbers import EXPECTED_EFFECTS, MOST_BINS
from stiffcal.judgement.rivals import with_rivals_refitted
from stiffcal.judgement.rows_off import Off
from stiffcal.judgement.unlisted_motion import unlisted_motion_laws
from stiffcal.kinds.row_search import RowCourse, RowFit, RowProblem
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.effect import Effect


def judge_rows(
    problem: RowProblem, catalogue: Mapping[str, Effect], progress: Progress = no_progress, n_joints: int | None = None
) -> Judged:
    """Compare all sets of members that are worth it.

    Parameters
    ----------
    problem : the rows and the present model. catalogue : effects by name.
    progress : receives a description of each step.
    n_joints : joints of all problems of the campaign; None: of this one.
    """
    n_joints = n_joints or len(problem.joints)
    return judge(RowsOfCampaign.of(problem, catalogue, n_joints), problem.fit(problem.robot), progress)


@dataclass(frozen=True)
class RowsOfCampaign(JudgedReadings[RowFit]):
    """Rows of one problem, and what may be missing from a model of them."""

    problem: RowProblem
    """The rows."""
    common: CompliantRobot
    """What every hypothesis has."""
    candidates: Sequence[Candidate]
    """Effects of the catalogue at their places."""
    scale: MotionSizes
    """How large these usually are."""
    bins: Bins
    """Of the rows, which are judged as means."""
    course: RowCourse
    """In which order these were read."""
    expected: float
    """Effects beyond the present model that are missing at these joints."""

    @classmethod
    def of(cls, problem: RowProblem, catalogue: Mapping[str, Effect], n_joints: int) -> RowsOfCampaign:
        """Prepare; of what is missing in all each of so many joints has the same share."""
        robot = problem.robot
        bare = replace(robot, placed=tuple(placed for placed in robot.placed if not is_member(placed)))
        expected = EXPECTED_EFFECTS * len(problem.joints) / n_joints
        candidates, _ = row_candidates(problem, bare, catalogue)
        # what these rows cannot show is no question: where the model has it, every hypothesis does
        shown = {one.name for one in candidates}
        common = replace(robot, placed=tuple(one for one in robot.placed if name_of(one) not in shown))
        course = problem.course()
        bins = Bins.of(course.joint, 2 * course.group + (course.direction > 0.0), MOST_BINS)
        return cls(problem, common, candidates, MotionSizes.of(problem), bins, course.select(bins.first), expected)

    def judged_effects(self, robot: CompliantRobot) -> list[PlacedEffect]:
        """Return the effects of a model that these rows can show beyond what every hypothesis has."""
        common = {name_of(one) for one in self.common.placed}
        return [one for one in robot.placed if name_of(one) not in common]

    def about(self, fit: RowFit) -> RowsOfCampaign:
        """Return it as it is: nothing in it hangs on a fit."""
        return self

    def without(self, names: frozenset[str]) -> RowsOfCampaign:
        """Return it without some effects."""
        return replace(self, candidates=[one for one in self.candidates if one.name not in names])

    def fit(self, chosen: Sequence[Member], aside: frozenset[Off]) -> RowFit:
        """Return the fit of the model with some effects."""
        added = tuple(
            PlacedEffect(one.candidate.effect, one.candidate.place, dict(one.shape))
            for one in chosen
            if one.candidate is not None
        )
        return self.problem.fit(replace(self.common, placed=(*self.common.placed, *added)))

    def judged(self, fit: RowFit, chosen: frozenset[str], number: int, progress: Progress = no_progress) -> Judged:
        """Weigh sets about a model."""
        ground = self._ground(fit, fit)
        laws = unlisted_motion_laws(ground.state, self.problem.joints)
        members = list_members(ground, self.candidates, self.scale, laws, expected=self.expected, progress=progress)
        evidence = ground.evidence([one.columns for one in members])
        weighed, own = weighed_about(members, evidence, chosen, progress=progress)
        return Judged(weighed, fit, ground, chosen, own, number)

    def with_rivals(self, judged: Judged, fit: RowFit, aside: frozenset[Off]) -> Judged:
        """Return a judgement with the nearest rivals of its set refitted."""
        weighed = with_rivals_refitted(
            judged.weighed,
            judged.own,
            judged.ground,
            self.scale,
            lambda members: self._ground(self.fit(members, aside), fit),
        )
        return replace(judged, weighed=weighed)

    def _ground(self, fit: RowFit, best: RowFit) -> GroundOfRows:
        """Return what members are compared about: a fit, with the noise of that of the best set."""
        return GroundOfRows.of(fit, self.common, self.course, self.bins, self.bins.sigma(best.sigma))
