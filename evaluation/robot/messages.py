"""Messages of ROS 2 as DDS types of cyclonedds, by the names that they have on the wire.

The definitions are those of ROS 2 Humble to Rolling as far as they are the same; of an action's result, which is not,
nothing is read. The header of requests and replies is that of ``rmw_cyclonedds_cpp`` (``cdds_request_header_t`` in its
``serdata.hpp``): a number of the client and one of the request, before the message itself.
"""

from __future__ import annotations

from functools import cache
from typing import Any

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.interfaces.ros import quaternion_of

try:
    from cyclonedds.idl import make_idl_struct, types
except ImportError as error:
    raise InputError(
        'expected the package cyclonedds, got none; install it: pip install -c constraints.txt -e ".[robot]"'
    ) from error

#: Fields of each message; ``[]`` is a sequence, ``[16]`` an array.
DEFINITIONS = {
    "builtin_interfaces/msg/Time": "int32 sec, uint32 nanosec",
    "builtin_interfaces/msg/Duration": "int32 sec, uint32 nanosec",
    "std_msgs/msg/Header": "builtin_interfaces/msg/Time stamp, string frame_id",
    "std_msgs/msg/Bool": "bool data",
    "std_msgs/msg/String": "string data",
    "std_msgs/msg/ColorRGBA": "float32 r, float32 g, float32 b, float32 a",
    "std_msgs/msg/MultiArrayDimension": "string label, uint32 size, uint32 stride",
    "std_msgs/msg/MultiArrayLayout": "std_msgs/msg/MultiArrayDimension[] dim, uint32 data_offset",
    "std_msgs/msg/Float64MultiArray": "std_msgs/msg/MultiArrayLayout layout, float64[] data",
    "geometry_msgs/msg/Point": "float64 x, float64 y, float64 z",
    "geometry_msgs/msg/Vector3": "float64 x, float64 y, float64 z",
    "geometry_msgs/msg/Quaternion": "float64 x, float64 y, float64 z, float64 w",
    "geometry_msgs/msg/Pose": "geometry_msgs/msg/Point position, geometry_msgs/msg/Quaternion orientation",
    "geometry_msgs/msg/PoseStamped": "std_msgs/msg/Header header, geometry_msgs/msg/Pose pose",
    "geometry_msgs/msg/Transform": "geometry_msgs/msg/Vector3 translation, geometry_msgs/msg/Quaternion rotation",
    "geometry_msgs/msg/TransformStamped": "std_msgs/msg/Header header, string child_frame_id, "
    "geometry_msgs/msg/Transform transform",
    "tf2_msgs/msg/TFMessage": "geometry_msgs/msg/TransformStamped[] transforms",
    "nav_msgs/msg/MapMetaData": "builtin_interfaces/msg/Time map_load_time, float32 resolution, uint32 width, "
    "uint32 height, geometry_msgs/msg/Pose origin",
    "nav_msgs/msg/OccupancyGrid": "std_msgs/msg/Header header, nav_msgs/msg/MapMetaData info, int8[] data",
    "sensor_msgs/msg/CompressedImage": "std_msgs/msg/Header header, string format, uint8[] data",
    "visualization_msgs/msg/UVCoordinate": "float32 u, float32 v",
    "visualization_msgs/msg/MeshFile": "string filename, uint8[] data",
    "visualization_msgs/msg/Marker": "std_msgs/msg/Header header, string ns, int32 id, int32 type, int32 action, "
    "geometry_msgs/msg/Pose pose, geometry_msgs/msg/Vector3 scale, std_msgs/msg/ColorRGBA color, "
    "builtin_interfaces/msg/Duration lifetime, bool frame_locked, geometry_msgs/msg/Point[] points, "
    "std_msgs/msg/ColorRGBA[] colors, string texture_resource, sensor_msgs/msg/CompressedImage texture, "
    "visualization_msgs/msg/UVCoordinate[] uv_coordinates, string text, string mesh_resource, "
    "visualization_msgs/msg/MeshFile mesh_file, bool mesh_use_embedded_materials",
    "visualization_msgs/msg/MarkerArray": "visualization_msgs/msg/Marker[] markers",
    "unique_identifier_msgs/msg/UUID": "uint8[16] uuid",
    "action_msgs/msg/GoalInfo": "unique_identifier_msgs/msg/UUID goal_id, builtin_interfaces/msg/Time stamp",
    "action_msgs/msg/GoalStatus": "action_msgs/msg/GoalInfo goal_info, int8 status",
    "action_msgs/msg/GoalStatusArray": "action_msgs/msg/GoalStatus[] status_list",
    "action_msgs/srv/CancelGoal_Request": "uint64 guid, int64 seq, action_msgs/msg/GoalInfo goal_info",
    "action_msgs/srv/CancelGoal_Response": "uint64 guid, int64 seq, int8 return_code, "
    "action_msgs/msg/GoalInfo[] goals_canceling",
    "nav2_msgs/action/NavigateToPose_Goal": "geometry_msgs/msg/PoseStamped pose, string behavior_tree",
    "nav2_msgs/action/NavigateToPose_SendGoal_Request": "uint64 guid, int64 seq, unique_identifier_msgs/msg/UUID "
    "goal_id, nav2_msgs/action/NavigateToPose_Goal goal",
    "nav2_msgs/action/NavigateToPose_SendGoal_Response": "uint64 guid, int64 seq, bool accepted, "
    "builtin_interfaces/msg/Time stamp",
}
_PLAIN = {"bool": bool, "string": str} | {
    name: getattr(types, name) for name in ("int8", "uint8", "int32", "uint32", "int64", "uint64", "float32", "float64")
}


@cache
def type_of(kind: str) -> Any:
    """Return the DDS type of a message such as ``std_msgs/msg/Bool``."""
    package, group, name = kind.split("/")
    fields = {field: _field(word) for word, field in _fields(kind)}
    return make_idl_struct(name, f"{package}::{group}::dds_::{name}_", fields)


def new(kind: str, **given: Any) -> Any:
    """Return a message with the given fields; all others are zero, empty, or such messages."""
    return type_of(kind)(**{field: given[field] if field in given else _zero(word) for word, field in _fields(kind)})


def point(x: float, y: float) -> Any:
    """Return a ``geometry_msgs/Point`` on the ground."""
    return new("geometry_msgs/msg/Point", x=x, y=y)


def turned(yaw: float) -> Any:
    """Return the ``geometry_msgs/Quaternion`` of a rotation about z in radians."""
    return new("geometry_msgs/msg/Quaternion", **dict(zip("xyzw", quaternion_of(yaw), strict=True)))


def uuid(number: bytes) -> Any:
    """Return a ``unique_identifier_msgs/UUID`` of 16 bytes."""
    return new("unique_identifier_msgs/msg/UUID", uuid=number)


def _fields(kind: str) -> list[tuple[str, str]]:
    return [(word, field) for word, _, field in (part.partition(" ") for part in DEFINITIONS[kind].split(", "))]


def _field(word: str) -> Any:
    inner, bracket, size = word.partition("[")
    kind = _PLAIN.get(inner) or type_of(inner)
    if not bracket:
        return kind
    made: Any = types  # which mypy takes for classes without parameters
    return made.sequence[kind] if size == "]" else made.array[kind, int(size[:-1])]


def _zero(word: str) -> Any:
    inner, bracket, size = word.partition("[")
    if bracket:
        return [] if size == "]" else bytes(int(size[:-1]))
    return new(inner) if inner not in _PLAIN else {"bool": False, "string": ""}.get(inner, 0)
