"""What files and links are called, as bodies and as places for beams."""

from __future__ import annotations

from collections.abc import Sequence

MANIFEST_FILE = "campaign.toml"


def name_links(written: Sequence[str | None]) -> tuple[str, ...]:
    """Name the links: as written, else `swing` and `arm` for joints 2 and 3 of six, else link1, link2 and so on.

    Examples
    --------
    >>> name_links([None, None, "upper", None, None, None])
    ('link1', 'swing', 'upper', 'link4', 'link5', 'link6')
    """
    defaults = {1: "swing", 2: "arm"} if len(written) == 6 else {}
    names = []
    for k, name in enumerate(written):
        default = defaults.get(k)
        names.append(name or (default if default is not None and default not in written else f"link{k + 1}"))
    return tuple(names)


def beam_name(k: int, link_names: Sequence[str]) -> str:
    """Return the name of the link after joint index `k` (from 0) as a place for a beam.

    For six axes the links of joints 2 and 3 are `swing` and `arm`, whatever their own name, unless some link is
    called so in the file.

    Examples
    --------
    >>> beam_name(1, ("a", "b", "c", "d", "e", "f")), beam_name(1, ("a", "b", "swing", "d", "e", "f"))
    ('swing', 'b')
    """
    default = {1: "swing", 2: "arm"}.get(k) if len(link_names) == 6 else None
    return default if default is not None and default not in link_names else link_names[k]


def body_number(name: str, link_names: Sequence[str]) -> int | None:
    """Return the body that `name` stands for: 0 base, k the link of joint k, J + 1 flange; None where unknown.

    Examples
    --------
    >>> names = name_links([None] * 6)
    >>> [body_number(name, names) for name in ("base", "swing", "flange", "hook")]
    [0, 2, 7, None]
    """
    if name == "base":
        return 0
    if name == "flange":
        return len(link_names) + 1
    if name in link_names:
        return list(link_names).index(name) + 1
    beams = [beam_name(k, link_names) for k in range(len(link_names))]
    return beams.index(name) + 1 if name in beams else None
