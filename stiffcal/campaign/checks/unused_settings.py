"""What campaign.toml states and nothing of the campaign reads: a frame, a rod, a unit, an option, a key of a run."""

from __future__ import annotations

from collections.abc import Collection, Iterator

from stiffcal.campaign.checks.source_checks import frames_of_signal
from stiffcal.campaign.found.experiment_kinds import OF_SOME_KINDS, kinds_that_read
from stiffcal.campaign.found.file_formats import format_names
from stiffcal.campaign.manifest.manifest import Manifest
from stiffcal.campaign.manifest.source import Source
from stiffcal.campaign.signals.displacement_signals import WITHOUT_UNIT
from stiffcal.campaign.signals.signals import Deflection, JointSignals, Lengths, Pose, Signal, Wrench
from stiffcal.campaign.toml.naming import MANIFEST_FILE


def unused_settings(manifest: Manifest, named: Collection[str] = ()) -> list[str]:
    """Return a sentence for each setting of a manifest that nothing reads, in the order of the file.

    Parameters
    ----------
    manifest : checked, with the runs that were found. named : frames that another file of the campaign names.
    """
    unused = [*_frames(manifest, named), *_of_sources(manifest), *_rods(manifest), *_of_runs(manifest)]
    return [f"{MANIFEST_FILE}: {place} is not used: {why}" for place, why in unused]


def _frames(manifest: Manifest, named: Collection[str]) -> Iterator[tuple[str, str]]:
    """Yield the frames that no signal names and in which no such frame lies."""
    waiting = [*named]
    waiting += [frame for _, name, signal in manifest.signals() for _, frame in frames_of_signal(signal, name)]
    waiting += [marker for _, _, signal in manifest.signals() if isinstance(signal, Pose) for marker in signal.markers]
    used: set[str] = set()
    while waiting:
        name = waiting.pop()
        if name in manifest.frames and name not in used:
            used.add(name)
            waiting.append(manifest.frames[name].parent)
    for name in manifest.frames:
        if name not in used:
            mend = "name it there (frame, axes, point or body), or remove it"
            yield f"frames.{name}", f"no signal refers to it; {mend}"


def _rods(manifest: Manifest) -> Iterator[tuple[str, str]]:
    read = {column for _, _, signal in manifest.signals() if isinstance(signal, Lengths) for column in signal.columns}
    for name in manifest.ids:
        if name not in read:
            yield f"ids.{name}", "no lengths signal has such a column; name the column after the rod, or remove it"


def _of_sources(manifest: Manifest) -> Iterator[tuple[str, str]]:
    for name, source in manifest.sources.items():
        yield from _options(manifest, name, source)
        for key, signal in source.signals().items():
            place = f"sources.{name}.{key}"
            for of_table, quantities in (("units", _without_unit(signal)), ("sigma", _not_measured(signal))):
                table = getattr(signal, of_table, None)
                written = () if table is None else table.model_fields_set
                for quantity in quantities:
                    if quantity in written:
                        yield f"{place}.{of_table}.{quantity}", "no column of this signal holds it; remove it"
            if isinstance(signal, JointSignals) and signal.torque_constant is not None and signal.current is None:
                yield f"{place}.torque_constant", "no currents are read; name their columns as current, or remove it"


def _options(manifest: Manifest, name: str, source: Source) -> Iterator[tuple[str, str]]:
    """Yield the tables of options of formats that none of a source's logs has."""
    files = [*source.files.values(), *([source.file] if source.file is not None else [])]
    files += [run.files[name] for run in manifest.runs if name in run.files]
    formats = {source.format_for(file) for file in files}
    if not formats or None in formats:
        return
    for other in format_names():
        if source.options_of(other) and other not in formats:
            own = " and ".join(sorted(str(found) for found in formats))
            yield f"sources.{name}.{other}", f"its logs are {own}; remove it, or write format = …"


def _not_measured(signal: Signal) -> tuple[str, ...]:
    """Return the quantities of a signal of which it has no columns."""
    if isinstance(signal, Wrench) and not signal.moments_measured:
        return ("moment",)
    if (isinstance(signal, Pose) and signal.orientation is None and not signal.markers) or (
        isinstance(signal, Deflection) and signal.rotation is None
    ):
        return ("rotation",)
    if isinstance(signal, JointSignals):
        groups = signal.groups()
        return tuple(key for key in ("velocity", "torque", "current") if key not in groups)
    return ()


def _without_unit(signal: Signal) -> tuple[str, ...]:
    """Return the quantities of a signal of which no column has a unit."""
    orientation = signal.orientation if isinstance(signal, Pose) else None
    return _not_measured(signal) + (("rotation",) if orientation is not None and orientation[0] in WITHOUT_UNIT else ())


def _of_runs(manifest: Manifest) -> Iterator[tuple[str, str]]:
    readers = kinds_that_read() if any(run.model_fields_set & OF_SOME_KINDS for run in manifest.runs) else {}
    for number, run in enumerate(manifest.runs):
        for key, kinds in readers.items():
            if key in run.model_fields_set and run.experiment not in kinds:
                why = f"it is for runs of kind {' or '.join(kinds)}, and this one is {run.experiment}; remove it"
                yield f"runs[{number + 1}] ({run.id}).{key}", why
