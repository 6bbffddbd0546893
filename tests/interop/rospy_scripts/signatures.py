"""Prints the names and arguments of the public functions, classes and methods of rospy and its libraries."""

import importlib
import inspect
import json

MODULES = (
    *("rospy", "rospy.names", "rospy.rostime", "rospy.timer", "rospy.topics", "rospy.numpy_msg"),
    *("genpy", "genpy.message", "actionlib", "tf", "tf2_ros", "rosbag", "message_filters"),
    *("rosgraph", "rosgraph.names", "roslib", "roslib.message", "roslib.packages", "rosmsg", "rosnode"),
    *("rosparam", "rospkg", "rosservice", "rostopic", "sensor_msgs.point_cloud2"),
)


def arguments(function: object) -> "list[str] | None":
    """Return the names of a function's arguments, with `=` if they have a default; None if unknown."""
    try:
        parameters = inspect.signature(function).parameters.values()
    except (TypeError, ValueError):
        return None
    return [each.name + ("" if each.default is each.empty else "=") for each in parameters]


found = {}
for module_name in MODULES:
    module = importlib.import_module(module_name)
    for name, value in vars(module).items():
        if name.startswith("_") or not callable(value):
            continue
        found[f"{module_name}.{name}"] = arguments(value)
        for method in dir(value) if inspect.isclass(value) else ():
            static = inspect.getattr_static(value, method)
            if isinstance(static, property):
                found[f"{module_name}.{name}.{method}"] = ["property"]
            elif callable(getattr(value, method, None)) and not method.startswith("_"):
                found[f"{module_name}.{name}.{method}"] = arguments(getattr(value, method))
print(json.dumps(found))
