"""The choice of runs next to FIGAROH 1.0.2's: ``python -P -m tests.benchmarks.figaroh_choice PYTHON [CANDIDATES …]``.

PYTHON is the interpreter of an environment with tests/benchmarks/figaroh/requirements.txt. Both choose by determinant
from the same candidates: possible poses of campaigns/kr240 with loads, the columns that load runs determine. Compared
are det(M)^(1/p) of what is chosen, with the same number of runs, and processor seconds of the choice. FIGAROH has two
methods: continuous weights (a cone program, each candidate at most once) and an exchange (candidates may be repeated);
stiffcal chooses under the same rule each time.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.campaign.loading import load_campaign
from stiffcal.campaign.plan_file import PlanFile
from stiffcal.planning.campaign.candidates import candidates_of
from stiffcal.planning.choice import identifiable
from stiffcal.planning.criterion import Criterion
from stiffcal.planning.design import best_design, information
from stiffcal.stages.plans.model import planned_model
from stiffcal.stages.steps import RunContext

CAMPAIGN = Path(__file__).parents[2] / "campaigns" / "kr240"
CHOOSE = Path(__file__).parent / "figaroh" / "choose.py"
RUNS = 24
LONGEST_S = 600.0
# Of FIGAROH's det(M)^(1/p), and of its seconds.
LEAST_RATIO = 0.99


def factors_of(n_candidates: int) -> Floats:
    """Return (N, r, p) the information of candidates on the parameters that they determine."""
    campaign = load_campaign(CAMPAIGN, check_files=False)
    load = {"force_N": 4000.0, "point": "hook"}
    plan = PlanFile.model_validate({"load": load, "candidates": -(-n_candidates // 6)})
    model = planned_model(campaign, plan, RunContext())
    candidates = candidates_of(campaign, plan, model)
    factors = model.information(candidates.subset(np.arange(n_candidates))).factors
    free, identified = identifiable(factors, None)
    factors = factors[:, :, free & identified]
    # ratios of determinants stay, and FIGAROH's cone program needs well-scaled columns
    scaled = np.linalg.inv(np.linalg.cholesky(information(factors).mean(axis=0)))
    return np.ascontiguousarray(factors @ scaled.T)


def criterion_of(factors: Floats, chosen: Integers) -> float:
    """Return det(M)^(1/p) of a choice."""
    matrix = information(factors[chosen]).sum(axis=0)
    return float(np.exp(np.linalg.slogdet(matrix)[1] / len(matrix)))


def theirs(python: str, factors: Floats, method: str) -> tuple[Integers, float] | str:
    """Return FIGAROH's choice and its seconds; the kind of error where it fails, or takes longer than `LONGEST_S`."""
    with tempfile.TemporaryDirectory() as folder:
        given, out = Path(folder) / "factors.npz", Path(folder) / "chosen.json"
        np.savez(given, factors=factors)
        command = [python, str(CHOOSE), str(given), str(out), method, str(RUNS)]
        try:
            subprocess.run(command, check=True, timeout=LONGEST_S, capture_output=True)
        except (subprocess.TimeoutExpired, subprocess.CalledProcessError) as error:
            return type(error).__name__
        answer = json.loads(out.read_text(encoding="utf-8"))
    return np.array(answer["chosen"], dtype=np.int64), float(answer["seconds"])


def main(python: str, sizes: list[int]) -> bool:
    """Print both choices for each number of candidates; return whether none is below FIGAROH's, nor slower."""
    holds = True
    for size in sizes:
        factors = factors_of(size)
        for method, limit in (("socp", 1), ("detmax", None)):
            began = time.process_time()
            own = best_design(factors, RUNS, Criterion.DETERMINANT, limit=limit).chosen
            seconds = time.process_time() - began
            answer = theirs(python, factors, method)
            head = f"{size} candidates, {factors.shape[2]} columns, {RUNS} runs, {method}"
            if isinstance(answer, str):
                print(f"{head}: {seconds:.2f} s; FIGAROH has no answer: {answer}", flush=True)
                continue
            ratio = criterion_of(factors, own) / criterion_of(factors, answer[0])
            good = ratio >= LEAST_RATIO and seconds <= answer[1]
            holds &= good
            text = f"det^(1/p) {ratio:.3f} of FIGAROH's, {seconds:.2f} s against {answer[1]:.2f} s"
            print(f"{head}: {text}: {'holds' if good else 'MISSED'}", flush=True)
    return holds


if __name__ == "__main__":
    sys.exit(0 if main(sys.argv[1], [int(size) for size in sys.argv[2:]] or [100, 1000, 5000]) else 1)
