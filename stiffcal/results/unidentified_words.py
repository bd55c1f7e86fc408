"""What data do not identify, in words: parameters with one reason stand in one sentence."""

from __future__ import annotations

from collections.abc import Iterable

from stiffcal.estimation.undetermined import Undetermined
from stiffcal.identification.answers.fit_results import UnidentifiedParameters
from stiffcal.wording import listing

MOST_NAMED = 24


def unidentified_in_words(groups: Iterable[UnidentifiedParameters]) -> list[str]:
    """Return the parameters that these data do not distinguish, why, and what is known of them.

    Parameters of one effect that are each by themselves not identifiable, for the same cause, are named together.

    Examples
    --------
    >>> pair = UnidentifiedParameters(parameters=["a", "b"], reason="they move the target alike", known="a + b")
    >>> names, no_load = ("e.1", "e.2", "f"), Undetermined.NO_LOAD
    >>> alone = [UnidentifiedParameters(parameters=[n], reason="no load", known=None, cause=no_load) for n in names]
    >>> unidentified_in_words([alone[0], pair, *alone[1:]])
    ['each of e.1 and e.2: no load', 'a, b: they move the target alike; known: a + b', 'f: no load']
    """
    alike: dict[tuple[str, Undetermined] | int, list[UnidentifiedParameters]] = {}
    for number, group in enumerate(groups):
        alone = len(group.parameters) == 1 and group.known is None
        key = (group.parameters[0].partition(".")[0], group.cause) if alone and group.cause is not None else number
        alike.setdefault(key, []).append(group)
    texts = []
    for together in alike.values():
        first, names = together[0], [name for group in together for name in group.parameters]
        each = "each of " if len(together) > 1 else ""
        named = listing(names, MOST_NAMED) if len(together) > 1 else ", ".join(names)
        known = f"; known: {first.known}" if first.known else ""
        texts.append(f"{each}{named}: {first.reason}{known}" if names else f"{first.reason}{known}")
    return texts
