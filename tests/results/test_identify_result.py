"""What `identify` answers: every key of its document is read back, and further kinds of experiment keep theirs."""

from __future__ import annotations

import math
from dataclasses import replace

from stiffcal.documents import document_of
from tests.laboratory.fits import fit_of, parameter


def test_a_compliance_keeps_its_keys_where_its_stiffness_is_not_known() -> None:
    known = {"stiffness": None, "stiffness_std": None, "stiffness_interval": None}
    spring = parameter("joint-compliance.j2.c", None, where={"joints": [2]}, **known)
    assert spring.is_compliance
    assert spring.known_stiffness is None
    assert math.isnan(spring.stiffness or 0.0)
    assert document_of(spring).items() >= known.items()


def test_what_is_no_compliance_has_no_stiffness() -> None:
    play = parameter("backlash.j4.width", 1e-3, 1e-4, unit="rad")
    assert not play.is_compliance
    assert not {"stiffness", "stiffness_std", "stiffness_interval"} & document_of(play).keys()


def test_a_fit_is_read_back_as_it_was_written() -> None:
    fit = fit_of(
        parameters=[document_of(parameter("backlash.j4.width", 1e-3, 1e-4, where={"joints": [4]}, unit="rad"))],
        n_readings=12,
        rms={"translation": None, "rotation": None, "torque": 0.5, "motor_angle": None},
        free_parameters=["backlash.j4.width"],
        covariance=[[1e-8]],
        fit_id="3",
    )
    document = document_of(fit)
    assert document["rms"] == {"translation": None, "rotation": None, "torque": 0.5, "motor_angle": None}
    assert document_of(fit_of(**document)) == document


def test_the_noise_per_axis_is_a_key_of_fits_of_load_states_alone() -> None:
    assert document_of(fit_of())["noise_per_axis"] is None
    assert "noise_per_axis" not in document_of(fit_of(n_readings=12))


def test_a_further_kind_of_experiment_has_a_key_of_its_own() -> None:
    fit = replace(fit_of(), sections={"probing": {"plates": 2}})
    assert document_of(fit)["probing"] == {"plates": 2}
    assert "sections" not in document_of(fit)
