"""What `doctor` shows: what is installed, and what is missing with the command that installs it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stiffcal.show.builder import PageBuilder

if TYPE_CHECKING:
    from stiffcal.presentation.values import Page
    from stiffcal.results.doctor_result import DoctorResult
    from stiffcal.show.options import ShowOptions


def page(result: DoctorResult, options: ShowOptions) -> Page:
    """Return the table of libraries, then what is missing, each with the command that installs it."""
    made = PageBuilder("Installation")
    made.say(f"stiffcal {result.version}, Python {result.python}, {result.platform}", "versions")
    rows = [(one.name, one.version or "missing", one.required, one.purpose or "everything") for one in result.libraries]
    made.table(("library", "version", "works with", "for"), rows)
    made.say(f"reads logs of the formats {', '.join(result.formats)}", "formats")
    missing = [library for library in result.libraries if library.version is None]
    for command in dict.fromkeys(library.install for library in missing):
        names = ", ".join(library.name for library in missing if library.install == command)
        made.say(f"{names}: {command}", "missing")
    for plugin in result.plugins:
        made.say(f"installed {plugin}", "plugin")
    if result.state_fault:
        text = f"{result.state_folder}: {result.state_fault}; nothing can be recorded as trusted"
        made.say(text, "state-fault")
    return made.page()
