"""Follow the `next:` lines of every command in all states: ``python -m tests.next_steps [NAME…]``.

Names take the states whose name begins so. Returns 1 where a proposed step does not run, or a state comes again.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
import time
from pathlib import Path

from tests.next_steps.states import ALL
from tests.next_steps.walking import Walker


def main() -> int:
    """Follow all lines; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME")
    names = parser.parse_args().names
    states = [state for state in ALL if not names or any(state.name.startswith(name) for name in names)]
    wrong = followed = 0
    with tempfile.TemporaryDirectory(prefix="stiffcal-next-") as work, open(os.devnull) as nothing:  # noqa: PTH123
        sys.stdin = nothing  # nobody is asked
        os.environ["STIFFCAL_STATE"] = str(Path(work) / "state")
        for number, state in enumerate(states):
            began, place = time.process_time(), Path(work) / f"{number}"
            (place / "copies").mkdir(parents=True)
            state.make(place / "made" / "campaign")
            walker = Walker(place / "copies")
            start = walker.begin(place / "made" / "campaign")
            faults = [fault for words in state.entries for fault in walker.follow(start, words)]
            followed += len(walker.answers)
            wrong += len(faults)
            sys.stdout.write(f"{state.name}: {len(walker.answers)} answers, {time.process_time() - began:.1f} s\n")
            sys.stdout.writelines(f"  {fault}\n" for fault in dict.fromkeys(faults))
            sys.stdout.flush()
    sys.stdout.write(f"{len(states)} states, {followed} answers, {wrong} faults\n")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
