"""Manifests with absolute runs: what is missing, and what cannot stand next to them, in one line each."""

from __future__ import annotations

from typing import Any

from stiffcal.campaign.checks.absolute_checks import absolute_faults
from stiffcal.campaign.manifest.manifest import Manifest
from stiffcal.fault_codes import FaultCode

POSE = {"frame": "tracker", "position": ["X", "Y", "Z"], "units": {"position": "mm"}}


def manifest(run: str = "absolute", **table: Any) -> Manifest:
    source = {"file": "raw/poses.csv", "sampling": "states", "poses": {"target1": POSE}, **table}
    return Manifest.model_validate(
        {"schema": "stiffcal/campaign/1", "sources": {"table": source}, "runs": [{"id": "poses", "experiment": run}]}
    )


def test_a_whole_one_has_no_fault() -> None:
    assert not list(absolute_faults(manifest()))
    assert not list(absolute_faults(manifest("load", poses={})))


def test_a_place_must_be_measured() -> None:
    (fault,) = absolute_faults(manifest(poses={}))
    assert fault.code is FaultCode.SIGNAL_MISSING


def with_run(document: Manifest, **run: Any) -> Manifest:
    written = document.model_dump(by_alias=True, exclude_unset=True)
    written["runs"] = [*written["runs"], run]
    return Manifest.model_validate(written)


def test_clamped_runs_need_a_campaign_of_their_own() -> None:
    (fault,) = absolute_faults(with_run(manifest(), id="drive", experiment="clamped"))
    assert fault.code is FaultCode.KEY_CONFLICT
    assert "drive" in fault.place
    assert not list(absolute_faults(with_run(manifest(), id="push", experiment="load")))


def test_displacements_need_load_runs() -> None:
    deflection = {"translation": ["dx", "dy", "dz"], "units": {"translation": "mm"}, "body": "target1", "axes": "base"}
    (fault,) = absolute_faults(manifest(deflection=deflection))
    assert fault.code is FaultCode.KEY_CONFLICT
    assert not list(absolute_faults(with_run(manifest(deflection=deflection), id="push", experiment="load")))


def test_a_wrench_must_be_the_whole_load() -> None:
    wrench = {"columns": ["Fx", "Fy", "Fz"], "units": {"force": "N"}, "axes": "base", "point": "target1"}
    (fault,) = absolute_faults(manifest(wrench=wrench))
    assert fault.code is FaultCode.KEY_CONFLICT
    assert not list(absolute_faults(manifest(wrench=wrench | {"tared": "no"})))
    # a table of all runs may hold loads of other runs: rows are looked at when they are read
    assert not list(absolute_faults(with_run(manifest(wrench=wrench), id="push", experiment="load")))


def test_a_zeroed_sensor_may_serve_other_runs_but_not_an_absolute_one() -> None:
    wrench = {"columns": ["Fx", "Fy", "Fz"], "units": {"force": "N"}, "axes": "base", "point": "target1"}
    written = with_run(manifest(), id="push", experiment="load").model_dump(by_alias=True, exclude_unset=True)
    written["sources"]["ft"] = {"sampling": "states", "wrench": wrench}
    written["sources"]["table"].pop("file")
    written["runs"][0]["files"] = {"table": "raw/poses.csv"}
    written["runs"][1]["files"] = {"table": "raw/push.csv", "ft": "raw/ft.csv"}
    assert not list(absolute_faults(Manifest.model_validate(written)))
    written["runs"][0]["files"]["ft"] = "raw/ft0.csv"
    (fault,) = absolute_faults(Manifest.model_validate(written))
    assert fault.place == "sources.ft.wrench.tared"


def test_the_order_of_approach_is_that_of_absolute_runs() -> None:
    assert not list(absolute_faults(manifest(joints={"position": "A1..A6", "approach": "D1..D6"})))
    (fault,) = absolute_faults(manifest("load", joints={"position": "A1..A6", "approach": "D1..D6"}))
    assert fault.code is FaultCode.KEY_CONFLICT
    assert fault.place == "sources.table.joints.approach"
    direct = with_run(manifest(), id="push", experiment="load", approach="direct")
    (fault,) = absolute_faults(direct)
    assert "push" in fault.place


def test_a_measured_frame_is_not_attached_to_an_estimated_one() -> None:
    poses = {"point": POSE | {"position": ["X1", "Y1", "Z1"]}}
    written = manifest(poses=poses).model_dump(by_alias=True, exclude_unset=True)
    written["frames"] = {
        "tracker": {"parent": "base", "estimate": True},
        "plate": {"parent": "flange", "estimate": True},
        "point": {"parent": "plate"},
    }
    (fault,) = absolute_faults(Manifest.model_validate(written))
    assert (fault.code, fault.place) == (FaultCode.FRAME_UNSUITABLE, "frames.plate.estimate")
    assert "markers" in fault.mend
    written["frames"]["plate"]["estimate"] = False
    written["frames"]["point"]["estimate"] = True
    assert not list(absolute_faults(Manifest.model_validate(written)))
