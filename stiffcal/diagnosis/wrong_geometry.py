"""Whether errors of the robot's geometry explain what an effect seems to explain.

Lengths and angles that are off by centimetres leave a structure that link springs or a coupling of axes mimic. Where
absolute places miss by much more than the geometry's tolerance, the tolerance that they show is put next to the model
as nuisance columns with a prior, and what these explain is held against what is missing.
"""

from __future__ import annotations

import numpy as np

from stiffcal.diagnosis.answers.setting_results import WrongGeometry
from stiffcal.diagnosis.scans.load_scan import LoadScan
from stiffcal.estimation.triangular import triangular
from stiffcal.identification.fitting.geometry import geometry_columns, geometry_prior
from stiffcal.measurements.load_states import LoadStates


def wrong_geometry(states: LoadStates, scan: LoadScan) -> WrongGeometry | None:
    """Return how wrong the geometry is, and what of the error it explains; None where places do not contradict it.

    Parameters
    ----------
    states : the campaign's load states.
    scan : of the present model.
    """
    prior = geometry_prior(states, scan.fit.robot)
    if prior.misfit is None or not prior.contradicted(scan.fit.robot.chain.masses_known):
        return None
    sizes = prior.sizes(scan.fit.robot.chain.n_joints)
    nuisance = geometry_columns(scan.fit.robot, scan.fit.data) * sizes[:, None, None]
    rows = scan.space.rows(np.concatenate([scan.columns, nuisance, scan.residual[None]]))
    n_own = len(scan.columns)
    rest = triangular(rows.T)[n_own:, n_own:]
    factor, target = rest[:, :-1], rest[:, -1]
    left, values, _ = np.linalg.svd(factor, full_matrices=False)
    share = values**2 / (1.0 + values**2)
    before = float(target @ target)
    # What nuisance columns take of the noise alone is no explanation.
    gained = float(np.sum((1.0 - (1.0 - share) ** 2) * (left.T @ target) ** 2)) - float(
        np.sum(1.0 - (1.0 - share) ** 2)
    )
    avoidable = before - (scan.dof - n_own)
    explains = float(np.clip(gained / avoidable, 0.0, 1.0)) if avoidable > 0.0 else 0.0
    return WrongGeometry(misfit=prior.misfit, explains=explains)
