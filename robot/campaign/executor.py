"""Where the jobs of a campaign run: processes of this machine, or a Dask cluster; same answers."""

from collections.abc import Iterator
from concurrent.futures import Executor
from contextlib import contextmanager

from gap.worker_pool import worker_pool
from model.errors import ConfigError
from robot.console.installed import how_to_install

CONNECT_S = 10.0  # how long a scheduler may take to answer


@contextmanager
def campaign_executor(jobs: int, dask: str | None) -> Iterator[Executor]:
    """Yield an executor: so many processes here, or those of the cluster whose scheduler is named.

    Raises:
        ConfigError: Dask is not installed, or nothing answers.
    """
    if dask is None:
        with worker_pool(jobs) as local:
            yield local
        return
    try:
        from distributed import Client  # an extra
    except ImportError as error:
        raise ConfigError(
            "--dask", f"needs Dask; install it with: {how_to_install('dask')}"
        ) from error
    try:
        client = Client(dask, timeout=CONNECT_S)  # type: ignore[no-untyped-call]
    except (OSError, ValueError) as error:
        raise ConfigError("--dask", f"nothing answers at {dask}: {error}") from error
    with client, client.get_executor() as cluster:  # type: ignore[no-untyped-call]
        yield cluster
