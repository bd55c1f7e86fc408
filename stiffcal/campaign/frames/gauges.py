"""Rods and gauges of the manifest, put on the robot: what integral deformation sensors and dial gauges are fixed to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.campaign.manifest.manifest import Manifest
from stiffcal.campaign.signals.signals import Displacement, Lengths
from stiffcal.campaign.toml.naming import body_number
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.measurements.load_states import Attachment, Gauge
from stiffcal.measurements.rods import BeamProperties, Rods, rods_between
from stiffcal.mechanics.chain import Chain


def rods_of(manifest: Manifest, chain: Chain) -> tuple[tuple[Rods, BeamProperties], ...]:
    """Return the rods that some source logs, link by link, with what their link's field needs to know of it.

    Columns that nothing places on a link are a fault of the manifest, reported by `stiffcal.campaign.checks.together`.

    Raises
    ------
    InputError
        A rod sits on a link that is no beam, or its ends are one point.
    """
    sigma = _stated_sigma_of_rods(manifest)
    columns = [
        name for _, _, signal in manifest.signals() if isinstance(signal, Lengths) for name in signal.column_names()
    ]
    rods: dict[str, list[str]] = {}
    for name in dict.fromkeys(column for column in columns if column in manifest.ids):
        rods.setdefault(_link_of(name, manifest, chain), []).append(name)
    return tuple(
        (
            _rods_on(link, tuple(names), manifest, chain, np.array([sigma.get(name, np.nan) for name in names])),
            chain.beams[link].shape,
        )
        for link, names in rods.items()
    )


def _rods_on(link: str, names: tuple[str, ...], manifest: Manifest, chain: Chain, sigma: Floats) -> Rods:
    """Put the rods of one link; their warping as written, else as the drawn section has it."""
    start = np.array([manifest.ids[name].start_m for name in names])
    end = np.array([manifest.ids[name].end_m for name in names])
    section = chain.beams[link].section
    warping = np.full((len(names), 2), np.nan)
    if section is not None:
        warping = np.column_stack([section.warping_at(start[:, 1:]), section.warping_at(end[:, 1:])])
    for row, name in enumerate(names):
        stated = manifest.ids[name].warping_m2
        if stated is not None:
            warping[row] = stated
    rods = replace(rods_between(link, start, end, names=names), warping=warping, sigma=sigma)
    return replace(rods, growth=rods.length * _expansion_next_to(link, names, manifest, chain))


def _expansion_next_to(link: str, names: tuple[str, ...], manifest: Manifest, chain: Chain) -> Floats:
    """Return (m,) by how much the link expands more than each rod, 1/K; NaN where the rod's own is not written."""
    own = chain.beams[link].expansion
    written = [name for name in names if manifest.ids[name].expansion_per_K is not None]
    if written and own is None:
        reason = f"the thermal expansion of {link} is not given, and a rod reads the difference of the two"
        mend = f"add [links.{link}] expansion_per_K to robot.toml, or leave it out here"
        raise InputError.at(FaultCode.KEY_MISSING, "campaign.toml", f"ids.{written[0]}.expansion_per_K", reason, mend)
    rods = (manifest.ids[name].expansion_per_K for name in names)
    return np.array([np.nan if rod_expansion is None or own is None else own - rod_expansion for rod_expansion in rods])


def _link_of(name: str, manifest: Manifest, chain: Chain) -> str:
    """Return the beam that a rod sits on, by its name in the chain."""
    entry, beams = manifest.ids[name], chain.beams
    number = body_number(entry.link, chain.link_names)
    link = next((link for link, beam in beams.items() if link == entry.link or beam.joint == number), None)
    if link is None:
        reason = f'"{entry.link}" is not a link that can bend: it connects no two joints that are 50 mm apart'
        mend = f"name one of {', '.join(beams)}" if beams else "leave the rods out"
        raise InputError.at(FaultCode.LINK_UNKNOWN, "campaign.toml", f"ids.{name}.link", reason, mend)
    if entry.start_m == entry.end_m:
        reason = "start_m and end_m are the same point"
        mend = "give the fixed end and the measured end of the rod"
        raise InputError.at(FaultCode.VALUE_INVALID, "campaign.toml", f"ids.{name}", reason, mend)
    return link


def gauges_of(manifest: Manifest, frames: Mapping[str, Attachment], targets: tuple[str, ...]) -> tuple[Gauge, ...]:
    """Return the gauges in the manifest's order: one for each source with a `displacement` signal."""
    gauges = []
    for source, settings in manifest.sources.items():
        gauge = settings.displacement
        if gauge is not None:
            direction = np.array(gauge.direction)
            direction = direction / np.linalg.norm(direction)
            gauges.append(Gauge(source, targets.index(gauge.body), frames[gauge.axes], direction))
    return tuple(gauges)


def metres_of_rods(manifest: Manifest) -> dict[str, float]:
    """Return how many metres a unit of each logged rod's reading is, by the rod's name.

    Of a strain it is the rod's length, from its ends, times the unit. Rods that nothing places on a link are left out.
    """
    metres = {}
    for _, _, signal in manifest.signals():
        if not isinstance(signal, Lengths):
            continue
        written = signal.unit_of("length")
        for name in signal.columns:
            if written.quantity == "length":
                metres[name] = written.factor
            elif name in manifest.ids:
                rod = manifest.ids[name]
                metres[name] = written.factor * float(np.linalg.norm(np.subtract(rod.end_m, rod.start_m)))
    return metres


def _stated_sigma_of_rods(manifest: Manifest) -> dict[str, float]:
    """Return the standard uncertainty of each rod whose signal states one, m."""
    metres = metres_of_rods(manifest)
    return {
        name: signal.sigma.length * metres[name]
        for _, _, signal in manifest.signals()
        if isinstance(signal, Lengths) and signal.sigma is not None and signal.sigma.length is not None
        for name in signal.columns
        if name in metres
    }


def sigma_of_rods(manifest: Manifest) -> float | None:
    """Return the stated standard uncertainty of rods, m, None where none is; of several the root of the mean square."""
    stated = list(_stated_sigma_of_rods(manifest).values())
    return float(np.sqrt(np.mean(np.square(stated)))) if stated else None


def sigma_of_gauges(manifest: Manifest) -> float | None:
    """Return the stated standard uncertainty of gauges, m: the first that states one."""
    for _, _, signal in manifest.signals():
        if isinstance(signal, Displacement) and signal.sigma is not None and signal.sigma.length is not None:
            return float(signal.sigma.length * signal.unit_of("length").factor)
    return None
