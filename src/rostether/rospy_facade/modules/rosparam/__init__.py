"""rosparam: parameters of YAML files."""

# ruff: noqa: F401
from rostether.rospy_facade.master_tools import (
    RosParamException,
    delete_param,
    get_param,
    list_params,
    load_file,
    load_str,
    upload_params,
)
from rostether.rospy_facade.parameters import set_param
