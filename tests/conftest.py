"""What holds for all tests: one thread of linear algebra a process, and how often a property is tried.

A worker of pytest-xdist inherits the environment, so this is in time for all of them.
"""

import pytest
from hypothesis import settings

from bigant.one_thread import one_thread

one_thread()

# No deadline: how long an example takes depends on what else the computer does.
settings.register_profile("usual", deadline=None)
settings.register_profile("soak", deadline=None, max_examples=1000)


def pytest_configure(config: pytest.Config) -> None:
    words = str(config.option.markexpr)
    settings.load_profile("soak" if words == "soak" else "usual")
