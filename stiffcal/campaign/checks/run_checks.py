"""Runs and excluded rows: every name means something, and no two runs claim the same log."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Collection, Iterator
from difflib import get_close_matches

from stiffcal.campaign.manifest.manifest import Manifest
from stiffcal.campaign.toml.naming import MANIFEST_FILE
from stiffcal.errors import Fault
from stiffcal.fault_codes import FaultCode

MOST_LOOKED_FOR = 100
"""Faults of one kind that are looked for: who has corrected these will ask again."""
MOST_COMPARED = 300  # names that a misspelt one is compared with: each comparison takes a tenth of a millisecond


def run_faults(manifest: Manifest) -> Iterator[Fault]:
    """Check the runs' names, the sources they name, and that each log belongs to one run."""
    counts = Counter(run.id for run in manifest.runs)
    earlier: set[str] = set()
    logs = _Logs(manifest)
    no_source_has_a_file = not any(source.own_file is not None or source.files for source in manifest.sources.values())
    for number, run in enumerate(manifest.runs):
        place = f"runs[{number + 1}] ({run.id})"
        if run.id in earlier:
            yield _fault(
                FaultCode.NAME_DUPLICATE,
                place,
                f'{counts[run.id]} runs have the name "{run.id}"',
                "give each run a unique name",
                run.id,
            )
        earlier.add(run.id)
        for key, names in (("files", run.files), ("clock_ahead_s", run.clock_ahead_s)):
            for name in names:
                if name not in manifest.sources:
                    reason = f'there is no source "{name}"'
                    yield _fault(
                        FaultCode.SOURCE_UNKNOWN, f"{place}.{key}.{name}", reason, choices(name, manifest.sources), name
                    )
        yield from logs.faults(number, place)
        if not run.files and manifest.sources and no_source_has_a_file:
            yield _fault(FaultCode.KEY_MISSING, place, "the run has no files", 'add files = { SOURCE = "raw/…" }')


class _Logs:
    """Which runs name which log, among those that were asked about so far."""

    def __init__(self, manifest: Manifest) -> None:
        self._manifest = manifest
        self._split = {entry.run for entry in manifest.exclude}
        self._earlier: dict[tuple[str, str, str | None], list[str]] = defaultdict(list)

    def faults(self, number: int, place: str) -> Iterator[Fault]:
        """See that a run does not name an earlier run's log, unless rows or holds keep the two apart."""
        run = self._manifest.runs[number]
        for name, file in run.files.items():
            if name not in self._manifest.sources or self._manifest.sources[name].run is not None:
                continue
            if run.id in self._split:  # rows keep it apart from every other run
                continue
            earlier = self._earlier[(name, file, run.states)]
            other_run = next((identifier for identifier in earlier if identifier != run.id), None)
            if other_run is not None:
                reason = f"{file} is also used by run {other_run}"
                yield _fault(FaultCode.KEY_CONFLICT, f"{place}.files.{name}", reason, "give the log of this run")
            if len(earlier) < 2 and run.id not in earlier:  # the first, and one of another name than the first
                earlier.append(run.id)


def exclusion_faults(manifest: Manifest) -> Iterator[Fault]:
    """Check that excluded rows name a source, and a run where each run has its own file."""
    runs = {run.id for run in manifest.runs}
    in_later_runs = {name for run in manifest.runs[1:] for name in run.files}
    for number, entry in enumerate(manifest.exclude):
        place = f"exclude[{number + 1}]"
        if entry.source not in manifest.sources:
            reason = f'there is no source "{entry.source}"'
            mend = choices(entry.source, manifest.sources)
            yield _fault(FaultCode.SOURCE_UNKNOWN, f"{place}.source", reason, mend, entry.source)
        elif entry.run is None and entry.source in in_later_runs:
            yield _fault(
                FaultCode.KEY_MISSING,
                place,
                "each run has its own file, so a row number is not unique",
                "add run = …",
            )
        if entry.run is not None and runs and entry.run not in runs:
            yield _fault(
                FaultCode.RUN_UNKNOWN,
                f"{place}.run",
                f'there is no run "{entry.run}"',
                choices(entry.run, sorted(runs)),
                entry.run,
            )


def choices(wrong: str, known: Collection[str]) -> str:
    """Return the mend of a name that does not exist: the names to choose from."""
    names = list(known)[:MOST_COMPARED]
    suggestions = get_close_matches(wrong, names, n=1)
    if suggestions:
        return f'did you mean "{suggestions[0]}"?'
    return "use one of " + ", ".join(names) if names else "describe it first"


def _fault(code: FaultCode, place: str, reason: str, mend: str, *names: str) -> Fault:
    return Fault(code, MANIFEST_FILE, place, reason, mend, names)
