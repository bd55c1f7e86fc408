"""Every test's faults and answers are looked through for TOML that is offered and cannot be pasted."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import pytest

from stiffcal.cli import answers
from stiffcal.errors import Fault
from stiffcal.escapes.json_text import document_text
from tests.laboratory.offered_toml import faults_in

_TEXTS: list[str] = []


def texts_of(document: object) -> Iterator[str]:
    """Yield the texts of a JSON document; a list of texts is one, with a line for each."""
    if isinstance(document, str):
        yield document
    elif isinstance(document, Mapping):
        for value in document.values():
            yield from texts_of(value)
    elif isinstance(document, list | tuple):
        if document and all(isinstance(entry, str) for entry in document):
            yield "\n".join(document)
        else:
            for value in document:
                yield from texts_of(value)


@pytest.fixture(scope="session")
def _watched() -> Iterator[None]:
    """Keep what faults advise, what is written to standard error, and the JSON documents."""
    own = pytest.MonkeyPatch()
    begin, notify, write = Fault.__post_init__, answers.Answer.notify, document_text

    def begun(self: Fault) -> None:
        begin(self)
        _TEXTS.append(self.mend)

    def notified(self: answers.Answer, text: str, level: str = "INFO") -> None:
        _TEXTS.append(text)
        notify(self, text, level)

    def written(document: Any) -> str:
        _TEXTS.extend(texts_of(document))
        return write(document)

    own.setattr(Fault, "__post_init__", begun)
    own.setattr(answers.Answer, "notify", notified)
    own.setattr(answers, "document_text", written)
    yield
    own.undo()


def forget_offers() -> None:
    """Let what was offered so far count for nothing."""
    _TEXTS.clear()


@pytest.fixture(autouse=True)
def _offers(_watched: None) -> Iterator[None]:
    """Fail a test in which something was offered that none of our files takes."""
    yield
    texts = list(dict.fromkeys(_TEXTS))
    _TEXTS.clear()
    wrong = [fault for text in texts for fault in faults_in(text)]
    assert not wrong, "cannot be pasted: " + "\n".join(wrong)
