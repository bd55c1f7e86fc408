"""What kinds of experiment say of their load states, where states of several are fitted together.

Each kind says it in its own folder (`stiffcal.kinds`): how its states are called, what is left out of them, and
in which measure their error is. Fits and judgements ask the kinds of the runs, and name none.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from typing import ClassVar, cast

import numpy as np

from stiffcal.arrays import Booleans, Integers
from stiffcal.campaign.found.experiment_kinds import KnownKind, experiment_kind, kind_names
from stiffcal.identification.readings.observations import Observations
from stiffcal.identification.readings.search_subject import SearchSubject
from stiffcal.measurements.load_states import LoadStates
from stiffcal.measurements.rms import Rms


class StateKind(ABC):
    """The load states of one kind of experiment."""

    name: ClassVar[str]
    """In answers."""
    runs: ClassVar[str]
    """What its runs are called: "load runs"."""
    left_out: ClassVar[str]
    """What is left out of them in turn, in words."""
    measure: ClassVar[str]
    """In which measure their error is compared: "translation", "motor_angle"."""
    scheme: ClassVar[str]
    """How they are left out when a model is validated: one of `stiffcal.validation.schemes`, or words of its own."""
    subject: ClassVar[SearchSubject | None] = None
    """What each joint's states are called where they share no parameter with those of others and are searched apart;
    None: all states are searched together.
    """

    @abstractmethod
    def folds(self, data: Observations) -> Integers:
        """Return (n,) numbers, from 0, of what is left out together when a model is validated; data of this kind alone.

        States of a run share one.
        """

    def search_folds(self, data: Observations) -> Integers:
        """Return (n,) numbers of what is left out together where effects are compared; those of `folds` by default."""
        return self.folds(data)

    @abstractmethod
    def expected_error(self, error: Rms, whole: Rms, noise: Rms | None) -> str:
        """Return the error to expect in what was not measured, in words; "" where none is known.

        Parameters
        ----------
        error : held-out, of states of this kind. whole : what no model leaves. noise : of the instruments.
        """


def state_kind(experiment: str) -> StateKind:
    """Return what the kind of experiment of a name says of its load states.

    Examples
    --------
    >>> state_kind("load").name, state_kind("free").name, state_kind("clamped").measure
    ('loads', 'loads', 'motor_angle')
    """
    kind = cast(KnownKind, experiment_kind(experiment) or experiment_kind("load"))
    return cast(StateKind, kind.state_kind())


def state_kinds() -> dict[str, StateKind]:
    """Return what all kinds say of their load states, by the name that answers call them by.

    Examples
    --------
    >>> {"absolute", "clamped", "loads"} <= state_kinds().keys()
    True
    """
    return {kind.name: kind for kind in map(state_kind, kind_names())}


def kinds_of_observations(data: Observations) -> list[tuple[StateKind, Booleans]]:
    """Return the kinds of n states, and which states (n,) are of each."""
    return list(_kinds(data.run_kinds, data.run))


def measured_kinds(data: Observations) -> list[tuple[StateKind, Booleans]]:
    """Return the same of the kinds of which something was read."""
    return [(kind, mask) for kind, mask in kinds_of_observations(data) if data.measured_mask[:, mask].any()]


def kinds_of_states(states: LoadStates) -> list[tuple[StateKind, Booleans]]:
    """Return the kinds of n load states, and which states (n,) are of each."""
    return list(_kinds([run.experiment for run in states.runs], states.run))


def _kinds(experiments: Sequence[str], run: Integers) -> Iterator[tuple[StateKind, Booleans]]:
    """Yield kinds with their states, in an order that does not depend on that of the runs.

    Parameters
    ----------
    experiments : of each run; load runs where not given. run : (n,) index into them.
    """
    present, of_state = np.unique(run, return_inverse=True)
    of_run = [experiments[number] if number < len(experiments) else "load" for number in present.tolist()]
    kinds = {experiment: state_kind(experiment) for experiment in dict.fromkeys(of_run)}
    name_of_run = np.array([kinds[experiment].name for experiment in of_run])
    by_name = {kind.name: kind for kind in kinds.values()}
    for name in sorted(by_name, reverse=True):
        yield by_name[name], np.asarray((name_of_run == name)[of_state], dtype=np.bool_)
