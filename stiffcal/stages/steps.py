"""The chain of steps behind every command: what is there, what is missing or stale, what has to run first.

ingest → identify → validate. A step's result lies in the store with a key: a hash of all that went into it. A result
whose key is not the present one is stale. Why hashes and not times: a copied or restored campaign keeps its results.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stiffcal.campaign.loading import Campaign, load_campaign
from stiffcal.campaign.model.model_file import MODEL_FILE, ModelFile
from stiffcal.documents import Document, Result
from stiffcal.errors import InputError, Progress, no_progress
from stiffcal.escapes.shell import command_line
from stiffcal.fault_codes import FaultCode
from stiffcal.files import read_regular
from stiffcal.limits import TOML
from stiffcal.revision import REVISION

if TYPE_CHECKING:
    import pyarrow as pa

    from stiffcal.campaign.manifest.manifest import Exclusion
    from stiffcal.ingest.results import IngestResult
    from stiffcal.measurements.load_states import LoadStates
    from stiffcal.reduction.registration.frames import RegistrationSummary
    from stiffcal.results.identify_result import IdentifyResult
    from stiffcal.results.validate_result import ValidateResult
    from stiffcal.store import Store
    from stiffcal.store.trial import TrialResults


STATES, FIT_STATES, HELDOUT_STATES = "states", "fit", "unseen"
IDENTIFY, VALIDATE, DIAGNOSE, HISTORY = "identify", "validate", "diagnose", "history"
INGEST, LOAD_PATHS = "ingest", "load_paths"


def ignore_note(text: str) -> None:
    """Let a note pass; the default of `RunContext.notify`."""


def ignore_step(step: str, reason: str) -> None:
    """Let a step pass; the default of `RunContext.on_step`."""


@dataclass(frozen=True)
class TrialModel:
    """A model that is tried: what is computed with it stays in memory, and the folder and its store as they are."""

    text: str
    """As model.toml would read."""
    model: ModelFile
    """The same, read."""
    results: TrialResults
    """What was computed so far; filled by those who work with the trial."""
    exclude: tuple[Exclusion, ...] = ()
    """Rows to leave out besides those of the manifest: the logs are then read again, into memory."""


@dataclass(frozen=True)
class RunContext:
    """What a command works with."""

    store: str | None = None
    """Where the store is; None: DIR/store."""
    update: bool = True
    """False: refuse where an earlier step is missing or stale, instead of running it."""
    progress: Progress = no_progress
    """Called with what is being done."""
    notify: Callable[[str], None] = ignore_note
    """Called with a line for people, also when an earlier step is run first."""
    on_step: Callable[[str, str], None] = ignore_step
    """Called with an earlier step that is run first, and why."""
    reach: tuple[Path, ...] = ()
    """Folders and files that the user has named; a manifest may point to a baseline in them."""
    thorough: bool = False
    """Hash all logs and all files of the store, whatever is known of them."""
    overwrite: bool = False
    """Also write to files that hold something stiffcal did not write."""
    jobs: int = 1
    """Threads in which effects are compared; answers do not depend on it."""
    trial: TrialModel | None = None
    """A model to work with instead of model.toml; nothing is written then."""
    runs: frozenset[str] | None = None
    """Only these runs, where the logs of others are still being written: the store holds what was read of them, and is
    used as it is; None: all runs, as their logs are now.
    """


@dataclass(frozen=True)
class Ingested:
    """A campaign with its load states."""

    campaign: Campaign
    """The folder's three files."""
    store: Store
    """The opened store."""
    table: pa.Table
    """The states as they lie in the store."""
    states: LoadStates
    """The same as arrays, without what a correcting controller commanded (`reduction.states.commanded`); none where the
    campaign holds other experiments alone.
    """
    non_load: dict[str, pa.Table] = field(default_factory=dict)
    """Tables of what other experiments measured, as far as there are any."""
    origin: str = "own"
    """From whom the states come: "own", "trusted place", or "foreign" where the logs to make them are missing."""
    missing: tuple[str, ...] = ()
    """Logs that are not there; what is stored is then all there is."""

    @property
    def uncounted(self) -> str:
        """Why no threshold can be held against these results, "" where they count."""
        if self.origin == "foreign":
            return "the results were not computed by you, and the logs are missing"
        return f"the logs are missing ({self.missing[0]})" if self.missing else ""

    @property
    def registration(self) -> RegistrationSummary | None:
        """What is left between the kinematics and the places of estimated frames; None where none is estimated."""
        result = stored_ingest(self.store)
        return None if result is None else result.registration

    def commit(self, tables: Mapping[str, Any], documents: Any, command: str) -> None:
        """Write what was made of these states into the store; it comes from whom they come.

        Raises
        ------
        DamagedError : what was made from the logs has been damaged meanwhile; nothing is written then.
        """
        from stiffcal.ingest.parts import is_needed

        with self.store.begin(command) as writing:
            writing.origin, writing.needed = self.origin, is_needed
            writing.write_all(tables, documents)
            writing.keep_rest()
            writing.commit()

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The names of the logged joints, L of them."""
        return self.campaign.chain.joint_names


def open_store(folder: Path, context: RunContext) -> Store:
    """Return the campaign's store; it need not exist yet."""
    from stiffcal.kinds.declared_tables import campaign_store

    return campaign_store(context.store or Path(folder) / "store", display_name=context.store or "store")


