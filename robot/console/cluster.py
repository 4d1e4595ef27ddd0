"""A Dask cluster that a command was told of with ``--dask``."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from model.errors import ConfigError
from robot.console.installed import how_to_install

CONNECT_S = 10.0  # how long a scheduler may take to answer, and workers to be there


@contextmanager
def cluster_client(address: str) -> Iterator[Any]:
    """Connect to the scheduler of a cluster that has workers; yield Dask's client.

    Raises:
        ConfigError: Dask is not installed, nothing answers, or there are no workers.
    """
    try:
        from distributed import Client  # an extra
    except ImportError as error:
        raise ConfigError(
            "--dask", f"needs Dask; install it with: {how_to_install('dask')}"
        ) from error
    try:
        client = Client(address, timeout=CONNECT_S)
    except (OSError, ValueError) as error:
        raise ConfigError("--dask", f"nothing answers at {address}: {error}") from error
    with client:
        try:
            client.wait_for_workers(1, timeout=CONNECT_S)
        except TimeoutError as error:
            words = f"the cluster at {address} has no workers; start one: dask worker {address}"
            raise ConfigError("--dask", words) from error
        yield client
