"""The models that the page for a browser can show: fits of the history, and refits that `diagnose` stored."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from stiffcal.arrays import Booleans, Floats
from stiffcal.diagnosis.refits import RefitSummary, StoredRefits
from stiffcal.identification.before_after import EstimatedParameter, estimated_parameters, stiffness_unit
from stiffcal.identification.state_tables import component_block, gauge_block
from stiffcal.model.campaign_effects import all_effects
from stiffcal.model.effect import Effect
from stiffcal.model.measured_frames import FRAME, FramePose
from stiffcal.reduction.motion import gauge_directions
from stiffcal.view.content import ViewModel, ViewShare, ViewValue, ViewVariable
from stiffcal.view.shares import share_explained
from stiffcal.workflow.diagnose import diagnosis_key
from stiffcal.workflow.evidence import REFITS
from stiffcal.workflow.history import stored_fits
from stiffcal.workflow.steps import (
    FIT_STATES,
    HELDOUT_STATES,
    Ingested,
    kept_table,
    key_of_table,
    stored_result,
)

if TYPE_CHECKING:
    import pyarrow as pa

    from stiffcal.results.history_results import StoredFit
    from stiffcal.results.identify_result import IdentifyResult

COMPONENTS = ("x", "y", "z", "rx", "ry", "rz")
FEWEST_SHARE = 0.02
"""Variables that explain less are not proposed."""


def residual_block(data: Ingested) -> Callable[[pa.Table], Floats]:
    """Return the function from a table of states to the (n, 6) residual of the first target, m and rad."""
    states = data.states
    if not states.has_poses and states.setup.gauges:
        return partial(
            gauge_block,
            names=[gauge.name for gauge in states.setup.gauges],
            directions=gauge_directions(states, data.campaign.chain),
            kind="residual",
            n_states=len(states),
        )
    return partial(component_block, target=states.setup.target_names[0], kind="residual", n_states=len(states))


def view_models(
    data: Ingested,
    identified: IdentifyResult,
    variables: Sequence[ViewVariable],
    used: Booleans,
    width: int,
    own: Floats | None = None,
) -> list[ViewModel]:
    """Return every fit of the history, oldest first, then the refits of the present diagnosis; over all n states.

    Parameters
    ----------
    data : the campaign. identified : the present fit.
    variables : what residuals may follow, over all states. used : (n,) states that are judged.
    width : columns of residuals, 3 or 6.
    own : (n, width) residual of the present fit, where the store's tables hold none.
    """
    states_key = key_of_table(data.table)
    block = residual_block(data) if len(data.states) else None

    def residual(name: str) -> Floats | None:
        if block is None or name not in data.store.tables:
            return None
        values = block(data.store.read_table(name))[:, :width]
        return values if np.isfinite(values).any() else None

    models = []
    for fit in stored_fits(data.store):
        current = fit.states_key == states_key
        present = fit.id == identified.fit_id
        names = (FIT_STATES, HELDOUT_STATES) if present else _kept(fit)
        inside, outside = (residual(name) if current else None for name in names)
        if present and own is not None:
            inside, outside = own, None
        models.append(
            ViewModel(
                id=f"fit{fit.id}",
                kind="fit",
                label=f"fit {fit.id}: {_in_words(fit)}" + ("" if current else " (other load states)"),
                present=present,
                fit_rms=fit.fit_rms,
                heldout_rms=fit.heldout_rms,
                values=[_value(entry) for entry in estimated_parameters(identified.parameters)]
                if present
                else [_value(entry) for entry in fit.parameters or ()],
                residual_fit=inside,
                residual_heldout=outside,
                shares=_shares(variables, outside if outside is not None else inside, used),
            )
        )
    return models if block is None else [*models, *_refits(data, identified, variables, used, block, width)]


def _kept(fit: StoredFit) -> tuple[str, str]:
    return kept_table(FIT_STATES, fit.key), kept_table(HELDOUT_STATES, fit.key)


def _in_words(fit: StoredFit) -> str:
    basic = "joint-compliance"
    names = [entry.type for entry in fit.model.effects if entry.type != basic]
    joints = any(entry.type == basic for entry in fit.model.effects)
    return " + ".join([*(["joint springs"] if joints else []), *names]) or "no effects"


def _value(entry: EstimatedParameter) -> ViewValue:
    low, high = entry.interval or (None, None)
    return ViewValue(name=entry.name, unit=entry.unit, value=entry.value, low=low, high=high)


def _refits(
    data: Ingested,
    identified: IdentifyResult,
    variables: Sequence[ViewVariable],
    used: Booleans,
    block: Callable[[pa.Table], Floats],
    width: int,
) -> list[ViewModel]:
    stored = stored_result(data.store, REFITS, StoredRefits)
    if stored is None or stored.key != diagnosis_key(data, identified) or REFITS not in data.store.tables:
        return []
    table = data.store.read_table(REFITS)
    entry = table.column("entry").to_numpy()
    catalogue, _ = all_effects(data.campaign)
    models = []
    for number, summary in enumerate(stored.entries):
        values = block(table.filter(entry == number))[:, :width]
        residual = values if np.isfinite(values).any() else None
        place = _place_words(summary)
        name = f"{summary.effect} {place}".strip()
        models.append(
            ViewModel(
                id=f"{summary.change}{number + 1}",
                kind=summary.change,
                label=f"{'with' if summary.change == 'with' else 'without'} {name}",
                heldout_rms=summary.heldout_rms,
                values=[_refit_value(value.name, value.value, catalogue) for value in summary.values],
                effect=name,
                residual_heldout=residual,
                shares=_shares(variables, residual, used),
            )
        )
    return models


def _refit_value(name: str, value: float | None, catalogue: dict[str, Effect]) -> ViewValue:
    effect, _, symbol = name.split(".")
    spec = (FramePose() if effect == FRAME else catalogue[effect].form((symbol,))).spec(symbol)
    if not spec.compliance:
        return ViewValue(name=name, unit=spec.unit, value=value)
    return ViewValue(name=name, unit=stiffness_unit(spec.unit), value=1.0 / value if value else None)


def _place_words(summary: RefitSummary) -> str:
    where = summary.where
    words = [f"j{joint}" for joint in where.joints or ()] + list(where.links or ())
    words += ["-".join(f"j{joint}" for joint in pair) for pair in where.pairs or ()]
    return ", ".join(words) or "setup"


def _shares(variables: Sequence[ViewVariable], residual: Floats | None, used: Booleans) -> list[ViewShare]:
    if residual is None:
        return []
    shares = [
        ViewShare(
            variable=variable.name,
            component=COMPONENTS[axis],
            share=share_explained(
                # a component is exactly zero where it was not measured: gauges read along one direction
                np.where(used & (residual[:, axis] != 0.0), variable.values, np.nan),
                residual[:, axis],
                bool(variable.levels),
            ),
        )
        for variable in variables
        for axis in range(residual.shape[1])
    ]
    return sorted((share for share in shares if share.share >= FEWEST_SHARE), key=lambda share: -share.share)
