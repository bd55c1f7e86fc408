"""Columns of campaign.toml: no column is read as two quantities."""

from __future__ import annotations

from collections.abc import Iterator

from stiffcal.campaign.manifest.manifest import Manifest
from stiffcal.campaign.signals.signals import JointSignals, Pose, Signal
from stiffcal.campaign.toml.naming import MANIFEST_FILE
from stiffcal.errors import Fault
from stiffcal.fault_codes import FaultCode


def column_faults(manifest: Manifest) -> Iterator[Fault]:
    """Check that two signals of a file, and two quantities of one signal, do not name the same column.

    Only keys of `joints` may share columns: a command that is the position, an approach that is the velocity.
    """
    for name, source in manifest.sources.items():
        first: dict[tuple[str, str], str] = {}
        for signal_name, signal in source.signals().items():
            place, file = f"sources.{name}.{signal_name}", source.files.get(signal_name, "")
            here: dict[tuple[str, str], str] = {}
            reported: set[str] = set()
            for key, column in _keys_and_columns(signal):
                earlier = first.get((file, column))
                if not isinstance(signal, JointSignals):
                    earlier = earlier or here.get((file, column))
                if earlier is not None and earlier not in reported:
                    # of several columns with the same mistake the first is enough
                    reported.add(earlier)
                    yield Fault(
                        FaultCode.KEY_CONFLICT, MANIFEST_FILE, f"{place}.{key}",
                        f'column "{column}" is named in {earlier} as well, and holds one quantity only',
                        "name the right column in each of the two places",
                        (column,),
                    )  # fmt: skip
                here.setdefault((file, column), f"{place}.{key}")
            first |= {column: at for column, at in here.items() if column not in first}


def _keys_and_columns(signal: Signal) -> Iterator[tuple[str, str]]:
    """Yield each column that a signal reads, with the key that names it."""
    if isinstance(signal, Pose):
        for marker, point in signal.markers.items():
            yield from ((f"markers.{marker}", column) for column in point.columns)
    columns = set(signal.column_names())
    for key in type(signal).model_fields:
        value = getattr(signal, key)
        named = value if isinstance(value, tuple) else (value,) if key.endswith("column") else ()
        yield from ((key, name) for name in named if name in columns)
