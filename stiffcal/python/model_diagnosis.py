"""What the diagnosis of a model answers in Python: the verdict, the effects that were tried, their evidence."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.python.campaign_answer import CampaignAnswer
from stiffcal.python.frames import frame_of, frame_of_rows, frame_of_table
from stiffcal.wording import place_label

if TYPE_CHECKING:
    import pandas as pd
    import pyarrow as pa

    from stiffcal.diagnosis.answers.results import DiagnoseResult, Finding, LookAlike, ProposedEffect
    from stiffcal.model.summary import EffectAt


class ModelDiagnosis(CampaignAnswer):
    """Whether a model is good enough, and which effect it lacks.

    Parameters
    ----------
    result : of ``diagnose``.
    evidence : the store's table ``evidence``; None where no effect has any.
    """

    result: DiagnoseResult

    def __init__(self, result: DiagnoseResult, evidence: pa.Table | None) -> None:
        super().__init__(result)
        self._evidence = evidence

    @property
    def adequate(self) -> bool | None:
        """Whether the model explains the readings to their noise; None where that cannot be judged."""
        return self.result.adequate

    @property
    def ranking(self) -> pd.DataFrame:
        """The effects that were tried, the best next step first; errors in held-out poses in m."""
        return frame_of_rows(
            (_finding(finding, self.result.explained_by(finding)) for finding in self.result.findings),
            ("effect", "place"),
        )

    @property
    def missing(self) -> pd.DataFrame:
        """The set of effects to add, in order, with their look-alikes in these poses (probabilities in brackets)."""
        return frame_of_rows(
            (
                {
                    "effect": proposed.effect,
                    "place": place_label(proposed.where),
                    "alternatives": "; ".join(_look_alike(proposed, other) for other in proposed.alternatives),
                }
                for proposed in self.result.missing
            ),
            ("effect", "place", "alternatives"),
        )

    def evidence(self, effect: str | None = None, place: str | None = None) -> pd.DataFrame:
        """Return the evidence for effects, state by state: the residual against what drives the effect.

        Parameters
        ----------
        effect : its name; None: all that have evidence.
        place : as in parameter names (``j4``); None: everywhere.

        Raises
        ------
        InputError : there is none for this effect or place.
        """
        if self._evidence is None:
            return frame_of(None)
        frame = frame_of_table(self._evidence)
        for column, wanted in (("effect", effect), ("place", place)):
            if wanted is not None:
                known_names = ", ".join(sorted(set(frame[column].astype(str))))
                frame = frame[frame[column] == wanted].reset_index(drop=True)
                if frame.empty:
                    reason = f"there is no evidence for {wanted}"
                    raise InputError.at(
                        FaultCode.EFFECT_ABSENT, "evidence", column, reason, f"choose {known_names or 'none'}"
                    )
        return frame

    def summary(self) -> str:
        """Return the verdict in words."""
        return self.result.summary

    def __repr__(self) -> str:
        return self.summary()


def _finding(finding: Finding, explained: float | None) -> dict[str, str | float | None]:
    before, after = finding.heldout_rms_before, finding.heldout_rms_after
    return {
        "effect": finding.effect,
        "place": place_label(finding.where),
        "verdict": finding.verdict,
        "explains": explained,
        "probability": finding.probability,
        "confidence": finding.confidence,
        "p_value": finding.p_value,
        "size_m": finding.size_m,
        "before_m": before.translation,
        "after_m": after.translation,
        "before_rad": before.rotation,
        "after_rad": after.rotation,
        "alternatives": _candidates(finding.alternatives),
        "why": finding.why,
    }


def _candidates(effects: Sequence[EffectAt]) -> str:
    return "; ".join(f"{effect.effect} {place_label(effect.where)}" for effect in effects)


def _look_alike(of: ProposedEffect, effect: LookAlike) -> str:
    p = of.probability_of(effect)
    alike = "" if p is None else f" ({p:.3f})"
    return f"{effect.effect} {place_label(effect.where)}{alike}"
