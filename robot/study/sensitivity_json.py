"""The result of ``bigant model sensitivity`` as JSON."""

import math

from model.fit.result import FitResult
from robot.study.sensitivity_table import PAPER_CHANGE, QUANTITIES, UNITS, Fits, Sensitivity


def as_json(
    fits: Fits, found: Sensitivity, fitted_to: int, parts: tuple[str, ...]
) -> dict[str, object]:
    """Return everything the command found, as JSON has it.

    Args:
        fits: Fitted parameters.
        found: Errors of both.
        fitted_to: Number of frames fitted to.
        parts: Names of what was fitted to and what was judged by.
    """
    rows = zip(
        QUANTITIES, UNITS, found.fitted, found.naive, found.change, PAPER_CHANGE, strict=True
    )
    return {
        "law": fits.law.value,
        "fitted_to": {"what": parts[0], "frames": fitted_to, "weight_n": fits.weight_n},
        "judged_by": {
            "what": parts[1],
            "frames": found.frames,
            "without_answer": found.without_answer,
        },
        "rmse": [
            {
                "quantity": name,
                "unit": unit,
                "fitted": _known(fitted),
                "naive": _known(naive),
                "change_percent": _known(change),
                "paper_change_percent": paper,
            }
            for name, unit, fitted, naive, change, paper in rows
        ],
        "stiffness": _result(fits.stiffness),
        "friction": _result(fits.friction),
    }


def _result(result: FitResult) -> dict[str, object]:
    return {
        "parameters": [
            {"name": name, "value": _known(value), "standard_error": _known(error)}
            for name, value, error in zip(
                result.names, result.values, result.standard_errors, strict=True
            )
        ],
        "residual_rms": _known(result.residual_rms),
        "frames_used": result.frames_used,
        "left_out": [{"why": why, "count": count} for why, count in result.left_out],
        "undetermined": list(result.undetermined),
        "warnings": list(result.warnings),
        "converged": result.converged,
    }


def _known(value: float) -> float | None:
    """JSON has no NaN: what is not known is null."""
    return float(value) if math.isfinite(value) else None