def stored_document(store: Store, name: str) -> Document | None:
    """Return a document of the store, checked; None where there is none that can be used: it is computed again."""
    from stiffcal.ingest.parts import needed_parts
    from stiffcal.stages.stored import stored_document as checked_document
    from stiffcal.store.index import DamagedStoreError
    from stiffcal.trust.notices import notice

    try:
        return checked_document(store, name)
    except DamagedStoreError as error:
        if name in needed_parts():
            raise
        notice(f"{store.folder}: {name}: {error.faults[0].reason}: not used")
        return None


def stored_result(store: Store, name: str, kind: type[Result]) -> Result | None:
    """Return the content of a document of the store; None where none can be used, as `stored_document`."""
    from stiffcal.stages.stored import stored_result as checked_result
    from stiffcal.store.index import DamagedStoreError
    from stiffcal.trust.notices import notice

    try:
        return checked_result(store, name, kind)
    except DamagedStoreError as error:
        notice(f"{store.folder}: {name}: {error.faults[0].reason}: not used")
        return None


def stored_fit(store: Store) -> IdentifyResult | None:
    """Return the stored fit; None where there is none that can be used."""
    from stiffcal.results.identify_result import IdentifyResult

    return stored_result(store, IDENTIFY, IdentifyResult)


def stored_validation(store: Store) -> ValidateResult | None:
    """Return the stored validation; None where there is none that can be used."""
    from stiffcal.results.validate_result import ValidateResult

    return stored_result(store, VALIDATE, ValidateResult)


def stored_ingest(store: Store) -> IngestResult | None:
    """Return the result of the ingest behind the stored load states, None where the store does not hold that."""
    from stiffcal.ingest.results import IngestResult
    from stiffcal.store.document_shape import result_from

    document = stored_document(store, INGEST)
    return None if document is None else result_from(IngestResult, document, store.display_name, INGEST)


def up_to_date_states(folder: Path, context: RunContext) -> Ingested:
    """Return the campaign's load states, ingesting first where they are missing, stale or somebody else's.

    Where logs are missing and nothing else has changed, what is stored is used; `Ingested.origin` holds whose it is.

    Raises
    ------
    InputError : the input is wrong, or a step is missing and ``context.update`` is False.
    """
    from stiffcal.ingest.freshness import freshness_of, warn_missing_sources, with_stored_runs, without_damaged
    from stiffcal.ingest.ingesting import ingest_now
    from stiffcal.kinds import tables_of_logs
    from stiffcal.reduction.states.commanded import without_commands
    from stiffcal.store.index import FOREIGN, OWN
    from stiffcal.trust.foreign_content import use_foreign_results

    campaign = load_campaign(Path(folder), check_files=False)
    store = open_store(campaign.folder, context)
    missing: tuple[str, ...] = ()
    if context.runs is not None:
        campaign = with_runs(campaign, context.runs)
    else:
        campaign = with_stored_runs(campaign, store)
        fresh = freshness_of(campaign, store, context.thorough)
        missing = fresh.missing
        if missing:
            warn_missing_sources(fresh, context.notify)
        else:
            reason = fresh.reason or without_damaged(store, context.notify)
            if reason:
                # Logs that are not there are named before anything is announced.
                campaign = load_campaign(campaign.folder)
                announce("ingest", reason, campaign.folder, context)
                ingest_now(campaign, store, "" if fresh.first else reason, context.progress, context.thorough)
    if context.trial is not None:
        campaign, store = _on_trial(campaign, store, context.trial, context.progress)
    table, states = stored_table(store)
    non_load = {name: store.read_table(name) for name in tables_of_logs() if name in store.tables}
    origin = store.origin_of(STATES, *tables_of_logs(), INGEST)
    if origin != FOREIGN:  # where results of others are only shown, nothing is changed
        store.remove_leftovers()
    if origin != OWN:  # in a place that several people write, too
        use_foreign_results(store.display_name)
    states = without_commands(states, campaign.chain)
    return Ingested(campaign, store, table, states, non_load, origin, missing)


def with_runs(campaign: Campaign, runs: Collection[str]) -> Campaign:
    """Return the campaign with some of its runs alone."""
    kept = tuple(run for run in campaign.manifest.runs if run.id in runs)
    return replace(campaign, manifest=campaign.manifest.model_copy(update={"runs": kept}))


