"""All benchmarks, as ratios to a peer or limit in the same run: ``python -m tests.benchmarks [--smoke]``.

Every benchmark runs in a process of its own with one BLAS thread, set before numpy is imported. ``--smoke`` runs small
sizes to see that everything still works; ratios do not count then. A batch of a hundred campaigns, and ingest, which
writes gigabytes, run last and not in the smoke run. The coverage study is apart, as it takes minutes:
``python -m tests.benchmarks.coverage``.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
from collections.abc import Sequence

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
ONE_THREAD = dict.fromkeys(THREADS, "1")

CALLS = {
    "jacobian_speed": ("main()", "main(2000, 1)"),
    "fit_speed": ("main()", "main(400, 1)"),
    "step_speed": ("main()", "main(300, 500, 1)"),
    "cost": ("main()", "main(400, 200, 400)"),
}
LONG = ("batch_speed", "ingest_speed", "plan_cost", "absolute_cost")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the benchmarks; return 1 where a wanted ratio was missed, 2 where one did not run."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--smoke", action="store_true", help="small sizes, for CI: only whether it runs")
    parser.add_argument("--only", choices=[*CALLS, *LONG], help="one benchmark instead of all")
    options = parser.parse_args(arguments)
    names = [options.only] if options.only else [*CALLS] if options.smoke else [*CALLS, *LONG]
    missed = 0
    for name in names:
        print(f"== {name}", flush=True)
        ended = subprocess.run(command(name, options.smoke), env={**os.environ, **ONE_THREAD}, check=False).returncode
        if ended not in (0, 1):
            return 2
        missed += ended
    return 0 if options.smoke else min(missed, 1)


def command(name: str, smoke: bool) -> list[str]:
    """Return the command line of one benchmark."""
    if name not in CALLS:
        return [sys.executable, "-m", f"tests.benchmarks.{name}"]
    call = CALLS[name][1 if smoke else 0]
    return [sys.executable, "-c", f"import sys; from tests.benchmarks.{name} import main; sys.exit(0 if {call} else 1)"]


if __name__ == "__main__":
    sys.exit(main())
