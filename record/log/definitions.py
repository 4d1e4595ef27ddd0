"""ROS 2 message definitions of everything in a log, as texts that go into the file.

Standard types are those of ROS 2's common_interfaces and geometry2 (field names and order are facts of
the format); ``bigant_msgs/msg/Tick`` is ours and holds a tick completely.
"""

from types import MappingProxyType

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
    "tf2_msgs/TFMessage": "geometry_msgs/TransformStamped[] transforms\n",
    "diagnostic_msgs/KeyValue": "string key\nstring value\n",
    "diagnostic_msgs/DiagnosticStatus": (
        "byte OK=0\nbyte WARN=1\nbyte ERROR=2\nbyte STALE=3\nbyte level\nstring name\n"
        "string message\nstring hardware_id\ndiagnostic_msgs/KeyValue[] values\n"
    ),
    "diagnostic_msgs/DiagnosticArray": (
        "std_msgs/Header header\ndiagnostic_msgs/DiagnosticStatus[] status\n"
    ),
    "bigant_msgs/Fault": "uint8 kind\nstring source\nstring detail\n",
    "bigant_msgs/ForceRecord": (
        "int64 t_ns\nint64 device_ticks\nint64 sequence\nint64[2] status\nint64 battery\nint64 mask\n"
        "int64[36] counts\nbool[6] present\nbool[6] saturated\n"
    ),
    "bigant_msgs/PoseRecord": (
        "int64 t_ns\nfloat64[3] position_w\nfloat64[4] quaternion_xyzw\nfloat64 sd_position_m\n"
        "float64 sd_angle_rad\n"
    ),
    # planar: x, y, yaw; vx, vy, yaw rate; bias of the same; roll, pitch, height; NIS, log likelihood, age
    # of forces. Covariances: lower halves, row by row.
    "bigant_msgs/Estimate": (
        "uint8 OK=0\nuint8 DEGRADED=1\nuint8 LOST=2\n"
        "int64 t_ns\nuint8 health\nstring reason\nbool holding\nint64 nis_dof\nint64 rejects\n"
        "float64[15] planar\nfloat64[6] pose_covariance\nfloat64[6] twist_covariance\n"
        "float64[] mu\nfloat64[] mu_sd\nfloat64[] stiffness\nfloat64[] stiffness_sd\n"
        "float64[] force_b\nfloat64[] force_covariance\nfloat64[] load_share\n"
        "float64[] load_share_sd\nfloat64[] innovation\nbool[] contact\nbool[] slipping\n"
    ),
    "bigant_msgs/Tick": (
        "int64 t_ns\nint64 index\nuint8 mode\nuint8 stop_reason\n"
        "uint8 request_intent\nstring request_gait\nfloat64 request_frequency_hz\n"
        "float64 request_steer\nuint8 request_reason\n"
        "int64 deadline_ns\nint64 lateness_ns\nint64 missed\nint64 busy_ns\n"
        "bool servos_attached\nint64 servos_t_ns\nint64[] position_ticks\nint64[] velocity_counts\n"
        "int64[] current_counts\nint64[] duty_counts\nint64[] voltage_counts\n"
        "int64[] servo_temperature_c\nint64[] error_byte\nint64[] hardware_error\n"
        "bool[] servo_valid\nint64[] servo_age_ns\n"
        "bigant_msgs/ForceRecord[] force_records\n"
        "bool truth_known\nint64 truth_t_ns\nfloat64[3] truth_position_w\n"
        "float64[4] truth_quaternion_xyzw\nfloat64[3] truth_velocity_b\n"
        "float64[3] truth_angular_velocity_b\nfloat64[] truth_foot_position_w\n"
        "float64[] truth_foot_velocity_w\nfloat64[] truth_foot_force_b\nbool[] truth_contact\n"
        "bigant_msgs/Fault[] input_faults\n"
        "bigant_msgs/PoseRecord[] pose_records\n"
        "int64 joints_t_ns\nfloat64[] angle_rad\nfloat64[] rate_rad_s\nfloat64[] current_a\n"
        "float64[] duty\nfloat64[] voltage_v\nfloat64[] temperature_c\nbool[] joints_valid\n"
        "int64 forces_t_ns\nfloat64[] force_n\nbool[] force_valid\n"
        "float64 gait_phase\n"
        "int64 wished_t_ns\nfloat64[] wished_angle_rad\nfloat64[] wished_rate_rad_s\n"
        "bool wished_torque\n"
        "int64 sent_t_ns\nfloat64[] sent_angle_rad\nfloat64[] sent_rate_rad_s\nbool sent_torque\n"
        "float64[] foot_position_b\nfloat64[] foot_velocity_b\n"
        "bool support_converged\nstring support_reason\nfloat64 height_m\nfloat64 slope_x\n"
        "float64 slope_y\nfloat64[] load_n\nbool[] contact\nint64 switches\n"
        "bool traction_valid\nstring traction_reason\nfloat64[3] velocity_b\nfloat64[] slip_b\n"
        "float64[] force_b\n"
        "int64 dead_reckoning_t_ns\nfloat64[2] dead_reckoning_position_m\n"
        "float64 dead_reckoning_yaw_rad\nfloat64[3] dead_reckoning_velocity_b\n"
        "bool dead_reckoning_valid\n"
        "bigant_msgs/Fault[] faults\n"
        "bigant_msgs/Estimate[] estimate\n"
    ),
}

_BUILT_IN = frozenset({"bool", "byte", "uint8", "int32", "uint32", "int64", "float64", "string"})


def _needs(name: str) -> list[str]:
    """Return the message types that a definition mentions, directly or not, once each."""
    found: list[str] = []
    for line in _PARTS[name].splitlines():
        kind = line.split()[0].split("[")[0]
        if kind in _BUILT_IN or kind in found:
            continue
        found.append(kind)
        found += [deeper for deeper in _needs(kind) if deeper not in found]
    return found


def _full_text(name: str) -> str:
    text = _PARTS[name]
    for part in _needs(name):
        text += f"{_SEPARATOR}\nMSG: {part}\n{_PARTS[part]}"
    return text


def _ros2_name(name: str) -> str:
    package, message = name.split("/")
    return f"{package}/msg/{message}"


# Name as ROS 2 writes it, to the text that a log carries.
DEFINITIONS = MappingProxyType(
    {
        _ros2_name(name): _full_text(name)
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
