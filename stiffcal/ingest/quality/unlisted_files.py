"""Files that `[[runs]]` does not list, though they are named like the logs of a source that it lists."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from stiffcal.campaign.loading import Campaign
from stiffcal.campaign.manifest.file_patterns import RUN, FilePattern, files_of_runs
from stiffcal.campaign.manifest.manifest import Manifest, Run
from stiffcal.errors import InputError
from stiffcal.escapes import toml_text
from stiffcal.natural_order import natural_key
from stiffcal.propose.run_names import patterns_of_devices, shape_of
from stiffcal.readers import find_reader
from stiffcal.reduction.logs.log_rows import reader_options, wanted_columns
from stiffcal.reduction.logs.names import names_in_file


@dataclass(frozen=True)
class UnlistedRun:
    """Logs of one run by the source that they are named like."""

    files: Mapping[str, str]
    """Those that no run lists, by source."""
    lines: tuple[str, ...]
    """Of the manifest, to copy."""


def unlisted_runs(campaign: Campaign, files: Sequence[str]) -> list[UnlistedRun]:
    """Return the runs that files make which are named like the logs that `[[runs]]` lists, and have their columns.

    Parameters
    ----------
    campaign : as it was read. files : those that nothing names.
    """
    manifest = campaign.manifest
    patterns = _patterns(manifest, files)
    matches = {
        source: [
            (file, name)
            for file in files
            if (name := pattern.run_of(file)) is not None and _has_columns(campaign, source, file)
        ]
        for source, pattern in patterns.items()
    }
    found = files_of_runs({source: pairs for source, pairs in matches.items() if pairs}, patterns)
    by_name = {**found.runs, **{entry.run: entry.files for entry in found.unpartnered}}
    listed = {
        natural_key(name): run
        for run in manifest.runs
        for source, file in run.files.items()
        if source in patterns and (name := patterns[source].run_of(file)) is not None
    }
    return [
        UnlistedRun(files, tuple(_lines(name, files, tuple(patterns), listed.get(natural_key(name)))))
        for name, files in sorted(by_name.items(), key=lambda entry: (natural_key(entry[0]), entry[0]))
    ]


def _patterns(manifest: Manifest, files: Sequence[str]) -> dict[str, FilePattern]:
    """Return the pattern of each source's logs as the runs list them; none of those whose names show no run."""
    listed: dict[str, list[tuple[str, str]]] = {}
    for run in manifest.runs:
        for source, file in run.files.items():
            if manifest.sources[source].pattern is None:
                listed.setdefault(source, []).append((run.id, file))
    templates = {source: {file.replace(name, RUN) for name, file in pairs} for source, pairs in listed.items()}
    if all(len(own) == 1 and RUN in next(iter(own)) for own in templates.values()):
        texts = {source: own.pop() for source, own in templates.items()}
    else:  # the runs have other names than their logs
        shapes = {source: {shape_of(file) for _, file in pairs} for source, pairs in listed.items()}
        texts = patterns_of_devices({
            source: [*(file for _, file in pairs), *(file for file in files if shape_of(file) in shapes[source])]
            for source, pairs in listed.items()
        })  # fmt: skip
    return {source: FilePattern(text) for source, text in texts.items() if RUN in text}


def _has_columns(campaign: Campaign, source: str, file: str) -> bool:
    """Return whether a file has the columns of a source's logs."""
    settings = campaign.manifest.sources[source]
    path = Path(campaign.folder) / file
    try:
        reader = find_reader(path, settings.format_for(file), file)
        columns = reader.read_header(path, reader_options(settings, reader.name, file), file).columns
    except InputError:
        return False
    wanted = wanted_columns(settings, None)
    renamed = names_in_file(wanted, lambda: columns)
    return {renamed.get(name, name) for name in wanted.names} <= set(columns)


def _lines(name: str, files: Mapping[str, str], sources: Sequence[str], listed: Run | None) -> Iterator[str]:
    """Yield the lines of a run; `listed`: the manifest's entry of it, None where it has none."""
    there = {**(listed.files if listed is not None else {}), **files}
    pair = toml_text.pair("files", {source: there[source] for source in sources if source in there})
    if listed is not None:
        yield f"# in its run, {toml_text.pair('id', listed.id)}: {pair}"
        return
    yield from ("[[runs]]", toml_text.pair("id", name), pair)
    lacking = [source for source in sources if source not in there]
    if lacking:
        yield f"# a log of {', '.join(lacking)} that is named like the others is not there yet"
