"""Raw logs and tables → the store: load states, recordings, what was done to them, and from which files."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stiffcal.errors import InputError, Progress, no_progress
from stiffcal.revision import REVISION

if TYPE_CHECKING:
    from stiffcal.campaign.loading import Campaign
    from stiffcal.measurements.load_states import LoadStates
    from stiffcal.store import SourceFile, Store

SCHEMA = "stiffcal/ingest/1"
STATES = "states"
CLAMPED = "clamped"
FRICTION, FREE_MOTION = "friction", "free_motion"
INGEST = "ingest"
PROVENANCE = "provenance"
RECORDINGS = "recordings/"
NOTHING = "nothing is ingested yet"


def ingest_campaign(
    folder: str | Path, store: str | Path | None = None, progress: Progress = no_progress
) -> dict[str, Any]:
    """Turn the logs of a campaign into load states in its store.

    Parameters
    ----------
    folder : the campaign folder.
    store : where the store is; default ``folder/store``.
    progress : told what is being read.

    Returns
    -------
    The ingest document (interface, section 4): per run ``clock_ahead_s``, ``n_states``, ``dropped``; ``unchanged`` is
    True where nothing had to be done, and ``changed`` names the sources and settings that made it necessary.

    Raises
    ------
    InputError
        The campaign or one of its files is wrong; the store is then untouched.
    """
    from stiffcal.campaign.loading import load_campaign
    from stiffcal.store import Store
    from stiffcal.store.index import FOREIGN
    from stiffcal.workflow.freshness import freshness_of
    from stiffcal.workflow.stored import stored_document

    folder = Path(folder)
    campaign = load_campaign(folder)
    target = Store(store if store is not None else folder / "store", shown=str(store) if store is not None else "store")
    fresh = freshness_of(campaign, target)
    stored = None if fresh.reason else stored_document(target, INGEST)
    if stored is not None:
        if fresh.origin != FOREIGN:
            target.remove_leftovers()
        return stored | {"unchanged": True, "changed": "", "origin": fresh.origin}
    return ingest_now(campaign, target, fresh.reason, progress)


def ingest_now(campaign: Campaign, target: Store, reason: str, progress: Progress = no_progress) -> dict[str, Any]:
    """Read the logs, whatever the store holds; arguments and errors as of `ingest_campaign`.

    Parameters
    ----------
    reason : why, for the document's ``changed``.
    """
    from stiffcal.store import Provenance, hash_sources

    folder = campaign.folder
    files, settings = source_files(campaign), ingest_settings(campaign)
    outside = sources_elsewhere(campaign)
    changed = "" if reason == NOTHING else reason
    from stiffcal.measurements.clamped_readings import readings_table
    from stiffcal.measurements.friction_readings import motion_table, steady_table
    from stiffcal.measurements.tables import states_table
    from stiffcal.workflow.reducing import reduce_campaign

    with hash_sources(folder, files) as hashes, target.begin("ingest") as writing:
        reduced = reduce_campaign(campaign, progress, writing)
        document = reduced.document | {"unchanged": False, "changed": changed}
        writing.write_table(STATES, states_table(reduced.states, campaign.chain.joint_names))
        if reduced.non_load.clamped_readings is not None:
            writing.write_table(
                CLAMPED, readings_table(reduced.non_load.clamped_readings, campaign.chain.joint_names, settings)
            )
        friction = reduced.non_load.friction
        if friction is not None and friction.steady is not None:
            writing.write_table(FRICTION, steady_table(friction.steady, campaign.chain.joint_names))
        if friction is not None and friction.motion is not None:
            writing.write_table(FREE_MOTION, motion_table(friction.motion, campaign.chain.joint_names))
        writing.write_document(INGEST, document)
        progress("hashing the sources", None)
        if outside != sources_elsewhere(campaign):
            names = ", ".join(source.file for source in outside)
            raise InputError.at(names, "", "the rows changed while they were read", "wait until nothing writes them")
        provenance = Provenance.now("ingest", (*hashes.result(), *outside), settings)
        writing.write_document(PROVENANCE, provenance.as_document())
        writing.sources_state = hashes.state
        _keep_what_others_wrote(writing, target.tables, target.documents)
        writing.commit()
    return document | {"origin": "own"}


def _keep_what_others_wrote(writing: Any, tables: tuple[str, ...], documents: tuple[str, ...]) -> None:
    """Carry over history and fits; they say themselves from which states they come."""
    kept = [
        name
        for name in tables
        if name not in (STATES, CLAMPED, FRICTION, FREE_MOTION) and not name.startswith(RECORDINGS)
    ]
    kept += [name for name in documents if name not in (INGEST, PROVENANCE)]
    writing.keep(*dict.fromkeys(kept))


def is_stale(folder: str | Path, store: str | Path | None = None) -> str:
    """Return why the store does not hold what the campaign says now, "" where it does."""
    from stiffcal.campaign.loading import load_campaign
    from stiffcal.store import Store
    from stiffcal.workflow.freshness import freshness_of

    folder = Path(folder)
    target = Store(store if store is not None else folder / "store", shown=str(store) if store is not None else "store")
    fresh = freshness_of(load_campaign(folder, check_files=False), target)
    return fresh.reason or (f"missing: {', '.join(fresh.missing)}" if fresh.missing else "")


def stored_states(
    folder: str | Path, store: str | Path | None = None, progress: Progress = no_progress, update: bool = True
) -> LoadStates:
    """Return the campaign's load states, ingesting first where they are missing or stale.

    Parameters
    ----------
    update : False: refuse instead of ingesting (``--no-update``).

    Raises
    ------
    InputError
        The campaign is wrong, or the store is stale and may not be updated.
    """
    from stiffcal.store import Store
    from stiffcal.workflow.steps import stored_table

    folder = Path(folder)
    reason = is_stale(folder, store)
    if reason:
        if not update:
            raise InputError.at(str(store or folder / "store"), "", f"out of date ({reason})", "run ingest first")
        ingest_campaign(folder, store, progress)
    target = Store(store if store is not None else folder / "store", shown=str(store) if store is not None else "store")
    return stored_table(target)[1]


def source_files(campaign: Campaign) -> list[str]:
    """Return every data file that the manifest names, as named there, each once."""
    manifest = campaign.manifest
    files: list[str] = []
    for name, source in manifest.sources.items():
        if not source.in_files:
            continue
        files += manifest.files_of(name).values()
        for run in manifest.runs:
            files += [run.files[name]] if name in run.files else []
    files += [run.states for run in manifest.runs if run.states is not None]
    return list(dict.fromkeys(files))


def sources_elsewhere(campaign: Campaign) -> tuple[SourceFile, ...]:
    """Return the tables and queries that the manifest names instead of files, as they are now.

    Raises
    ------
    InputError
        A database cannot be reached.
    """
    manifest = campaign.manifest
    if all(source.in_files for source in manifest.sources.values()):
        return ()
    import hashlib

    from stiffcal.reduction.logs import fingerprint_of
    from stiffcal.store import SourceFile

    found: dict[str, SourceFile] = {}
    for name, source in manifest.sources.items():
        if source.in_files:
            continue
        named = [*manifest.files_of(name).values(), *(run.files[name] for run in manifest.runs if name in run.files)]
        for text in dict.fromkeys(named):
            rows, told = fingerprint_of(source, text)
            key = f"{name}: {' '.join(text.split())}"
            found[key] = SourceFile(key, rows, 0, hashlib.sha256(told.encode()).hexdigest())
    return tuple(found.values())


def ingest_settings(campaign: Campaign) -> dict[str, Any]:
    """Return what besides the files shapes the load states: manifest, robot, what computes."""
    manifest: Mapping[str, Any] = campaign.manifest.model_dump(mode="json", exclude={"thresholds", "plugins", "name"})
    robot: Mapping[str, Any] = campaign.robot.model_dump(mode="json")
    return {"manifest": dict(manifest), "robot": dict(robot), "revision": REVISION}
