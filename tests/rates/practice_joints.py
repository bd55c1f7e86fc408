"""Practice campaigns of single joints (``campaigns/joints``): `improve` on a copy, compared with the truth."""

from __future__ import annotations

import json
import shutil
import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.special import chdtrc

from stiffcal.arrays import Floats
from stiffcal.commands.diagnose import diagnose_campaign
from stiffcal.commands.improve import improve_campaign
from stiffcal.measurements.rms import Rms
from stiffcal.results.identify_result import IdentifyResult
from stiffcal.stages.fit import up_to_date_fit
from stiffcal.stages.steps import RunContext, up_to_date_states

JOINTS = Path(__file__).resolve().parents[2] / "campaigns" / "joints"
# effects of truth.json that are in no catalogue
OUTSIDE = ("rate-stiffening", "after-speed")
# truth.json's symbols where the catalogue's differ
SYMBOLS = {"width_rad": "width", "band_Nm": "band", "slip_Nm": "slip", "stribeck_Nm": "stribeck"}
# conditions of the simulation, which no fit answers
CONDITIONS = ("reference_degC",)
# p-values below this one contradict the truth
LEAST_P = 0.001


@dataclass(frozen=True)
class JointTruth:
    """What one campaign hides.

    Attributes
    ----------
    experiment : ``clamped`` or ``friction``.
    hidden : names of the hidden effects.
    parameters : true values by the names of the fit, without the joint's place: ``stribeck.velocity``.
    """

    experiment: str
    hidden: frozenset[str]
    parameters: Mapping[str, float]

    @property
    def outside(self) -> bool:
        """No effect of the catalogue explains it."""
        return bool(self.hidden & set(OUTSIDE))


@dataclass(frozen=True)
class JointAnswer:
    """What `improve` answered for one campaign.

    Attributes
    ----------
    folder : its name. truth : what is hidden.
    searched : candidates were compared; where False, the rest is of the model as it was.
    named : effects that were added.
    unexplained : something is missing that no effect accounts for.
    p_value : of all true parameters together, χ² with the fit's covariance; NaN where not all are fitted.
    before, after : error in held-out readings over the noise, with the first and the last model.
    seconds : of `improve`, from ingested data.
    """

    folder: str
    truth: JointTruth
    searched: bool
    named: tuple[str, ...]
    unexplained: bool
    p_value: float
    before: float
    after: float
    seconds: float

    @property
    def right(self) -> bool:
        """The hidden effects are named and no others, with the true parameters, or it is unexplained."""
        if not self.searched:
            return False
        if self.truth.outside:
            return self.unexplained
        return set(self.named) == self.truth.hidden and not self.unexplained and self.p_value > LEAST_P


def read_truths(folder: Path = JOINTS) -> dict[str, JointTruth]:
    """Return what is hidden, by folder name."""
    truths = {}
    for entry in json.loads((folder / "truth.json").read_text("utf-8")):
        if entry["experiment"] == "clamped":
            parameters = {"joint-compliance.c": 1.0 / entry["stiffness"]}
        else:
            parameters = {"joint-friction.coulomb": entry["coulomb_Nm"], "joint-friction.viscous": entry["viscous"]}
        for effect, values in entry["hidden"].items():
            for symbol in values.keys() - set(CONDITIONS):
                parameters[f"{effect}.{SYMBOLS.get(symbol, symbol)}"] = values[symbol]
        truths[entry["name"]] = JointTruth(entry["experiment"], frozenset(entry["hidden"]), parameters)
    return truths


def series_of_p_form(p: Floats) -> tuple[Floats, Floats]:
    """Return the compliances of φ = c τ + c2 τ² + c3 τ³ + …, which inverts τ = p1 φ + p2 φ² + p3 φ³ about zero.

    Parameters
    ----------
    p : (3,) p1, N·m/rad; p2, N·m/rad²; p3, N·m/rad³.

    Returns
    -------
    coefficients : (3,) c, c2, c3.
    jacobian : (3, 3) their derivatives by p.
    """
    p1, p2, p3 = p
    coefficients = np.array([1.0 / p1, -p2 / p1**3, 2.0 * p2**2 / p1**5 - p3 / p1**4])
    jacobian = np.array(
        [
            [-1.0 / p1**2, 0.0, 0.0],
            [3.0 * p2 / p1**4, -1.0 / p1**3, 0.0],
            [-10.0 * p2**2 / p1**6 + 4.0 * p3 / p1**5, 4.0 * p2 / p1**5, -1.0 / p1**4],
        ]
    )
    return coefficients, jacobian


