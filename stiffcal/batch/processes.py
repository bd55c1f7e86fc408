"""Tasks of a batch on this machine's cores: a process per core, one BLAS thread in each, one campaign at a time.

Memory is bounded: a process holds one campaign, and one that has grown large is replaced by a fresh one. A process that
is killed costs its task a second try in another; one that makes no progress is ended, and its campaign is lost.
"""

from __future__ import annotations

import json
import queue
import sys
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

from stiffcal.batch.worker import work
from stiffcal.documents import document_of, result_from_values
from stiffcal.errors import Fault
from stiffcal.escapes.terminal import escaped
from stiffcal.fault_codes import FaultCode
from stiffcal.masking import mask
from stiffcal.processes import ChildEndedError, ChildProcess, ChildSilentError
from stiffcal.results.batch_results import BROKEN, LOST, STEPS, BatchStep, BatchTask, CampaignOutcome, outcome_of

ATTEMPTS = 2
LARGE_BYTES = 1 << 30


@dataclass
class Heard:
    """What a worker process has reported of its task."""

    plugins: tuple[str, ...] = ()
    """Files of the campaign whose code it had begun to run."""
    step: str = STEPS[0]
    """The step that it had begun."""
    steps: dict[str, BatchStep] = field(default_factory=dict)
    """The steps that had ended."""
    place: str = ""
    """The function in which it was last seen to make progress; "" where that is not known."""


class WorkerLostError(Exception):
    """A worker process has ended in the middle of a task.

    Parameters
    ----------
    how : it ended. heard : what it had reported of the task. silent : True where it made no progress and was ended.
    """

    def __init__(self, how: str, heard: Heard, silent: bool = False) -> None:
        super().__init__(how, heard, silent)
        self.how = how
        self.heard = heard
        self.silent = silent

    def __str__(self) -> str:
        return self.how


class WorkerProcess:
    """A process of `stiffcal.batch.worker`. Used by one thread at a time."""

    def __init__(self) -> None:
        self._process = ChildProcess(work)

    @property
    def pid(self) -> int:
        """The process's number."""
        return self._process.pid

    def do(self, task: BatchTask) -> CampaignOutcome:
        """Have a task done; messages of the process meanwhile go to standard error.

        Raises
        ------
        WorkerLostError : the process ended before it answered, with its exit status and its last output; it answered
            with something else than an outcome; or it made no progress for the task's idle timeout.
        """
        heard = Heard()
        self._process.send(json.dumps(document_of(task)).encode())
        try:
            while True:
                document = json.loads(self._process.receive(task.idle_timeout_s))
                if "progress" in document:
                    heard.place = str(document["progress"])
                elif "step" in document:
                    heard.step = str(document["step"])
                    heard.steps = {
                        name: result_from_values(BatchStep, step) for name, step in document["steps"].items()
                    }
                elif "plugins" in document:
                    heard.plugins = tuple(map(str, document["plugins"]))
                elif "said" in document:
                    sys.stderr.write(escaped(mask(document["said"])) + "\n")
                    sys.stderr.flush()
                else:
                    return result_from_values(CampaignOutcome, document)
        except ChildEndedError as error:
            raise WorkerLostError(str(error), heard) from None
        except ChildSilentError:
            where = f" in {heard.place}" if heard.place else ""
            how = f"its process made no progress for {task.idle_timeout_s:g} s{where}"
            raise WorkerLostError(how, heard, silent=True) from None
        except (ValueError, TypeError, AttributeError) as error:  # of pydantic too
            raise WorkerLostError("its process returned something other than a result", heard) from error

    def stop(self) -> None:
        """End the process: what it is writing to a store is taken away or was complete."""
        self._process.stop()


class _Pool:
    """Threads that each keep one worker process busy, and the queues between them and the caller."""

    def __init__(self, tasks: Sequence[BatchTask]) -> None:
        self.waiting: queue.SimpleQueue[tuple[BatchTask, tuple[str, ...]]] = queue.SimpleQueue()
        """Each with how its processes were lost before."""
        self.outcomes: queue.SimpleQueue[CampaignOutcome | BaseException] = queue.SimpleQueue()
        for task in tasks:
            self.waiting.put((task, ()))
        self._lock = threading.Lock()
        self._workers: set[WorkerProcess] = set()
        self._stopped = False

    def keep_one_busy(self) -> None:
        """Start processes one after another and give them tasks, until none are left."""
        worker: WorkerProcess | None = None
        try:
            while not self._stopped:
                try:
                    task, lost = self.waiting.get_nowait()
                except queue.Empty:
                    return
                worker = worker or self._started()
                try:
                    outcome = worker.do(task)
                except WorkerLostError as error:
                    self._ended(worker)
                    worker = None
                    self._again(task, lost, error)
                    continue
                if (outcome.memory_bytes or 0) > LARGE_BYTES:
                    self._ended(worker)
                    worker = None
                again = [f"{how}; it was tried once more, in another" for how in lost]
                self.outcomes.put(replace(outcome, warnings=[*again, *outcome.warnings]))
        except BaseException as error:
            self.outcomes.put(error)
        finally:
            if worker is not None:
                self._ended(worker)

    def _again(self, task: BatchTask, lost: tuple[str, ...], error: WorkerLostError) -> None:
        """Try a task once more, after all others; give it up when that ended in the same way, or in silence."""
        if len(lost) + 1 < ATTEMPTS and not error.silent:
            self.waiting.put((task, (*lost, error.how)))
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
    """Return the outcome of a task whose process was lost; its campaign's own code is at fault, where that ran."""
    heard = error.heard
    if error.silent:
        reason = error.how
        mend = "run it alone: stiffcal run DIR; where it needs more time for one call: --idle-timeout"
    else:
        reason = f"{error.how}, {ATTEMPTS} times"
        mend = "check whether memory is short (fewer --jobs), and run it alone: stiffcal run DIR"
    fault = Fault(FaultCode.PROCESS_LOST, task.folder, "", reason, mend)
    if heard.plugins:
        fault = Fault(
            FaultCode.PLUGIN_FAILED,
            ", ".join(heard.plugins),
            "plugins",
            f"{reason}, after code of this campaign began to run",
            f"correct the code, or {mend}",
        )
    outcome = outcome_of(task, BROKEN if heard.plugins and not error.silent else LOST, fault)
    return replace(outcome, steps=heard.steps, failed_at=heard.step)


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
