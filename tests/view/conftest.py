"""A browser, and the contents of pages, for all tests of the page."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from stiffcal.commands.history import read_history
from stiffcal.stages.fit import up_to_date_fit
from stiffcal.stages.steps import RunContext, up_to_date_states
from stiffcal.stages.validation import up_to_date_validation
from stiffcal.view.gathering.content import view_content
from stiffcal.view.page import build_page
from tests.laboratory.browser import chromium, opened
from tests.laboratory.diagnosed_folders import SMALL, diagnosed_copy


@pytest.fixture(scope="package")
def browser() -> Iterator[Any]:
    """Debian's chromium; where CI is set it must be there. It has a loop of events run: closed before other tests."""
    with chromium() as started:
        yield started


@pytest.fixture(scope="session")
def content(tmp_path_factory: pytest.TempPathFactory) -> Any:
    folder, context = diagnosed_copy(SMALL, tmp_path_factory.mktemp("view") / "small"), RunContext()
    data = up_to_date_states(folder, context)
    identified = up_to_date_fit(data, context)
    made = view_content(data, identified, up_to_date_validation(data, identified, context), raw=True)
    return made, read_history(folder)


@pytest.fixture(scope="session")
def friction_content(tmp_path_factory: pytest.TempPathFactory) -> Any:
    folder, context = diagnosed_copy("joints/07", tmp_path_factory.mktemp("friction") / "07"), RunContext()
    data = up_to_date_states(folder, context)
    identified = up_to_date_fit(data, context)
    return view_content(data, identified, up_to_date_validation(data, identified, context), raw=True)


@pytest.fixture(scope="session")
def file(content: Any, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("page") / "view.html"
    path.write_text(build_page(content[0]), encoding="utf-8")
    return path


@pytest.fixture
def page(browser: Any, file: Path) -> Iterator[Any]:
    page, complaints = opened(browser, file)
    yield page
    assert complaints == []
    page.context.close()
