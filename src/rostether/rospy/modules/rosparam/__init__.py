"""rosparam: reads and sets parameters, and copies them from and to YAML files."""

from rostether.rospy.client.parameters import get_master as get_param_server
from rostether.rospy.tools.master_tools import (
    RosParamException,
    RosParamIOException,
    delete_param,
    dump_params,
    get_param,
    list_params,
    load_file,
    load_str,
    set_param,
    set_param_raw,
    upload_params,
)
