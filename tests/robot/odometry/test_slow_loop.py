"""Odometry of a slow loop, whose servos jump to each goal and are read while they wait."""

import numpy as np
import pytest

from robot.odometry.compare import walking_part
from robot.odometry.track import track_log
from robot.report.ground_truth import true_pose
from tests.pace import usual
from tests.walk_logs import walk_log


@pytest.mark.soak
@pytest.mark.parametrize("rate_hz", ["33", "50"])
def test_the_distance_of_a_walk_is_right_at_any_rate(
    tmp_path_factory: pytest.TempPathFactory, rate_hz: str
) -> None:
    words = ("--cycles", "1", "--frequency-hz", "0.2", "--rate-hz", rate_hz)
    found = track_log(walk_log(tmp_path_factory, words, usual))
    span = walking_part(found.log)
    own, true = found.track.pose[span], true_pose(found.log)[span]
    went = np.hypot(*(true[-1] - true[0])[:2])
    assert went > 0.1
    # With the speeds that the servos report it is 10 % at 33 Hz, 4 % at 50 Hz.
    assert np.hypot(*(own[-1] - own[0])[:2]) == pytest.approx(went, rel=0.02)
