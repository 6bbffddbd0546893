"""rospkg.environment."""

# ruff: noqa: F401
from rostether.rospy.tools.ros_packages import (
    get_log_dir,
    get_ros_home,
    get_ros_package_path,
    get_ros_paths,
    get_ros_root,
    get_test_results_dir,
)
