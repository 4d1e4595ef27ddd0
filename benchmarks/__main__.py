"""Run benchmarks: ``python -m benchmarks`` for all, ``python -m benchmarks model`` for some.

Every figure is a median over repetitions in this run, with quartiles where they say something; compare
figures of one run with each other, not with those of another machine.
"""

import argparse
import importlib

from bigant.one_thread import one_thread

NAMES = {
    "model": "benchmarks.model.speed",
    "legs": "benchmarks.model.legs",
    "parallel": "benchmarks.model.parallel",
    "loop": "benchmarks.loop_cost",
    "virtual_time": "benchmarks.virtual_time",
    "chain": "benchmarks.chain_tick",
    "log_size": "benchmarks.log_size",
    "twin": "benchmarks.twin.trials",
    "twin_steps": "benchmarks.twin.steps",
    "gap_chain": "benchmarks.gap.chain",
    "fuzz": "benchmarks.fuzz.frames",
    "soak": "benchmarks.faults.soak",
    "matrix": "benchmarks.faults.matrix",
    "cycle": "benchmarks.bus_cycle",
}


def main() -> None:
    """Run the benchmarks that were asked for."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument(
        "names", nargs="*", choices=[*NAMES, []], metavar="NAME", help=str([*NAMES])
    )
    one_thread()
    for name in parser.parse_args().names or NAMES:
        print(f"== {name}", flush=True)
        importlib.import_module(NAMES[name]).main()


if __name__ == "__main__":
    main()
