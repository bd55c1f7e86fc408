"""What runs of absolute places need of the manifest, and what cannot stand next to them."""

from __future__ import annotations

from collections.abc import Iterator

from stiffcal.campaign.manifest import Manifest
from stiffcal.campaign.naming import MANIFEST_FILE
from stiffcal.campaign.signals import Wrench
from stiffcal.errors import Fault
from stiffcal.fault_codes import FaultCode

ABSOLUTE = "absolute"
"""As in ``experiment = "absolute"`` of a run."""
# Kinds whose load states go into the same fit; they carry an offset per run, which a place has not.
_OTHER_STATES = ("load", "clamped")


def absolute_faults(manifest: Manifest) -> Iterator[Fault]:
    """Check a manifest that has absolute runs; one without has none of these faults."""
    absolute = [(number, run) for number, run in enumerate(manifest.runs) if run.experiment == ABSOLUTE]
    if not absolute:
        return
    number, first = absolute[0]
    place = f"runs[{number + 1}] ({first.id})"
    poses = [pose for source in manifest.sources.values() for pose in source.body_poses().values()]
    if not poses:
        yield Fault(
            FaultCode.SIGNAL_MISSING, MANIFEST_FILE, place, "no source measures the place of a target",
            'add [sources.NAME.poses.TARGET] with frame = "tracker" and position = ["X", "Y", "Z"]',
        )  # fmt: skip
    for source, settings in manifest.sources.items():
        if settings.deflection is not None or settings.displacement is not None:
            yield Fault(
                FaultCode.KEY_CONFLICT, MANIFEST_FILE, f"sources.{source}",
                "displacements cannot be fitted together with absolute places",
                'give them a campaign of their own, or remove experiment = "absolute"',
            )  # fmt: skip
    for other_number, run in enumerate(manifest.runs):
        if run.experiment in _OTHER_STATES:
            yield Fault(
                FaultCode.KEY_CONFLICT, MANIFEST_FILE, f"runs[{other_number + 1}] ({run.id})",
                f'{run.experiment} runs cannot be fitted together with absolute ones ("{first.id}") in this version',
                "give them a campaign of their own",
            )  # fmt: skip
            return
    for source, name, signal in manifest.signals():
        if isinstance(signal, Wrench) and signal.tared != "no":
            yield Fault(
                FaultCode.KEY_CONFLICT, MANIFEST_FILE, f"sources.{source}.{name}.tared",
                f'absolute runs have no reference at which the wrench was zeroed ("{signal.tared}")',
                'write tared = "no" where the reading is the whole load, or use dead_weight',
            )  # fmt: skip
