"""Tasks of a batch on this machine's cores: a process per core, one BLAS thread in each, one campaign at a time.

Memory is bounded: a process holds one campaign, and one that has grown large is replaced by a fresh one. A process that
is killed costs its task a second try in another.
"""

from __future__ import annotations

import json
import os
import queue
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable, Sequence
from contextlib import suppress

from stiffcal.batch.results import BROKEN, LOST, BatchTask, CampaignOutcome, outcome_of
from stiffcal.documents import document_of, result_from_values
from stiffcal.errors import Fault
from stiffcal.escapes.terminal import escaped
from stiffcal.fault_codes import FaultCode
from stiffcal.masking import mask
from stiffcal.module_path import child_environment, child_options, without_current_folder

ATTEMPTS = 2
LARGE_BYTES = 1 << 30
STOP_S = 5.0
LAST_BYTES = 4000
SAID, PLUGINS = b'{"said":', b'{"plugins":'
_NEW_GROUP = 0x200  # CREATE_NEW_PROCESS_GROUP of Windows
ONE_THREAD = dict.fromkeys(
    ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "BLIS_NUM_THREADS", "VECLIB_MAXIMUM_THREADS"), "1"
)
# The child finds stiffcal, and all else, where this process has found it; until then it takes nothing from the current
# folder.
_START = "import json, sys; sys.path[:] = json.loads(sys.argv[1]); from stiffcal.batch.worker import main; main()"


class WorkerLostError(Exception):
    """A worker process has ended in the middle of a task.

    Parameters
    ----------
    how : it ended. plugins : files of the campaign whose code it had begun to run.
    """

    def __init__(self, how: str, plugins: tuple[str, ...] = ()) -> None:
        super().__init__(how, plugins)
        self.how = how
        self.plugins = plugins

    def __str__(self) -> str:
        return self.how


