"""What counts as progress of a worker: computing, however long; not waiting, and not a plugin's endless call."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from stiffcal.batch.worker import Progress
from stiffcal.trust import running

LONG_S = 120.0
PLUGIN = "plugin-of-this-test.py"
ENDLESS = """
def terms(ended):
    while not ended.is_set():
        pass

def used_again_and_again(ended):
    while not ended.is_set():
        for _ in range(100_000):
            pass
        break
"""


@contextmanager
def thread_that(work: object, ended: threading.Event) -> Iterator[Progress]:
    thread = threading.Thread(target=work, args=(ended,), daemon=True)  # type: ignore[arg-type]
    thread.start()
    assert thread.ident is not None
    try:
        yield Progress(thread.ident)
    finally:
        ended.set()
        thread.join()


def compute(ended: threading.Event) -> None:
    while not ended.is_set():
        pass


def looked_until_computed(progress: Progress) -> str | None:
    """Look once this process has surely computed for a hundredth of a second since the last look."""
    until, deadline = time.process_time() - time.thread_time() + 0.01, time.monotonic() + LONG_S
    while time.process_time() - time.thread_time() < until and time.monotonic() < deadline:
        time.sleep(0.001)
    return progress.look()


def test_a_thread_that_computes_makes_progress_at_every_look() -> None:
    with thread_that(compute, threading.Event()) as progress:
        assert all(looked_until_computed(progress) is not None for _ in range(5))


def test_a_thread_that_waits_makes_none() -> None:
    with thread_that(threading.Event.wait, threading.Event()) as progress:
        progress.look()
        assert progress.look() is None


@pytest.fixture
def plugin(monkeypatch: pytest.MonkeyPatch) -> dict[str, object]:
    monkeypatch.setattr(running, "_running", {PLUGIN: "own.py"})
    names: dict[str, object] = {}
    exec(compile(ENDLESS, PLUGIN, "exec"), names)
    return names


def test_a_plugins_call_that_does_not_return_is_progress_once(plugin: dict[str, object]) -> None:
    with thread_that(plugin["terms"], threading.Event()) as progress:
        assert looked_until_computed(progress) == "terms of own.py"
        assert looked_until_computed(progress) is None


def test_a_plugin_that_is_called_again_makes_progress(plugin: dict[str, object]) -> None:
    use = plugin["used_again_and_again"]

    def fit(ended: threading.Event) -> None:
        while not ended.is_set():
            use(ended)  # type: ignore[operator]

    with thread_that(fit, threading.Event()) as progress:
        assert all(looked_until_computed(progress) is not None for _ in range(5))
