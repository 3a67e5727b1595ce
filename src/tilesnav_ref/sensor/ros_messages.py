"""Definitions of the messages of ROS 2 that a recording holds, as it must carry them itself.

References
----------
ROS 2 common_interfaces, geometry2 and rcl_interfaces: packages std_msgs, sensor_msgs, geometry_msgs,
tf2_msgs and builtin_interfaces.
"""

from __future__ import annotations

DIVIDER = "=" * 80
"""Line before each definition that another one uses."""

TIME = ("builtin_interfaces/Time", "int32 sec\nuint32 nanosec")
HEADER = ("std_msgs/Header", "builtin_interfaces/Time stamp\nstring frame_id")
POINT = ("geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z")
VECTOR = ("geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z")
QUATERNION = ("geometry_msgs/Quaternion", "float64 x\nfloat64 y\nfloat64 z\nfloat64 w")
POSE = ("geometry_msgs/Pose", "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation")
TRANSFORM = (
    "geometry_msgs/Transform",
    "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation",
)
TRANSFORM_STAMPED = (
    "geometry_msgs/TransformStamped",
    "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform",
)
POINT_FIELD = (
    "sensor_msgs/PointField",
    "uint8 INT8=1\nuint8 UINT8=2\nuint8 INT16=3\nuint8 UINT16=4\nuint8 INT32=5\nuint8 UINT32=6\n"
    "uint8 FLOAT32=7\nuint8 FLOAT64=8\nstring name\nuint32 offset\nuint8 datatype\nuint32 count",
)


def _definition(fields: str, *used: tuple[str, str]) -> str:
    return "\n".join((fields, *(f"{DIVIDER}\nMSG: {name}\n{text}" for name, text in used))) + "\n"


POINT_CLOUD = _definition(
    "std_msgs/Header header\nuint32 height\nuint32 width\nsensor_msgs/PointField[] fields\n"
    "bool is_bigendian\nuint32 point_step\nuint32 row_step\nuint8[] data\nbool is_dense",
    HEADER,
    TIME,
    POINT_FIELD,
)
"""Definition of sensor_msgs/msg/PointCloud2."""
POSE_STAMPED = _definition(
    "std_msgs/Header header\ngeometry_msgs/Pose pose", HEADER, TIME, POSE, POINT, QUATERNION
)
"""Definition of geometry_msgs/msg/PoseStamped."""
TF_MESSAGE = _definition(
    "geometry_msgs/TransformStamped[] transforms",
    TRANSFORM_STAMPED,
    HEADER,
    TIME,
    TRANSFORM,
    VECTOR,
    QUATERNION,
)
"""Definition of tf2_msgs/msg/TFMessage."""
