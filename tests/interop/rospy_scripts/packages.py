"""Finds packages and definitions by name, without a graph, and prints the results."""

# Written as users write their nodes.

import sys
from pathlib import Path

import genpy.dynamic
import roslib
import roslib.names
import roslib.packages
import rospkg
import rospkg.environment
from geometry_msgs.msg import PointStamped

roslib.load_manifest("std_msgs")
pack = rospkg.RosPack()
folder = pack.get_path("std_msgs")
print(folder, "sensor_msgs" in pack.list(), roslib.packages.get_pkg_dir("std_msgs") == folder)
for find in (pack.get_path, roslib.packages.get_pkg_dir, pack.get_manifest):
    try:
        print(find("no_such_package"))
    except rospkg.ResourceNotFound as error:
        print(type(error).__name__)
    except roslib.packages.InvalidROSPkgException:
        print("ResourceNotFound")
manifest = pack.get_manifest("std_msgs")
print(manifest.version, manifest.license, manifest.licenses, manifest.type, manifest.is_catkin)
print(
    rospkg.get_package_name(folder + "/msg/String.msg"),
    rospkg.get_package_name(folder),
    rospkg.get_package_name("/"),
)
print(roslib.packages.get_dir_pkg(folder), roslib.packages.get_dir_pkg("/"))
print(
    roslib.packages.find_resource("std_msgs", "String.msg"), roslib.packages.find_node("std_msgs", "nothing")
)
home = {"ROS_HOME": "/x", "ROS_PACKAGE_PATH": "/a:/b"}
print(rospkg.get_ros_home(home), rospkg.get_log_dir(home), rospkg.get_test_results_dir(home))
print(rospkg.get_log_dir({"ROS_LOG_DIR": "/l"}), rospkg.get_ros_home({}) == str(Path.home() / ".ros"))
print(rospkg.environment.get_ros_root({}), roslib.names.ns_join("/a", "b"))
classes = genpy.dynamic.generate_dynamic("geometry_msgs/PointStamped", PointStamped._full_text)
print(sorted(classes), classes["geometry_msgs/PointStamped"]._md5sum == PointStamped._md5sum)
print(classes["geometry_msgs/PointStamped"]().point.x, genpy.struct_I.size)
sys.stdout.flush()
