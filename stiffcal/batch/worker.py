"""What a worker process of a batch does: it works through tasks, and reports what it is at.

Messages are JSON. One that comes is a task; each is answered with its outcome. Before it go messages with keys of their
own: ``said``, a line to be shown at once, because standard error is not; ``plugins``, the names of files whose code
runs next; ``step`` with ``steps``, the step that begins and those that have ended; and ``progress``, where the work is,
every half second in which it moves on.
"""

from __future__ import annotations

import json
import sys
import threading
import time
from contextlib import suppress
from types import FrameType

from stiffcal.documents import Document
from stiffcal.module_path import quiet_libraries
from stiffcal.processes import Channel
from stiffcal.trust.running import display_name_of

# Short against the time after which a process without progress is given up, s.
_LOOK_S = 0.5
# A loop that looks ten times a second whether something has come computes a quarter of this meanwhile (measured); a
# computation that gets a hundredth of a processor five times as much, s.
_LEAST_S = 1e-3


def work(channel: Channel) -> None:
    """Work through the tasks that come."""
    quiet_libraries()
    reporter = threading.Thread(target=_report_progress, args=(channel, threading.get_ident()), daemon=True)
    reporter.start()
    from stiffcal.batch.task import run_task
    from stiffcal.documents import document_of, result_from_values
    from stiffcal.results.batch_results import BatchStep, BatchTask
    from stiffcal.trust.notices import notices_to
    from stiffcal.trust.running import before_plugin_code

    def begin_step(step: str, steps: dict[str, BatchStep]) -> None:
        _send(channel, {"step": step, "steps": {name: document_of(done) for name, done in steps.items()}})

    # This process's standard error is not shown: what started it prints the line instead.
    notices_to(lambda line: _send(channel, {"said": line}))
    # A process that ends from now on has probably been ended by that code.
    before_plugin_code(lambda files: _send(channel, {"plugins": list(files)}))
    for request in channel.requests():
        task = result_from_values(BatchTask, json.loads(request))
        _send(channel, document_of(run_task(task, begin_step)))


def _send(channel: Channel, document: Document) -> None:
    from stiffcal.escapes.json_text import document_text

    channel.send(document_text(document, indent=None).encode())


def _report_progress(channel: Channel, worker: int) -> None:
    progress = Progress(worker)
    while True:
        time.sleep(_LOOK_S)
        place = progress.look()
        if place is not None:
            with suppress(OSError):  # nobody listens any more
                _send(channel, {"progress": place})


class Progress:
    """Whether the work of a thread moves on, from one look at it to the next.

    It does where this process has computed meanwhile: a fit computes, however long it takes, and so does what reads a
    log from a slow disk. What waits for something that does not come does not. A call of a plugin that has not returned
    since the last look is no progress, though it may compute without end.

    Parameters
    ----------
    worker : the thread's identifier.
    """

    def __init__(self, worker: int) -> None:
        self._worker = worker
        self._computed_s = _computed_s()
        # held: another call at the same address would else look the same
        self._call: FrameType | None = None

    def look(self) -> str | None:
        """Return where the thread is; None where its work has not moved on since the last look."""
        call_before, computed_before = self._call, self._computed_s
        place, self._call = _place(sys._current_frames().get(self._worker))
        self._computed_s = _computed_s()
        has_computed = self._computed_s - computed_before >= _LEAST_S
        return place if has_computed and (self._call is None or self._call is not call_before) else None


def _computed_s() -> float:
    """Return the processor time of this process without that of the present thread, s."""
    return time.process_time() - time.thread_time()


def _place(frame: FrameType | None) -> tuple[str, FrameType | None]:
    """Return where a thread is: the innermost function of stiffcal's, or a plugin's outermost with its call."""
    place, call = "", None
    while frame is not None:
        file, function = display_name_of(frame.f_code.co_filename), frame.f_code.co_qualname
        module = str(frame.f_globals.get("__name__", ""))
        if file is not None:
            place, call = f"{function} of {file}", frame
        elif not place and module.startswith("stiffcal."):
            place = f"{module}.{function}"
        frame = frame.f_back
    return place, call
