"""What a campaign folder wants to run: its code and its queries, read without running any of it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from stiffcal.campaign.loading import load_manifest
from stiffcal.campaign.manifest.queries import queries_of
from stiffcal.model.catalogue.plugin_code import PluginCode, read_plugins
from stiffcal.results.trust_results import CampaignCode, CampaignQuery, CodeFile, TrustedItem, TrustResult
from stiffcal.trust.content import TrustEntry, lines_of_code
from stiffcal.trust.queries import query_digest
from stiffcal.trust.record import open_record


@dataclass(frozen=True)
class TrustOverview:
    """What a campaign wants to run, read once: what is shown is what can be allowed."""

    folder: Path
    """The campaign folder."""
    plugins: PluginCode
    """Its code; without files where it brings none."""
    queries: dict[str, tuple[str, str]]
    """Texts that it sends to a database, by their SHA-256: (where it stands, text)."""

    @property
    def hashes(self) -> list[str]:
        """The SHA-256 of everything in it that needs to be allowed."""
        return [*([self.plugins.digest] if self.plugins.files else []), *self.queries]

    @property
    def allowed(self) -> bool:
        """Whether the user has allowed all of it."""
        record = open_record()
        code = not self.plugins.files or self.plugins.allowed()
        return code and all(record.text_allowed(digest) for digest in self.queries)

    def result(self, action: Literal["shown", "allowed"] = "shown", entries: Sequence[TrustEntry] = ()) -> TrustResult:
        """Return the result of `trust` for it, with the entries of the record that were made."""
        files = [
            CodeFile(
                name=file.name,
                lines=len(lines_of_code(file.text)),
                bytes=len(file.content),
                effects=file.effect_names(),
                text=file.text,
            )
            for file in self.plugins.files
        ]
        code = CampaignCode(sha256=self.plugins.digest, trusted=self.plugins.allowed(), files=files)
        record = open_record()
        return TrustResult(
            warnings=[],
            action=action,
            entries=trusted_items(entries),
            folder=str(self.folder),
            plugins=code if files else None,
            queries=[
                CampaignQuery(sha256=digest, trusted=record.text_allowed(digest), place=place, text=text)
                for digest, (place, text) in self.queries.items()
            ],
        )


def read_campaign(folder: Path) -> TrustOverview:
    """Read what a campaign folder wants to run, without running any of it.

    Raises
    ------
    InputError : there is no campaign, or a file of its code is missing or cannot be code of it.
    """
    folder = Path(folder)
    manifest = load_manifest(folder)
    queries = {query_digest(text): (place, text) for place, text in queries_of(manifest)}
    return TrustOverview(folder, read_plugins(folder, manifest.plugins), queries)


def trusted_items(entries: Iterable[TrustEntry]) -> list[TrustedItem]:
    """Return entries of the record as an answer names them."""
    return [TrustedItem(kind=entry.kind, key=entry.key, note=entry.note, since=entry.since) for entry in entries]
