"""A loose rod, one of swapped sign, two exchanged, a drifting gauge: named; and nothing where nothing is wrong."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.measurements.rods import BeamProperties, Rods
from stiffcal.mechanics.rods import rod_matrix
from stiffcal.mistakes.rods.faults import RodFault, find_rod_faults
from tests.laboratory.dropped_in import dropped_in
from tests.links.test_compliance import loads
from tests.links.test_rods import SHAPE, compliance, paper_rods, seven_rods

STATES, NOISE = 60, 1e-6
TIME, RUN = np.tile(np.arange(20.0) * 5.0, 3) + np.repeat([0.0, 200.0, 400.0], 20), np.repeat([0, 1, 2], 20)


def readings(rods: Rods, shape: BeamProperties = SHAPE, seed: int = 1) -> tuple[Floats, Floats]:
    wrench = loads(STATES, seed)
    read = wrench @ compliance(shape) @ rod_matrix(rods, shape).T
    return read + NOISE * np.random.default_rng(seed + 50).standard_normal(read.shape), wrench


def loose(read: Floats, rod: int) -> Floats:
    """A rod that slips in its seat: a third of the way is lost, with a dead band of a third of what it reads."""
    spoiled = read.copy()
    band = 0.3 * np.std(read[:, rod])
    spoiled[:, rod] = 0.66 * np.sign(read[:, rod]) * np.maximum(np.abs(read[:, rod]) - band, 0.0)
    return spoiled


def swapped(read: Floats, rod: int) -> Floats:
    spoiled = read.copy()
    spoiled[:, rod] *= -1.0
    return spoiled


def exchanged(read: Floats, one: int, other: int) -> Floats:
    spoiled = read.copy()
    spoiled[:, [one, other]] = spoiled[:, [other, one]]
    return spoiled


def drifting(read: Floats, rod: int) -> Floats:
    spoiled = read.copy()
    spoiled[:, rod] += 0.1e-6 * (TIME - np.repeat([0.0, 200.0, 400.0], 20))
    return spoiled


def only(faults: tuple[RodFault, ...]) -> RodFault:
    assert len(faults) == 1, faults
    return faults[0]


FIVE, UNSTATED, SEVEN = paper_rods(NOISE), paper_rods(), seven_rods(NOISE)
CASES = [(FIVE, 0), (FIVE, 1), (FIVE, 2), (FIVE, 3), (FIVE, 4), (UNSTATED, 2), (UNSTATED, 4), (SEVEN, 3), (SEVEN, 6)]


@pytest.mark.parametrize(("rods", "rod"), CASES)
def test_one_wrong_rod_is_named_by_the_load(rods: Rods, rod: int) -> None:
    read, wrench = readings(rods)
    fault = only(find_rod_faults(rods, SHAPE, swapped(read, rod), wrench, TIME, RUN))
    assert (fault.kind, fault.rods) == ("swapped-sign", (rods.names[rod],))
    fault = only(find_rod_faults(rods, SHAPE, drifting(read, rod), wrench, TIME, RUN))
    assert (fault.kind, fault.rods) == ("drifting", (rods.names[rod],))
    assert fault.size == pytest.approx(0.1e-6 * 95.0 / np.sqrt(3.0), rel=0.25)
    fault = only(find_rod_faults(rods, SHAPE, loose(read, rod), wrench, TIME, RUN))
    assert (fault.kind, fault.rods) == ("loose", (rods.names[rod],))


@pytest.mark.parametrize("pair", [(0, 1), (1, 2), (3, 4), (2, 4), (0, 3)])
def test_two_exchanged_rods_are_named_by_the_load(pair: tuple[int, int]) -> None:
    rods = paper_rods(NOISE)
    read, wrench = readings(rods)
    fault = only(find_rod_faults(rods, SHAPE, exchanged(read, *pair), wrench, TIME, RUN))
    assert fault.kind == "exchanged"
    assert set(fault.rods) == {rods.names[i] for i in pair}
    assert "interchanged" in fault.sentence


def test_without_the_load_rods_to_spare_show() -> None:
    rods = seven_rods(NOISE).pick([0, 1, 2, 3, 4, 6])
    assert rods.names == ("ids1", "ids2", "ids3", "ids4", "ids5", "ids7")
    read, _ = readings(rods)
    assert find_rod_faults(rods, SHAPE, read) == ()
    fault = only(find_rod_faults(rods, SHAPE, swapped(read, 2)))
    assert (fault.kind, fault.rods) == ("swapped-sign", ("ids3",))
    # One rod to spare sees that something is loose, and cannot say which; two can.
    assert only(find_rod_faults(rods, SHAPE, loose(read, 0))).kind in ("unexplained", "loose")


def test_without_the_load_and_none_to_spare_nothing_is_found() -> None:
    rods = paper_rods(NOISE)
    read, _ = readings(rods)
    assert find_rod_faults(rods, SHAPE, swapped(read, 1)) == ()


@pytest.mark.parametrize("seed", range(4))
def test_nothing_wrong_nothing_named(seed: int) -> None:
    for rods in (paper_rods(NOISE), paper_rods(), seven_rods(NOISE)):
        read, wrench = readings(rods, seed=seed)
        assert find_rod_faults(rods, SHAPE, read, wrench, TIME, RUN) == ()


def test_a_rod_that_reads_a_little_less_is_no_fault() -> None:
    """15 % less where one rod sits: a rib next to it, a thicker wall. The beam is no better than that."""
    rods = paper_rods(NOISE)
    # ten times the loads: the noise hides nothing
    wrench = 10.0 * loads(STATES, 1)
    read = wrench @ compliance(SHAPE) @ rod_matrix(rods, SHAPE).T
    read[:, 1] *= 0.85
    read += NOISE * np.random.default_rng(51).standard_normal(read.shape)
    assert find_rod_faults(rods, SHAPE, read, wrench, TIME, RUN) == ()


def test_two_faults_are_named_one_after_the_other() -> None:
    rods = paper_rods(NOISE)
    read, wrench = readings(rods)
    faults = find_rod_faults(rods, SHAPE, drifting(swapped(read, 1), 4), wrench, TIME, RUN)
    assert {(fault.kind, fault.rods) for fault in faults} == {("swapped-sign", ("ids2",)), ("drifting", ("ids5",))}


def test_all_signs_swapped_points_at_the_load() -> None:
    rods = paper_rods(NOISE)
    read, wrench = readings(rods)
    fault = only(find_rod_faults(rods, SHAPE, -read, wrench, TIME, RUN))
    assert fault.kind == "swapped-sign"
    assert "acts_on" in fault.sentence


def test_rods_of_another_link_are_unexplained() -> None:
    rods = paper_rods(NOISE)
    read, wrench = readings(rods)
    rng = np.random.default_rng(0)
    fault = only(find_rod_faults(rods, SHAPE, np.std(read) * rng.standard_normal(read.shape), wrench, TIME, RUN))
    assert fault.kind == "unexplained"


def test_a_rod_with_the_wrong_sign_on_a_link_that_is_no_even_beam_is_not_loose() -> None:
    """Each rod reads some percent more or less than an even beam has it, which a rod left out explains a bit better."""
    read, wrench = readings(FIVE)
    uneven = read * (1.0 + 0.06 * np.random.default_rng(1).standard_normal(read.shape[1]))
    fault = only(find_rod_faults(FIVE, SHAPE, swapped(uneven, 3), wrench, TIME, RUN))
    assert (fault.kind, fault.rods) == ("swapped-sign", ("ids4",))


def test_a_mistake_that_is_dropped_in_as_a_file_is_named() -> None:
    rods = paper_rods(NOISE)
    read, wrench = readings(rods)
    read[:, 2] *= 10.0
    with dropped_in("mistakes"):
        fault = only(find_rod_faults(rods, SHAPE, read, wrench, TIME, RUN))
    assert (fault.kind, fault.rods) == ("tenfold", ("ids3",))
