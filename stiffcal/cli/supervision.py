"""A command whose campaign brings code along: the answer stays clean, and its end is the command's own.

Before such code first runs, the command is started again in a child process, and this one waits. The child reports
in a file how the command has ended; where it ends without that word (`os._exit`, a signal, a crash), the code is at
fault, and the parent ends with exit code 2. Commands without such code pay nothing for this. Why no fork: libraries
have threads by then, whose locks a copy of the process would have without them.

From then on standard output belongs to the answer alone: whatever else prints goes to standard error.
"""

from __future__ import annotations

import os
import signal
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from typing import IO, NoReturn, TextIO

from stiffcal.cli.endings import INTERRUPTED, NOT_HELD, OK, WRONG_INPUT, report_input_error
from stiffcal.cli.streams import StandardStream
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode

VARIABLE = "STIFFCAL_SUPERVISED_BY"


class Supervision:
    """What is known of one command.

    Parameters
    ----------
    own_process : True where the process is the command's own, False where a caller's program goes on afterwards.
    as_json : the answer is one JSON document.
    """

    def __init__(self, own_process: bool, as_json: bool) -> None:
        self.own_process = own_process
        self.as_json = as_json
        self.files: tuple[str, ...] = ()
        self.answered = False
        self.before_child: Callable[[], None] | None = None
        self._report: IO[bytes] | None = None
        self._answers: TextIO | None = None
        self._interrupted = False
        self._forwarded_by = -1
        self._started_by = os.environ.pop(VARIABLE, "") if own_process else ""

    def begin(self, files: tuple[str, ...]) -> None:
        """Prepare for code of these files, which runs next."""
        first, self.files = not self.files, (*self.files, *files)
        if not first:
            return
        if self.before_child is not None:
            self.before_child()
        for stream in (sys.stdout, sys.stderr):
            with suppress(OSError, ValueError, AttributeError):
                stream.flush()
        if self.own_process:
            if self._started_by:
                alive, forwarded, name = self._started_by.split(" ", 2)
                self._report = Path(name).open("wb")  # noqa: SIM115 - closed by `end`
                if int(alive) >= 0:
                    self._follow_parent(int(alive), int(forwarded))
            else:
                self._start_again()
            self._count_interruptions()
        self._keep_answers_clean()

    @contextmanager
    def answering(self) -> Iterator[None]:
        """Have standard output be the answer's, inside the block."""
        self.answered = True
        if self._answers is None:
            yield
            return
        inside, sys.stdout = sys.stdout, self._answers
        try:
            yield
        finally:
            sys.stdout = inside

    def run(self, command: Callable[[], object]) -> object:
        """Run the command, and return its exit code.

        Raises
        ------
        InputError : the campaign's code has ended the command, or failed in it.
        """
        try:
            code = command()
        except BaseException as error:
            self.restore()
            fault = self._fault(error)
            if fault is None:
                raise
            raise fault from error
        self.restore()
        if self.files and not self._interrupted:
            if code == INTERRUPTED and self.own_process:
                raise _ended(self.files, "by an interruption that did not come from you")
            if code in (OK, NOT_HELD) and not self.answered:
                raise _ended(self.files, "without an answer")
        return code

    def _fault(self, error: BaseException) -> InputError | None:
        """Return the fault of the campaign's code where it has raised this, None where it has not."""
        if not self.files or isinstance(error, InputError) or self._interrupted:
            return None
        from stiffcal.model.catalogue.plugin_loading import fault_of
        from stiffcal.trust.running import place_in_plugin

        # where interruptions are not counted every one is the user's
        if isinstance(error, KeyboardInterrupt) and not self.own_process:
            return None
        if place_in_plugin(error) is not None:
            return fault_of(error, self.files[0])
        return None if isinstance(error, Exception) else _ended(self.files, f"by {type(error).__name__}")

    def restore(self) -> None:
        """Give standard output back, for the last messages of a command."""
        if self._answers is not None:
            sys.stdout, self._answers = self._answers, None

    def end(self, code: int) -> None:
        """Report how the command has ended, to the parent that waits."""
        if self._report is not None:
            with suppress(OSError), self._report as report:
                report.write(b"%d\n" % code)

    def interrupted(self) -> bool:
        """Return whether the user has pressed Ctrl-C."""
        return self._interrupted or not self.own_process

    def _keep_answers_clean(self) -> None:
        self._answers = sys.stdout
        if self.own_process and isinstance(self._answers, StandardStream):
            # what writes to the number of standard output, like a program that the code starts
            number = self._answers.fileno()
            self._answers.move_to(os.fdopen(os.dup(number), "w", encoding="utf-8", errors="backslashreplace"))
            os.dup2(sys.stderr.fileno(), number)
        sys.stdout = sys.stderr

    def _follow_parent(self, alive: int, forwarded: int) -> None:
        """End with the parent, and hear from it of every interruption that it sends on.

        Parameters
        ----------
        alive : descriptor that ends with the parent. forwarded : with a byte for every interruption it has sent.
        """
        threading.Thread(target=_end_with_parent, args=(alive,), daemon=True).start()
        os.set_blocking(forwarded, False)
        self._forwarded_by = forwarded

    def _count_interruptions(self) -> None:
        """Raise once for every Ctrl-C, which a terminal and the waiting parent both send.

        Of all that arrive those that the parent has sent are known; the others are the terminal's. Two that arrive
        together count as one, of the parent.
        """
        if threading.current_thread() is not threading.main_thread():
            return
        arrived = forwarded = pressed = 0

        def interrupt(number: int, frame: object) -> None:
            nonlocal arrived, forwarded, pressed
            arrived, forwarded = arrived + 1, forwarded + _waiting(self._forwarded_by)
            if max(forwarded, arrived - forwarded) <= pressed:
                return
            pressed += 1
            self._interrupted = True
            raise KeyboardInterrupt

        if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
            signal.signal(signal.SIGINT, interrupt)

    def _start_again(self) -> None:
        """Start the command anew in a child process, and leave with its exit code."""
        import subprocess

        descriptor, name = tempfile.mkstemp(prefix="stiffcal-")
        os.close(descriptor)
        sent: list[int] = []
        alive, parent = os.pipe() if os.name == "posix" else (-1, -1)
        forwarded, forwards = os.pipe() if os.name == "posix" else (-1, -1)
        environment = {**os.environ, VARIABLE: f"{alive} {forwarded} {name}"}
        passed = (alive, forwarded) if alive >= 0 else ()
        with subprocess.Popen([sys.executable, *sys.orig_argv[1:]], env=environment, pass_fds=passed) as child:
            forward = partial(_forward, child.pid, sent=sent, forwards=forwards)
            for number in _FORWARDED if os.name == "posix" else (signal.SIGINT,):
                # On Windows the console sends Ctrl-C to both.
                signal.signal(number, (lambda number, frame: forward(number)) if os.name == "posix" else _ignore)
            _close_all_but(parent, forwards)
            status = child.wait()
        code_text = Path(name).read_bytes()
        with suppress(OSError):
            Path(name).unlink()
        self._leave(code_text, status, sent)

    def _leave(self, code_text: bytes, status: int, sent: list[int]) -> NoReturn:
        code = int(code_text) if code_text.strip().isdigit() else None
        if code is None and status < 0 and -status in sent:
            signal.signal(-status, signal.SIG_DFL)
            os.kill(os.getpid(), -status)
        if code is None:
            ending = f"by signal {-status}" if status < 0 else f"with code {status}"
            report_input_error(_ended(self.files, f"{ending}, without an answer"), self.as_json)
            code = WRONG_INPUT
        for stream in (sys.stdout, sys.stderr):
            with suppress(OSError, ValueError, AttributeError):
                stream.flush()
        os._exit(code)


