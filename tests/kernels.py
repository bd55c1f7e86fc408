"""The numerical tests under the BLAS kernels of several processors: `python -m tests.kernels [NAME ...]`.

numpy and scipy bring OpenBLAS with them, which holds kernels for many processors and takes those of the one it runs on.
They sum in different orders, so that the last digits differ. `OPENBLAS_CORETYPE` asks for others; one that the
processor cannot run, or that the library does not hold, is not taken, which the library itself is asked about. Kernels
whose results are those of others to the last bit (Zen's are Haswell's with other sizes of blocks) are not tried again.

``--others`` leaves out the kernels that this processor takes by itself: under those all tests run anyway.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from tests.conftest import NUMERICAL

KERNELS = ("Haswell", "SkylakeX", "Zen")
ROOT = Path(__file__).parents[1]
# OpenBLAS takes a kernel on demand without asking whether the processor has its instructions.
INSTRUCTIONS = {
    "Haswell": {"avx2", "fma"},
    "Zen": {"avx2", "fma"},
    "SkylakeX": {"avx512f", "avx512dq", "avx512bw", "avx512vl"},
}
# Prints the kernels in use by each OpenBLAS that numpy and scipy have loaded, one per line.
ASK = """
import ctypes, glob, os
import numpy, scipy.linalg
for package in (numpy, scipy):
    inside = os.path.dirname(package.__file__)
    places = inside + ".libs", os.path.join(inside, ".dylibs")
    for file in sorted(file for place in places for file in glob.glob(os.path.join(place, "*openblas*"))):
        library = ctypes.CDLL(file)
        for start in ("scipy_", ""):
            for end in ("64_", ""):
                name = start + "openblas_get_corename" + end
                if hasattr(library, name):
                    ask = getattr(library, name)
                    ask.restype = ctypes.c_char_p
                    print(ask().decode())
"""
# Prints a digest of products, factors, solutions and singular values at the sizes of these tests.
COMPUTE = """
import hashlib
import numpy as np, scipy.linalg as la
draw = np.random.default_rng(0).normal
digest = hashlib.sha256()
for rows in (6, 37, 150, 1200):
    for columns in (3, 12, 37, 130):
        A, B, b, x = draw(size=(rows, columns)), draw(size=(columns, 50)), draw(size=rows), draw(size=columns)
        S = A.T @ A + np.eye(columns)
        parts = [A @ B, A.T @ A, A @ x, A.T @ b, b @ b, la.norm(b), draw(size=(9, 6, 6)) @ draw(size=(6, columns))]
        parts += [*la.qr(A, mode="economic", pivoting=True), *np.linalg.qr(A), *np.linalg.svd(A, full_matrices=False)]
        parts += [la.cholesky(S), la.cho_solve(la.cho_factor(S), x), la.solve(S, x), np.linalg.inv(S), *la.eigh(S)]
        parts += [np.linalg.lstsq(A, b)[0], la.solve_triangular(np.triu(S), A.T)]
        for part in parts:
            digest.update(np.ascontiguousarray(part).tobytes())
print(digest.hexdigest())
"""


def flags() -> set[str] | None:
    """Return the processor's instruction sets; None where the system does not list them."""
    file = Path("/proc/cpuinfo")
    if not file.exists():
        return None
    found = [line for line in file.read_text(encoding="utf-8").splitlines() if line.startswith("flags")]
    return set(found[0].partition(":")[2].split()) if found else None


def taken(kernel: str) -> set[str]:
    """Return the kernels that numpy's and scipy's libraries take where ``kernel`` is asked for."""
    ended = subprocess.run([sys.executable, "-c", ASK], env=environment(kernel), capture_output=True, text=True)
    return set(ended.stdout.split()) if ended.returncode == 0 else set()


def computed(kernel: str) -> str:
    """Return the digest of what numpy and scipy compute under these kernels; empty where they fail."""
    ended = subprocess.run([sys.executable, "-c", COMPUTE], env=environment(kernel), capture_output=True, text=True)
    return ended.stdout.strip() if ended.returncode == 0 else ""


def environment(kernel: str) -> dict[str, str]:
    """Return the environment in which a process takes these kernels, on one thread as stiffcal does."""
    return {**os.environ, "OPENBLAS_CORETYPE": kernel, "OPENBLAS_NUM_THREADS": "1"}


def why_skipped(kernel: str, done: Sequence[str], has: set[str] | None) -> str:
    """Return the reason for which these kernels cannot be tried here; empty where they can.

    Parameters
    ----------
    kernel : name, as OpenBLAS spells it.
    done : kernels that have been tried.
    has : of `flags`.
    """
    lacking = INSTRUCTIONS.get(kernel, set()) - (has if has is not None else INSTRUCTIONS.get(kernel, set()))
    if lacking:
        return f"this processor has no {', '.join(sorted(lacking))}"
    found = taken(kernel)
    if not found:
        return "numpy and scipy do not say which kernels they take"
    if found != {kernel}:
        names = ", ".join(sorted(found))
        again = ", which have been tried" if found <= set(done) else ""
        return f"the libraries take {names} in their place{again}"
    return ""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the tests marked `numerical` once under each kernel; return 1 where any fails."""
    parser = argparse.ArgumentParser(prog="python -m tests.kernels", description=main.__doc__)
    parser.add_argument("kernels", nargs="*", default=KERNELS, help="as OpenBLAS spells them: Haswell, Nehalem, …")
    parser.add_argument("--workers", default="2", help="processes of pytest")
    parser.add_argument("--others", action="store_true", help="leave out what the processor takes by itself")
    given = parser.parse_args(arguments)
    has = flags()
    own = taken(os.environ.get("OPENBLAS_CORETYPE", "")) if given.others else set()
    done: list[str] = []
    failed: list[str] = []
    digests: dict[str, str] = {}
    if given.others and (digest := computed(os.environ.get("OPENBLAS_CORETYPE", ""))):
        digests[digest] = "this processor"
    for kernel in given.kernels:
        if own == {kernel}:
            print(f"{kernel}: left out, the tests run under these kernels anyway", flush=True)
            done.append(kernel)
            continue
        if reason := why_skipped(kernel, done, has):
            print(f"{kernel}: skipped, {reason}", flush=True)
            continue
        digest = computed(kernel)
        if digest in digests:
            print(f"{kernel}: left out, its results are those of {digests[digest]} to the last bit", flush=True)
            done.append(kernel)
            continue
        if digest:
            digests[digest] = kernel
        began = time.monotonic()
        words = ["-m", "pytest", "-q", "-m", "numerical and not practice", "-n", given.workers, "--dist", "worksteal"]
        words += [f"tests/{place}" for place in NUMERICAL]
        code = subprocess.run([sys.executable, *words], cwd=ROOT, env=environment(kernel)).returncode
        print(f"{kernel}: {'passed' if code == 0 else 'FAILED'} in {time.monotonic() - began:.0f} s", flush=True)
        done.append(kernel)
        if code:
            failed.append(kernel)
    if not done:
        print("no kernels could be tried")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
