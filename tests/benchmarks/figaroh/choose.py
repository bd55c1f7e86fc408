"""FIGAROH's choice of configurations from given information matrices. Run in FIGAROH's own environment.

``python choose.py FACTORS.npz OUT.json METHOD RUNS``: METHOD is "socp" (continuous weights; chosen are those of largest
weight, as many as RUNS, 0: all above FIGAROH's threshold) or "detmax" (exchange from a random start).
"""

from __future__ import annotations

import json
import random
import sys
import time
from pathlib import Path

import numpy as np
from figaroh.optimal.base_optimal_calibration import Detmax, SOCPOptimizer

THRESHOLD = 1e-5


def main(factors_file: Path, out: Path, method: str, n_runs: int) -> None:
    """Write which configurations are chosen, and the seconds that it took."""
    factors = np.load(factors_file)["factors"]
    random.seed(0)
    began = time.process_time()
    pool = {k: factor.T @ factor for k, factor in enumerate(factors)}
    if method == "socp":
        _, ranked = SOCPOptimizer(pool, {"NbSample": len(pool)}).solve()
        chosen = [int(k) for k, weight in ranked.items() if n_runs or weight > THRESHOLD]
        chosen = chosen[:n_runs] if n_runs else chosen
    else:
        algorithm = Detmax(pool, n_runs)
        # its set of chosen configurations is a local name of main_algo: it is taken from the last one evaluated
        evaluated: list[list[int]] = []
        criterion = algorithm.get_critD

        def noted(chosen: list[int]) -> float:
            evaluated.append(list(chosen))
            return float(criterion(chosen))

        algorithm.get_critD = noted
        algorithm.main_algo()
        chosen = [int(k) for k in evaluated[-1]]
    seconds = time.process_time() - began
    out.write_text(json.dumps({"chosen": chosen, "seconds": seconds}), encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]), sys.argv[3], int(sys.argv[4]))
