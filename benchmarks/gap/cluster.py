"""One diagnosis of an MJCF machine by one process, and on a Dask cluster of two workers beside it.

``python -m benchmarks.gap.cluster RUN.parquet [ROBOT.xml]``: what a cluster costs. On one machine it can
save nothing, because simulations use all cores either way.
"""

import json
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from benchmarks.real.machines import command
from robot.console.table import Column, table_lines

COLUMNS = (Column("where"), Column("seconds", ".0f"), Column("verdict"), Column("causes"))


def main(run: str, robot: str = "") -> None:
    """Print how long each takes, and whether they agree."""
    from distributed import LocalCluster

    rows, said = [], []
    machine = ["--machine", robot] if robot else []
    cluster: Any = LocalCluster(
        n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address="127.0.0.1:0"
    )
    with tempfile.TemporaryDirectory(prefix="cluster-") as folder, cluster:
        where = {
            "this process": ["--jobs", "1"],
            "two workers": ["--dask", cluster.scheduler_address],
        }
        for name, words in where.items():
            out = Path(folder) / "diagnosis.json"
            began = time.perf_counter()
            command(["gap", "diagnose", run, *machine, "--json", str(out), *words])
            found = json.loads(out.read_text(encoding="utf-8"))
            causes = [(one["effect"], one["legs"], one["parameters"]) for one in found["causes"]]
            said.append(causes)
            rows.append((name, time.perf_counter() - began, found["verdict"], str(len(causes))))
    print("\n".join(table_lines(COLUMNS, rows)))
    print("the same numbers" if said[0] == said[1] else "numbers that differ in the last digits")


if __name__ == "__main__":
    main(*sys.argv[1:])
