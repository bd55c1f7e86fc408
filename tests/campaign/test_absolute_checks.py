"""Manifests with absolute runs: what is missing, and what cannot stand next to them, in one line each."""

from __future__ import annotations

from typing import Any

import pytest

from stiffcal.campaign.absolute_checks import absolute_faults
from stiffcal.campaign.manifest import Manifest
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


@pytest.mark.parametrize("kind", ["load", "clamped"])
def test_loads_need_a_campaign_of_their_own(kind: str) -> None:
    document = manifest().model_dump(by_alias=True, exclude_unset=True)
    document["runs"] = [*document["runs"], {"id": "push", "experiment": kind}]
    (fault,) = absolute_faults(Manifest.model_validate(document))
    assert fault.code is FaultCode.KEY_CONFLICT
    assert "push" in fault.place


def test_displacements_need_one_too() -> None:
    deflection = {"translation": ["dx", "dy", "dz"], "units": {"translation": "mm"}, "body": "target1", "axes": "base"}
    (fault,) = absolute_faults(manifest(deflection=deflection))
    assert fault.code is FaultCode.KEY_CONFLICT


def test_a_wrench_must_be_the_whole_load() -> None:
    wrench = {"columns": ["Fx", "Fy", "Fz"], "units": {"force": "N"}, "axes": "base", "point": "target1"}
    (fault,) = absolute_faults(manifest(wrench=wrench))
    assert fault.code is FaultCode.KEY_CONFLICT
    assert not list(absolute_faults(manifest(wrench=wrench | {"tared": "no"})))
