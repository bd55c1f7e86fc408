"""All benchmarks, as ratios to a peer or limit in the same run: ``python -m tests.benchmarks [--smoke]``.

Every benchmark runs in a process of its own with one BLAS thread, set before numpy is imported. ``--smoke`` runs small
sizes to see that everything still works; ratios do not count then. Ingest, which writes gigabytes, runs last. The
coverage study is apart, as it takes minutes: ``python -m tests.benchmarks.coverage``.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
ONE_THREAD = dict.fromkeys(THREADS, "1")
ROOT = Path(__file__).parents[2]
MISSED = 3  # exit code; 1 is that of an exception

# What each `main` gets in the smoke run: few seconds, but as many states, pairs and bytes as it takes to go the way of
# the full size where that is another: a second block of angles or poses (4096), of runs (256, 500) or whitened rows;
# fits that start on some of the poses (10 000); campaigns that are copies; a log of more blocks than are kept (655 s).
SMOKE: dict[str, tuple[object, ...]] = {
    "jacobian_speed": (5000, 1),
    "fit_speed": (10_000, 1),
    "step_speed": (600, 20_500, 1),
    "cost": (5140, 60, 2000, "irb4400"),
    "judgement_cost": (200,),
    "plan_cost": (30, 600, 60),
    "absolute_cost": (40, 60, 0, (40, 10_000)),
    "batch_speed": (2,),
    "ingest_speed": (0.03, 1, 500),
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the benchmarks; return 1 where a wanted ratio was missed, 2 where one did not run."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--smoke", action="store_true", help="small sizes: only whether it runs")
    parser.add_argument("--only", choices=[*SMOKE], help="one benchmark instead of all")
    options = parser.parse_args(arguments)
    ended = {}
    for name in [options.only] if options.only else SMOKE:
        print(f"== {name}", flush=True)
        done = subprocess.run(command(name, options.smoke), env={**os.environ, **ONE_THREAD}, check=False, cwd=ROOT)
        ended[name] = done.returncode
    failed = [name for name, code in ended.items() if code not in (0, MISSED)]
    missed = [name for name, code in ended.items() if code == MISSED and not options.smoke]
    for state, names in (("missed", missed), ("did not run", failed)):
        if names:
            print(f"{state}: {', '.join(names)}")
    return 2 if failed else 1 if missed else 0


def command(name: str, smoke: bool) -> list[str]:
    """Return the command line of one benchmark."""
    call = f"main{SMOKE[name] if smoke else ()}"
    code = f"import sys; from tests.benchmarks.{name} import main; sys.exit(0 if {call} else {MISSED})"
    return [sys.executable, "-c", code]


if __name__ == "__main__":
    sys.exit(main())
