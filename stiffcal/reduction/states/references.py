"""Which state of each run is the reference: displacements are relative to it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from stiffcal.arrays import Booleans, Integers
from stiffcal.errors import Fault, raise_faults
from stiffcal.fault_codes import FaultCode
from stiffcal.measurements.load_states import members_of


def reference_states(
    run: Integers, names: Sequence[str], chosen: Mapping[str, int], usable: Booleans, manifest: str = "campaign.toml"
) -> Booleans:
    """Mark each run's reference: the first state, unless the manifest names another.

    Parameters
    ----------
    run : (n,) index into ``names``, states of a run in order.
    chosen : run's name to the reference state's number, from 1.
    usable : (n,) False for states that are set aside; the first usable one then takes the place of the first.

    Raises
    ------
    InputError
        The manifest names a state that a run does not have, or one that is set aside.

    Examples
    --------
    >>> import numpy as np
    >>> run = np.array([0, 0, 1, 1])
    >>> reference_states(run, ["a", "b"], {"b": 2}, np.ones(4, dtype=bool)).tolist()
    [True, False, False, True]
    """
    reference = np.zeros(run.size, dtype=np.bool_)
    faults: list[Fault] = []
    for name, members in zip(names, members_of(run, len(names)), strict=True):
        if members.size == 0:
            continue
        reference_row = chosen.get(name, 1)
        place = f"run {name}: reference"
        if reference_row > members.size:
            reason = f"reference = {reference_row}, but the run has {members.size} states"
            faults.append(Fault(FaultCode.REFERENCE_INVALID, manifest, place, reason, "give one of them, from 1"))
        elif reference_row > 1 and not usable[members[reference_row - 1]]:
            reason = f"state {reference_row} is set aside and cannot be the reference"
            faults.append(Fault(FaultCode.REFERENCE_INVALID, manifest, place, reason, "choose another"))
        else:
            candidates = (
                members[reference_row - 1 :] if reference_row == 1 else members[reference_row - 1 : reference_row]
            )
            good = candidates[usable[candidates]]
            reference[good[0] if good.size else candidates[0]] = True
    raise_faults(faults)
    return reference
