"""The live view in Foxglove or Lichtblick: a websocket server, a file, or both (extra ``bigant[view]``).

The server binds to the loopback address by default. From another computer: ``ssh -L 8765:localhost:8765``.
"""

import contextlib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from foxglove import Channel, Context, open_mcap, start_server
from foxglove.channels import FrameTransformsChannel, LogChannel, SceneUpdateChannel
from foxglove.messages import (
    ArrowPrimitive,
    Color,
    CubePrimitive,
    FrameTransform,
    FrameTransforms,
    LinePrimitive,
    LinePrimitiveLineType,
    Log,
    LogLevel,
    Point3,
    Pose,
    Quaternion,
    SceneEntity,
    SceneUpdate,
    SpherePrimitive,
    Timestamp,
    Vector3,
)

from model.errors import ConfigError
from model.values.arrays import FloatArray
from model.values.parameters import RobotParameters
from model.values.tick import Tick
from record.whole_file import clear_name, writing
from robot.report.scene import (
    MEASURED,
    PREDICTED,
    Arrow,
    Colour,
    LegScene,
    body_of,
    legs_of,
    turn_from_x,
)
from robot.view.frames import BODY_FRAME, TRUE_FRAME
from robot.view.numbers import Numbers, known, numbers_of
from robot.view.viewer import Viewer

SCENE_TOPIC, TRAJECTORY_TOPIC, FRAMES_TOPIC, NEWS_TOPIC = "/robot", "/trajectory", "/tf", "/log"
LINK_M, FOOT_M, SHAFT_M, HEAD_M = 0.006, 0.018, 0.006, 0.014
NO_TURN = np.array([0.0, 0.0, 0.0, 1.0])
GHOST = 0.25  # opacity of the body where the truth is


class FoxgloveView(Viewer):
    """Publishes ticks.

    Args:
        parameters: Dimensions of the robot.
        save: File to write, None for none.
        serve: Address and port to listen at, None for no server.

    Raises:
        RecordError: The file cannot be written.
        ConfigError: The address cannot be used.
    """

    def __init__(
        self, parameters: RobotParameters, save: Path | None, serve: tuple[str, int] | None
    ) -> None:
        super().__init__(parameters)
        self._context = Context()
        self._scene = SceneUpdateChannel(SCENE_TOPIC, context=self._context)
        self._trajectory = SceneUpdateChannel(TRAJECTORY_TOPIC, context=self._context)
        self._transforms = FrameTransformsChannel(FRAMES_TOPIC, context=self._context)
        self._log = LogChannel(NEWS_TOPIC, context=self._context)
        self._numbers: dict[str, Channel] = {}
        self._file: Any = None
        self._server: Any = None
        if save is not None:
            clear_name(save, "--save")
            with writing(save, "--save"):
                self._file = open_mcap(save, allow_overwrite=True, context=self._context)
        if serve is not None:
            host, port = serve
            try:
                self._server = start_server(
                    name="bigant", host=host, port=port, context=self._context
                )
            except (OSError, RuntimeError, ValueError) as error:
                self.close()
                raise ConfigError(
                    "--host, --port",
                    f"{host}:{port} cannot be listened at ({error}); choose others",
                ) from error
            self.port = int(self._server.port)

    @property
    def watched(self) -> bool:
        """Whether somebody has asked for the robot: a viewer, or the file."""
        return bool(self._scene.has_sinks())

    def note(self, tick: Tick, unix_ns: int) -> None:
        """Publish what is new in a tick; see ``Viewer``."""
        for news in self.news.news_of(tick):
            level = LogLevel.Error if news.fault else LogLevel.Info
            message = Log(
                timestamp=_stamp(unix_ns), level=level, message=news.text, name=news.source
            )
            self._log.log(message, log_time=unix_ns)

    def show(self, tick: Tick, unix_ns: int) -> None:
        """Publish frames, scene and numbers of a tick."""
        stamp = _stamp(unix_ns)
        transforms = [
            FrameTransform(
                timestamp=stamp,
                parent_frame_id=transform.parent,
                child_frame_id=transform.child,
                translation=_vector(transform.translation),
                rotation=_quaternion(transform.rotation_xyzw),
            )
            for transform in self.frames.transforms(tick)
        ]
        self._transforms.log(FrameTransforms(transforms=transforms), log_time=unix_ns)
        self._scene.log(self._scene_of(tick, stamp), log_time=unix_ns)
        for topic, numbers in numbers_of(tick, self.names):
            if topic not in self._numbers:
                schema = _schema(f"bigant{topic}", numbers)
                self._numbers[topic] = Channel(topic, schema=schema, context=self._context)
            self._numbers[topic].log(_nested(known(numbers)), log_time=unix_ns)
        if self.trajectory_due(unix_ns):
            entities = [
                SceneEntity(
                    timestamp=stamp,
                    frame_id=frame,
                    id=name,
                    lines=[_line(points, colour, thickness=2.0, scale_invariant=True)],
                )
                for name, frame, points, colour in self.frames.trajectories()
            ]
            self._trajectory.log(SceneUpdate(entities=entities), log_time=unix_ns)

    def _scene_of(self, tick: Tick, stamp: Timestamp) -> SceneUpdate:
        body = body_of(self.parameters)
        bodies = [(BODY_FRAME, PREDICTED, 0.6), (TRUE_FRAME, MEASURED, GHOST)]
        entities = [
            SceneEntity(
                timestamp=stamp,
                frame_id=frame,
                id=f"body in {frame}",
                frame_locked=True,
                cubes=[
                    CubePrimitive(
                        pose=_pose(body.centre),
                        size=_vector(body.size),
                        color=_colour(colour, alpha),
                    )
                ],
            )
            for frame, colour, alpha in bodies[: 1 if tick.inputs.truth is None else 2]
        ]
        entities += [_leg(leg, stamp) for leg in legs_of(tick, self.parameters)]
        return SceneUpdate(entities=entities)

    def close(self) -> None:
        """Finish the file and stop the server."""
        if self._file is not None:
            self._file.close()
            self._file = None
        if self._server is not None:
            with contextlib.suppress(RuntimeError):
                self._server.stop()
            self._server = None


