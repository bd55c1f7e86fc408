"""Places of targets, as absolute runs measure them: a kind of its own, with words of its own."""

from __future__ import annotations

from stiffcal.identification.readings.state_kinds import StateKind
from stiffcal.kinds import ExperimentKind
from stiffcal.kinds.absolute import KIND as ABSOLUTE
from stiffcal.kinds.absolute.state_kind import AbsoluteStateKind
from stiffcal.measurements.state_measures import StateMeasure


class SurveyedStateKind(AbsoluteStateKind):
    """Places that were surveyed."""

    name = "surveyed"
    runs = "surveyed poses"


class SurveyedKind(ExperimentKind):
    """Poses that were surveyed."""

    def state_kind(self) -> StateKind:
        """Return places, left out by region."""
        return SurveyedStateKind()


KIND = SurveyedKind("surveyed", default_model=ABSOLUTE.default_model, measures=StateMeasure.PLACE)
