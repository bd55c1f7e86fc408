"""Estimation has one room: who else makes columns, calls a solver or reads bounds and priors is listed, and fewer."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

import stiffcal

ROOT = Path(stiffcal.__file__).parent
# where fits are made: `estimation`, and `identification`, which makes rows of load states
OWN = ("estimation/", "identification/")

# Differentiates the model itself: poses that a plan predicts, where nothing is measured.
COLUMNS = {"planning/information.py"}

# Linearises without a fit: runs that are planned or compared with others.
ROWS = {"planning/information.py", "planning/rivals.py", "diagnosis/suspects/whitened_runs.py"}

# Solvers of other kinds of experiment and of questions that are no fit of a model's parameters.
SOLVERS = {
    "diagnosis/scans/normal_equations.py",  # folds and candidates, from inner products
    "kinds/clamped/states/state_noise.py",
    "mistakes/displacements/springs.py",  # springs that cannot be negative, of loads and deflections as read
    "mistakes/displacements/turned_sensor.py",  # turns of a force sensor, against springs
    "propose/unnamed_states.py",  # the load at rest
    "reduction/loads/excitation.py",  # loads that a person chose
}

# Leaves folds out in other ways than `estimation.leave_out`, until they are replaced.
FOLDS = {
    "diagnosis/scans/base_rows.py",  # the catalogue, candidate by candidate
    "diagnosis/scans/few_rows.py",
    "diagnosis/scans/folds.py",
    "diagnosis/scans/load_scan.py",
    "diagnosis/scans/scoring.py",
    "diagnosis/suspects/whitened_runs.py",  # runs that are off
    "diagnosis/suspects/find.py",
    "diagnosis/suspects/selection.py",
}

# Reads bounds or a prior of a law's parameter.
BOUNDS = {
    "diagnosis/scans/scan.py",  # keeps a shape that it tries within what is possible
    "diagnosis/suspects/rival_effects.py",
    "effects/presliding.py",  # keeps a shape within what is possible
    "effects/stribeck.py",
    "identification/fitting/base_load.py",  # the directions of gravity that a prior holds
    "model/assembled/assembly.py",  # values that a person wrote
    "model/parameters.py",
    "model/catalogue/plugin_contract.py",
    "model/laws/prismatic.py",  # the law along an axis has other units
    "ingest/checks/absolute.py",
    "commands/effects.py",  # prints them
}


def sources() -> Iterator[tuple[str, ast.Module]]:
    for path in sorted(ROOT.rglob("*.py")):
        yield path.relative_to(ROOT).as_posix(), ast.parse(path.read_text(encoding="utf-8"))


def imported(tree: ast.Module) -> Iterator[tuple[str, str]]:
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module:
            yield from ((node.module, alias.name) for alias in node.names)


def reads_bounds(tree: ast.Module) -> bool:
    """Return whether ``lower``, ``upper`` or ``prior`` of a ``spec`` is read."""
    for node in ast.walk(tree):
        if not isinstance(node, ast.Attribute) or node.attr not in {"lower", "upper", "prior"}:
            continue
        of = node.value
        name = of.id if isinstance(of, ast.Name) else of.attr if isinstance(of, ast.Attribute) else ""
        if isinstance(of, ast.Call) and isinstance(of.func, ast.Attribute):
            name = of.func.attr
        if name in {"spec", "parameter_spec"}:
            return True
    return False


@pytest.fixture(scope="module")
def trees() -> dict[str, ast.Module]:
    return dict(sources())


def test_nobody_else_differentiates_the_model(trees: dict[str, ast.Module]) -> None:
    found = {
        name
        for name, tree in trees.items()
        if not name.startswith(OWN)
        and any(
            module == "stiffcal.identification.derivatives.observation" and what in {"evaluate", "derivatives"}
            for module, what in imported(tree)
        )
    }
    assert found == COLUMNS


def test_rows_come_from_a_fit(trees: dict[str, ast.Module]) -> None:
    made = {
        name
        for name, tree in trees.items()
        if not name.startswith(OWN)
        and any(
            isinstance(node, ast.Attribute)
            and node.attr == "about"
            and isinstance(node.value, ast.Name)
            and node.value.id == "LoadRows"
            for node in ast.walk(tree)
        )
    }
    assert made == ROWS


def test_nobody_else_calls_a_solver(trees: dict[str, ast.Module]) -> None:
    solvers = {"least_squares", "least_squares_within", "lsq_linear", "minimize", "solve_step"}
    found = {
        name
        for name, tree in trees.items()
        if not name.startswith(OWN)
        and any(
            what in solvers and module.startswith(("scipy.optimize", "stiffcal.estimation"))
            for module, what in imported(tree)
        )
    }
    assert found == SOLVERS


def test_gauss_newton_has_one_caller_for_each_kind_of_rows(trees: dict[str, ast.Module]) -> None:
    """Every fit of load states and absolute places goes through `fit_observations`, every one of friction `PartFit`."""
    callers = {name for name, tree in trees.items() if ("stiffcal.estimation.solve", "settle") in imported(tree)}
    assert callers == {
        "identification/fitting/identify.py",
        "kinds/friction/fitting/part_fit.py",
        "kinds/clamped/loops/torque_angle_fit.py",
    }


def test_bounds_and_priors_are_read_by_estimation(trees: dict[str, ast.Module]) -> None:
    found = {name for name, tree in trees.items() if not name.startswith("estimation/") and reads_bounds(tree)}
    assert found == BOUNDS


def test_folds_are_left_out_by_one_engine(trees: dict[str, ast.Module]) -> None:
    """Validation, regions, friction, clamped robots, rods, forecasts and refits have `LeaveOut`, and nothing else."""
    others = {"scans.folds", "scans.few_rows", "scans.scoring", "suspects.influence"}
    own = {f"stiffcal.diagnosis.{name}" for name in others}
    results = {"Score", "LeftOutFolds", "most_suspects"}  # what a scan holds, and a number
    found = {
        name
        for name, tree in trees.items()
        if any((module in own and what not in results) or what == "without_rows" for module, what in imported(tree))
    }
    assert found == FOLDS
    users = {name for name, tree in trees.items() if ("stiffcal.estimation.leave_out", "LeaveOut") in imported(tree)}
    assert users >= {
        "diagnosis/refits/forecast.py",
        "diagnosis/of_rows/row_forecast.py",
        "diagnosis/scans/scan.py",
        "kinds/friction/fitting/heldout.py",
        "links/rods.py",
        "validation/heldout.py",
    }
