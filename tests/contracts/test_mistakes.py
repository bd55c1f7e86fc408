"""What every mistake of the catalogue promises: found by walking, never by name."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest

from stiffcal.campaign.loading import load_campaign
from stiffcal.errors import no_progress
from stiffcal.ingest.reading.reducing import reduce_campaign
from stiffcal.mistakes.found import mistakes_of
from stiffcal.mistakes.inputs.mistake import AsRead, InputMistake, TakenBack, TriedOn
from stiffcal.mistakes.inputs.taken_back import mistakes_on, taken_back
from stiffcal.mistakes.references.match import missed_by
from stiffcal.mistakes.stated_units import stated_units
from tests.laboratory.displacement_table import displacement_columns, write_displacement_campaign
from tests.laboratory.hidden_campaigns import folder_of

ABSOLUTE = Path(__file__).parents[2] / "campaigns" / "absolute" / "03"


def _read(tried_on: TriedOn, folder: Path) -> AsRead:
    """Return a sound campaign, every third of its rows looked at."""
    campaign = load_campaign(folder)
    states = reduce_campaign(campaign, no_progress).states
    return AsRead(
        tried_on,
        states,
        campaign.chain,
        np.arange(0, len(states), 3),
        stated_units(campaign),
        ("Fx", "Fy", "Fz", "Mx", "My", "Mz"),
        load_units=("N", "N*m"),
        robot=campaign.robot,
        folder=campaign.robot_path.parent,
    )


def _of_displacements(tried_on: TriedOn) -> AsRead:
    with TemporaryDirectory() as folder:
        read = _read(tried_on, write_displacement_campaign(Path(folder) / "c", displacement_columns(12)))
    return replace(read, states=replace(read.states, wrench=read.states.wrench + np.arange(6.0)))


MADE: dict[TriedOn, Callable[[TriedOn], AsRead]] = {
    TriedOn.ABSOLUTE_TABLE: lambda tried_on: _read(tried_on, ABSOLUTE),
    TriedOn.ABSOLUTE_ROWS: lambda tried_on: _read(tried_on, ABSOLUTE),
    TriedOn.REFERENCES: lambda tried_on: _read(tried_on, folder_of("01")),
    TriedOn.ORIENTATIONS: lambda tried_on: _read(tried_on, folder_of("01")),
    TriedOn.DISPLACEMENTS: _of_displacements,
    TriedOn.WORK: _of_displacements,
}


@cache
def read_of(tried_on: TriedOn) -> AsRead:
    return MADE[tried_on](tried_on)


@cache
def taken_on(tried_on: TriedOn) -> tuple[TakenBack, ...]:
    # all names of poses are asked for where their places are in another order than they were measured
    read = read_of(tried_on)
    shuffled = replace(read.states, position=read.states.position[::-1])
    return tuple(taken_back(replace(read, states=shuffled) if tried_on is TriedOn.REFERENCES else read))


@pytest.mark.parametrize("tried_on", TriedOn)
def test_each_is_tried_in_ways_of_its_own_and_changes_what_it_says(tried_on: TriedOn) -> None:
    read, taken = read_of(tried_on), taken_on(tried_on)
    adjusted = {mistake for mistake in mistakes_on(tried_on) if any(True for _ in mistake.adjustments(read))}
    assert {one.mistake for one in taken} | adjusted == set(mistakes_on(tried_on))
    for one in taken:
        if one.change.sizes and not any(one.change.sizes):
            continue  # a fit that finds nothing to move
        assert len(one.states) <= len(read.rows)
        same = all(
            np.array_equal(getattr(one.states, part), getattr(read.chosen, part), equal_nan=True)
            for part in ("joints", "position", "rotation", "wrench", "deflection")
        )
        assert not same or one.chain is not read.chain, one.change


@pytest.mark.parametrize("tried_on", TriedOn)
def test_each_reads_unlike_the_others(tried_on: TriedOn) -> None:
    # three targets may be exchanged in a circle either way
    texts = list({one.change: one.mistake.texts(one.change, one.chain) for one in taken_on(tried_on)}.values())
    assert all(text.place and text.words and text.mend for text in texts)
    assert len({(text.words, text.mend) for text in texts}) == len(texts)
    if tried_on is TriedOn.ABSOLUTE_ROWS:
        assert all(text.in_rows for text in texts)


def test_an_adjustment_by_nothing_changes_nothing() -> None:
    read = read_of(TriedOn.REFERENCES)
    as_read = missed_by(read.chosen, read.chain)
    for mistake in mistakes_on(TriedOn.REFERENCES):
        for by in mistake.adjustments(read):
            nothing, something = np.zeros(len(by.start)), np.full(len(by.start), 0.1)
            assert np.allclose(missed_by(by.applied(read.chosen, nothing), read.chain), as_read, atol=1e-12)
            assert not np.allclose(missed_by(by.applied(read.chosen, something), read.chain), as_read, atol=1e-6)
            assert len(by.sizes(something)) == len(something)


def test_the_likelier_come_first_and_no_two_are_alike() -> None:
    ranks = [mistake.rank for mistake in mistakes_of(InputMistake)]
    assert ranks == sorted(set(ranks))
