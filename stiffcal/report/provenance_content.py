"""Where a report comes from: campaign, programs, files and instruments, as they are printed."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class ReportSource:
    """A file the results rest on."""

    file: str
    """Path as in the manifest, relative to the campaign folder."""
    sha256: str
    """Hexadecimal digest of its bytes."""
    n_bytes: int
    """Its size."""


@dataclass(frozen=True)
class ReportProvenance:
    """Where the report comes from."""

    campaign: str
    """The campaign's name."""
    robot: str
    """The robot's name."""
    date: str
    """ISO date or date and time that is printed and put into the PDF, e.g. ``"2026-11-21"``. It is passed in, so that
    the same content gives the same bytes.
    """
    versions: tuple[tuple[str, str], ...] = ()
    """(program, version) pairs: stiffcal first, then what it computed with."""
    sources: tuple[ReportSource, ...] = ()
    """The files read: logs, manifest, robot file, model file."""
    settings: tuple[tuple[str, str], ...] = ()
    """(name, value) pairs that a customer may want: balance, weights, loss, …."""


@dataclass(frozen=True)
class ReportInstrument:
    """A sensor's signal, one line of the table of instruments."""

    source: str
    """The source's name in the manifest."""
    measures: str
    """What it measures, in words: "force and moment", "pose of target", "joint angles"."""
    detail: str = ""
    """In words: file format, frame, columns."""
    rate: float | None = None
    """Samples per second, None where states came averaged."""
    sigma: str = ""
    """Standard uncertainties with unit as they are to be printed, e.g. "0.016 mm, 0.03 mrad"; "" where not given."""
