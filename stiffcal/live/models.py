"""Models of one campaign that are tried in memory: forecast, refit, what is left, and the way into model.toml."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from threading import Lock
from typing import TYPE_CHECKING, TypeVar

from stiffcal.campaign.loading import load_campaign
from stiffcal.campaign.model.model_file import model_of_text
from stiffcal.commands.diagnose import diagnose_campaign
from stiffcal.commands.edit_model import change_model
from stiffcal.errors import Progress
from stiffcal.live.choice import ModelChoice, model_of_choice, placed_name
from stiffcal.live.forecasts import Forecasts
from stiffcal.presentation.time_left import TimeLeft
from stiffcal.stages.diagnoses.current import current_diagnosis, keep_diagnosis
from stiffcal.stages.fit import up_to_date_fit
from stiffcal.stages.steps import (
    Ingested,
    RunContext,
    TrialModel,
    ignore_note,
    model_text,
    open_store,
    up_to_date_states,
)
from stiffcal.stages.validation import up_to_date_results
from stiffcal.store.trial import TrialResults
from stiffcal.view.content import ViewContent, ViewForecast, ViewLive, ViewModel
from stiffcal.view.gathering.change import LastAdded
from stiffcal.view.gathering.content import EarlierVerdict, view_content

if TYPE_CHECKING:
    from stiffcal.arrays import Integers
    from stiffcal.diagnosis.answers.results import DiagnoseResult

T = TypeVar("T")

MOST_KEPT = 12
"""Models that were tried and stand on the ladder; each keeps its residuals in memory."""
OF_FILE = "the model in model.toml"
OF_EARLIER_LOGS = "the logs before"
OF_EARLIER_MODEL = "the model before"
OF_ANOTHER_PAGE = "another page of this server computes"


class SupersededError(Exception):
    """Something else was asked for before this was done."""


class ModelChangedError(Exception):
    """The file model.toml is no longer what the page was made from."""


@dataclass
class _Tried:
    """A model that is tried, with what was computed of it so far."""

    trial: TrialModel
    """The model, and its results in memory."""
    id: str
    """Of its rung."""
    rows: str
    """Which rows are left out, `ModelChoice.rows_key`."""
    rung: ViewModel | None = None
    """On the ladder, once it was fitted."""


class LiveModels:
    """The models that a page tries; one at a time, the last that was asked for.

    Parameters
    ----------
    folder : the campaign folder.
    context : store and so on. What is tried stays in memory; fits of model.toml itself are stored as `identify` does.
    raw : whether readings and names of logs are shown.

    Raises
    ------
    InputError : the folder holds no campaign.
    """

    def __init__(self, folder: Path, context: RunContext, raw: bool = True) -> None:
        self._folder, self._context, self._raw = folder, context, raw
        self._lock, self._serials = Lock(), itertools.count(1)
        self._latest: dict[str, int] = {}
        self._numbers = itertools.count(1)
        self._tried: dict[str, _Tried] = {}
        self._forecasts: Forecasts | None = None
        self._base: tuple[str | None, tuple[ViewContent, DiagnoseResult | None]] | None = None
        self._earlier: EarlierVerdict | None = None
        self._text = self._text_now()
        self._doing: tuple[str | None, int, str, float | None] = (None, 0, "", None)
        self._time_left = TimeLeft()

    def doing(self, page: str) -> tuple[str, float | None, str]:
        """Return what is done of what a page asked for last, the share, and in words how long it still takes.

        "" while something earlier still ends.

        Parameters
        ----------
        page : as in `content`.
        """
        of, serial, text, share = self._doing
        if text and of != page:
            return OF_ANOTHER_PAGE, None, ""
        if serial != self._latest.get(page):
            return "", None, ""
        return text, share, self._time_left.in_words(share)

    def content(self, choice: ModelChoice, page: str | None = None) -> ViewContent:
        """Return all that the page shows of a model: fitted, and judged in held-out data.

        Parameters
        ----------
        choice : what is ticked.
        page : a name of the page that asks: what it asked for before ends, what others asked for is waited for. None
            of what nothing ends.

        Raises
        ------
        InputError : the input is wrong, or the model cannot be fitted.
        SupersededError : something else was asked for meanwhile.
        ModelChangedError : model.toml was changed by somebody else.
        """
        return self._alone(lambda progress: self._content(choice, progress), page)

    def prepare(self, page: str | None = None) -> bool:
        """Try what the page offers once, so that forecasts can be made; return whether these data have any.

        Parameters
        ----------
        page : as in `content`.

        Raises
        ------
        InputError, SupersededError : as `content`.
        """

        def run(progress: Progress) -> bool:
            context = replace(self._context, progress=progress)
            content, _ = self._base_content(context)
            data = up_to_date_states(self._folder, context)
            identified = up_to_date_fit(data, context)
            if self._forecasts is None or self._forecasts.key != identified.key:
                self._forecasts = Forecasts.of(data, identified, content, context)
            self._forecasts.try_each([one.name for one in content.candidates], progress)
            return self._can_forecast

        return self._alone(run, page)

    @property
    def _can_forecast(self) -> bool:
        return self._forecasts is not None and bool(self._forecasts.pages)

    def forecast(self, choice: ModelChoice) -> ViewForecast | None:
        """Return what one linear step about the fit of model.toml leaves; at once, whatever else is computed.

        None where no forecast can be made: none is prepared, rows are left out, or these data have none.
        """
        made = self._forecasts
        return None if made is None or choice.excluded else made.forecast(choice)

    def diagnose(self, choice: ModelChoice, page: str | None = None) -> ViewContent:
        """Diagnose a model, and return all that the page shows of it.

        Parameters
        ----------
        choice, page : as in `content`.

        Raises
        ------
        InputError, SupersededError, ModelChangedError : as `content`.
        """

        def run(progress: Progress) -> ViewContent:
            self._check_unchanged()
            diagnose_campaign(self._folder, self._context_of(choice, progress))
            return self._content(choice, progress)

        return self._alone(run, page)

    def write(self, choice: ModelChoice, to_changed_file: bool = False, page: str | None = None) -> None:
        """Write what is ticked into model.toml, as `stiffcal add` and `stiffcal remove` do; comments stay.

        The diagnosis of the model before is shown until there is one of the new model.

        Parameters
        ----------
        choice, page : as in `content`.
        to_changed_file : also where somebody else has changed model.toml: what is ticked is then added to that.

        Raises
        ------
        ModelChangedError : model.toml has changed, and ``to_changed_file`` is False; nothing is written.
        InputError : it cannot be written, or not all of it fits the model there; nothing is written then.
        """

        def run(progress: Progress) -> None:
            is_changed = self._text_now() != self._text
            if is_changed and not to_changed_file:
                raise ModelChangedError
            model_of_choice(load_campaign(self._folder, check_files=False), self._text_now(), choice)
            for action, names in (("remove", choice.removed), ("add", choice.added)):
                for name in names:
                    campaign = load_campaign(self._folder, check_files=False)
                    effect, where = placed_name(campaign, name)
                    change_model(campaign, "add" if action == "add" else "remove", effect, where=where)
            tried, earlier = self._tried.get(choice.key), self._judged(OF_EARLIER_MODEL, same_states=True)
            self._begin_anew()
            self._earlier = None if is_changed else earlier
            if tried is not None and not is_changed:
                context = replace(self._context, progress=progress)
                data = up_to_date_states(self._folder, context)
                keep_diagnosis(data, up_to_date_fit(data, context), tried.trial.results)

        self._alone(run, page)

    def reload(self, page: str | None = None) -> None:
        """Take the campaign as it is now; what was tried is forgotten.

        Parameters
        ----------
        page : as in `content`.
        """
        self._alone(lambda progress: self._begin_anew(), page)

    def leave(self, page: str) -> None:
        """Have what a page asked for end at its next report of progress: it was closed, or is loaded anew.

        Parameters
        ----------
        page : as in `content`.
        """
        self._latest[page] = next(self._serials)

    def take_runs(self, runs: frozenset[str], store: str) -> None:
        """Work with these runs from now on, once what is being computed is done; what was tried is forgotten.

        The diagnosis of the runs before is shown until there is one of these, as long as the model is the same.

        Parameters
        ----------
        runs : their names. store : that holds what was read of them.
        """
        with self._lock:
            # that other readings are fitted anew is what the page is there for
            self._context = replace(self._context, runs=runs, store=store, notify=ignore_note)
            earlier, text = self._judged(OF_EARLIER_LOGS, same_states=False) or self._earlier, self._text
            self._begin_anew()
            self._earlier = earlier if text == self._text else None

    def _alone(self, run: Callable[[Progress], T], page: str | None = None) -> T:
        """Run something when nothing else runs; what the page asked for before ends at its next report of progress."""
        serial = next(self._serials)
        if page is not None:
            self._latest[page] = serial

        def check() -> None:
            if page is not None and serial != self._latest[page]:
                raise SupersededError

        def progress(text: str, share: float | None = None) -> None:
            check()
            self._time_left.reached(share)
            self._doing = (page, serial, text, share)

        with self._lock:
            check()
            self._time_left = TimeLeft()
            try:
                return run(progress)
            finally:
                self._doing = (page, serial, "", None)

    def _check_unchanged(self) -> None:
        if self._text_now() != self._text:
            raise ModelChangedError

    def _text_now(self) -> str:
        return model_text(load_campaign(self._folder, check_files=False))

    def _judged(self, of: str, *, same_states: bool) -> EarlierVerdict | None:
        """Return the diagnosis that is shown of model.toml, as one that is shown next to something else."""
        diagnosis = None if self._base is None else self._base[1][1]
        return None if diagnosis is None else EarlierVerdict(diagnosis=diagnosis, of=of, same_states=same_states)

    def _begin_anew(self) -> None:
        self._text, self._forecasts, self._base = self._text_now(), None, None
        self._earlier = None
        self._tried.clear()

    def _context_of(self, choice: ModelChoice, progress: Progress) -> RunContext:
        context = replace(self._context, progress=progress)
        return replace(context, trial=self._tried_model(choice).trial) if choice.key != ModelChoice().key else context

    def _tried_model(self, choice: ModelChoice) -> _Tried:
        known = self._tried.pop(choice.key, None)
        if known is None:
            campaign = load_campaign(self._folder, check_files=False)
            text = model_of_choice(campaign, self._text, choice)
            model = model_of_text(text, campaign.chain.n_joints) if text else campaign.model
            trial = TrialModel(text, model, TrialResults(), choice.exclusions)
            known = _Tried(trial, f"tried{next(self._numbers)}", choice.rows_key)
        self._tried[choice.key] = known  # the last that was asked for stands last
        for key in list(self._tried)[:-MOST_KEPT]:
            del self._tried[key]
        return known

    def _content(self, choice: ModelChoice, progress: Progress) -> ViewContent:
        self._check_unchanged()
        context = replace(self._context, progress=progress)
        base, judged = self._base_content(context)
        live = ViewLive(
            added=choice.added,
            removed=choice.removed,
            excluded=[one.as_toml() for one in choice.excluded],
            forecasts=self._can_forecast and not choice.excluded,
        )
        if choice.key == ModelChoice().key:
            return replace(base, models=with_tried(base.models, self._rungs(choice)), live=live)
        tried = self._tried_model(choice)
        earlier = self._earlier
        if judged is not None:
            earlier = EarlierVerdict(diagnosis=judged, of=OF_FILE, same_states=not choice.excluded)
        drawn = None if base.states is None or choice.excluded else base.states.index
        content, _ = self._content_of(replace(context, trial=tried.trial), earlier, drawn, base)
        present, label = next(model for model in content.models if model.present), f"tried: {choice.label}"
        is_candidate = not choice.removed and not choice.excluded
        effect = ", ".join(choice.added) if is_candidate else ""
        tried.rung = replace(present, id=tried.id, label=label, short="tried", effect=effect)
        added = LastAdded(before=next(model.id for model in base.models if model.present), names=choice.added)
        fits = [replace(model, present=False) for model in base.models if model.kind == "fit"]
        if choice.excluded:
            fits = [replace(model, residual_fit=None, residual_heldout=None) for model in fits]
        models = added.remarked([*fits, *self._rungs(choice), tried.rung])
        return replace(content, models=models, change=added.change(models, content.evidence), live=live)

    def _base_content(self, context: RunContext) -> tuple[ViewContent, DiagnoseResult | None]:
        """Return what the page shows of model.toml; made again where the store has changed."""
        known = self._base
        if known is None or known[0] != open_store(self._folder, context).generation:
            # other readings may have come: of the page before only the robot is the same
            alike = None if known is None else replace(known[1][0], runs=[])
            made = self._content_of(context, self._earlier, None, alike)
            self._base = known = (open_store(self._folder, context).generation, made)
        return known[1]

    def _rungs(self, choice: ModelChoice) -> list[ViewModel]:
        """Return the models that were tried before, as the page draws them next to a model."""
        rungs = [
            (replace(tried.rung, present=False), tried.rows)
            for key, tried in self._tried.items()
            if tried.rung is not None and key != choice.key
        ]
        return [
            rung if rows == choice.rows_key else replace(rung, residual_fit=None, residual_heldout=None)
            for rung, rows in rungs
        ]

    def _content_of(
        self, context: RunContext, earlier: EarlierVerdict | None, drawn: Integers | None, alike: ViewContent | None
    ) -> tuple[ViewContent, DiagnoseResult | None]:
        """Return what the page shows of the context's model, and the diagnosis of it that is stored."""
        data: Ingested = up_to_date_states(self._folder, context)
        identified, validation = up_to_date_results(data, context)
        content = view_content(data, identified, validation, self._raw, earlier, drawn, alike)
        return content, current_diagnosis(data, identified)[0]


def with_tried(models: Sequence[ViewModel], tried: Sequence[ViewModel]) -> list[ViewModel]:
    """Return the models of a page with those that were tried, after the fits and before the refits of the diagnosis.

    A linear refit of what was tried is left out: of one model there is one error.
    """
    known = {_effects(model) for model in tried if model.effect}
    fits = [model for model in models if model.kind == "fit"]
    refits = [model for model in models if model.kind != "fit"]
    return [*fits, *tried, *(one for one in refits if one.kind == "without" or _effects(one) not in known)]


def _effects(model: ViewModel) -> frozenset[str]:
    return frozenset(model.effect.split(", "))
