"""Where the jobs of a campaign run: processes of this machine, or a Dask cluster; same answers."""

from collections.abc import Iterator
from concurrent.futures import Executor
from contextlib import contextmanager

from gap.worker_pool import worker_pool
from robot.console.cluster import cluster_client


@contextmanager
def campaign_executor(jobs: int, dask: str | None) -> Iterator[Executor]:
    """Yield an executor: so many processes here, or those of the cluster whose scheduler is named.

    Raises:
        ConfigError: Dask is not installed, nothing answers, or there are no workers.
    """
    if dask is None:
        with worker_pool(jobs) as local:
            yield local
        return
    with cluster_client(dask) as client, client.get_executor() as cluster:
        yield cluster
