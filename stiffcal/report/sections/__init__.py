"""The report's sections, one per file: found by walking this folder, sorted by their ``ORDER``.

Each module holds ``ORDER`` (an integer, gaps left for later ones) and ``section(content) -> Section | LeftOut | None``
(None: nothing to show and nothing missing; a tuple: several sections). ``IN_SHORT = True`` puts it into the report of
two pages for a customer, too. A new page, such as the diagnosis, is one new
file here: it finds what it shows in the content, whose documents and `extra` hold all that the other rooms have
answered.
"""

from __future__ import annotations

import importlib
import pkgutil
from typing import Protocol, cast

from stiffcal.report.blocks import LeftOut, ReportSection
from stiffcal.report.content import ReportContent


class SectionModule(Protocol):
    """What each file in this folder offers."""

    __name__: str
    ORDER: int

    def section(self, content: ReportContent) -> ReportSection | LeftOut | tuple[ReportSection | LeftOut, ...] | None:
        """Lay out the section, or several, or give the reason why it is left out."""


def all_sections() -> list[SectionModule]:
    """Find the section files, in the order of the report."""
    names = sorted(module_info.name for module_info in pkgutil.iter_modules(__path__))
    modules = [cast(SectionModule, importlib.import_module(f"{__name__}.{name}")) for name in names]
    return sorted(modules, key=lambda module: module.ORDER)
