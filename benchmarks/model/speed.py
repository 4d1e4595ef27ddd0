"""Time a frame: ours compiled and in numpy, viscous and Coulomb, single and batched."""

import subprocess
import sys
from collections.abc import Callable

import numpy as np

from benchmarks.timing import each, keep_model, repeat
from model.quasistatic.frame import prepare, solve_frame
from model.quasistatic.frames import FrictionLaw, solve_frames
from model.systems.disk import disk, random_disk_poses
from model.systems.system import System
from model.values.arrays import readonly
from model.values.contact import ContactSolution
from model.values.legs import FootMotion
from model.values.parameters import ContactParameters
from tests.model.oracles.coulomb import solve_coulomb_reference
from tests.model.oracles.traction import solve_frame_reference

FRAMES = 20_000
SINGLES = 2000
PAPER_US = {"viscous": 190.0, "one": 3700.0, "coulomb": 10_400.0}


def _reference(
    feet: FootMotion, contact: ContactParameters, weight_n: float, i: int
) -> Callable[[], bool]:
    one = FootMotion(feet.position_m[i : i + 1], feet.velocity_m_s[i : i + 1])
    start = solve_frames(one, contact, weight_n)
    return lambda: (
        solve_coulomb_reference(
            one.position_m[0, :, :2],
            one.velocity_m_s[0, :, :2],
            start.load_n[0],
            contact.mu,
            start.velocity_B[0],
        ).converged
    )


def _batch(feet: FootMotion, system: System, law: FrictionLaw) -> Callable[[], object]:
    return lambda: solve_frames(feet, system.contact, system.weight_n, law=law)


def _single(
    solve: Callable[[FootMotion, ContactParameters, float], ContactSolution],
    feet: FootMotion,
    system: System,
) -> Callable[[], object]:
    contact, weight_n = system.contact, system.weight_n
    return lambda: solve(feet, contact, weight_n)


def _first_call() -> None:
    code = (
        "import time; a = time.perf_counter(); import numba; b = time.perf_counter();"
        "from model.quasistatic.frame import prepare; prepare(); c = time.perf_counter();"
        "print(f'{b - a:.2f} s import numba, {c - b:.2f} s load the model from the cache')"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    print(f"start of a process              {out.stdout.strip()}")


def main() -> None:
    """Print the table."""
    rng = np.random.default_rng(0)
    system = disk(6)
    contact, weight = system.contact, system.weight_n
    feet = random_disk_poses(FRAMES, 6, rng)
    prepare()
    singles = [
        FootMotion(readonly(feet.position_m[i].copy()), readonly(feet.velocity_m_s[i].copy()))
        for i in range(SINGLES)
    ]
    batch = {law: repeat(_batch(feet, system, law), 15, FRAMES) for law in FrictionLaw}
    single = each([_single(solve_frame, f, system) for f in singles])
    plain = each([_single(solve_frame_reference, f, system) for f in singles[:500]], 1)
    searches = [_reference(feet, contact, weight, i) for i in range(300)]
    theirs = each(list(searches), 1)
    converged = sum(s() for s in searches)
    print(f"hexapod frames, {FRAMES} random poses")
    print(f"viscous, batched                {batch[FrictionLaw.VISCOUS]}")
    print(f"viscous, single call            {single}")
    print(f"viscous, plain numpy            {plain}   the paper: {PAPER_US['viscous']:.0f} us")
    print(f"Coulomb, batched                {batch[FrictionLaw.COULOMB]}")
    print(f"Coulomb, the paper's method     {theirs}   the paper: {PAPER_US['coulomb']:.0f} us")
    print(f"  of which converged            {converged} of {len(searches)}")
    ratio = theirs.median / batch[FrictionLaw.COULOMB].median
    print(f"Coulomb, ours against it        {ratio:.0f} times faster")
    ratio = plain.median / batch[FrictionLaw.VISCOUS].median
    print(f"viscous, compiled against numpy {ratio:.0f} times faster")
    keep_model(
        viscous=batch[FrictionLaw.VISCOUS],
        single=single,
        numpy=plain,
        coulomb=batch[FrictionLaw.COULOMB],
        coulomb_reference=theirs,
    )
    _first_call()


if __name__ == "__main__":
    main()
