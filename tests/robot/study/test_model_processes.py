"""Frames on several processes are the frames on one."""

import numpy as np
import pytest

from benchmarks.model.processes import ModelProcesses, SharedFrames
from model.errors import ModelError
from model.quasistatic.frames import FrameSolutions, FrictionLaw, solve_frames
from model.systems.disk import disk, random_disk_poses


@pytest.mark.soak
def test_processes_give_what_one_gives() -> None:
    system, feet = disk(6), random_disk_poses(501, 6, np.random.default_rng(0))
    with ModelProcesses(2) as pool, SharedFrames(501, 6) as room:
        room.feet.position_m[:] = feet.position_m
        room.feet.velocity_m_s[:] = feet.velocity_m_s
        room.feet.position_m[7, 2, 1] = np.nan
        for law in FrictionLaw:
            expected = solve_frames(room.feet, system.contact, system.weight_n, law=law)
            found = pool.solve(room, system.contact, system.weight_n, law=law)
            for field in FrameSolutions._fields:
                np.testing.assert_allclose(
                    getattr(found, field), getattr(expected, field), rtol=0, atol=1e-11
                )
        assert not found.valid[7]


def test_no_process_is_no_pool() -> None:
    with pytest.raises(ModelError, match="at least one"):
        ModelProcesses(0)


def test_memory_that_is_not_there_is_said() -> None:
    with pytest.raises(ModelError, match="solve fewer frames"):
        SharedFrames(10**14, 6)
