"""filterpy is loaded without SciPy's statistics and image filters, and works as it always does."""

import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
ESTIMATOR = """
import sys
from model.estimator.filterpy_filter import kalman_filter_class
filtering = kalman_filter_class()(2, 1)
assert not {"scipy.stats", "scipy.ndimage"} & set(sys.modules)
"""
ITS_DENSITY = """
filtering.predict()
filtering.update(1.0)
import math, filterpy.stats
print(filtering.log_likelihood, filterpy.stats.logpdf(1.0, 0.0, 4.0),
      filterpy.stats.norm_cdf((-1.0, 1.0), 0.0, 1.0))
import scipy.stats
print(scipy.stats.norm.cdf(0.0), scipy.stats.__file__ is not None)
"""
ITS_OTHER_FILTER = """
import filterpy.discrete_bayes
print(*filterpy.discrete_bayes.predict([0.0, 1.0, 0.0, 0.0], 1, [0.25, 0.5, 0.25]))
import scipy.ndimage
print(*scipy.ndimage.shift([1.0, 2.0], 1, order=0, cval=3.0))
"""
LOADED_BEFORE = """
import scipy.stats
from model.estimator.filterpy_filter import kalman_filter_class
kalman_filter_class()
import filterpy.stats.stats
print(filterpy.stats.stats.norm is scipy.stats.norm)
"""


def said(code: str) -> list[str]:
    return subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, check=True, capture_output=True, text=True
    ).stdout.split()


@cache  # both in one interpreter
def behind_it() -> list[str]:
    return said(ESTIMATOR + ITS_DENSITY + ITS_OTHER_FILTER)


def test_its_own_densities_work_behind_it() -> None:
    likelihood, density, within, half, real = behind_it()[:5]
    assert float(likelihood) == pytest.approx(-1.4189, abs=1e-4)  # log N(1; 0, 1)
    assert float(density) == pytest.approx(-1.7371, abs=1e-4)  # log N(1; 0, 4)
    assert float(within) == pytest.approx(0.6827, abs=1e-4)
    assert (half, real) == ("0.5", "True")


def test_its_filter_of_cells_works_behind_it() -> None:
    cells = [float(cell) for cell in behind_it()[5:]]
    assert cells == pytest.approx([0.0, 0.25, 0.5, 0.25, 3.0, 1.0])


def test_statistics_that_are_there_already_are_used() -> None:
    assert said(LOADED_BEFORE) == ["True"]