_FORWARDED: tuple[signal.Signals, ...] = tuple(
    getattr(signal, name)
    for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT", "SIGUSR1", "SIGUSR2")
    if hasattr(signal, name)
)
_current: list[Supervision] = []


def current() -> Supervision | None:
    """Return the supervision of the command that runs, None outside of one."""
    return _current[-1] if _current else None


@contextmanager
def supervised(own_process: bool, as_json: bool) -> Iterator[Supervision]:
    """Watch over a command."""
    from stiffcal.trust.running import before_plugin_code, forget, interruptions_by

    supervision = Supervision(own_process, as_json)
    forget()  # a caller's program may have run such code before: what counts is what this command runs
    _current.append(supervision)
    before_plugin_code(supervision.begin)
    interruptions_by(supervision.interrupted)
    try:
        yield supervision
    finally:
        _current.remove(supervision)
        supervision.restore()
        before_plugin_code(None)
        interruptions_by(None)
        forget()


def _ended(files: tuple[str, ...], how: str) -> InputError:
    reason = f"the program ended {how}, after code of this campaign began to run"
    return InputError.at(
        FaultCode.PLUGIN_FAILED,
        ", ".join(files),
        "plugins",
        reason,
        "correct the code, or check whether memory ran out",
    )


def _close_all_but(*kept: int) -> None:
    """Close the files of a parent that only waits: its copies of their locks would outlast the child's."""
    for place in ("/proc/self/fd", "/dev/fd"):
        with suppress(OSError):
            for name in os.listdir(place):  # noqa: PTH208 - numbers, no files
                if int(name) > 2 and int(name) not in kept:
                    with suppress(OSError):
                        os.close(int(name))
            return


def _forward(child: int, number: int, sent: list[int], forwards: int) -> None:
    """Send a signal on to the child, which knows of an interruption that it is the parent's before it arrives."""
    sent.append(number)
    if number == signal.SIGINT:
        with suppress(OSError):  # it has ended already
            os.write(forwards, b"i")
    with suppress(ProcessLookupError):
        os.kill(child, number)


def _waiting(descriptor: int) -> int:
    """Return how many bytes wait in a pipe, and take them out; 0 where there is none."""
    try:
        return len(os.read(descriptor, 1 << 10)) if descriptor >= 0 else 0
    except OSError:  # none waits
        return 0


def _ignore(number: int, frame: object) -> None:
    """Let the child decide."""


def _end_with_parent(alive: int) -> None:
    """End with a parent that was killed: nobody waits for an answer, and a store is whole whenever a writer ends."""
    with suppress(OSError):
        os.read(alive, 1)
    os._exit(WRONG_INPUT)
