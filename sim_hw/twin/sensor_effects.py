"""Effects of sensing: what encoders, transducers and cameras report that is not so."""

from model.values.arrays import FloatArray, IntArray
from sim_hw.twin.effects import ALL, LEG, EffectKind, adds, adds_vector, changed, scales, sized
from sim_hw.twin.twin import Twin


def _marker_swap(twin: Twin, legs: IntArray, _: FloatArray) -> Twin:
    other = (int(legs[0]) + 1) % len(twin.names)
    return changed(twin, "sensors.swapped", (int(legs[0]), other))


KINDS = (
    EffectKind(
        "force_gain", "sensing", LEG, (sized("ratio", "", 0.2, 3, 1, 1.1, 1.3),),
        "the transducer's wrench", scales("sensors.force_gain"),
    ),
    EffectKind(
        "force_bias", "sensing", LEG,
        (
            sized("x_n", "N", -10, 10, 0, 0.5, 1.5),
            sized("y_n", "N", -10, 10, 0, 0.5, 1.0),
            sized("z_n", "N", -20, 20, 0, 1.0, 3.0),
        ),
        "added to the transducer's force, its own axes",
        adds_vector("sensors.force_bias", leg_wise=True),
    ),
    EffectKind(
        "force_drift", "sensing", LEG, (sized("n_per_s", "N/s", -1, 1, 0, 0.03, 0.1),),
        "grows on the transducer's vertical force from the start of the stream on",
        adds("sensors.force_drift"),
    ),
    EffectKind(
        "force_rotation", "sensing", LEG, (sized("yaw_rad", "rad", -1.6, 1.6, 0, 0.1, 0.3),),
        "the transducer is mounted turned", adds("sensors.force_yaw"),
    ),
    EffectKind(
        "force_cross_talk", "sensing", LEG,
        (sized("x_share", "", -0.5, 0.5, 0, 0.05, 0.15), sized("y_share", "", -0.5, 0.5, 0, 0.0, 0.1)),
        "the vertical load shows on the transducer's horizontal axes",
        adds_vector("sensors.force_cross_talk", leg_wise=True),
    ),
    EffectKind(
        "force_delay", "sensing", ALL, (sized("delay_s", "s", 0, 1, 0, 0.06, 0.15),),
        "the force unit sends what was", adds("sensors.force_delay_s"),
    ),
    EffectKind(
        "force_lowpass", "sensing", ALL, (sized("time_constant_s", "s", 0, 1, 0, 0.06, 0.15),),
        "the force unit's filter", adds("sensors.force_lag_s"),
    ),
    EffectKind(
        "pose_delay", "sensing", ALL, (sized("delay_s", "s", 0, 1, 0, 0.06, 0.15),),
        "the cameras' poses and markers", adds("sensors.pose_delay_s"),
    ),
    EffectKind(
        "pose_yaw_offset", "sensing", ALL, (sized("yaw_rad", "rad", -0.5, 0.5, 0, 0.03, 0.08),),
        "the marker frame is turned in the body", adds("sensors.pose_yaw"),
    ),
    EffectKind(
        "pose_origin_offset", "sensing", ALL,
        (sized("x_m", "m", -0.1, 0.1, 0, 0.01, 0.03), sized("y_m", "m", -0.1, 0.1, 0, 0.0, 0.01)),
        "the marker frame sits elsewhere in the body", adds_vector("sensors.pose_origin"),
    ),
    EffectKind(
        "marker_on_shank", "sensing", ALL, (sized("share", "", 0, 1, 1, 0.7, 0.3),),
        "foot markers sit on the legs, above springs, and go along with a share of what these give",
        scales("sensors.marker_share"),
    ),
    EffectKind(
        "clock_skew", "sensing", ALL, (sized("ratio", "", 1, 1.05, 1, 1.004, 1.012),),
        "the cameras' clock runs faster than the controller's, from the trial's start on",
        scales("sensors.pose_clock"),
    ),
    EffectKind(
        "encoder_scale", "sensing", LEG, (sized("ratio", "", 0.95, 1.05, 1, 1.004, 1.01),),
        "angles and speeds that a servo reports; its control loop has them right",
        scales("sensors.encoder_scale"),
    ),
    EffectKind(
        "marker_swap", "sensing", LEG, (),
        "the cameras take this foot's marker for the next leg's and the other way round",
        _marker_swap, catalogued=False,
    ),
)  # fmt: skip