def without_place(name: str) -> str:
    """Return a parameter's name without its joint: ``stribeck.velocity`` for ``stribeck.j1.velocity``."""
    effect, *_, symbol = name.split(".")
    return f"{effect}.{symbol}"


def p_of_truth(fit: IdentifyResult, truth: JointTruth) -> float:
    """Return the χ² probability of the true parameters in a fit.

    Every free parameter takes part; what the truth does not list is zero there. NaN where the fit lacks a listed
    parameter that is not a whole number (a ripple's order is chosen, not fitted).
    """
    names = [without_place(name) for name in fit.free_parameters]
    by_name = {parameter.name: parameter.value for parameter in fit.parameters}
    values = np.array([by_name[name] for name in fit.free_parameters], dtype=np.float64)
    covariance = np.array(fit.covariance, dtype=np.float64)
    p_form = [f"cubic-stiffness.p{k}" for k in (1, 2, 3)]
    if set(p_form) <= set(names):
        place = [names.index(name) for name in p_form]
        jacobian = np.eye(len(names))
        values[place], jacobian[np.ix_(place, place)] = series_of_p_form(values[place])
        covariance = jacobian @ covariance @ jacobian.T
        for at, symbol in zip(place, ("joint-compliance.c", "cubic-stiffness.c2", "cubic-stiffness.c3"), strict=True):
            names[at] = symbol
    chosen = {without_place(name) for name in by_name} - {without_place(name) for name in fit.free_parameters}
    if not set(truth.parameters) <= set(names) | chosen:
        return float("nan")
    found = {without_place(name): value for name, value in by_name.items()}
    if any(found[name] != truth.parameters.get(name) for name in chosen):
        return 0.0
    off = values - np.array([truth.parameters.get(name, 0.0) for name in names])
    scale = np.sqrt(np.diag(covariance))
    correlation = covariance / np.outer(scale, scale)
    chi2 = float(off / scale @ np.linalg.solve(correlation, off / scale))
    return float(chdtrc(len(names), chi2))


def ask_joint(folder: Path) -> JointAnswer:
    """Improve a copy of a campaign and compare with the truth."""
    truth = read_truths(folder.parent)[folder.name]
    with tempfile.TemporaryDirectory(prefix="joints-") as temporary:
        copy = Path(shutil.copytree(folder, Path(temporary) / folder.name, ignore=shutil.ignore_patterns("store")))
        context = RunContext()
        up_to_date_states(copy, context)
        start = time.perf_counter()
        improved = improve_campaign(copy, context)
        seconds = time.perf_counter() - start
        fit = up_to_date_fit(up_to_date_states(copy, context), context)
        diagnosis = diagnose_campaign(copy, context)
    return JointAnswer(
        folder=folder.name,
        truth=truth,
        searched=diagnosis.pace.candidates > 0,
        named=tuple(step.effect for step in improved.steps if step.action == "add" and step.effect is not None),
        unexplained=bool(improved.unexplained),
        p_value=p_of_truth(fit, truth),
        before=over_noise(improved.steps[0].heldout_rms, improved.noise),
        after=over_noise(improved.heldout_rms, improved.noise),
        seconds=seconds,
    )


def over_noise(error: Rms | None, noise: Rms | None) -> float:
    """Return an error over the noise in the quantity that the experiment measures; NaN where there is none."""
    if error is None or noise is None:
        return float("nan")
    for value, scatter in ((error.motor_angle, noise.motor_angle), (error.torque, noise.torque)):
        if value is not None and scatter:
            return value / scatter
    return float("nan")


def joint_table(answers: Sequence[JointAnswer]) -> str:
    """Return the table."""
    lines = [f"{'':<4}{'hidden':<42}{'named':<44}{'right':<7}{'p':>7}{'before':>8}{'after':>7}{'s':>6}"]
    for answer in answers:
        hidden = " + ".join(sorted(answer.truth.hidden)) or "nothing"
        hidden += " (outside the catalogue)" if answer.truth.outside else ""
        named = " + ".join(answer.named) or ("none of these" if answer.unexplained else "nothing")
        named = named if answer.searched else "no effect is searched for"
        lines.append(
            f"{answer.folder:<4}{hidden:<42}{named:<44}{'yes' if answer.right else 'NO':<7}{answer.p_value:>7.3f}"
            f"{answer.before:>8.3f}{answer.after:>7.3f}{answer.seconds:>6.1f}"
        )
    right = sum(answer.right for answer in answers)
    lines.append(
        f"{right} of {len(answers)} right; p of the true parameters; errors in held-out readings, over the noise"
    )
    return "\n".join(lines)
