"""Tasks of a batch on an existing Dask cluster, whose workers see the campaign folders under the same paths.

Each thread of a Dask worker keeps a process of its own for the tasks, as on this machine: one BLAS thread, and nothing
of one campaign reaches another. A Dask worker that is killed takes its processes with it; its tasks go to another.
"""

from __future__ import annotations

import importlib
import logging
import threading
import uuid
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from stiffcal.batch.processes import LARGE_BYTES, WorkerLostError, WorkerProcess, outcome_of_lost_worker
from stiffcal.errors import Fault, InputError
from stiffcal.extras import install_command
from stiffcal.fault_codes import FaultCode
from stiffcal.results.batch_results import BROKEN, LOST, BatchTask, CampaignOutcome, outcome_of

ANSWER_S = 15
"""How long a scheduler, and its first worker, may take to answer, s."""
RETRIES = 2

_kept = threading.local()


def cluster_task(task: BatchTask) -> CampaignOutcome:
    """Do a task on a Dask worker, in the process that this thread keeps.

    Raises
    ------
    WorkerLostError : that process has ended; Dask then tries again.
    """
    if not Path(task.folder).is_dir():
        reason = "this folder does not exist on a worker of the cluster"
        mend = "the campaign folders must have the same path on every worker"
        fault = Fault(FaultCode.FILE_MISSING, task.folder, "--scheduler", reason, mend)
        return outcome_of(task, BROKEN, fault)
    worker: WorkerProcess | None = getattr(_kept, "worker", None)
    if worker is None:
        worker = _kept.worker = WorkerProcess()
    try:
        outcome = worker.do(task)
    except WorkerLostError as error:
        _kept.worker = None
        worker.stop()
        if error.silent:
            return outcome_of_lost_worker(task, error)
        raise
    if (outcome.memory_bytes or 0) > LARGE_BYTES:
        _kept.worker = None
        worker.stop()
    return outcome


def run_on_cluster(tasks: Sequence[BatchTask], address: str, finished: Callable[[CampaignOutcome], None]) -> int:
    """Run tasks on the cluster of a scheduler.

    Parameters
    ----------
    tasks : in the order in which they are begun.
    address : of the scheduler, like ``tcp://host:8786``.
    finished : called with each outcome, in the order in which they end.

    Returns
    -------
    How many threads the cluster had at the start.

    Raises
    ------
    InputError : Dask is not installed, or no cluster answers at this address.
    """
    try:
        distributed: Any = importlib.import_module("distributed")
    except ImportError:
        mend = f"install it: {install_command('dask')}"
        raise InputError.at(
            FaultCode.LIBRARY_MISSING, "command line", "--scheduler", "the package distributed is not installed", mend
        ) from None
    with _silent_log(), _connected(distributed, address) as client:
        threads = _threads(client, address)
        batch = uuid.uuid4().hex
        futures = {
            client.submit(cluster_task, task, key=f"stiffcal-{batch}-{number}", retries=RETRIES, pure=False): task
            for number, task in enumerate(tasks)
        }
        try:
            for future in distributed.as_completed(futures):
                outcome = _outcome_of_future(future, futures[future], "" if client.status == "running" else address)
                record_generation(futures[future], outcome.generations or [])
                finished(outcome)
        except BaseException:
            client.cancel(list(futures))
            raise
    return threads


def record_generation(task: BatchTask, committed: Sequence[str]) -> None:
    """Record what a worker has committed to the store of a task as this user's own: workers have other home folders.

    Only what lies in that task's store now is recorded, whatever else a worker names.

    Parameters
    ----------
    committed : digests of the generations that the worker reports as committed.
    """
    from stiffcal.stages.steps import RunContext, open_store
    from stiffcal.store.origin import remember

    if not committed:
        return
    try:
        with open_store(Path(task.folder), RunContext(store=task.store)).snapshot() as snapshot:
            digest = snapshot.index.digest
    except InputError:
        return
    if digest in committed:
        remember(digest, "")


@contextmanager
def _silent_log() -> Iterator[None]:
    """Keep from standard error what Dask writes there of a lost scheduler: the outcomes state it, in one line each."""
    names = [name for name in logging.root.manager.loggerDict if name.partition(".")[0] == "distributed"]
    found = [(logger, logger.handlers) for logger in map(logging.getLogger, names) if logger.handlers]
    for logger, _ in found:
        logger.handlers = [logging.NullHandler()]
    try:
        yield
    finally:
        for logger, handlers in found:
            logger.handlers = handlers


def _connected(distributed: Any, address: str) -> Any:
    try:
        return distributed.Client(address, timeout=ANSWER_S, name="stiffcal")
    except (OSError, TimeoutError, ValueError) as error:
        text = (str(error).splitlines() or [type(error).__name__])[0]
        mend = "give the address that dask scheduler shows when it starts, like tcp://host:8786"
        raise InputError.at(
            FaultCode.CLUSTER_UNREACHABLE,
            "command line",
            "--scheduler",
            f"no Dask scheduler at {address} ({text})",
            mend,
        ) from None


def _threads(client: Any, address: str) -> int:
    """Return how many threads the cluster's workers have; wait a little for the first worker."""
    try:
        client.wait_for_workers(1, timeout=ANSWER_S)
    except TimeoutError:
        mend = f"start workers: dask worker {address}"
        raise InputError.at(
            FaultCode.CLUSTER_UNREACHABLE,
            "command line",
            "--scheduler",
            f"the cluster at {address} has no worker",
            mend,
        ) from None
    return sum(client.nthreads().values())


def _outcome_of_future(future: Any, task: BatchTask, lost_scheduler: str) -> CampaignOutcome:
    """Return the outcome of a task; where Dask has given it up, why.

    Parameters
    ----------
    lost_scheduler : the address of the scheduler, where it does not answer any more; else "".
    """
    if future.status == "finished":
        outcome: CampaignOutcome = future.result()
        return outcome
    error = None if future.cancelled() else future.exception()
    if isinstance(error, WorkerLostError):
        return outcome_of_lost_worker(task, error)
    reason = (
        "the cluster has dropped it" if error is None else f"{type(error).__name__}: {' '.join(str(error).split())}"
    )
    if error is None and lost_scheduler:
        reason = f"the scheduler at {lost_scheduler} answers no more"
        mend = "start it and its workers, then run the batch again: what is done is not computed again"
        return outcome_of(task, LOST, Fault(FaultCode.PROCESS_LOST, task.folder, "--scheduler", reason, mend))
    mend = "see the logs of the workers; stiffcal of the same version must be installed there"
    return outcome_of(task, LOST, Fault(FaultCode.PROCESS_LOST, task.folder, "--scheduler", reason, mend))
