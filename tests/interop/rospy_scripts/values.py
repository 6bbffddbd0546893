"""Uses messages, times and names without a graph, and prints the results."""

# Written as users write their nodes.
# ruff: noqa: BLE001, F403, F405

import io
import pickle
import sys

import genpy
import rospy
from geometry_msgs.msg import Point, PoseStamped, TransformStamped
from rospy.exceptions import ROSException
from sensor_msgs.msg import Image, Imu, JointState, NavSatFix
from std_msgs.msg import *
from std_srvs.srv import SetBool, SetBoolRequest, SetBoolResponse


def attempt(label, function):
    try:
        print(label, "->", function())
    except Exception as error:
        print(label, "raises", type(error).__name__)


def round_trip(message):
    buffer = io.BytesIO()
    message.serialize(buffer)
    print(type(message).__name__, buffer.getvalue().hex())
    again = type(message)().deserialize(buffer.getvalue())
    print(again == message)
    print(again)
    return again


for time_class in (rospy.Time, genpy.Time, rospy.Duration, genpy.Duration):
    one, two = time_class(3, 1500000000), time_class(1.25)
    print(repr(one), str(two), one.to_sec(), one.to_nsec(), one > two, one == two, bool(time_class()))
    print(one.is_zero(), hash(one) == hash(time_class(4, 500000000)), time_class.from_sec(0.1).nsecs)
print(
    repr(rospy.Time(5) - rospy.Time(3)),
    repr(rospy.Time(5) - rospy.Duration(3)),
    rospy.Time(5) + rospy.Duration(0.5),
)
print(repr(-rospy.Duration(1, 5)), abs(rospy.Duration(-2.5)), rospy.Duration(3) * 2, rospy.Duration(3) * 0.5)
print(
    rospy.Duration(3) / 2,
    rospy.Duration(3) / rospy.Duration(2),
    rospy.Duration(3) // 2,
    rospy.Duration(7) % rospy.Duration(4),
)
print(divmod(rospy.Duration(7), rospy.Duration(4)), rospy.Duration(-0.5).secs, rospy.Duration(-0.5).nsecs)
print(sorted([rospy.Time(3), rospy.Time(1)]), rospy.Time(1) < rospy.Time(2) <= rospy.Time(2))
attempt("negative time", lambda: rospy.Time(-1))
attempt("time + time", lambda: rospy.Time(1) + rospy.Time(1))
attempt("time < duration", lambda: rospy.Time(1) < rospy.Duration(1))
attempt("float and nsecs", lambda: rospy.Time(1.5, 3))
attempt("now too early", rospy.Time.now)

round_trip(String("hallo"))
round_trip(String(data="gr\u00fc\u00df"))
round_trip(Header(7, rospy.Time(1, 2), "map"))
state = JointState(name=["a", "b"], position=[1, 2.5], header=Header(frame_id="x"))
found = round_trip(state)
print(type(found.position).__name__, type(found.name).__name__, found.position == (1.0, 2.5))
round_trip(Image(height=1, width=2, encoding="mono8", step=2, data=[1, 2]))
print(type(round_trip(Image(data=b"\x01\xff")).data).__name__)
round_trip(Imu())
print(type(Imu().orientation_covariance).__name__, len(Imu().orientation_covariance))
round_trip(UInt8MultiArray(data=b"abc"))
round_trip(Float32MultiArray(data=[0.5, 1.5]))
round_trip(Bool(True))
round_trip(Time(rospy.Time(4, 5)))
round_trip(Duration(rospy.Duration(-4, 5)))
round_trip(ColorRGBA(1, 2, 3, 4))
pose = PoseStamped()
pose.pose.position = Point(1, 2, 3)
pose.pose.orientation.w = 1
pose.header.stamp.secs = 9
round_trip(pose)
print(PoseStamped().header.stamp, PoseStamped().pose.position.x)
print(pickle.loads(pickle.dumps(pose)) == pose)
print(
    String._type,
    String._md5sum,
    String._slot_types,
    String.__slots__,
    JointState._has_header,
    String._has_header,
)
print(
    JointState._slot_types, TransformStamped._md5sum, NavSatFix.COVARIANCE_TYPE_KNOWN, JointState().header.seq
)
print(
    SetBool._type,
    SetBool._md5sum,
    SetBool._request_class is SetBoolRequest,
    SetBoolResponse(True, "x").message,
)
print(SetBoolRequest(data=True), SetBoolRequest._type, SetBoolRequest._md5sum)
print(rospy.Header is Header, issubclass(String, rospy.Message), issubclass(String, genpy.Message))
attempt("too many", lambda: String(1, 2))
attempt("unknown field", lambda: String(dat="x"))
attempt("both", lambda: Point(1, y=2))
attempt("unknown attribute", lambda: setattr(String(), "foo", 1))
for wrong in (
    String(5),
    Int16(70000),
    Int16(1.5),
    UInt8(-1),
    JointState(position="ab"),
    JointState(name=[1]),
):
    attempt("serialize " + type(wrong).__name__, lambda wrong=wrong: wrong.serialize(io.BytesIO()))
attempt("short", lambda: Int32().deserialize(b"ab"))
attempt("publish too early", lambda: rospy.Publisher("x", String, queue_size=1).publish("a"))
attempt("private too early", lambda: rospy.Publisher("~x", String, queue_size=1))
attempt("no class", lambda: rospy.Publisher("x", "String", queue_size=1))
attempt("no name", lambda: rospy.Subscriber("", String))
attempt("no queue", lambda: rospy.Subscriber("y", String, queue_size=0))
attempt("spin too early", rospy.spin)
attempt("namespace in name", lambda: rospy.init_node("a/b"))
attempt("empty name", lambda: rospy.init_node(""))
print(rospy.myargv(["x", "a:=b", "_c:=1", "__name:=d", "e", "f=g"]), rospy.get_name(), rospy.get_namespace())
print(rospy.resolve_name("a"), rospy.resolve_name("/a/"), rospy.resolve_name("~a"), rospy.is_shutdown())
print(
    issubclass(rospy.ROSInterruptException, KeyboardInterrupt),
    issubclass(rospy.ROSInitException, ROSException),
)
print(rospy.DEBUG, rospy.INFO, rospy.WARN, rospy.ERROR, rospy.FATAL, rospy.AnyMsg._type, rospy.AnyMsg._md5sum)
attempt("time too early", rospy.Time.now)
rospy.rostime.set_rostime_initialized(True)
print(rospy.rostime.is_rostime_initialized(), rospy.Time.now().secs > 1_600_000_000)
with_header, framed = PoseStamped(), io.BytesIO()
rospy.msg.serialize_message(framed, 7, with_header)
rospy.msg.serialize_message(framed, 8, String("after"))
print(framed.getvalue().hex(), with_header.header.seq)
print(rospy.get_ros_root(env={"ROS_ROOT": "/opt"}), rospy.core.get_ros_root(env={}))
attempt("no root", lambda: rospy.get_ros_root(required=True, env={}))
print(rospy.msproxy.MasterProxy is rospy.MasterProxy, rospy.core.ROSInitException is rospy.ROSInitException)
sys.stdout.flush()
