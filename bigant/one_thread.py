"""One thread a process for linear algebra: our matrices are small, what is large runs in several processes.

OpenBLAS, which numpy's wheels bring, starts a thread on every core for a product of a hundred rows. Threads
that wait for each other take ten times the processor's time of the product itself, and the last bits depend
on how many there are.
"""

import os

VARIABLE = "OPENBLAS_NUM_THREADS"


def one_thread() -> None:
    """Ask for one thread, unless the environment says how many; before numpy is imported, or too late."""
    os.environ.setdefault(VARIABLE, "1")