class WorkerProcess:
    """A process of `stiffcal.batch.worker`. Used by one thread at a time."""

    def __init__(self) -> None:
        self._words = tempfile.TemporaryFile()  # noqa: SIM115  (closed by `stop`)
        windows = sys.platform == "win32"
        # Of a group of its own: Ctrl-C in a terminal reaches the one who started it, who then stops it in order.
        self._process: subprocess.Popen[bytes] = subprocess.Popen(
            [sys.executable, *child_options(), "-c", _START, json.dumps(without_current_folder(sys.path))],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._words,
            env={**child_environment(), **ONE_THREAD},
            process_group=None if windows else 0,
            creationflags=_NEW_GROUP if windows else 0,
        )

    @property
    def pid(self) -> int:
        """The process's number."""
        return self._process.pid

    def do(self, task: BatchTask) -> CampaignOutcome:
        """Have a task done; messages of the process meanwhile go to standard error.

        Raises
        ------
        WorkerLostError : the process ended before it answered, with its exit status and its last output; or it answered
            with something else than an outcome.
        """
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        line, plugins = b"", ()
        with suppress(OSError, ValueError):
            self._process.stdin.write(json.dumps(document_of(task)).encode() + b"\n")
            self._process.stdin.flush()
            while (line := self._process.stdout.readline()).startswith((SAID, PLUGINS)):
                if line.startswith(PLUGINS):
                    plugins = tuple(json.loads(line)["plugins"])
                    continue
                sys.stderr.write(escaped(mask(json.loads(line)["said"])) + "\n")
                sys.stderr.flush()
        if not line.endswith(b"\n"):
            raise WorkerLostError(self._last_words(), plugins)
        try:
            return result_from_values(CampaignOutcome, json.loads(line))
        except ValueError as error:  # of pydantic too
            raise WorkerLostError("its process returned something other than a result", plugins) from error

    def _last_words(self) -> str:
        try:
            code = self._process.wait(STOP_S)
        except subprocess.TimeoutExpired:
            return "its process stopped responding"
        # its end alone: of what a library or a campaign's code writes there the amount is unknown
        self._words.seek(max(0, self._words.seek(0, os.SEEK_END) - LAST_BYTES))
        lines = self._words.read(LAST_BYTES).decode("utf-8", "replace").split("\n")
        message = next((line.strip() for line in reversed(lines) if line.strip()), "")
        ending = f"was ended by signal {-code}" if code < 0 else f"ended with code {code}"
        return f"its process {ending}" + (f": {message}" if message else "")

    def stop(self) -> None:
        """End the process: what it is writing to a store is taken away or was complete."""
        with suppress(OSError):
            self._process.terminate()
        try:
            self._process.wait(STOP_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        for stream in (self._process.stdin, self._process.stdout, self._words):
            with suppress(OSError):
                if stream is not None:
                    stream.close()


class _Pool:
    """Threads that each keep one worker process busy, and the queues between them and the caller."""

    def __init__(self, tasks: Sequence[BatchTask]) -> None:
        self.waiting: queue.SimpleQueue[tuple[BatchTask, int]] = queue.SimpleQueue()
        self.outcomes: queue.SimpleQueue[CampaignOutcome | BaseException] = queue.SimpleQueue()
        for task in tasks:
            self.waiting.put((task, 1))
        self._lock = threading.Lock()
        self._workers: set[WorkerProcess] = set()
        self._stopped = False

    def keep_one_busy(self) -> None:
        """Start processes one after another and give them tasks, until none are left."""
        worker: WorkerProcess | None = None
        try:
            while not self._stopped:
                try:
                    task, attempt = self.waiting.get_nowait()
                except queue.Empty:
                    return
                worker = worker or self._started()
                try:
                    outcome = worker.do(task)
                except WorkerLostError as error:
                    self._ended(worker)
                    worker = None
                    self._again(task, attempt, error)
                    continue
                if (outcome.memory_bytes or 0) > LARGE_BYTES:
                    self._ended(worker)
                    worker = None
                self.outcomes.put(outcome)
        except BaseException as error:
            self.outcomes.put(error)
        finally:
            if worker is not None:
                self._ended(worker)

    def _again(self, task: BatchTask, attempt: int, error: WorkerLostError) -> None:
        """Try a task once more, after all others; give it up when that ended in the same way."""
        if attempt < ATTEMPTS:
            self.waiting.put((task, attempt + 1))
        else:
            self.outcomes.put(outcome_of_lost_worker(task, error))

    def _started(self) -> WorkerProcess:
        with self._lock:
            worker = WorkerProcess()
            self._workers.add(worker)
        return worker

    def _ended(self, worker: WorkerProcess) -> None:
        worker.stop()
        with self._lock:
            self._workers.discard(worker)

    def stop(self) -> None:
        """Stop all processes, each in the middle of whatever it does."""
        self._stopped = True
        with self._lock:
            workers = list(self._workers)
        stopping = [threading.Thread(target=worker.stop) for worker in workers]
        for thread in stopping:
            thread.start()
        for thread in stopping:
            thread.join()


def outcome_of_lost_worker(task: BatchTask, error: WorkerLostError) -> CampaignOutcome:
    """Return the outcome of a task whose process was lost each time; by its campaign's own code, where that ran."""
    mend = "check whether memory is short (fewer --jobs), and run it alone: stiffcal run DIR"
    reason = f"{error.how}, {ATTEMPTS} times"
    if not error.plugins:
        return outcome_of(task, LOST, Fault(FaultCode.PROCESS_LOST, task.folder, "", reason, mend))
    fault = Fault(
        FaultCode.PLUGIN_FAILED,
        ", ".join(error.plugins),
        "plugins",
        f"{reason}, after code of this campaign began to run",
        f"correct the code, or {mend}",
    )
    return outcome_of(task, BROKEN, fault)


def run_on_this_machine(tasks: Sequence[BatchTask], jobs: int, finished: Callable[[CampaignOutcome], None]) -> None:
    """Run tasks in parallel processes.

    Parameters
    ----------
    tasks : in the order in which they are begun.
    jobs : how many processes at most.
    finished : called with each outcome, in this thread, in the order in which they end.

    Raises
    ------
    KeyboardInterrupt : the user wants no more; all processes have been stopped by then.
    """
    pool = _Pool(tasks)
    threads = [threading.Thread(target=pool.keep_one_busy, daemon=True) for _ in range(min(jobs, len(tasks)))]
    try:
        for thread in threads:
            thread.start()
        for _ in tasks:
            finished(_next(pool.outcomes))
    finally:
        pool.stop()
    for thread in threads:
        thread.join()


def _next(outcomes: queue.SimpleQueue[CampaignOutcome | BaseException]) -> CampaignOutcome:
    while True:
        try:
            # Not without end: on Windows a waiting thread does not see Ctrl-C.
            outcome = outcomes.get(timeout=0.5)
        except queue.Empty:
            continue
        if isinstance(outcome, BaseException):
            raise outcome
        return outcome
