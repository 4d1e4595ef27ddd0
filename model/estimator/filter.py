"""Odometry and foot forces online: an extended Kalman filter whose process is the model of slipping.

One step a tick, a pure function of the state before and what is known now. The design and its limits are
described in ``docs/odometry.md``; late samples are the business of ``model.estimator.history``.
"""

from dataclasses import replace
from math import isfinite, nan

import numpy as np

from model.errors import ModelError
from model.estimator import (
    force_blend,
    frame_kernel,
    gate_kernel,
    health,
    kalman,
    process,
    senses,
    shaft_zeros,
    sources,
    tolerance_kernel,
    tolerances,
    vibration,
)
from model.estimator import measurements as measure
from model.estimator import neighbourhood as around
from model.estimator import report as reports
from model.estimator import stride as strides
from model.estimator.kalman import Kalman, MeasurementStack, Updated, mended, sound
from model.estimator.measurements import TURN
from model.estimator.neighbourhood import Neighbourhood, neighbourhood, no_answer, with_effects
from model.estimator.process import ProcessStep
from model.estimator.report import Answered, Believed, Observed, estimate, report
from model.estimator.settings import EstimatorSettings, record_of
from model.estimator.sources import ABSOLUTE
from model.estimator.stride import Moment, stride
from model.quasistatic import frame
from model.values.arrays import FloatArray, readonly
from model.values.estimate import (
    BIAS,
    FIXED,
    GYRO_BIAS,
    NEVER,
    POSE,
    SCALE,
    SOURCES,
    TILT_BIAS,
    VELOCITY,
    YAW,
    Estimate,
    EstimatorState,
    OdometryInputs,
)
from model.values.legs import FootMotion
from model.values.parameters import ContactParameters

START_SD = 1e-4  # of pose [m, rad] and velocity [m/s, rad/s] at the beginning
HEIGHT = 5  # in a row of ``Neighbourhood``
NO_SHAKE = readonly(np.zeros(3))
SENSOR_BIASES = np.array([GYRO_BIAS, *range(TILT_BIAS.start, TILT_BIAS.stop)])


