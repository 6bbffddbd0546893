"""tf2_ros.BufferClient: gets transforms from the buffer of another node, by an action of its BufferServer."""

from __future__ import annotations

from typing import Any

from rostether.rospy.actionlib.action_client import as_duration
from rostether.rospy.actionlib.action_types import GoalStatus
from rostether.rospy.actionlib.simple_action_client import SimpleActionClient
from rostether.rospy.client.logs import logwarn
from rostether.rospy.client.message_types import all_types
from rostether.rospy.client.ros_time import Duration
from rostether.rospy.tf.buffer_interface import NO_TIME, BufferInterface
from rostether.rospy.tf.exceptions import (
    ConnectivityException,
    ExtrapolationException,
    InvalidArgumentException,
    LookupException,
    TimeoutException,
    TransformException,
)

# As in tf2_ros.
_PADDING = Duration(2)


class BufferClient(BufferInterface):
    """Looks up transforms with the server in the namespace `ns`, without receiving /tf.

    A lookup ends `timeout_padding` after its timeout if the server does not answer.
    """

    def __init__(self, ns: str, check_frequency: Any = None, timeout_padding: Any = _PADDING) -> None:
        super().__init__()
        types = all_types()
        self._goal_class: Any = types.message_class("tf2_msgs/LookupTransformGoal")
        error_class: Any = types.message_class("tf2_msgs/TF2Error")
        self._exceptions = {
            error_class.LOOKUP_ERROR: LookupException,
            error_class.CONNECTIVITY_ERROR: ConnectivityException,
            error_class.EXTRAPOLATION_ERROR: ExtrapolationException,
            error_class.INVALID_ARGUMENT_ERROR: InvalidArgumentException,
            error_class.TIMEOUT_ERROR: TimeoutException,
        }
        self._no_error = error_class.NO_ERROR
        self.timeout_padding = timeout_padding
        self.client = SimpleActionClient(ns, types.message_class("tf2_msgs/LookupTransformAction"))
        if check_frequency is not None:
            logwarn("Argument check_frequency is deprecated and should not be used.")

    def wait_for_server(self, timeout: Any = NO_TIME) -> bool:
        """Wait until the server is connected; return False at the timeout."""
        return self.client.wait_for_server(timeout)

    def lookup_transform(
        self, target_frame: str, source_frame: str, time: Any, timeout: Any = NO_TIME
    ) -> Any:
        """Return a TransformStamped. Raises TransformException, as `Buffer.lookup_transform` does."""
        return self._ask(
            timeout, target_frame=target_frame, source_frame=source_frame, source_time=time, advanced=False
        )

    def lookup_transform_full(
        self,
        target_frame: str,
        target_time: Any,
        source_frame: str,
        source_time: Any,
        fixed_frame: str,
        timeout: Any = NO_TIME,
    ) -> Any:
        """Return the pose of the source at one time in the target at another. Raises TransformException."""
        return self._ask(
            timeout,
            target_frame=target_frame,
            target_time=target_time,
            source_frame=source_frame,
            source_time=source_time,
            fixed_frame=fixed_frame,
            advanced=True,
        )

    def can_transform(self, target_frame: str, source_frame: str, time: Any, timeout: Any = NO_TIME) -> bool:
        """Return whether `lookup_transform` with these arguments succeeds."""
        try:
            self.lookup_transform(target_frame, source_frame, time, timeout)
        except TransformException:
            return False
        return True

    def can_transform_full(
        self,
        target_frame: str,
        target_time: Any,
        source_frame: str,
        source_time: Any,
        fixed_frame: str,
        timeout: Any = NO_TIME,
    ) -> bool:
        """Return whether `lookup_transform_full` with these arguments succeeds."""
        try:
            self.lookup_transform_full(
                target_frame, target_time, source_frame, source_time, fixed_frame, timeout
            )
        except TransformException:
            return False
        return True

    def _ask(self, timeout: Any, **fields: Any) -> Any:
        self.client.send_goal(self._goal_class(timeout=timeout, **fields))
        if not self.client.wait_for_result(as_duration(timeout) + as_duration(self.timeout_padding)):
            self.client.cancel_goal()
            raise TimeoutException("the BufferServer did not answer in time; is it running?")
        result = self.client.get_result()
        if self.client.get_state() != GoalStatus.SUCCEEDED or result is None:
            raise TimeoutException(
                f"the BufferServer did not look up the transform: {self.client.get_goal_status_text()}"
            )
        if result.error.error != self._no_error:
            raise self._exceptions.get(result.error.error, TransformException)(result.error.error_string)
        return result.transform
