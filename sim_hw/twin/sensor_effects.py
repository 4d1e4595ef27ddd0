"""Effects of sensing: what encoders, transducers and cameras report that is not so."""

from dataclasses import replace

from model.values.arrays import FloatArray, IntArray
from sim_hw.twin.body import at
from sim_hw.twin.effects import ALL, LEG, EffectKind, EffectParameter
from sim_hw.twin.twin import Twin


def _sensors(twin: Twin, **changes: object) -> Twin:
    return replace(twin, sensors=replace(twin.sensors, **changes))  # type: ignore[arg-type]


def _force_gain(twin: Twin, legs: IntArray, values: FloatArray) -> Twin:
    return _sensors(twin, force_gain=at(twin.sensors.force_gain, legs, values[0]))


def _force_bias(twin: Twin, legs: IntArray, values: FloatArray) -> Twin:
    return _sensors(twin, force_bias=at(twin.sensors.force_bias, legs, values))


def _force_drift(twin: Twin, legs: IntArray, values: FloatArray) -> Twin:
    return _sensors(twin, force_drift=at(twin.sensors.force_drift, legs, values[0]))


def _force_rotation(twin: Twin, legs: IntArray, values: FloatArray) -> Twin:
    return _sensors(twin, force_yaw=at(twin.sensors.force_yaw, legs, values[0]))


def _force_delay(twin: Twin, _: IntArray, values: FloatArray) -> Twin:
    return _sensors(twin, force_delay_s=float(values[0]))


def _force_lowpass(twin: Twin, _: IntArray, values: FloatArray) -> Twin:
    return _sensors(twin, force_lag_s=float(values[0]))


def _pose_delay(twin: Twin, _: IntArray, values: FloatArray) -> Twin:
    return _sensors(twin, pose_delay_s=float(values[0]))


def _pose_yaw_offset(twin: Twin, _: IntArray, values: FloatArray) -> Twin:
    return _sensors(twin, pose_yaw=float(values[0]))


def _pose_origin_offset(twin: Twin, _: IntArray, values: FloatArray) -> Twin:
    return _sensors(twin, pose_origin=values.copy())


def _clock_skew(twin: Twin, _: IntArray, values: FloatArray) -> Twin:
    return _sensors(twin, pose_clock=float(values[0]))


def _encoder_scale(twin: Twin, legs: IntArray, values: FloatArray) -> Twin:
    return _sensors(twin, encoder_scale=at(twin.sensors.encoder_scale, legs, values[0]))


def _marker_swap(twin: Twin, legs: IntArray, _: FloatArray) -> Twin:
    other = (int(legs[0]) + 1) % len(twin.names)
    return _sensors(twin, swapped=(int(legs[0]), other))


def _p(name: str, unit: str, low: float, high: float, *sizes: float) -> EffectParameter:
    neutral, mild, strong = sizes
    return EffectParameter(name, unit, low, high, neutral, mild, strong)


KINDS = (
    EffectKind(
        "force_gain", "sensing", LEG, (_p("ratio", "", 0.2, 3, 1, 1.1, 1.3),),
        "the transducer's wrench", _force_gain,
    ),
    EffectKind(
        "force_bias", "sensing", LEG,
        (
            _p("x_n", "N", -10, 10, 0, 0.5, 1.5),
            _p("y_n", "N", -10, 10, 0, 0.5, 1.0),
            _p("z_n", "N", -20, 20, 0, 1.0, 3.0),
        ),
        "added to the transducer's force, its own axes", _force_bias,
    ),
    EffectKind(
        "force_drift", "sensing", LEG, (_p("n_per_s", "N/s", -1, 1, 0, 0.03, 0.1),),
        "grows on the transducer's vertical force from the start of the stream on", _force_drift,
    ),
    EffectKind(
        "force_rotation", "sensing", LEG, (_p("yaw_rad", "rad", -1.6, 1.6, 0, 0.1, 0.3),),
        "the transducer is mounted turned", _force_rotation,
    ),
    EffectKind(
        "force_delay", "sensing", ALL, (_p("delay_s", "s", 0, 1, 0, 0.06, 0.15),),
        "the force unit sends what was", _force_delay,
    ),
    EffectKind(
        "force_lowpass", "sensing", ALL, (_p("time_constant_s", "s", 0, 1, 0, 0.06, 0.15),),
        "the force unit's filter", _force_lowpass,
    ),
    EffectKind(
        "pose_delay", "sensing", ALL, (_p("delay_s", "s", 0, 1, 0, 0.06, 0.15),),
        "the cameras' poses and markers", _pose_delay,
    ),
    EffectKind(
        "pose_yaw_offset", "sensing", ALL, (_p("yaw_rad", "rad", -0.5, 0.5, 0, 0.03, 0.08),),
        "the marker frame is turned in the body", _pose_yaw_offset,
    ),
    EffectKind(
        "pose_origin_offset", "sensing", ALL,
        (_p("x_m", "m", -0.1, 0.1, 0, 0.01, 0.03), _p("y_m", "m", -0.1, 0.1, 0, 0.0, 0.01)),
        "the marker frame sits elsewhere in the body", _pose_origin_offset,
    ),
    EffectKind(
        "clock_skew", "sensing", ALL, (_p("ratio", "", 1, 1.05, 1, 1.004, 1.012),),
        "the cameras' clock runs faster than the controller's, from the trial's start on", _clock_skew,
    ),
    EffectKind(
        "encoder_scale", "sensing", LEG, (_p("ratio", "", 0.95, 1.05, 1, 1.004, 1.01),),
        "angles and speeds that a servo reports; its control loop has them right", _encoder_scale,
    ),
    EffectKind(
        "marker_swap", "sensing", LEG, (),
        "the cameras take this foot's marker for the next leg's and the other way round",
        _marker_swap, catalogued=False,
    ),
)  # fmt: skip