def with_trial_model(campaign: Campaign, context: RunContext) -> Campaign:
    """Return the campaign with what is tried, where there is something: another model, rows left out."""
    trial = context.trial
    if trial is None:
        return campaign
    campaign = replace(campaign, model=trial.model)
    if not trial.exclude:
        return campaign
    exclude = (*campaign.manifest.exclude, *trial.exclude)
    return replace(campaign, manifest=campaign.manifest.model_copy(update={"exclude": exclude}))


def _on_trial(campaign: Campaign, store: Store, trial: TrialModel, progress: Progress) -> tuple[Campaign, Store]:
    """Return the campaign with what is tried, and its store with the trial's results over it.

    Where the trial leaves rows out the logs are read again, into memory; what is stored stays.
    """
    from stiffcal.ingest.freshness import freshness_of
    from stiffcal.ingest.ingesting import ingest_now
    from stiffcal.store.trial import TrialStore

    campaign = with_trial_model(campaign, RunContext(trial=trial))
    store = TrialStore(store, trial.results)
    if trial.exclude:
        reason = freshness_of(campaign, store).reason
        if reason:
            ingest_now(campaign, store, reason, progress)
    return campaign, store


def stored_table(store: Store) -> tuple[pa.Table, LoadStates]:
    """Return the load states as they lie in the store, as a table and as arrays.

    Raises
    ------
    DamagedError : the table holds something else.
    """
    from stiffcal.measurements.tables import states_from_table
    from stiffcal.store.origin import damaged

    table = store.read_table(STATES)
    try:
        return table, states_from_table(table)
    except (ValueError, TypeError, KeyError, IndexError, AttributeError, OverflowError, RecursionError) as error:
        # Anybody may have written what stands next to the columns.
        raise damaged(store.display_name, STATES, (str(error).splitlines() or [""])[0]) from error


def announce(step: str, reason: str, folder: Path, context: RunContext) -> None:
    """Report that an earlier step is run first, or refuse.

    Raises
    ------
    InputError : ``context.update`` is False.
    """
    if not context.update:
        mend = f"run {command_line(step, folder)}, or leave --no-update out"
        raise InputError.at(FaultCode.STORE_OUTDATED, str(folder), step, reason, mend)
    context.on_step(step, reason)
    context.notify(f"running {step}: {reason}")


def key_of(*parts: Any) -> str:
    """Return a hash of JSON values, and of the revision that computes with them.

    Examples
    --------
    >>> key_of({"a": 1, "b": 2}) == key_of({"b": 2, "a": 1}), key_of("a") == key_of("b")
    (True, False)
    """
    text = json.dumps([REVISION, *parts], sort_keys=True, default=str)
    return hashlib.sha256(text.encode()).hexdigest()


def key_of_table(table: pa.Table) -> str:
    """Return a hash of a table's values and of the document written with them, not of what describes its columns."""
    import pyarrow as pa

    from stiffcal.measurements.columns import TABLE_DOCUMENT

    sink = pa.BufferOutputStream()
    document = {key: text for key, text in (table.schema.metadata or {}).items() if key == TABLE_DOCUMENT}
    schema = pa.schema([(field.name, field.type) for field in table.schema], document or None)
    # One batch: how the rows were cut into pieces is no property of them.
    combined = pa.Table.from_arrays(table.columns, schema=schema).combine_chunks()
    with pa.ipc.new_stream(sink, combined.schema) as writer:
        writer.write_table(combined)
    return hashlib.sha256(sink.getvalue()).hexdigest()


def key_of_fit(data: Ingested, loss: str) -> str:
    """Return the key under which a fit of these states with the present model lies in the store."""
    campaign = data.campaign
    documents = [campaign.model.model_dump(mode="json"), campaign.robot.model_dump(mode="json")]
    plugins = plugin_digests(campaign)
    non_load = {name: key_of_table(table) for name, table in data.non_load.items()}
    return key_of(key_of_table(data.table), documents, plugins, loss, *([non_load] if non_load else []))


def plugin_digests(campaign: Campaign) -> list[str]:
    """Return the hash of the campaign's code where its model file needs it, else none: other code changes no fit."""
    if not campaign.manifest.plugins:
        return []
    from stiffcal.model.catalogue.campaign_effects import needs_plugins, plugin_code

    return [plugin_code(campaign).digest] if needs_plugins(campaign) else []


def kept_table(table: str, key: str) -> str:
    """Return the name under which a table of states stays in the store for every fit of the history.

    Parameters
    ----------
    table : `FIT_STATES` or `HELDOUT_STATES`, which are of the last fit.
    key : of the fit, `StoredFit.key`.
    """
    return f"{'heldout' if table == HELDOUT_STATES else table}-{key[:16]}"


def model_text(campaign: Campaign) -> str:
    """Return model.toml as it stands, "" where there is none and the default model holds."""
    path = campaign.folder / MODEL_FILE
    return read_regular(path, MODEL_FILE, limit=TOML).decode("utf-8") if path.exists() else ""
