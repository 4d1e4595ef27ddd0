"""Arrays of a trial as bytes to be hashed: the same readings give the same bytes."""

from collections.abc import Iterator, Mapping
from dataclasses import fields

import numpy as np

from model.values.arrays import FloatArray
from record.trial.trial import Trial


def arrays_of(trial: Trial) -> dict[str, FloatArray]:
    """Return the arrays of a trial by their fields' names."""
    every = {one.name: getattr(trial, one.name) for one in fields(trial)}
    return {name: values for name, values in every.items() if isinstance(values, np.ndarray)}


def bytes_of(arrays: Mapping[str, FloatArray]) -> Iterator[bytes]:
    """Yield what tells arrays from others, their names and shapes included; what is missing is alike."""
    for name, values in arrays.items():
        yield f"{name} {values.dtype} {values.shape}".encode() + values.tobytes()
