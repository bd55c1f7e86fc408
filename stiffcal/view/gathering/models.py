"""The models that the page for a browser can show: fits of the history, and refits that `diagnose` stored."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from stiffcal.arrays import Booleans, Floats
from stiffcal.diagnosis.refits.refit_values import RefitValue
from stiffcal.diagnosis.refits.refits import StoredRefits
from stiffcal.estimate import Estimate
from stiffcal.identification.answers.state_tables import component_block, gauge_block, motor_block
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.assembled.measured_frames import FRAME, FramePose
from stiffcal.model.catalogue.campaign_effects import all_effects
from stiffcal.model.effect import Effect
from stiffcal.model.forms import form_of
from stiffcal.model.summary import Where
from stiffcal.quantity import Units, quantity_of
from stiffcal.reduction.loads.motion import gauge_directions
from stiffcal.results.value_words import as_shown, value_in_model
from stiffcal.stages.diagnoses.current import diagnosis_key, shifted_by_missing
from stiffcal.stages.diagnoses.stored_curves import REFITS
from stiffcal.stages.history import stored_fits
from stiffcal.stages.steps import (
    FIT_STATES,
    HELDOUT_STATES,
    Ingested,
    kept_table,
    key_of_table,
    stored_result,
)
from stiffcal.view.content import ViewEvidence, ViewModel, ViewShare, ViewValue, ViewVariable
from stiffcal.view.gathering.refits_of_joints import is_of_one_joint, of_all_joints
from stiffcal.view.shares import share_explained

if TYPE_CHECKING:
    import pyarrow as pa

    from stiffcal.results.history_results import StoredFit
    from stiffcal.results.identify_result import IdentifyResult

COMPONENTS = ("x", "y", "z", "rx", "ry", "rz")
FEWEST_SHARE = 0.02
"""Variables that explain less are not proposed."""


@dataclass(frozen=True, kw_only=True)
class ResidualTables:
    """Where the store holds residuals of n states or rows, and how they are read: (n, 3) or (n, 6), SI."""

    fit: str
    """Table of the present fit."""
    heldout: str
    """Table with each pose, or speed, by a fit without it."""
    refits: str
    """Table of the refits that `diagnose` stored."""
    of_fit: Callable[[pa.Table], Floats | None]
    """Reads the first; None where the table is of other readings."""
    of_heldout: Callable[[pa.Table], Floats | None]
    """Reads the second, likewise."""
    of_refit: Callable[[pa.Table], Floats]
    """Reads the part of the third that is of one refit."""
    documents: tuple[str, ...] = (REFITS,)
    """The document with the summaries of the refits, the first that there is."""


def tables_of_states(data: Ingested, width: int, of_motors: bool) -> ResidualTables:
    """Return the tables of load states.

    Parameters
    ----------
    data : the campaign. width : columns of residuals, 3 or 6.
    of_motors : for clamped runs alone: the residual is that of the moved motor's angle, in the first column.
    """
    block = _residual_block(data, of_motors)

    def read(table: pa.Table) -> Floats:
        return block(table)[:, :width]

    return ResidualTables(
        fit=FIT_STATES, heldout=HELDOUT_STATES, refits=REFITS, of_fit=read, of_heldout=read, of_refit=read
    )


def _residual_block(data: Ingested, of_motors: bool) -> Callable[[pa.Table], Floats]:
    """Return the function from a table of states to the (n, 6) residual of the first target, m and rad."""
    states = data.states
    if of_motors:
        return partial(motor_block, kind="residual", n_states=len(states))
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
    tables: ResidualTables | None,
    own: Floats | None = None,
    evidence: Sequence[ViewEvidence] = (),
) -> list[ViewModel]:
    """Return every fit of the history, oldest first, then the refits of the present diagnosis; over all n states.

    Parameters
    ----------
    data : the campaign. identified : the present fit.
    variables : what residuals may follow, over all states. used : (n,) states that are judged.
    tables : where residuals are; None where nothing of the campaign can be drawn.
    own : (n, …) residual of the present fit, which is taken where the store's tables hold none.
    evidence : directions along which residuals are read too.
    """
    share_of = partial(_shares, variables, used=used, evidence=evidence)
    states_key = key_of_table(data.table)

    shifted = shifted_by_missing(data, identified) or ()
    models = []
    for fit in stored_fits(data.store):
        current = fit.states_key == states_key
        present = fit.id == identified.fit_id
        inside, outside = _residuals(data, tables, None if present else fit) if current else (None, None)
        if present and inside is None:
            inside = own
        models.append(
            ViewModel(
                id=f"fit{fit.id}",
                kind="fit",
                short=f"fit {fit.id}",
                label=f"fit {fit.id}: {_in_words(fit)}" + ("" if current else " (other load states)"),
                present=present,
                fit_rms=fit.fit_rms,
                heldout_rms=fit.heldout_rms,
                values=_values({one.name: as_shown(one, (), shifted) for one in identified.parameters})
                if present
                else _values({one.name: one.estimate for one in fit.parameters}),
                residual_fit=inside,
                residual_heldout=outside,
                shares=share_of(outside if outside is not None else inside),
            )
        )
    if tables is None:
        return models
    refits = _refits(data, identified, share_of, tables)
    present_fit = next((model for model in models if model.present), None)
    if present_fit is None or not any(is_of_one_joint(refit, present_fit, used) for refit in refits):
        return [*models, *refits]
    return [*models, *of_all_joints(refits, present_fit, used, share_of)]


def _residuals(
    data: Ingested, tables: ResidualTables | None, fit: StoredFit | None
) -> tuple[Floats | None, Floats | None]:
    """Return the residuals of a fit of the history, None of the present one, and held-out; None where not stored."""
    if tables is None:
        return None, None

    def residual(table: str, read: Callable[[pa.Table], Floats | None]) -> Floats | None:
        name = table if fit is None else kept_table(table, fit.key)
        values = read(data.store.read_table(name)) if name in data.store.tables else None
        return values if values is not None and np.isfinite(values).any() else None

    return residual(tables.fit, tables.of_fit), residual(tables.heldout, tables.of_heldout)


def _in_words(fit: StoredFit) -> str:
    basic = "joint-compliance"
    names = [entry.type for entry in fit.model.effects if entry.type != basic]
    joints = any(entry.type == basic for entry in fit.model.effects)
    return " + ".join([*(["joint-compliance"] if joints else []), *names]) or "no effects"


def _values(estimates: Mapping[str, Estimate]) -> list[ViewValue]:
    """Return the values of a model as the page shows them, each quantity in one unit."""
    known = {name: (one, one.quantity or quantity_of("1")) for name, one in estimates.items()}
    units = Units((quantity, [one.value]) for one, quantity in known.values())
    return [
        ViewValue(
            name=name,
            unit=units.of(quantity).name,
            value=one.value,
            text=value_in_model(one, units.of(quantity)),
            is_identified=one.is_bounded,
        )
        for name, (one, quantity) in known.items()
    ]


def _refits(
    data: Ingested,
    identified: IdentifyResult,
    share_of: Callable[[Floats | None], list[ViewShare]],
    tables: ResidualTables,
) -> list[ViewModel]:
    found = (stored_result(data.store, name, StoredRefits) for name in tables.documents)
    stored = next((document for document in found if document is not None), None)
    if stored is None or stored.key != diagnosis_key(data, identified) or tables.refits not in data.store.tables:
        return []
    table = data.store.read_table(tables.refits)
    entry = table.column("entry").to_numpy()
    catalogue, _ = all_effects(data.campaign)
    # one effect that is missing is shown by its own fit, not by the linear refit too
    alone = [(refit.added[0].effect, refit.added[0].where) for refit in stored.entries if len(refit.added) == 1]
    models = []
    for number, summary in enumerate(stored.entries):
        if summary.change == "with" and (summary.effect, summary.where) in alone:
            continue
        values = tables.of_refit(table.filter(entry == number))
        residual = values if np.isfinite(values).any() else None
        name = f"{summary.effect} {place_words(summary.where)}".strip()
        label = short = f"{summary.change} {name}"
        if summary.change == "all":
            short = "all missing added"
            name = ", ".join(f"{added.effect} {place_words(added.where)}" for added in summary.added)
            label = f"with all that is missing: {name}"
        models.append(
            ViewModel(
                id=f"{summary.change}{number + 1}",
                kind=summary.change,
                label=label,
                short=short,
                heldout_rms=summary.heldout_rms,
                values=_values({value.name: _refitted(value, catalogue) for value in summary.values}),
                effect=name,
                residual_heldout=residual,
                shares=share_of(residual),
            )
        )
    return models


def _refitted(entry: RefitValue, catalogue: dict[str, Effect]) -> Estimate:
    effect, _, symbol = entry.name.split(".")
    spec = (FramePose() if effect == FRAME else form_of(catalogue[effect], (symbol,))).spec(symbol)
    value = replace(entry.estimate, quantity=quantity_of(spec.unit))
    return value.reciprocal() if spec.compliance else value


def names_in(robot: CompliantRobot) -> set[str]:
    """Return the effects of a model at their places, "effect place"."""
    return {f"{placed.effect.name} {placed.place.label}" for placed in robot.placed}


def place_words(where: Where) -> str:
    """Return a place as names of effects end: "j2", "j5-j6", "swing", "setup"."""
    words = [f"j{joint}" for joint in where.joints or ()] + list(where.links or ())
    words += ["-".join(f"j{joint}" for joint in pair) for pair in where.pairs or ()]
    return ", ".join(words) or "setup"


def _shares(
    variables: Sequence[ViewVariable], residual: Floats | None, used: Booleans, evidence: Sequence[ViewEvidence]
) -> list[ViewShare]:
    if residual is None:
        return []
    # a component is exactly zero where it was not measured: gauges read along one direction
    parts = {
        COMPONENTS[axis]: np.where(residual[:, axis] != 0.0, residual[:, axis], np.nan)
        for axis in range(residual.shape[1])
    }
    for number, one in enumerate(evidence):
        parts[f"e{number + 1}"] = np.sum(one.along * (residual[:, 3:] if one.turns else residual[:, :3]), axis=1)
    shares = [
        ViewShare(
            variable=variable.name,
            component=component,
            share=share_explained(np.where(used, variable.values, np.nan), values, bool(variable.levels)),
        )
        for variable in variables
        for component, values in parts.items()
    ]
    return sorted((share for share in shares if share.share >= FEWEST_SHARE), key=lambda share: -share.share)
