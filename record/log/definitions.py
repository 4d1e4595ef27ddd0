"""ROS 2 message definitions of everything in a log, as texts that go into the file.

Standard types are those of ROS 2's common_interfaces and geometry2 (field names and order are facts of
the format); ``bigant_msgs/msg/Tick`` is ours and holds a tick completely.
"""

from types import MappingProxyType

from record.log.tick_message import TICK_DEFINITIONS

_SEPARATOR = "=" * 80

_TIME = "int32 sec\nuint32 nanosec\n"
_HEADER = "builtin_interfaces/Time stamp\nstring frame_id\n"
_VECTOR3 = "float64 x\nfloat64 y\nfloat64 z\n"
_QUATERNION = "float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n"

_PARTS = {
    "builtin_interfaces/Time": _TIME,
    "std_msgs/Header": _HEADER,
    "geometry_msgs/Vector3": _VECTOR3,
    "geometry_msgs/Point": _VECTOR3,
    "geometry_msgs/Quaternion": _QUATERNION,
    "geometry_msgs/Wrench": "geometry_msgs/Vector3 force\ngeometry_msgs/Vector3 torque\n",
    "geometry_msgs/WrenchStamped": "std_msgs/Header header\ngeometry_msgs/Wrench wrench\n",
    "geometry_msgs/Pose": "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n",
    "geometry_msgs/PoseWithCovariance": "geometry_msgs/Pose pose\nfloat64[36] covariance\n",
    "geometry_msgs/Twist": "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n",
    "geometry_msgs/TwistWithCovariance": "geometry_msgs/Twist twist\nfloat64[36] covariance\n",
    "geometry_msgs/Transform": (
        "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n"
    ),
    "geometry_msgs/TransformStamped": (
        "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n"
    ),
    "sensor_msgs/JointState": (
        "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\n"
        "float64[] effort\n"
    ),
    "nav_msgs/Odometry": (
        "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/PoseWithCovariance pose\n"
        "geometry_msgs/TwistWithCovariance twist\n"
    ),
    "sensor_msgs/Imu": (
        "std_msgs/Header header\ngeometry_msgs/Quaternion orientation\n"
        "float64[9] orientation_covariance\ngeometry_msgs/Vector3 angular_velocity\n"
        "float64[9] angular_velocity_covariance\ngeometry_msgs/Vector3 linear_acceleration\n"
        "float64[9] linear_acceleration_covariance\n"
    ),
    "tf2_msgs/TFMessage": "geometry_msgs/TransformStamped[] transforms\n",
    "diagnostic_msgs/KeyValue": "string key\nstring value\n",
    "diagnostic_msgs/DiagnosticStatus": (
        "byte OK=0\nbyte WARN=1\nbyte ERROR=2\nbyte STALE=3\nbyte level\nstring name\n"
        "string message\nstring hardware_id\ndiagnostic_msgs/KeyValue[] values\n"
    ),
    "diagnostic_msgs/DiagnosticArray": (
        "std_msgs/Header header\ndiagnostic_msgs/DiagnosticStatus[] status\n"
    ),
    **TICK_DEFINITIONS,
}

_BUILT_IN = frozenset({"bool", "byte", "uint8", "int32", "uint32", "int64", "float64", "string"})


def _needs(name: str) -> list[str]:
    """Return the message types that a definition mentions, directly or not, once each."""
    names: list[str] = []
    for line in _PARTS[name].splitlines():
        kind = line.split()[0].split("[")[0]
        if kind in _BUILT_IN or kind in names:
            continue
        names.append(kind)
        names += [deeper for deeper in _needs(kind) if deeper not in names]
    return names


def _full_text(name: str) -> str:
    parts = (f"{_SEPARATOR}\nMSG: {part}\n{_PARTS[part]}" for part in _needs(name))
    return _PARTS[name] + "".join(parts)


# Name as ROS 2 writes it, to the text that a log carries.
DEFINITIONS = MappingProxyType(
    {
        name.replace("/", "/msg/"): _full_text(name)
        for name in (
            "bigant_msgs/Tick",
            "sensor_msgs/JointState",
            "geometry_msgs/WrenchStamped",
            "nav_msgs/Odometry",
            "tf2_msgs/TFMessage",
            "diagnostic_msgs/DiagnosticArray",
        )
    }
)
# Of a topic that only a log with an IMU has.
IMU_TYPE = "sensor_msgs/msg/Imu"
IMU_DEFINITION = _full_text("sensor_msgs/Imu")
