"""What the commands answer with ``--json``, typed; SI units, null for what is not known.

Documents may hold more than stands here: what does stand here is what other programs may rely on.
"""

from __future__ import annotations

from typing import NotRequired

from typing_extensions import TypedDict

from stiffcal.workflow.document_types import FaultEntry


class Error(TypedDict):
    """Answer of any command with exit code 2 or 3; ``others`` where there are more faults."""

    error: FaultEntry
    others: NotRequired[list[FaultEntry]]
