"""What `improve` asks before a step: the reason, the expected error, the look-alikes; another effect, details, skip."""

from __future__ import annotations

from typing import TYPE_CHECKING

import typer

from stiffcal.show.effects import effect_words
from stiffcal.wording import deviation, explained_in_words, probability_in_words

if TYPE_CHECKING:
    from collections.abc import Callable

    from stiffcal.diagnosis.answers.results import Finding, LookAlike, ProposedEffect
    from stiffcal.model.summary import EffectAt
    from stiffcal.results.model_changes import Decision, EffectProposal

QUESTION = "yes, other, details, skip, quit"
WIDTH = 79


class ImproveDialog:
    """Asks about each change of the model.

    Attributes
    ----------
    write : takes a line for the terminal. ask : takes a question and its default, returns what was typed.
    """

    def __init__(self, write: Callable[[str], None], ask: Callable[[str, str], str] | None = None) -> None:
        self.write = write
        self.ask = ask or _prompt

    def __call__(self, proposal: EffectProposal) -> Decision:
        """Show a proposal and return what the user decides."""
        self._lines(_proposal_lines(proposal))
        while True:
            typed = self.ask(QUESTION, "yes").strip().lower()
            if typed and "yes".startswith(typed):
                return "yes"
            if typed and "skip".startswith(typed):
                return "skip"
            if typed in ("n", "no") or (typed and "quit".startswith(typed)):
                return "stop"
            if typed and "details".startswith(typed):
                self._lines(_detail_lines(proposal))
            elif typed and "other".startswith(typed):
                chosen = self._other(proposal)
                if chosen is not None:
                    return chosen
            else:
                self.write("type one of the words, or its first letter")

    def _other(self, proposal: EffectProposal) -> EffectAt | None:
        """Let the user choose another effect; None to go back."""
        others = other_effects(proposal)
        if not others:
            self.write("no other effect lowers the error in held-out poses")
            return None
        for number, effect in enumerate(others, 1):
            finding = proposal.diagnosed.finding_of(effect)
            after = f": {deviation(finding.heldout_rms_after)} rms in held-out poses" if finding is not None else ""
            self.write(f"  {number}  {effect_words(effect)}{after}")
        typed = self.ask("number of the effect, 0 to go back", "0").strip()
        number = int(typed) if typed.isdecimal() else 0
        return others[number - 1] if 0 < number <= len(others) else None

    def _lines(self, lines: list[str]) -> None:
        from stiffcal.cli.console import wrapped

        for line in lines:
            for piece in wrapped(line, WIDTH).split("\n"):
                self.write(piece)


def other_effects(proposal: EffectProposal) -> list[EffectAt]:
    """Return what could be added in place of a proposal: its look-alikes first, then what else lowers the error."""
    from stiffcal.model.summary import EffectAt

    if proposal.change == "remove":
        return []
    alternatives = getattr(proposal.effect, "alternatives", [])
    ranked = [item for item in proposal.diagnosed.findings if item.verdict != "rejected"]
    names, others = {(proposal.effect.effect, str(proposal.effect.where))}, []
    for item in (*alternatives, *ranked):
        if (item.effect, str(item.where)) not in names:
            names.add((item.effect, str(item.where)))
            others.append(EffectAt(effect=item.effect, where=item.where))
    return others


def _proposal_lines(proposal: EffectProposal) -> list[str]:
    name = effect_words(proposal.effect)
    if proposal.change == "remove":
        return ["", f"remove {name}?", "  reason: without it the error in held-out poses is no larger"]
    lines = ["", f"add {name}?"]
    finding = proposal.diagnosed.finding_of(proposal.effect)
    if finding is not None:
        reason = (finding.evidence.seen if finding.evidence is not None else "") or finding.why
        lines += [f"  reason: {reason}"] if reason else []
        before, after = deviation(finding.heldout_rms_before), deviation(finding.heldout_rms_after)
        lines.append(
            f"  expected error in held-out poses: {before} now, {after} with it{_explained(proposal, finding)}"
        )
    from stiffcal.diagnosis.answers.results import ProposedEffect

    alike = []
    if isinstance(proposal.effect, ProposedEffect):
        lines += _probability_lines(proposal.effect)
        alike = [_alike(proposal.effect, other) for other in proposal.effect.alternatives]
    lines.append(f"  look-alikes in these poses and loads: {', '.join(alike) or 'no other effect'}")
    return lines


def _probability_lines(effect: ProposedEffect) -> list[str]:
    own = effect.probability_of(effect)
    if own is None or effect.probability is None:
        return []
    certain = "certain" if effect.firm else "not certain"
    group = f", of it or a look-alike {probability_in_words(effect.probability)}" if effect.alternatives else ""
    return [f"  probability: {probability_in_words(own)}, {certain}{group}"]


def _alike(of: ProposedEffect, effect: LookAlike) -> str:
    """Return a look-alike with its probability, where one is stated."""
    p = of.probability_of(effect)
    return effect_words(effect) if p is None else f"{effect_words(effect)} {probability_in_words(p)}"


def _explained(proposal: EffectProposal, finding: Finding) -> str:
    explained = proposal.diagnosed.explained_by(finding)
    return "" if explained is None else f" ({explained_in_words(explained)} of the avoidable error)"


def _detail_lines(proposal: EffectProposal) -> list[str]:
    finding = proposal.diagnosed.finding_of(proposal.effect)
    if proposal.change == "remove" or finding is None:
        return ["  no further details"]
    lines = [f"  {finding.why}"] if finding.why and finding.evidence is None else []
    if finding.evidence is not None:
        parts = (finding.evidence.means, finding.evidence.check)  # what looks alike stands above
        lines += [f"  {text}" for text in parts if text]
    p = getattr(finding, "probability", None)
    if p is not None:
        lines.append(f"  probability {probability_in_words(p)} next to all other explanations")
    return lines or ["  no further details"]


def _prompt(question: str, default: str) -> str:
    return str(typer.prompt(question, default=default, err=True))
