"""The options that every command takes, declared once: each may stand before the command's name or after it."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any, TypeAlias

import typer

from stiffcal.cli.options import Overwrite

Verbose: TypeAlias = Annotated[bool, typer.Option("--verbose", help="Log each step to standard error.")]
LogFile: TypeAlias = Annotated[
    str | None,
    typer.Option("--log-file", metavar="FILE", help="Append a log of each step to this file.", show_default=False),
]
Debug: TypeAlias = Annotated[bool, typer.Option("--debug", help="Show the traceback of an internal fault.")]


@dataclass(frozen=True)
class CommonOptions:
    """What the options are set to."""

    verbose: bool = False
    """Log to standard error."""
    log_file: str | None = None
    """Log to this file."""
    debug: bool = False
    """Show the traceback of an internal fault."""
    overwrite: bool = False
    """Write to files that hold something else than what stiffcal wrote."""


def _declared(
    verbose: Verbose = False, log_file: LogFile = None, debug: Debug = False, overwrite: Overwrite = False
) -> None:
    """Declare the options: their names are those of `CommonOptions`."""


def with_common_options(function: Callable[..., int], begin: Callable[[CommonOptions], None]) -> Callable[..., int]:
    """Return a command that takes these options as well as its own, for typer to read its signature.

    Parameters
    ----------
    function : the command. An option that it declares itself, it gets as well.
    begin : called with what the options are set to, before the command.
    """
    own = inspect.signature(function, eval_str=True)
    common = inspect.signature(_declared, eval_str=True).parameters

    @functools.wraps(function)
    def command(**values: Any) -> int:
        begin(CommonOptions(**{name: values[name] for name in common}))
        return function(**{name: values[name] for name in own.parameters})

    added = [parameter for name, parameter in common.items() if name not in own.parameters]
    signature = own.replace(parameters=[*own.parameters.values(), *added])
    vars(command)["__signature__"] = signature
    return command
