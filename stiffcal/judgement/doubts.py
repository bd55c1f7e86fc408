"""Single readings that are off, as results."""

from __future__ import annotations

import numpy as np

from stiffcal.diagnosis.answers.suspect_results import Suspect
from stiffcal.identification.fitting.identify import fit_problem
from stiffcal.identification.noise.weights import predict_observations
from stiffcal.identification.readings.row_layout import ROTATION, TRANSLATION
from stiffcal.judgement.diagnosed import DiagnosedStates
from stiffcal.judgement.numbers import FIRM
from stiffcal.judgement.rows_off import Off
from stiffcal.mistakes.suspect_kinds import SuspectKind
from stiffcal.wording import angle, length


def reading_off(found: DiagnosedStates, off: Off, probability: float) -> Suspect:
    """Return a reading that is off: how far it lies from where the others put it.

    Parameters
    ----------
    found : what is missing. off : the reading. probability : that it is off.
    """
    states, robot = found.states, found.last.fit.robot
    data = fit_problem(states, robot).data
    data = data.subset(data.run == off.run)
    residual = data.measured - predict_observations(robot, data)
    own, others = data.index == off.state, data.index != off.state
    if data.carries_offset[own].any() and others.any():
        residual = residual - np.nanmean(np.where(data.measured_mask, residual, np.nan)[:, others], axis=1)[:, None]
    moved = np.where(data.measured_mask, residual, 0.0)[:, own][:, 0]
    shift, turn = (float(np.linalg.norm(moved[data.kind == kind])) for kind in (TRANSLATION, ROTATION))
    parts = [length(shift)] if shift else []
    parts += [angle(turn)] if turn else []
    return Suspect(
        run=states.runs[off.run].name,
        row=int(states.row[off.state or 0]),
        kind=SuspectKind.OFF,
        why=f"this reading lies {' and '.join(parts) or 'far'} from where all others put it",
        likely=(
            "an outlier of the target (a disturbance, a typing error): compare it with the log, repeat it, or exclude "
            "it"
        ),
        factor=None,
        without=None,
        probability=probability,
        firm=probability >= FIRM,
    )
