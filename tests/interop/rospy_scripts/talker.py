"""Publishes for observer.py: headers, latching, types, private names, logs, a service.

It runs until it gets a signal.
"""

# Written as users write their nodes.
# ruff: noqa: SIM105

import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from sensor_msgs.msg import JointState
from std_msgs.msg import Header, Int32, String, UInt8MultiArray
from std_srvs.srv import SetBool, SetBoolResponse, Trigger

early = rospy.Publisher("early", String, queue_size=10)


def answer(request):
    if not request.data:
        raise ValueError("cannot")
    return SetBoolResponse(success=True, message=rospy.get_name())


def refuse(request):
    return None


def main():
    rospy.init_node("talker")
    latched = rospy.Publisher("~latched", DiagnosticArray, latch=True, queue_size=1)
    status = DiagnosticStatus(
        level=DiagnosticStatus.WARN, name="n", values=[KeyValue("k", "v"), KeyValue("k2", "")]
    )
    latched.publish(header=Header(frame_id="f", stamp=rospy.Time(7)), status=[status])
    states = rospy.Publisher("/joint_states", JointState, queue_size=10)
    raw = rospy.Publisher("raw", UInt8MultiArray, queue_size=None)
    rospy.Service("answer", SetBool, answer)
    rospy.Service("~refuse", Trigger, refuse)
    echoed = rospy.Publisher("echo", Int32, queue_size=10)
    rospy.Subscriber("ask", Int32, lambda message: echoed.publish(message.data + 1))
    rospy.set_param("~ready", [1, {"deep": 2.5}])
    rospy.on_shutdown(lambda: early.publish("bye"))
    state = JointState(name=["joint"], position=[0.25], header=Header(stamp=rospy.Time(1, 5)))
    rate = rospy.Rate(20)
    while not rospy.is_shutdown():
        early.publish("gr\u00fc\u00df")
        states.publish(state)
        raw.publish(data=b"\x00\xff")
        rospy.logwarn_once("tick")
        rate.sleep()


if __name__ == "__main__":
    try:
        main()
    except rospy.ROSInterruptException:
        pass
