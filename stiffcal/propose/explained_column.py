"""What is answered about a column of a table; apart, as every `check` answers with a list of these."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Annotated

from stiffcal.documents import NOT_IN_DOCUMENT

_OF_RODS = "where each is fixed is in no table, stiffcal init DIR --kind ids shows what to write"


class NotUsed(Enum):
    """Why a column is not used; each member is a sentence."""

    WORDS = "words, no numbers"
    STANDS_STILL = "an orientation that never changes is not measured"
    LEFT_OPEN = "the values leave open what it is"
    STRAIN = f"a strain is read of a rod: {_OF_RODS}"
    COMPUTED = "the controller computes that from its joints' angles, it is no measurement"
    COMMANDED = "commanded, not measured"
    OTHER_BODY = "of another body; one is taken"
    TURN = "how its angles are to be read is not stated: rotvec, or rpy; or moments"
    OTHER_TIME = "another column is the time"
    COUNTER = "a count of the rows"
    NO_SIGNAL = "no signal has such a name"


@dataclass(frozen=True, slots=True, kw_only=True)
class ExplainedColumn:
    """A column of a table, and what it is taken for."""

    file: str
    """The file that holds it."""
    column: str
    """Its name for the manifest."""
    taken_as: str
    """What it is taken for: joints, force, …, time, run, sigma of another; "" where it is not used."""
    unit: str
    """As the file states it, else as its values show; "" where it has none, or is not used and states none."""
    why: str
    """By what that was decided, or why it is not used."""
    not_used: Annotated[NotUsed | None, NOT_IN_DOCUMENT] = None
    """Why it is not used; None where it is, or for a reason of its own."""
