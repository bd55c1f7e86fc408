"""The runs of a manifest whose logs are named by patterns: what `[[runs]]` holds, and what lies in the folder."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from stiffcal.campaign.manifest.file_patterns import FilePattern, FoundFiles, Unpartnered, found_files, lacking_sources
from stiffcal.campaign.manifest.manifest import Manifest, Run
from stiffcal.campaign.manifest.tracker_frames import instead_of
from stiffcal.campaign.toml.name_checks import wrong_name
from stiffcal.campaign.toml.naming import MANIFEST_FILE
from stiffcal.errors import Fault
from stiffcal.escapes import toml_text
from stiffcal.fault_codes import FaultCode
from stiffcal.limits import RUNS
from stiffcal.natural_order import natural_key

MOST_NAMED = 5
"""Files or runs of one kind that a message names."""


def with_found_runs(manifest: Manifest, folder: Path) -> tuple[Manifest, FoundFiles | None]:
    """Return a manifest with all its runs, each with its files, and what was found; None where it has no pattern.

    Parameters
    ----------
    manifest : as read.
    folder : the campaign folder.

    Notes
    -----
    An entry of ``[[runs]]`` with `files` takes these and nothing from the patterns; one without has the files that
    match its id, and where there are none yet, those that are expected. All runs come in the natural order of their
    names. Of sources that stand in for each other, as where the tracker was moved, the last is expected.

    Raises
    ------
    InputError
        More runs than stiffcal reads.
    """
    patterns = patterns_of(manifest)
    if not patterns:
        return manifest, None
    named = frozenset(file for run in manifest.runs for file in run.files.values())
    found = found_files(folder, patterns, named, instead_of(manifest))
    RUNS.check(len(found.runs), MANIFEST_FILE, "runs of files that match the patterns")
    runs = _runs(manifest, patterns, found)
    listed = {natural_key(run.id) for run in manifest.runs}
    unpartnered = tuple(entry for entry in found.unpartnered if natural_key(entry.run) not in listed)
    ambiguous = tuple(entry for entry in found.ambiguous if natural_key(entry.run) not in _with_files(manifest))
    return manifest.model_copy(update={"runs": runs}), FoundFiles(found.runs, unpartnered, ambiguous)


def patterns_of(manifest: Manifest) -> dict[str, FilePattern]:
    """Return the patterns of the sources that have one and that mean something."""
    patterns = {name: source.pattern for name, source in manifest.sources.items()}
    return {name: pattern for name, pattern in patterns.items() if pattern is not None and pattern.fault is None}


def with_known_runs(manifest: Manifest, known: Mapping[str, Mapping[str, str]]) -> Manifest:
    """Return a manifest with runs whose logs are not there any more, as a store remembers them.

    Parameters
    ----------
    manifest : with the runs that were found.
    known : the files of each run, by source. Those that the patterns do not match are left out: a store may come from
        anybody.
    """
    patterns = patterns_of(manifest)
    files = {
        name: {source: file for source, file in named.items() if source in patterns}
        for name, named in known.items()
        if wrong_name(name) is None
    }
    instead = instead_of(manifest)
    runs = {
        name: named
        for name, named in files.items()
        if not lacking_sources(patterns, named, instead)
        and all(_is_run(patterns[source].run_of(file), name) for source, file in named.items())
    }
    found = FoundFiles(runs, (), ())
    return manifest.model_copy(update={"runs": _runs(manifest, patterns, found)})


def _is_run(found: str | None, name: str) -> bool:
    return found is not None and natural_key(found) == natural_key(name)


def _with_files(manifest: Manifest) -> set[tuple[tuple[int, int, str], ...]]:
    return {natural_key(run.id) for run in manifest.runs if run.files}


def _runs(manifest: Manifest, patterns: Mapping[str, FilePattern], found: FoundFiles) -> tuple[Run, ...]:
    by_key = {natural_key(name): files for name, files in found.runs.items()}
    partly = {natural_key(entry.run): entry for entry in found.unpartnered}
    instead = instead_of(manifest)
    has_table = any(source.own_file is not None or source.files for source in manifest.sources.values())
    runs = []
    for run in manifest.runs:
        key = natural_key(run.id)
        if run.files:
            by_key.pop(key, None)
            runs.append(run)
            continue
        files = by_key.pop(key, None)
        if files is None and (key in partly or not has_table):
            present = dict(partly[key].files) if key in partly else {}
            lacking = lacking_sources(patterns, present, instead)
            expected = {instead.get(source, source): source for source in patterns}
            files = present | {expected[source]: patterns[expected[source]].file_of(run.id) for source in lacking}
        runs.append(run if files is None else run.model_copy(update={"files": dict(files)}))
    kind = type(manifest).run_type
    for name, files in found.runs.items():
        if natural_key(name) in by_key and wrong_name(name) is None:
            runs.append(kind(id=name, files=dict(files)))
    return tuple(sorted(runs, key=lambda run: (natural_key(run.id), run.id)))


def pattern_faults(manifest: Manifest, found: FoundFiles | None) -> list[Fault]:
    """Return what is wrong with the patterns of a manifest in themselves, and with the files that they match."""
    faults = []
    for name, source in manifest.sources.items():
        place = f"sources.{name}.file"
        pattern = source.pattern
        if pattern is None:
            continue
        if pattern.fault is not None:
            faults.append(Fault(FaultCode.VALUE_INVALID, MANIFEST_FILE, place, *pattern.fault))
        if source.run is not None:
            reason = "file names one log for each run, and run states that one file holds the rows of several"
            faults.append(Fault(FaultCode.KEY_CONFLICT, MANIFEST_FILE, place, reason, "keep one of file and run"))
    runs = {} if found is None else found.runs
    for entry in () if found is None else found.ambiguous:
        first, second = entry.files
        reason = f'{first} and {second} are both a log of run "{entry.run}"'
        files = dict(runs.get(entry.run, {})) | {entry.source: first}  # all: others are not matched then
        mend = (
            "write more of the name into the pattern, move one of them away, or name all files of the run: "
            f"[[runs]], {toml_text.pair('id', entry.run)}, {toml_text.pair('files', files)}"
        )
        faults.append(Fault(FaultCode.KEY_CONFLICT, MANIFEST_FILE, f"sources.{entry.source}.file", reason, mend))
    for name in runs:
        wrong = wrong_name(name)
        if wrong is not None:
            faults.append(Fault(FaultCode.NAME_INVALID, MANIFEST_FILE, "sources", *wrong))
    return faults


def nothing_found(manifest: Manifest, found: FoundFiles | None) -> list[tuple[str, str, str]]:
    """Return (place, reason, mend) of each source whose pattern gives no run, where there is no run at all."""
    if found is None or any(run.files for run in manifest.runs):
        return []
    sentences = []
    for name, pattern in patterns_of(manifest).items():
        place = f"sources.{name}.file"
        own = [entry.files[name] for entry in found.unpartnered if name in entry.files]
        if not own:
            sentences.append((place, f"no file matches {pattern.text}", "put the logs there, or correct the pattern"))
        elif all(name in entry.files for entry in found.unpartnered):
            continue
        else:
            names = ", ".join(_named([entry.run for entry in found.unpartnered if name in entry.files]))
            reason = f"no other source has a file of a run {names}"
            sentences.append((place, reason, "write patterns in which {run} stands for the same text in every source"))
    return sentences


def unpartnered_remarks(manifest: Manifest, found: FoundFiles | None) -> list[str]:
    """Return a sentence for files that are no run, as another source has none of that name."""
    if found is None:
        return []
    patterns, instead = patterns_of(manifest), instead_of(manifest)
    by_lack: dict[tuple[str, ...], list[Unpartnered]] = {}
    for entry in found.unpartnered:
        by_lack.setdefault(entry.lacking, []).append(entry)
    texts: dict[str, list[str]] = {}
    for source, pattern in patterns.items():
        texts.setdefault(instead.get(source, source), []).append(pattern.text)
    return [_lack(entries, [" or ".join(texts[source]) for source in lacking]) for lacking, entries in by_lack.items()]


def _lack(entries: Sequence[Unpartnered], patterns: Sequence[str]) -> str:
    files = ", ".join(_named([file for entry in entries for file in entry.files.values()]))
    one = len(entries) == 1
    runs = f'run "{entries[0].run}"' if one else f"{len(entries)} runs ({', '.join(_named([e.run for e in entries]))})"
    return f"{runs} not used: {files} without {' and '.join(patterns)} of the same run"


def _named(names: Sequence[str]) -> list[str]:
    more = len(names) - MOST_NAMED
    return [*names[:MOST_NAMED], *([f"{more} more"] if more > 0 else [])]
