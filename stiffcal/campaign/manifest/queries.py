"""The queries that a manifest sends to databases."""

from __future__ import annotations

from stiffcal.campaign.manifest.manifest import Manifest
from stiffcal.trust.queries import needs_trust, query_text


def queries_of(manifest: Manifest) -> list[tuple[str, str]]:
    """Return every query that needs the user's trust, once each: where it stands first, and its text.

    Bare names of tables are not among them.
    """
    place_of: dict[str, str] = {}
    for name, source in manifest.sources.items():
        if source.in_files:
            continue
        named = [(f"sources.{name}.file", source.file)]
        named += [(f"sources.{name}.files.{signal}", text) for signal, text in source.files.items()]
        named += [(f"runs[{number}].files.{name}", run.files.get(name)) for number, run in enumerate(manifest.runs, 1)]
        for place, text in named:
            if text is not None and needs_trust(text):
                place_of.setdefault(query_text(text), place)
    return [(place, text) for text, place in place_of.items()]
