"""Whether a store agrees with its campaign, and whether that is the user's own work."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

from stiffcal.documents import document_of
from stiffcal.ingest.parts import INGEST, PROVENANCE, is_needed, missing_parts, needed_parts
from stiffcal.ingest.sources import ingest_settings, manifest_data_files, sources_elsewhere
from stiffcal.store.index import FOREIGN, OWN, DamagedStoreError, check_version

if TYPE_CHECKING:
    from stiffcal.campaign.loading import Campaign
    from stiffcal.store import Provenance, Snapshot, Store

OTHERWISE = "the store was written by another version of stiffcal, with other results"
NOT_YOURS = "the store was not written by you: recomputed"


@dataclass(frozen=True)
class Freshness:
    """What a look at a store has found."""

    reason: str = ""
    """Why the logs have to be read, "" where not."""
    missing: tuple[str, ...] = ()
    """Logs that are not there, where all else is as it was: what is stored is all there is."""
    origin: str = OWN
    """From whom the stored states come: "own", "trusted place" or "foreign"."""
    first: bool = False
    """True where nothing is ingested yet: there is nothing that changed."""

    @property
    def changed(self) -> str:
        """What differs from the store, in words; "" where nothing does or there is none."""
        return "" if self.first else self.reason


def freshness_of(campaign: Campaign, store: Store, thorough: bool = False) -> Freshness:
    """Check whether a store agrees with its campaign.

    Parameters
    ----------
    thorough : hash all sources and all files of the store, whatever is known of them.

    Raises
    ------
    InputError
        The store was written by a newer stiffcal, or a source or a part of the store cannot be read.
    """
    if not store.exists or INGEST not in store.documents:
        return Freshness("nothing is ingested yet", first=True)
    with store.snapshot() as snapshot:
        origin = snapshot.origin_of(*needed_parts())
        broken = [name for name in snapshot.damaged(thorough=thorough) if is_needed(name)]
        broken += missing_parts(snapshot)
        if broken:
            return Freshness(_damage_of(broken), origin=origin)
        try:
            then = _provenance_of(snapshot)
        except DamagedStoreError as error:
            return Freshness(f"the store is damaged: {error.faults[0].reason}", origin=origin)
        from stiffcal.ingest.reading.stored_sources import stored_states
        from stiffcal.store import changed_settings, changed_sources
        from stiffcal.store.origin import known_sources_state

        digest = snapshot.index.digest
        files = manifest_data_files(campaign)
        if origin == FOREIGN and all((campaign.folder / file).exists() for file in files):
            return Freshness(NOT_YOURS, origin=origin)
        outside = sources_elsewhere(campaign)
        state = known_sources_state(digest) if origin == OWN else ""
        changes = changed_sources(
            then, campaign.folder, files, thorough, outside, state, partial(stored_states, snapshot)
        )
        keys = changed_settings(then, document_of(ingest_settings(campaign)))
    if changes.missing and not (changes.changed or changes.new or changes.dropped or keys):
        return Freshness(missing=changes.missing, origin=origin)
    if not changes and set(keys) <= {"revision", "reduction"} and keys:
        return Freshness(OTHERWISE, origin=origin)
    if changes or keys:
        reasons = [str(changes)] if changes else []
        return Freshness("; ".join([*reasons, *([f"settings: {', '.join(keys)}"] if keys else [])]), origin=origin)
    if origin == OWN and changes.state and changes.state != state:
        from stiffcal.store.origin import remember

        remember(digest, changes.state)  # so that the next command need not hash the large sources
    return Freshness(origin=origin)


def with_stored_runs(campaign: Campaign, store: Store) -> Campaign:
    """Return a campaign with the runs that its store was made of, where no log is there any more to name them.

    Where patterns name the logs, the folder holds no other list of the runs.
    """
    if campaign.found is None or any(run.files for run in campaign.manifest.runs):
        return campaign
    known = _stored_runs(store)
    if not known:
        return campaign
    from stiffcal.campaign.manifest.found_runs import with_known_runs

    return replace(campaign, manifest=with_known_runs(campaign.manifest, known))


def new_runs(campaign: Campaign, store: Store) -> list[str]:
    """Return the runs that files have made since the store was written; none where there is no store."""
    known = _stored_runs(store) if campaign.found is not None else {}
    return [run.id for run in campaign.manifest.runs if run.files and run.id not in known] if known else []


def _stored_runs(store: Store) -> dict[str, dict[str, str]]:
    """Return the files of each run that a store was made of, by source; none where it does not hold them."""
    if not store.exists or PROVENANCE not in store.documents:
        return {}
    with store.snapshot() as snapshot:
        try:
            settings = snapshot.read_document(PROVENANCE).get("settings")
        except DamagedStoreError:  # reported where the store is compared with the campaign
            return {}
    manifest = settings.get("manifest") if isinstance(settings, dict) else None
    runs = manifest.get("runs") if isinstance(manifest, dict) else None
    return {
        run["id"]: {source: file for source, file in run["files"].items() if isinstance(file, str)}
        for run in (runs if isinstance(runs, list) else [])
        if isinstance(run, dict) and isinstance(run.get("id"), str) and isinstance(run.get("files"), dict)
    }


def _provenance_of(snapshot: Snapshot) -> Provenance:
    from stiffcal.store import Provenance
    from stiffcal.store.document_shape import result_from

    document = snapshot.read_document(PROVENANCE)
    if snapshot.origin_of(PROVENANCE) != OWN:
        check_version(document.get("schema"), "stiffcal/provenance/1", snapshot.display_name, PROVENANCE)
    return result_from(Provenance, document, snapshot.display_name, PROVENANCE)


def _damage_of(names: list[str]) -> str:
    return f"the store is damaged: {', '.join(names[:3])}"


def without_damaged(store: Store, notify: Callable[[str], None]) -> str:
    """Take what is damaged out of a store whose states are sound, so that it is computed again, and report it.

    Returns
    -------
    str
        Why the logs have to be read after all, "" where not: the states may have been damaged since they were compared.
    """
    with store.snapshot() as snapshot:
        broken = snapshot.damaged()
    needed = [name for name in broken if is_needed(name)]
    if needed:
        return _damage_of(needed)
    if broken:
        notify(f"{store.display_name}: {', '.join(broken)}: {next(iter(broken.values()))}: computed again")
        with store.begin("mend") as writing:
            writing.needed = is_needed
            writing.keep_rest()
            writing.commit()
    return ""


def warn_missing_sources(fresh: Freshness, notify: Callable[[str], None]) -> None:
    """Say that what is stored is all there is."""
    suffix = f" and {len(fresh.missing) - 1} more" if len(fresh.missing) > 1 else ""
    whose = "results that were not computed by you are shown" if fresh.origin == FOREIGN else "stored results are shown"
    notify(f"the logs are missing ({fresh.missing[0]}{suffix}): {whose}")
