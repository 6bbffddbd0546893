"""rospy.client, as some programs import it."""

# ruff: noqa: F401
from rostether.rospy.client.client import init_node, myargv, spin, wait_for_message
from rostether.rospy.client.logs import DEBUG, ERROR, FATAL, INFO, WARN, logdebug, logerr, loginfo, logwarn
from rostether.rospy.client.parameters import (
    delete_param,
    get_master,
    get_param,
    get_param_cached,
    get_param_names,
    get_published_topics,
    has_param,
    search_param,
    set_param,
)
from rostether.rospy.client.shutdown import on_shutdown
