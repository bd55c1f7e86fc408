"""`python -m tests.rates.ranks --count 200`: parameters that a fit solves for, against the rank of random robots.

For each robot: as many as the singular values of its columns count, and the residual of plain least squares on all.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from tests.laboratory.random_chains import draw_chain, ranked

MOST_RESIDUAL = 1e-4
"""Share by which the residual may exceed that of all columns: what forward differences and URDFs' decimals leave."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Draw robots; return 1 where a direction was lost."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args(arguments)
    lost, unclear, worst = 0, 0, 0.0
    for seed in range(options.seed, options.seed + options.count):
        found = ranked(draw_chain(seed), seed)
        unclear += found.unclear
        worst = max(worst, 0.0 if found.unclear else found.more_residual)
        if (
            found.free != found.rank
            or found.lost_by_conventions
            or (found.more_residual > MOST_RESIDUAL and not found.unclear)
        ):
            lost += 1
            print(f"robot {seed}: {found}", flush=True)
    print(f"{options.count} robots: {lost} lose a direction, {unclear} have a singular value just below the threshold")
    print(f"residual at most {worst:.1e} of itself above that of plain least squares")
    return 1 if lost else 0


if __name__ == "__main__":
    sys.exit(main())
