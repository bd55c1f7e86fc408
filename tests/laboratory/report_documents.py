"""Documents of a fit in the interface's form, for report tests: from arrays of a throw-away fit."""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.documents import result_of
from stiffcal.report.content import ReportStates
from stiffcal.results.history_results import HistoryResult
from tests.laboratory.fits import fit_of, validation_of


def rms(residual: Floats) -> float:
    """Root mean squared length of (n, 3)."""
    return float(np.sqrt(np.mean(np.sum(residual**2, axis=1)))) if residual.size else 0.0


def measures(residual: Floats) -> dict[str, float | None]:
    """The interface's {translation, rotation} of (n, 3) or (n, 6)."""
    return {
        "translation": rms(residual[:, :3]),
        "rotation": rms(residual[:, 3:]) if residual.shape[1] == 6 else None,
    }


def largest(residual: Floats) -> dict[str, float | None]:
    """The longest residual, as in the interface."""
    return {
        "translation": float(np.linalg.norm(residual[:, :3], axis=1).max()),
        "rotation": float(np.linalg.norm(residual[:, 3:], axis=1).max()) if residual.shape[1] == 6 else None,
    }


def breakdown(labels: np.ndarray[Any, Any], residual: Floats, order: list[str]) -> list[dict[str, Any]]:
    """`by_…` lists of the validate document."""
    out = []
    for label in order:
        pick = labels == label
        if pick.any():
            out.append(
                {"label": label, "low": None, "high": None, "n": int(pick.sum()), "rms": measures(residual[pick]),
                 "max": largest(residual[pick])}
            )  # fmt: skip
    return out


def parameters_of(joint_names: tuple[str, ...], c: Floats, covariance: Floats) -> list[dict[str, Any]]:
    """One compliance per joint, with its stiffness."""
    parameters = []
    for k in range(len(joint_names)):
        std = float(np.sqrt(covariance[k, k]))
        low, high = c[k] - 1.96 * std, c[k] + 1.96 * std
        parameters.append(
            {
                "name": f"joint-compliance.j{k + 1}.c", "effect": "joint-compliance", "where": {"joints": [k + 1]},
                "value": float(c[k]), "std": std, "interval": [float(low), float(high)], "unit": "rad/(N*m)",
                "fixed": False, "identifiable": True, "stiffness": float(1 / c[k]),
                "stiffness_std": float(std / c[k] ** 2),
                "stiffness_interval": [float(1 / high), float(1 / low) if low > 0 else None],
            }
        )  # fmt: skip
    return parameters


def validate_document(
    states: ReportStates, names: np.ndarray[Any, Any], run_names: list[str], noise: dict[str, float] | None
) -> dict[str, Any]:
    """The validate document; `names` are the run names of the states in use."""
    used = states.used
    heldout = states.residual[used]
    loads = states.load[used]
    edges = np.quantile(loads, [0, 0.33, 0.67, 1.0])
    bins = np.clip(np.searchsorted(edges, loads, side="right") - 1, 0, 2)
    load_names = [f"{edges[i]:.0f} … {edges[i + 1]:.0f} N" for i in range(3)]
    by_load = breakdown(np.array(load_names)[bins], heldout, load_names)
    axis = np.argmax(np.abs(states.force[used]), axis=1)
    positive = states.force[used][np.arange(len(axis)), axis] > 0
    mostly = np.array([f"near {'+' if up else '−'}{'xyz'[a]}" for a, up in zip(axis, positive, strict=True)])
    zero = measures(states.measured[used])
    order = np.argsort(-np.linalg.norm(heldout[:, :3], axis=1))[:5]
    return {
        "schema": "stiffcal/validate/1", "warnings": [], "rms": measures(heldout), "max": largest(heldout),
        "noise": noise,
        "relative": {k: (v / z if v and (z := zero[k]) else None) for k, v in measures(heldout).items()},
        "zero_model": zero, "scheme": f"leave one pose out, {len(run_names)} folds",
        "by_run": breakdown(names, heldout, run_names),
        "by_direction": breakdown(mostly, heldout, [f"near {sign}{axis}" for axis in "xyz" for sign in "+−"]),
        "by_load": by_load, "by_branch": breakdown(states.branch[used], heldout, ["loading", "unloading"]),
        "by_joint_angle": [], "passed": True,
        "worst": [
            {"run": str(names[i]), "row": int(i), "residual_m": float(np.linalg.norm(heldout[i, :3])),
             "load": float(loads[i]), "branch": str(states.branch[used][i])}
            for i in order
        ],
    }  # fmt: skip


def history_document(
    zero: dict[str, float | None],
    fit: dict[str, float | None],
    heldout: dict[str, float | None],
    noise: dict[str, float] | None,
) -> dict[str, Any]:
    """Three fits: two of a growing model, one that is not validated."""
    joints = ([2, 3], [1, 2, 3, 4, 5, 6])
    springs = [{"type": "joint-compliance", "joints": numbers} for numbers in joints]
    backlash = {"type": "backlash", "joints": [4]}
    return {
        "schema": "stiffcal/history/1", "warnings": [],
        "fits": [
            {"id": "1", "time": "2026-11-21T10:02:11Z", "model": {"balance": "deformed", "effects": springs[:1]},
             "heldout_rms": {k: (0.4 * v if v else None) for k, v in zero.items()},
             "fit_rms": {k: (0.38 * v if v else None) for k, v in zero.items()}, "noise": noise},
            {"id": "2", "time": "2026-11-21T10:09:40Z", "model": {"balance": "deformed", "effects": springs[1:]},
             "heldout_rms": heldout, "fit_rms": fit, "noise": noise},
            {"id": "3", "time": "2026-11-21T10:12:02Z",
             "model": {"balance": "deformed", "effects": [springs[1], backlash]},
             "heldout_rms": None, "fit_rms": fit, "noise": noise},
        ],
    }  # fmt: skip


def documents(
    joint_names: tuple[str, ...],
    c: Floats,
    covariance: Floats,
    states: ReportStates,
    run_names: list[str],
    noise: dict[str, float] | None,
) -> dict[str, Any]:
    """Fit, and validate and history documents in the interface's form."""
    used = states.used
    fit_rms = measures((states.measured - states.predicted)[used])
    names = np.array(run_names)[states.run[used]]
    joints = list(range(1, len(joint_names) + 1))
    fit = fit_of(
        model={"balance": "first-order", "effects": [{"type": "joint-compliance", "joints": joints}]},
        parameters=parameters_of(joint_names, c, covariance),
        n_states=int(used.sum()),
        n_runs=len(run_names),
        rms=fit_rms,
        noise=noise,
        noise_source="repeats" if noise else "none",
        reduced_chi2=1.02 if noise else None,
        condition=31.0,
    )
    return {
        "identify": fit,
        "validate": validation_of(**validate_document(states, names, run_names, noise)),
        "history": result_of(
            HistoryResult,
            json.dumps(
                history_document(measures(states.measured[used]), fit_rms, measures(states.residual[used]), noise)
            ),
        ),
    }
