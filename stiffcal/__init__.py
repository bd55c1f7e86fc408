"""stiffcal: find out how an industrial robot bends, and which physical effect the model lacks."""

import os

__version__ = "0.1.0"

# Threaded BLAS is not bit-equal between thread counts and was slower here; the libraries read these once, when numpy is
# imported. OMP_NUM_THREADS is left alone: pyarrow reads it too. A value that the user has set stays.
for _threads in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "BLIS_NUM_THREADS", "VECLIB_MAXIMUM_THREADS"):
    os.environ.setdefault(_threads, "1")
