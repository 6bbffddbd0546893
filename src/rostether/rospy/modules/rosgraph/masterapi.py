"""rosgraph.masterapi: the API of the master."""

from rostether.rospy.tools.master_tools import (
    Master,
    MasterError,
    MasterException,
    MasterFailure,
    get_master_uri,
)
from rostether.rospy.tools.master_tools import MasterError as Error
from rostether.rospy.tools.master_tools import MasterException as ROSMasterException
from rostether.rospy.tools.master_tools import MasterFailure as Failure
from rostether.rospy.tools.master_tools import is_master_online as is_online
