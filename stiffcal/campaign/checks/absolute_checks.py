"""What runs of absolute places need of the manifest, and what cannot stand next to them."""

from __future__ import annotations

from collections.abc import Iterator

from stiffcal.campaign.found.experiment_kinds import any_measures, measure_of, reads
from stiffcal.campaign.manifest.manifest import Manifest
from stiffcal.campaign.signals.signals import JointSignals, Wrench
from stiffcal.campaign.toml.naming import MANIFEST_FILE
from stiffcal.errors import Fault
from stiffcal.escapes import toml_text
from stiffcal.fault_codes import FaultCode
from stiffcal.measurements.state_measures import StateMeasure


def absolute_sources(manifest: Manifest) -> frozenset[str]:
    """Return the names of the sources that absolute runs read: tables of all runs where such a run names no file."""
    runs = [run for run in manifest.runs if measure_of(run.experiment) is StateMeasure.PLACE]
    any_table = any(not run.files for run in runs)
    return frozenset(
        name
        for name in manifest.sources
        if any(name in run.files for run in runs) or (any_table and manifest.files_of(name))
    )


def _torques_without_places(manifest: Manifest) -> Iterator[Fault]:
    for source, name, signal in manifest.signals():
        if isinstance(signal, JointSignals) and signal.torque_gain_sigma is not None:
            reason = 'torque_gain_sigma applies to absolute runs, and no run has experiment = "absolute"'
            place = f"sources.{source}.{name}.torque_gain_sigma"
            yield Fault(FaultCode.KEY_CONFLICT, MANIFEST_FILE, place, reason, "remove torque_gain_sigma")


def _approach_without_places(manifest: Manifest) -> Iterator[Fault]:
    """Check that the order of approach is stated of absolute runs alone, and that their rows are a sequence."""
    for number, run in enumerate(manifest.runs):
        if run.approach is not None and not reads(run.experiment, "approach"):
            place = f"runs[{number + 1}] ({run.id}).approach"
            reason = f"approach applies to absolute runs, and this one is {run.experiment}"
            yield Fault(FaultCode.KEY_CONFLICT, MANIFEST_FILE, place, reason, "remove approach")
    if any_measures((run.experiment for run in manifest.runs), StateMeasure.PLACE):
        return
    for source, name, signal in manifest.signals():
        if isinstance(signal, JointSignals) and signal.approach is not None:
            reason = 'approach applies to absolute runs, and no run has experiment = "absolute"'
            place = f"sources.{source}.{name}.approach"
            yield Fault(FaultCode.KEY_CONFLICT, MANIFEST_FILE, place, reason, "remove approach")


def _estimated_carriers(manifest: Manifest) -> Iterator[Fault]:
    """Check that no measured frame is attached to another one that is estimated: a fit moves measured frames singly."""
    measured = [body for source in manifest.sources.values() for body in source.body_poses()]
    for body in dict.fromkeys(measured):
        carrier, passed = body, {body}
        while carrier in manifest.frames and (carrier := manifest.frames[carrier].parent) not in passed:
            passed.add(carrier)
            if carrier in manifest.frames and manifest.frames[carrier].estimate:
                mend = (
                    f"list the points as markers of one body, {toml_text.pair('markers', {body: ['X', 'Y', 'Z']})} "
                    f"with their columns under [sources.NAME.poses.{toml_text.key(carrier)}], or give {carrier} and "
                    f"estimate {body}"
                )
                reason = f"{body} is measured and attached to this frame, which is estimated"
                yield Fault(FaultCode.FRAME_UNSUITABLE, MANIFEST_FILE, f"frames.{carrier}.estimate", reason, mend)
                return


def absolute_faults(manifest: Manifest) -> Iterator[Fault]:
    """Check what absolute runs need, and what counts in them alone."""
    yield from _approach_without_places(manifest)
    measures = [measure_of(run.experiment) for run in manifest.runs]
    absolute = [(k, manifest.runs[k]) for k, measure in enumerate(measures) if measure is StateMeasure.PLACE]
    if not absolute:
        yield from _torques_without_places(manifest)
        return
    number, first = absolute[0]
    place = f"runs[{number + 1}] ({first.id})"
    with_loads = any_measures((run.experiment for run in manifest.runs), StateMeasure.DISPLACEMENT)
    poses = [pose for source in manifest.sources.values() for pose in source.body_poses().values()]
    if not poses:
        yield Fault(
            FaultCode.SIGNAL_MISSING, MANIFEST_FILE, place, "no source measures the position of a target",
            'add [sources.NAME.poses.TARGET] with frame = "tracker" and position = ["X", "Y", "Z"]',
        )  # fmt: skip
    yield from _estimated_carriers(manifest)
    for source, settings in manifest.sources.items():
        if not with_loads and (settings.deflection is not None or settings.displacement is not None):
            yield Fault(
                FaultCode.KEY_CONFLICT, MANIFEST_FILE, f"sources.{source}",
                "no run is a load run, and absolute runs contain positions, not displacements",
                'list the runs with displacements in [[runs]] with experiment = "load", or remove the signal',
            )  # fmt: skip
    for other_number, run in enumerate(manifest.runs):
        if measure_of(run.experiment) is StateMeasure.MOTOR_ANGLE:
            yield Fault(
                FaultCode.KEY_CONFLICT, MANIFEST_FILE, f"runs[{other_number + 1}] ({run.id})",
                f'clamped runs cannot be fitted together with absolute ones ("{first.id}") in this version',
                "put them into a separate campaign",
            )  # fmt: skip
            return
    of_absolute = absolute_sources(manifest)
    for source, name, signal in manifest.signals():
        if not isinstance(signal, Wrench) or signal.tared == "no" or source not in of_absolute:
            continue
        if with_loads and manifest.files_of(source):
            continue  # a table of all runs: whether it has a load in rows of absolute runs is known when it is read
        yield Fault(
            FaultCode.KEY_CONFLICT, MANIFEST_FILE, f"sources.{source}.{name}.tared",
            f'absolute runs have no reference at which the wrench was zeroed ("{signal.tared}")',
            'write tared = "no" if the reading is the total load, or use dead_weight',
        )  # fmt: skip