class Estimator:
    """The filter and what it knows beforehand.

    Args:
        contact: Leg springs and friction of the robot file: where the parameters start.
        weight_n: Weight carried [N].
        settings: Noise and limits.
        names: What legs are called in reasons and remarks; by their number if empty.

    Attributes:
        settings: The same, as are the next two.
        contact: The same.
        weight_n: The same.
        legs: N.
        names: Of the legs.
        size: Number of states n.
        kalman: Predicts and corrects.
        record: The settings as compiled code takes them.
        sensor_walk: How an IMU's biases walk: variance a second, (3,).

    Raises:
        ModelError: Fewer than two legs, or a weight that is none.
    """

    def __init__(
        self,
        contact: ContactParameters,
        weight_n: float,
        settings: EstimatorSettings | None = None,
        names: tuple[str, ...] = (),
    ) -> None:
        if len(contact.mu) < 2 or not weight_n > 0:
            raise ModelError("the estimator needs at least two legs and a weight above 0")
        self.settings = settings if settings is not None else EstimatorSettings()
        self.contact = contact
        self.weight_n = weight_n
        self.legs = len(contact.mu)
        self.names = names or tuple(f"leg {k + 1}" for k in range(self.legs))
        self.size = FIXED + 2 * self.legs
        self.kalman = Kalman(self.size, FIXED, self.settings)
        self.record = record_of(self.settings, weight_n)
        tilt_walk = self.settings.tilt_bias_walk
        self.sensor_walk = np.square([self.settings.gyro_bias_walk, tilt_walk, tilt_walk])
        for module in (
            frame,
            frame_kernel,
            tolerance_kernel,
            process,
            around,
            strides,
            senses,
            health,
            measure,
            reports,
            gate_kernel,
            kalman,
            shaft_zeros,
            vibration,
        ):
            module.prepare()

    def initial(self, pose: FloatArray | None = None) -> EstimatorState:
        """Return the state before the first tick.

        Args:
            pose: x, y [m], yaw [rad] to start from; the origin if None.
        """
        settings, legs = self.settings, self.legs
        mean = np.zeros(self.size)
        if pose is not None:
            mean[POSE] = pose
        sd = np.full(self.size, settings.parameter_sd)
        sd[POSE] = sd[VELOCITY] = START_SD
        sd[BIAS] = [settings.bias_speed_sd, settings.bias_speed_sd, settings.bias_turn_sd]
        sd[SCALE], sd[GYRO_BIAS] = settings.scale_sd, settings.gyro_bias_sd
        sd[TILT_BIAS] = settings.tilt_bias_sd
        nan = np.full((legs, 3), np.nan)
        covariance = np.diag(sd**2)
        return EstimatorState(
            t_ns=NEVER, mean=mean, covariance=covariance, feet=FootMotion(nan, nan),
            force_ns=NEVER, used_ns=NEVER, share=np.full(legs, np.nan), expected=nan,
            contact=np.zeros(legs, dtype=bool), rejected=np.zeros((len(SOURCES), legs), dtype=np.int64),
            rejects=0, idle_ns=NEVER, answer_ns=NEVER, fine_ns=NEVER, lost=False, airborne=False,
            anchored=False, far_poses=0, before=(mean, covariance),
            transition=np.eye(self.size), companions=tolerances.at_start(legs),
            sources=sources.at_start(legs), forces=force_blend.at_start(),
            balance=health.UNKNOWN, strain=readonly(np.ones(3)), vibration=vibration.AT_REST,
            zeros=shaft_zeros.at_start(legs),
        )  # fmt: skip

    def step(
        self, state: EstimatorState, inputs: OdometryInputs
    ) -> tuple[EstimatorState, Estimate]:
        """Advance to a tick and use what was measured in it.

        A tick that is not later than the one before moves nothing; the estimate says so.

        Raises:
            ModelError: Shapes do not fit.
        """
        self._check(inputs)
        settings, t_ns = self.settings, inputs.t_ns
        trouble: list[str] = []
        first = state.t_ns == NEVER
        dt_s = 0.0 if first else (t_ns - state.t_ns) * 1e-9
        if dt_s < 0:
            trouble.append(f"time went back by {-dt_s:.3g} s")
            state = replace(
                state, force_ns=NEVER, used_ns=NEVER, idle_ns=NEVER, answer_ns=NEVER, fine_ns=NEVER
            )  # they are times of a clock that is no more
        elif dt_s == 0 and not first:
            trouble.append("a tick came twice")
        feet, dead, dead_legs, finite, _ = seen = senses.see(
            inputs.feet, state.feet, settings.idle_speed
        )
        if dead_legs:
            trouble.append(f"no encoder reading from {dead_legs} of {self.legs} legs")
        heard, airborne = senses.hear(state, inputs, self.weight_n, settings)
        idle_ns = senses.idle_since(state, t_ns, seen, heard)
        held = idle_ns != NEVER and (t_ns - idle_ns) * 1e-9 >= settings.idle_time_s
        held = held and not airborne
        model, companions, apart, step = None, state.companions, None, None
        if finite and not (held or airborne) and 0 < dt_s <= settings.longest_gap_s:
            moment = Moment(dt_s, dead_legs, self.sensor_walk)
            strode = stride(state, feet, self.contact, self.record, inputs.added, moment)
            if strode is not None:
                model, companions, apart, step = strode
        elif finite:
            model = neighbourhood(state.mean, feet, self.contact, self.record)
            model = with_effects(model, inputs.added)
        serving = None if airborne else model
        if step is None:
            step = self._without_stride(state, serving, dt_s, trouble)
        if airborne:
            trouble.append("picked up: the feet carry nothing")
        covariance = self.kalman.predict(state.covariance, step.transition, step.noise)
        if held:
            _close_books(covariance)
        if _has_place(inputs):  # what lies between the companions is then corrected as all the rest
            covariance[POSE, POSE] += companions.pose_covariance
            companions = companions.gathered()
        loaded, share = senses.expect(state, model, heard, self.record, airborne=airborne)
        # the model was solved at the parameters that the prediction leaves as they are
        answer = None if held else serving
        # no one knows what a robot in the hand would do, nor expects anything of one that stands
        solved = serving if serving is not None else no_answer(self.legs)
        moved_by_hand = airborne or dt_s < 0 or dt_s > settings.longest_gap_s
        anchored = state.anchored and not moved_by_hand
        far = anchored and self._pose_is_far(inputs, step.mean, covariance)
        if far:
            inputs = replace(inputs, pose_W=None)
        turning = isfinite(inputs.yaw_rate_rad_s)
        turn = nan
        if turning:
            turn = inputs.yaw_rate_rad_s - float(step.mean[TURN]) - float(step.mean[GYRO_BIAS])
        shaking = vibration.learn(state, inputs, feet, heard, turn, settings)
        shake = NO_SHAKE
        if answer is not None:
            shake = vibration.variance(shaking, answer, feet, self.record)
        measured = self._others(step.mean, inputs, answer, shake)
        if answer is not None and heard.use:
            doubt = measure.doubt_of(share, state.expected, dt_s, apart, self.record)
            forces = measure.feet_stack(
                measure.Belief(step.mean, covariance, doubt), heard.share, feet,
                loaded & ~dead if dead_legs else loaded, answer, self.contact.mu, self.record,
            )  # fmt: skip
            measured.insert(0, forces)
        used = self._correct(step.mean, covariance, measured, state, t_ns)
        mean, believed = used.mean, used.covariance
        if not (sound(believed) and isfinite(sum(mean.tolist()))):
            trouble.append("the covariance had to be repaired")
            mean = np.where(np.isfinite(mean), mean, state.mean)
            believed = mended(np.where(np.isfinite(believed), believed, state.covariance))
        refused = int(used.streak[ABSOLUTE, 0])
        pose_used = _has_place(inputs) and not refused
        far_poses = state.far_poses + 1 if far else state.far_poses
        if pose_used or not anchored:
            far_poses = 0
        if far_poses:
            trouble.append(
                f"absolute poses too far from the estimate (pose_limit): {far_poses} in a row not used"
            )
        elif refused:
            trouble.append(f"absolute poses contradict the estimate: {refused} in a row rejected")
        readout = report(
            state, Believed(mean, believed, loaded, float(step.mean[YAW])),
            Observed(feet, heard, share), Answered(
                model if model is not None else no_answer(self.legs), companions.pose_covariance, shake
            ),
            self.contact, self.record, airborne=airborne,
        )  # fmt: skip
        force_ns = inputs.forces.t_ns if heard.fresh and inputs.forces else state.force_ns
        answered = serving is not None or state.answer_ns == NEVER
        answer_ns = t_ns if answered else state.answer_ns
        trouble += health.contradictions(used.sources, self.names)
        verdict = health.judge(state, inputs, force_ns, answer_ns, settings, trouble, self.names)
        learned = settings.adaptive and used.sources is not state.sources
        after = EstimatorState(
            t_ns=t_ns, mean=mean, covariance=believed, feet=feet, force_ns=force_ns,
            used_ns=t_ns if heard.use else state.used_ns,
            share=heard.share[:, 2].copy() if heard.fresh else state.share,
            expected=no_answer(self.legs).force_n if held else share,
            contact=loaded, rejected=used.streak, rejects=state.rejects + used.rejects + far,
            idle_ns=idle_ns, answer_ns=answer_ns, fine_ns=verdict.fine_ns, lost=verdict.lost,
            airborne=airborne,
            anchored=(anchored or pose_used) and not (airborne or verdict.lost),
            far_poses=far_poses, before=(step.mean, covariance), transition=step.transition,
            companions=companions, sources=used.sources, forces=readout.forces,
            balance=readout.balance,
            strain=health.strain(used.sources) if learned else state.strain,
            vibration=shaking,
            zeros=shaft_zeros.learn(
                state.zeros, heard, share, apart, inputs.feet.velocity_m_s, inputs.shaft_rad_s,
                settings.height_sd * float(solved.rows[0, HEIGHT]),
            ),
            gyro_ns=t_ns if turning else state.gyro_ns,
        )  # fmt: skip
        height_m = float(model.rows[0, HEIGHT]) if model is not None else nan
        return after, estimate(after, readout, height_m, held, used, verdict)

    def _without_stride(
        self,
        state: EstimatorState,
        model: Neighbourhood | None,
        dt_s: float,
        trouble: list[str],
    ) -> ProcessStep:
        """The step of the process where the robot does not walk, and how an IMU's biases walk in it.

        Args:
            state: Before it.
            model: The model's answer; None without one.
            dt_s: Length of the step [s].
            trouble: What happens in it is added.
        """
        settings, mean = self.settings, state.mean
        if dt_s == 0:
            step = process.nothing(mean)
        elif dt_s < 0 or dt_s > settings.longest_gap_s:
            if dt_s > 0:
                trouble.append(f"a gap of {dt_s:.2g} s")
            step = process.after_gap(mean, settings, max(dt_s, settings.longest_gap_s))
        elif model is None:
            trouble.append("the feet do not carry the robot")
            step = process.carried(mean, settings, dt_s)
        else:
            step = process.standing(mean, settings)
        step.noise[SENSOR_BIASES, SENSOR_BIASES] += self.sensor_walk * abs(dt_s)
        return step

    def _correct(
        self,
        mean: FloatArray,
        covariance: FloatArray,
        measured: list[MeasurementStack],
        state: EstimatorState,
        t_ns: int,
    ) -> Updated:
        """Use what passes its gate."""
        if not measured:
            return self.kalman.update(mean, covariance, None, state.rejected, state.sources, t_ns)
        if state.rejected[ABSOLUTE, 0] >= self.settings.reject_limit:
            for part in measured:
                if part.blocks[0, 1] == ABSOLUTE:
                    # it keeps saying that we are elsewhere: then that is how little we know
                    elsewhere = part.innovation[:, None] ** 2 * part.rows
                    covariance = covariance + part.rows.T @ elsewhere
        return self.kalman.update(
            mean, covariance, measure.stacked(measured), state.rejected, state.sources, t_ns
        )

    def _pose_is_far(
        self, inputs: OdometryInputs, mean: FloatArray, covariance: FloatArray
    ) -> bool:
        pose = measure.pose_stack(mean, inputs, self.settings)
        return pose is not None and measure.too_far(pose, covariance, self.settings)

    def _check(self, inputs: OdometryInputs) -> None:
        shape = (self.legs, 3)
        feet = inputs.feet
        if feet.position_m.shape != shape or feet.velocity_m_s.shape != shape:
            raise ModelError(f"feet must be {shape}, not {feet.position_m.shape}")
        if inputs.forces is not None and inputs.forces.force_n.shape != shape:
            raise ModelError(f"forces must be {shape}, not {inputs.forces.force_n.shape}")

    def _others(
        self,
        mean: FloatArray,
        inputs: OdometryInputs,
        model: Neighbourhood | None,
        shake: FloatArray,
    ) -> list[MeasurementStack]:
        """What was measured beside the forces on the feet."""
        settings = self.settings
        stacks: list[MeasurementStack] = []
        tilt = (inputs.roll_rad, inputs.pitch_rad)
        if model is not None and (isfinite(tilt[0]) or isfinite(tilt[1])):
            stacks += measure.tilt_stacks(mean, tilt, model, settings)
        if isfinite(inputs.yaw_rate_rad_s):
            stacks.append(
                measure.gyro_stack(mean, inputs.yaw_rate_rad_s, float(shake[2]), settings)
            )
        pose = measure.pose_stack(mean, inputs, settings)
        if pose is not None:
            stacks.append(pose)
        return stacks


def _close_books(covariance: FloatArray) -> None:
    """Forget how errors of the pose and of all else go together, in place.

    What is learned of a leg from now on no longer says where the robot went before it stood still. So a
    displacement has a covariance of its own.
    """
    covariance[POSE, POSE.stop :] = 0.0
    covariance[POSE.stop :, POSE] = 0.0


def _has_place(inputs: OdometryInputs) -> bool:
    return inputs.pose_W is not None and bool(np.isfinite(inputs.pose_W[:2]).all())
