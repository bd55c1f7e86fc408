"""What the present model holds and the fit before it did not: the page for a browser opens on it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from stiffcal.diagnosis.answers.results import DiagnoseResult
from stiffcal.model.summary import ModelSummary, Where
from stiffcal.stages.history import stored_fits
from stiffcal.stages.steps import DIAGNOSE, Ingested, key_of_table, stored_result
from stiffcal.view.content import ViewChange, ViewEvidence, ViewModel
from stiffcal.view.gathering.models import place_words
from stiffcal.wording import count

if TYPE_CHECKING:
    from stiffcal.results.identify_result import IdentifyResult


@dataclass(frozen=True, kw_only=True)
class LastAdded:
    """The effects that the present fit has more than an earlier one of the same readings."""

    before: str = ""
    """Id of the earlier model on the page; "" where there is none."""
    names: list[str] = field(default_factory=list)
    """``effect place``."""

    @classmethod
    def of(cls, data: Ingested, identified: IdentifyResult) -> LastAdded:
        """Compare the present fit with the last other one whose effects are all in the present model.

        A model that was fitted earlier, lost an effect and got it back stands in the history where it was first fitted:
        the fits after it were made before it became the present one again.

        Parameters
        ----------
        data : the campaign. identified : the present fit.
        """
        fits, states_key = stored_fits(data.store), key_of_table(data.table)
        at = next((number for number, fit in enumerate(fits) if fit.id == identified.fit_id), 0)
        present = _names(fits[at].model) if fits else []
        for fit in reversed([*fits[:at], *fits[at + 1 :]]):
            earlier = _names(fit.model)
            if fit.states_key == states_key and {*earlier} < {*present}:
                return cls(before=f"fit{fit.id}", names=[name for name in present if name not in earlier])
        return cls()

    def remarked(self, models: Sequence[ViewModel]) -> list[ViewModel]:
        """Return the models; the present one with a remark where what was added lowers no error, or costs values.

        Parameters
        ----------
        models : of the page.
        """
        before = next((model for model in models if model.id == self.before), None)
        if before is None or not self.names:
            return list(models)
        return [replace(one, remark=_cost_in_words(before, one)) if one.present else one for one in models]

    def change(self, models: Sequence[ViewModel], evidence: Sequence[ViewEvidence]) -> ViewChange | None:
        """Return where the page shows what was added; None where the model before it cannot be drawn.

        What the diagnosis read of an added effect comes first, else what explained most of the earlier residual, if
        anything did.

        Parameters
        ----------
        models : of the page. evidence : of the page.
        """
        before = next((model for model in models if model.id == self.before), None)
        if before is None or (before.residual_heldout is None and before.residual_fit is None):
            return None
        read = next(((one, k) for name in self.names for k, one in enumerate(evidence) if one.name == name), None)
        if read is not None:
            return ViewChange(
                before=self.before, added=self.names, variable=read[0].variable, component=f"e{read[1] + 1}"
            )
        variable, component = (before.shares[0].variable, before.shares[0].component) if before.shares else ("", "")
        return ViewChange(before=self.before, added=self.names, variable=variable, component=component)


FALLS = 0.99
"""Share of the error before to which it falls at least where it is said to fall. Of 5000 readings the rms itself is
known to a hundredth (1 / √(2 n)): a fall by less is no gain that new readings would show. It words a remark alone."""


def _cost_in_words(before: ViewModel, after: ViewModel) -> str:
    """Return what an effect does not gain, or costs, in a sentence; "" where the error falls and all values stay known.

    Examples
    --------
    >>> from stiffcal.measurements.rms import Rms
    >>> from stiffcal.view.content import ViewValue
    >>> stiff = ViewValue(name="joint-compliance.j1.c", unit="N·m/rad", value=1e6, text="1.00·10⁶")
    >>> rms = Rms(translation=1e-5, rotation=None)
    >>> before = ViewModel(id="fit1", kind="fit", label="", short="", heldout_rms=rms, values=[stiff])
    >>> _cost_in_words(before, before)
    'The error does not fall.'
    >>> lost = replace(before, values=[replace(stiff, value=None, is_identified=False)])
    >>> _cost_in_words(before, lost).partition(":")[0]
    'The error does not fall, and 1 value that was identified is not any more'
    """
    old, new = (dict(model.heldout_rms.items()) if model.heldout_rms else {} for model in (before, after))
    shared = [(value, new.get(name)) for name, value in old.items() if value is not None]
    falls = not shared or any(now is not None and now < FALLS * value for value, now in shared)
    known = {one.name for one in before.values if one.value is not None}
    lost = sum(not one.is_identified for one in after.values if one.name in known)
    words = [] if falls else ["the error does not fall"]
    if lost:
        words.append(
            f"{count(lost, 'value')} that {'was' if lost == 1 else 'were'} identified {_be(lost)} not any more"
        )
    if not words:
        return ""
    why = ": these data do not distinguish what was added from what the model held" if lost else ""
    sentence = ", and ".join(words)
    return f"{sentence[0].upper()}{sentence[1:]}{why}."


def _be(number: int) -> str:
    return "is" if number == 1 else "are"


def diagnosis_of_states(data: Ingested) -> DiagnoseResult | None:
    """Return the stored diagnosis, of whatever fit to the present states: what it read of each state can be drawn.

    Parameters
    ----------
    data : the campaign.
    """
    diagnosis = stored_result(data.store, DIAGNOSE, DiagnoseResult)
    if diagnosis is None:
        return None
    keys = [fit.states_key for fit in stored_fits(data.store) if fit.id == diagnosis.fit_id]
    return diagnosis if key_of_table(data.table) in keys else None


def _names(model: ModelSummary) -> list[str]:
    """Return the effects of a model at each of their places, "effect place"."""
    return [f"{effect.type} {place_words(where)}" for effect in model.effects for where in _single(effect.where)]


def _single(where: Where) -> list[Where]:
    """Return each place by itself."""
    places = [
        *(Where(joints=[joint]) for joint in where.joints or ()),
        *(Where(links=[link]) for link in where.links or ()),
        *(Where(pairs=[pair]) for pair in where.pairs or ()),
    ]
    return places or [Where()]
