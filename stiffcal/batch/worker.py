"""A process that works through tasks: a line of JSON on standard input is a task, one on standard output its outcome.

Between them are lines of messages to be shown at once, ``{"said": …}``: its standard error is not shown; and
before code of a campaign runs, the names of its files, ``{"plugins": …}``.

Why not multiprocessing: its children import the caller's main script again, a killed one breaks the whole pool, and
tasks travel as pickles. A line of text is the same to another local process and to one that a cluster started.
"""

from __future__ import annotations

import json
import os
import queue
import signal
import sys
import threading
from typing import IO

from stiffcal.documents import Document
from stiffcal.module_path import quiet_libraries


def main() -> None:
    """Work until standard input ends."""
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    quiet_libraries()
    # What a plugin prints must not get between the outcomes.
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    tasks: queue.SimpleQueue[str] = queue.SimpleQueue()
    threading.Thread(target=_listen, args=(sys.stdin, tasks), daemon=True).start()
    from stiffcal.batch.results import BatchTask
    from stiffcal.batch.task import run_task
    from stiffcal.documents import document_of, result_from_values
    from stiffcal.escapes.json_text import document_text
    from stiffcal.trust.notices import notices_to
    from stiffcal.trust.running import before_plugin_code

    def answer(document: Document) -> None:
        answers.write(document_text(document, indent=None) + "\n")
        answers.flush()

    # This process's standard error is not shown: what started it prints the line instead.
    notices_to(lambda line: answer({"said": line}))
    # A process that ends from now on has probably been ended by that code.
    before_plugin_code(lambda files: answer({"plugins": list(files)}))
    try:
        while True:
            answer(document_of(run_task(result_from_values(BatchTask, json.loads(tasks.get())))))
    except (KeyboardInterrupt, BrokenPipeError):
        # Asked to stop: what was being written has been taken away by now.
        os._exit(130)


def _listen(stream: IO[str], tasks: queue.SimpleQueue[str]) -> None:
    """Hand on tasks. When the sender is gone nobody wants an answer, and a store is whole whenever a writer ends."""
    for line in stream:
        tasks.put(line)
    os._exit(0)


if __name__ == "__main__":
    main()
