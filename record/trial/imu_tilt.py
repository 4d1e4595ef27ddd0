"""Roll and pitch of an IMU that gives its orientation as a quaternion.

Columns ``imu_quaternion_x`` to ``imu_quaternion_w`` turn the IMU's axes into those of a world whose z axis
points up; a trial has its roll and pitch in their place. Its yaw is no measurement of a run's heading.
"""

from collections.abc import Iterable, Iterator

import numpy as np
from scipy.spatial.transform import Rotation

from model.errors import RecordError
from record.trial.body_pose import sound_quaternions
from record.trial.table_check import TableFinding
from record.trial.table_file import TableColumn
from record.trial.trial import IMU

IMU_QUATERNION = tuple(f"imu_quaternion_{axis}" for axis in "xyzw")


def levelled(columns: Iterable[TableColumn], findings: list[TableFinding]) -> Iterator[TableColumn]:
    """Yield columns of a trial: a quaternion of an IMU becomes its roll and pitch.

    Args:
        columns: Columns of a trial, or of ``IMU_QUATERNION``.
        findings: What is no rotation is added here.

    Raises:
        RecordError: A part of the quaternion is absent, the angles are there too, or most rows are no
            rotations.
    """
    held: dict[str, TableColumn] = {}
    angles = IMU[1:]
    seen = []
    for column in columns:
        if column.name in IMU_QUATERNION:
            held[column.name] = column
        else:
            seen += [column.name] if column.name in angles else []
            yield column
    if not held:
        return
    if seen:
        raise RecordError(f"the IMU's attitude is there twice ({seen[0]} too); map one of them")
    if missing := [name for name in IMU_QUATERNION if name not in held]:
        raise RecordError(f"the IMU's attitude lacks {', '.join(missing)}; map all of its columns")
    rows = np.column_stack([held[name].values for name in IMU_QUATERNION])
    known = sound_quaternions(rows, "imu", findings)
    if not known.any():
        return
    tilt = np.full((len(rows), 2), np.nan)
    tilt[known] = Rotation.from_quat(rows[known]).as_euler("ZYX")[:, :0:-1]
    yield from map(TableColumn, angles, tilt.T)
