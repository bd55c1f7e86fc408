"""What data do not identify, in words: parameters with one reason stand in one sentence."""

from __future__ import annotations

from collections.abc import Iterable

from stiffcal.identification.fit_results import UnidentifiedParameters
from stiffcal.wording import listing

MOST_NAMED = 24


def unidentified_in_words(groups: Iterable[UnidentifiedParameters]) -> list[str]:
    """Return the parameters that these data do not distinguish, why, and what is known of them.

    Parameters of one effect that are each by themselves not identifiable, for the same reason, are named together.

    Examples
    --------
    >>> pair = UnidentifiedParameters(parameters=["a", "b"], reason="they move the target alike", known="a + b")
    >>> names = ("e.1", "e.2", "f")
    >>> alone = [UnidentifiedParameters(parameters=[name], reason="no load", known=None) for name in names]
    >>> unidentified_in_words([alone[0], pair, *alone[1:]])
    ['each of e.1 and e.2: no load', 'a, b: they move the target alike; known: a + b', 'f: no load']
    """
    sentences: dict[tuple[str, ...], list[str]] = {}
    for number, group in enumerate(groups):
        names = group.parameters
        known = f"; known: {group.known}" if group.known else ""
        if len(names) == 1 and not known:
            sentences.setdefault((names[0].partition(".")[0], group.reason), []).append(names[0])
        else:
            head = f"{', '.join(names)}: " if names else ""
            sentences[str(number), f"{head}{group.reason}{known}"] = []
    texts = []
    for (_, reason), names in sentences.items():
        each = "each of " if len(names) > 1 else ""
        texts.append(f"{each}{listing(names, MOST_NAMED)}: {reason}" if names else reason)
    return texts
