"""What the page of a live view asks for, and what it is answered."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict
from http import HTTPStatus
from pathlib import Path
from typing import TYPE_CHECKING

from stiffcal.documents import Document, result_from_values
from stiffcal.errors import InputError
from stiffcal.escapes.json_text import document_text
from stiffcal.live.choice import ModelChoice
from stiffcal.live.models import LiveModels, ModelChangedError, SupersededError
from stiffcal.live.server import LiveServer, RefusedError
from stiffcal.live.watching import LogWatcher
from stiffcal.view.page import build_page, build_waiting_page, pack

if TYPE_CHECKING:
    from stiffcal.stages.steps import RunContext


def live_server(folder: Path, context: RunContext, raw: bool = True, watch: bool = False) -> LiveServer:
    """Return the server of a campaign's page; it answers once its `LiveServer.serve` is called.

    Parameters
    ----------
    folder : the campaign folder. context : store and so on. raw : whether readings and names of logs are shown.
    watch : follow the logs while they are measured; some or all of them may still be missing.

    Raises
    ------
    InputError : the input is wrong.
    """
    models = LiveModels(folder, context, raw)
    watcher = LogWatcher(folder, models) if watch else None
    if watcher is None:
        models.content(ModelChoice())  # what is wrong with the campaign is reported by the command, not by the page

    def page() -> str:
        if watcher is None:
            return build_page(models.content(ModelChoice()), live=True)
        version = watcher.seen.version
        if not version:
            return build_waiting_page("")
        try:
            return build_page(models.content(ModelChoice()), live=True, watched=version)
        except InputError as error:  # too little has come for a fit
            return build_waiting_page(str(error.faults[0]), version)

    answers: dict[str, Callable[[Document], str]] = {
        "content": lambda asked: pack(models.content(_choice(asked), _page(asked))),
        "prepare": lambda asked: document_text({"forecasts": models.prepare(_page(asked))}),
        "forecast": lambda asked: _forecast(models, _choice(asked), _page(asked)),
        "diagnose": lambda asked: pack(models.diagnose(_choice(asked), _page(asked))),
        "write": lambda asked: _written(models, asked),
        "reload": lambda asked: _reloaded(models, asked),
        "leave": lambda asked: _left(models, asked),
        "progress": lambda asked: document_text(
            dict(zip(("doing", "share", "left"), models.doing(_page(asked)), strict=True))
        ),
    }
    if watcher is not None:
        answers["watched"] = lambda asked: document_text(asdict(watcher.seen))
    guarded = {name: _guarded(answer) for name, answer in answers.items()}
    return LiveServer(lambda: _answered(page), guarded, watcher)


def _guarded(answer: Callable[[Document], str]) -> Callable[[Document], str]:
    return lambda asked: _answered(lambda: answer(asked))


def _answered(make: Callable[[], str]) -> str:
    """Return an answer; what the user can mend, and what is no longer wanted, as a refusal that the page shows."""
    try:
        return make()
    except InputError as error:
        fault = error.faults[0]
        document = {"file": fault.file, "place": fault.place, "reason": fault.reason, "mend": fault.mend}
        raise RefusedError(HTTPStatus.UNPROCESSABLE_ENTITY, {"error": document}) from error
    except SupersededError as error:
        raise RefusedError(HTTPStatus.CONFLICT, {"superseded": True}) from error
    except ModelChangedError as error:
        raise RefusedError(HTTPStatus.CONFLICT, {"model_changed": True}) from error


def _page(asked: Document) -> str:
    """Return the name that the asking page has given itself."""
    return str(asked.get("page", ""))


def _choice(asked: Document) -> ModelChoice:
    """Return the choice of a request.

    Raises
    ------
    RefusedError : it is none.
    """
    from pydantic import ValidationError

    try:
        choice = result_from_values(ModelChoice, asked.get("choice", {}))
        choice.exclusions  # noqa: B018 - rows that are none are refused here
    except (ValidationError, InputError) as error:
        raise RefusedError(HTTPStatus.BAD_REQUEST, {"refused": "this is no choice of effects and rows"}) from error
    return choice


def _forecast(models: LiveModels, choice: ModelChoice, page: str) -> str:
    """Return a forecast, packed, "" where there is none; what the page asked for before ends, as the refit follows."""
    models.leave(page)
    model = models.forecast(choice)
    return "" if model is None else pack(model)


def _written(models: LiveModels, asked: Document) -> str:
    models.write(_choice(asked), to_changed_file=asked.get("to_changed_file") is True, page=_page(asked))
    return pack(models.content(ModelChoice(), _page(asked)))


def _reloaded(models: LiveModels, asked: Document) -> str:
    models.reload(_page(asked))
    return pack(models.content(ModelChoice(), _page(asked)))


def _left(models: LiveModels, asked: Document) -> str:
    models.leave(_page(asked))
    return ""
