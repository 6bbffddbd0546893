"""rospkg: the folders and contents of packages."""

from rostether.rospy.import_hook import import_submodules as _import_submodules
from rostether.rospy.tools.ros_packages import (
    Depend,
    InvalidManifest,
    Manifest,
    ResourceNotFound,
    RosPack,
    get_log_dir,
    get_package_name,
    get_ros_home,
    get_ros_package_path,
    get_ros_paths,
    get_ros_root,
    get_test_results_dir,
)

_import_submodules(__name__)