def _leg(leg: LegScene, stamp: Timestamp) -> SceneEntity:
    size = Vector3(x=FOOT_M, y=FOOT_M, z=FOOT_M)
    return SceneEntity(
        timestamp=stamp,
        frame_id=BODY_FRAME,
        id=f"leg {leg.name}",
        frame_locked=True,
        lines=[_line(strip.points, strip.colour, thickness=LINK_M) for strip in leg.links],
        spheres=[
            SpherePrimitive(pose=_pose(dot.place), size=size, color=_colour(dot.colour, 1.0))
            for dot in leg.feet
        ],
        arrows=[_arrow(arrow) for arrow in leg.forces],
    )


def _line(points: Iterable[FloatArray], colour: Colour, **look: Any) -> LinePrimitive:
    return LinePrimitive(
        type=LinePrimitiveLineType.LineStrip,
        points=[Point3(**_named("xyz", point)) for point in points],
        color=_colour(colour, 1.0),
        **look,
    )


def _arrow(arrow: Arrow) -> ArrowPrimitive:
    length = float(np.linalg.norm(arrow.vector))
    head = min(HEAD_M, length / 2)
    return ArrowPrimitive(
        pose=_pose(arrow.start, turn_from_x(arrow.vector)),
        shaft_length=length - head,
        shaft_diameter=SHAFT_M,
        head_length=head,
        head_diameter=2 * SHAFT_M,
        color=_colour(arrow.colour, 0.9),
    )


def _schema(title: str, numbers: Numbers) -> dict[str, Any]:
    """JSON schema of a message of numbers, so that a viewer can offer its fields."""
    kinds = {
        name: {"type": "string" if isinstance(value, str) else "number"}
        for name, value in numbers.items()
    }
    properties = {
        name: kind if "type" in kind else {"type": "object", "properties": kind}
        for name, kind in _nested(kinds).items()
    }
    return {"type": "object", "title": title, "properties": properties}


def _nested(values: Mapping[str, Any]) -> dict[str, Any]:
    """Dotted names to the nested message that a viewer's paths go into."""
    message: dict[str, Any] = {}
    for name, value in values.items():
        group, _, field = name.rpartition(".")
        (message.setdefault(group, {}) if group else message)[field] = value
    return message


def _stamp(unix_ns: int) -> Timestamp:
    seconds, nanoseconds = divmod(unix_ns, 10**9)
    return Timestamp(seconds, nanoseconds)


def _named(letters: str, values: FloatArray) -> dict[str, float]:
    return dict(zip(letters, values.tolist(), strict=True))


def _vector(v: FloatArray) -> Vector3:
    return Vector3(**_named("xyz", v))


def _quaternion(q: FloatArray) -> Quaternion:
    return Quaternion(**_named("xyzw", q))


def _pose(place: FloatArray, turn: FloatArray = NO_TURN) -> Pose:
    return Pose(position=_vector(place), orientation=_quaternion(turn))


def _colour(colour: Colour, alpha: float) -> Color:
    return Color(r=colour[0], g=colour[1], b=colour[2], a=alpha)
