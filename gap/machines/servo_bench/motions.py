"""Runs that a bench of servos could make next: its motions otherwise, loaded, or logged better."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from gap.interfaces import Cause, Proposal
from model.values.arrays import FloatArray
from record.trial.header import TrialHeader
from record.trial.table_file import TableColumn
from record.trial.trial import Trial, build_trial

RATE_HZ = 100.0
SECONDS = 10.0
MINUTES, WEIGHT_MINUTES = 1.0, 5.0
WEIGHT = (0.2, 0.1)  # kg, and m from the shaft
CHIRP_HZ = (0.1, 3.0)
# Channel by channel, the field of a trial that it needs, and how the columns are called.
LOGGED = {
    "duty": ("pwm", "the duty (pwm_J)"),
    "current": ("current_a", "the current (current_J_a)"),
}


def propose_motions(trials: Sequence[Trial]) -> Sequence[Proposal]:
    """Return motions within the range of those that were made, as they were logged and logged better."""
    missing = tuple(
        channel
        for channel, (field, _) in LOGGED.items()
        if not any(np.isfinite(getattr(one, field)).any() for one in trials)
    )
    proposals = []
    for name, trial in _motions(trials):
        minutes = MINUTES + float(np.ptp(trial.time_s)) / 60
        proposals.append(Proposal(name, trial, minutes, "", unseen=missing))
        proposals += [
            Proposal(
                f"{name}, with {LOGGED[channel][1]} logged", trial, minutes, "",
                unseen=tuple(one for one in missing if one != channel),
            )
            for channel in missing
        ]  # fmt: skip
        mass_kg, length_m = WEIGHT
        known = tuple(Cause("payload", (joint,), WEIGHT) for joint in trial.joints)
        proposals.append(
            Proposal(
                f"{name}, with {mass_kg:g} kg more at {length_m:g} m from each shaft", trial,
                minutes + WEIGHT_MINUTES, "weigh it, fasten it, measure its place", known,
                unseen=missing,
            )
        )  # fmt: skip
    return proposals


def _motions(trials: Sequence[Trial]) -> Iterator[tuple[str, Trial]]:
    """Yield a motion already made, and others within its range."""
    header = replace(trials[0].header, notes="", conditions=())
    commands = np.concatenate([one.command_rad for one in trials])
    low, high = np.nanmin(commands, axis=0), np.nanmax(commands, axis=0)
    middle, reach = 0.5 * (low + high), 0.5 * (high - low)
    yield "the first run again", _run(header, trials[0].time_s, trials[0].command_rad)
    time_s = np.arange(round(SECONDS * RATE_HZ) + 1) / RATE_HZ
    first, last = CHIRP_HZ
    rate = np.log(last / first) / SECONDS
    chirp = np.sin(2 * np.pi * first * np.expm1(rate * time_s) / rate)
    ramp = 2 / np.pi * np.arcsin(np.sin(2 * np.pi * time_s / SECONDS))
    steps = np.sign(np.sin(2 * np.pi * 0.4 * time_s))
    for name, wave, share in (
        (f"a chirp from {first:g} to {last:g} Hz over a third of the range", chirp, 1 / 3),
        ("slow ramps over the whole range", ramp, 1.0),
        ("steps over half of the range", steps, 0.5),
    ):
        yield name, _run(header, time_s, middle + share * reach * wave[:, None])


def _run(header: TrialHeader, time_s: FloatArray, command: FloatArray) -> Trial:
    columns = [
        TableColumn(f"command_{joint}_rad", own)
        for joint, own in zip(header.joints, command.T, strict=True)
    ]
    return build_trial(header, (TableColumn("time_s", time_s - time_s[0]), *columns))
