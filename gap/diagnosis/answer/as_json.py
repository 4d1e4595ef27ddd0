"""A diagnosis as JSON: the shape that diagnoses from anywhere share, and more."""

from dataclasses import asdict
from typing import Any

from gap.diagnosis.answer.findings import Diagnosis, Verdict
from gap.diagnosis.answer.named_cause import NamedCause
from gap.residuals.vibration import ChannelVibration


def diagnosis_json(d: Diagnosis) -> dict[str, Any]:
    """Return the JSON object; dataclasses and NaN are still in it, as ``--json`` takes them."""
    far = d.far
    scale = 1.0 / far.before if far.before > 0 else 1.0
    return {
        "verdict": d.verdict.value,
        "sentence": d.sentence,
        "simulator": d.simulator,
        "where": {
            "stage": d.stage,
            "stages": d.where.stages,
            "joints": d.where.joints,
            "cells": d.where.cells,
        },
        "causes": [_cause(one) for one in d.causes] if d.verdict is not Verdict.NO_GAP else [],
        "ambiguous_with": _pairs(d),
        "open_rivals": _open(d),
        "gap": {
            "before": 1.0,
            "after": far.after * scale,
            "noise_floor": scale,
            "before_over_floor": far.before,
            "shrink": far.shrink,
            "shrink_interval": [far.low, far.high],
            "shrink_interval_over": "runs" if far.over_runs else "cycles",
            "held_out_runs": far.runs,
            "explainable": far.explainable,
            "what": "RMS over channels on held-out runs; before is 1",
            "end_to_end": far.end_to_end,  # else each stage was fed what was measured
        },
        "none_of_these": d.none,
        "rivals": d.rivals,
        "data_faults": [
            {"trial": one.trial, **asdict(fault)} for one in d.data_faults for fault in one.faults
        ],
        "standing": d.standing,
        "floor": {"source": d.floor_source},
        "detection": d.detection,
        "change": d.change,
        "hunting": d.hunting,
        "channels": far.channels,
        "fit": d.fit,
        "remaining": {"stage": d.remaining.stage, "cells": d.remaining.cells},
        "baselines": [
            {"method": b.method, "causes": [{"effect": e, "legs": list(j)} for e, j in b.causes]}
            for b in d.baselines
        ],
        # without ``values`` at this distance that make sense it is not detectable within its bounds
        "detectable": [{**asdict(one), "values": list(one.values)} for one in d.detectable],
        "next": d.next,
        "new_commands": d.new_commands,
        "trials": {"fitted": list(d.fitted_trials), "held_out": list(d.held_out_trials)},
        # until they are fixed, no answer can be trusted
        "severe_data_faults": list(d.severe_channels),
        "warnings": [*_data_warning(d), *d.warnings],
        "predictions": d.predictions,
        "seed": d.seed,
    }


def _data_warning(d: Diagnosis) -> list[str]:
    channels = ", ".join(d.severe_channels)
    words = f"fix the data first ({channels}): this diagnosis cannot be trusted"
    return [words] if channels else []


def _cause(one: NamedCause) -> dict[str, Any]:
    return {
        "effect": one.effect,
        "form": one.form,
        "legs": list(one.joints),
        "stage": one.stage,
        "parameters": {value.name: value.value for value in one.values},
        "errors": {value.name: value.error for value in one.values},
        "each_joint": [
            {
                "joint": joint,
                "parameters": {value.name: value.value for value in values},
                "errors": {value.name: value.error for value in values},
            }
            for joint, values in one.by_joint.items()
        ],
        "on_bound": [value.name for value in one.values if value.on_bound],
        "probability": one.probability,
        "p": one.p,
        "clear": one.clear,
        "shrink": one.shrink,
        "shrink_alone": one.alone,
        "shrink_last": one.last,
        "nats": one.nats,
        "nats_error": one.nats_error,
        "trend": {**asdict(one.trend), "chance": one.trend.chance},
        "vibration": _vibration(one.vibration),
        "physics": one.physics,
        "remedy": one.remedy,
    }


def _vibration(one: ChannelVibration | None) -> dict[str, Any] | None:
    if one is None:
        return None
    return {"channels": list(one.channels), "excess": one.excess, "nats": one.nats}


def _open(d: Diagnosis) -> list[dict[str, Any]]:
    """What is open instead of which cause, by its number in "causes", as a program needs it."""
    keys = [(one.effect, one.joints) for one in d.causes]
    return [
        {
            "cause": keys.index(one.of),
            "effect": one.effect,
            "form": one.form,
            "legs": list(one.joints),
        }
        for one in d.ambiguous
    ]


def _pairs(d: Diagnosis) -> list[list[str]]:
    """Pairs of effects that are indistinguishable; of one effect at two joints, both with their joint."""
    pairs = []
    for one in d.ambiguous:
        effect, joints = one.of
        places = (joints, one.joints) if one.effect == effect else ((), ())
        names = zip((effect, one.effect), places, strict=True)
        pairs.append(tuple(" ".join((name, *place)) for name, place in names))
    return [list(pair) for pair in dict.fromkeys(pairs)]
