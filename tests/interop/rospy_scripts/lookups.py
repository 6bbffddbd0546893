"""Uses the Python modules of ROS's tools, and prints the results."""

# Written as users write their nodes.
# ruff: noqa: BLE001

import sys
import tempfile
import xmlrpc.client

import genpy
import genpy.message
import rosgraph
import rosgraph.names
import rosmsg
import rosnode
import rosparam
import rospy
import rospy.names
import rosservice
import rostopic
from geometry_msgs.msg import PoseStamped
from sensor_msgs.msg import JointState
from std_msgs.msg import Header, String
from std_srvs.srv import SetBool, SetBoolResponse


def attempt(label, function):
    try:
        print(label, "->", function())
    except Exception as error:
        print(label, "raises", type(error).__name__)


names = rosgraph.names
for ns in ("", "/", "~", "/a", "/a/", "a"):
    print(ns, [rospy.names.ns_join(ns, name) for name in ("b", "/b", "~b", "b/c")])
for name in ("", "/", "a", "/a", "/a/", "/a/b", "a//b/", "//a", "~a"):
    print(name, names.namespace(name), names.canonicalize_name(name), names.is_legal_name(name))
    print([names.resolve_name(name, node) for node in ("/node", "/ns/node")], names.is_legal_base_name(name))
    print(
        bool(names.is_global(name)), bool(names.is_private(name)), names.script_resolve_name("script", name)
    )
    attempt("global", lambda name=name: names.make_global_ns(name) if name else "")
print(
    names.resolve_name("a", "/n/x", {"/n/a": "/other"}), names.make_caller_id("me"), names.get_ros_namespace()
)
print(names.load_mappings(["a:=b", "_c:=1", "__name:=d", "e"]), rosgraph.myargv(["x", "a:=b"]))
print(rospy.names.scoped_name("/foo/me", "/foo/bar/name"), rospy.names.SEP, rospy.names.TOPIC_ANYTYPE)
print(rospy.names.resolve_name_without_node_name("early"), names.anonymous_name("x-y").startswith("x_y_"))
attempt("relative", lambda: rospy.names.scoped_name("foo", "/foo/bar"))
attempt("private", lambda: names.make_global_ns("~a"))
print(rosgraph.network.parse_http_host_and_port("http://host:11311/"), rosgraph.network.get_host_name())
nowhere = "http://localhost:1"
print(rosgraph.is_master_online(), rosgraph.is_master_online(nowhere), rosgraph.Master("me").caller_id)
try:
    rosgraph.Master("/me", nowhere).getSystemState()
except OSError as error:
    print("socket error", isinstance(error, ConnectionRefusedError))

rospy.init_node("lookups")
publisher = rospy.Publisher("/look/joints", JointState, queue_size=1)
poses = rospy.Publisher("/look/poses", PoseStamped, queue_size=1, latch=True)
text_subscriber = rospy.Subscriber("/look/words", String, lambda message: None)
service = rospy.Service("/look/set", SetBool, lambda request: SetBoolResponse(request.data, "set"))

for topic in (
    "/look/joints",
    "/look/joints/name[0]",
    "/look/poses/pose/position/x",
    "/look/poses/no",
    "/none",
):
    kind, name, evaluate = rostopic.get_topic_type(topic)
    print(topic, kind, name, evaluate is not None)
message_class, name, evaluate = rostopic.get_topic_class("/look/joints/position[1:]", blocking=True)
print(message_class is JointState, name, evaluate(JointState(position=[1, 2, 3])))
print(rostopic.get_topic_class("/none"), rostopic.find_by_type("sensor_msgs/JointState"))
published, subscribed = rostopic.get_topic_list()
print([each for each in published if each[0].startswith("/look")])
print([tuple(each) for each in subscribed if each[0].startswith("/look")])
print(rostopic.msgevalgen("/pose/position/x")(PoseStamped()), rostopic.msgevalgen(""))
rate = rostopic.ROSTopicHz(-1)
print(rate.get_hz())
subscriber = rospy.Subscriber("/look/joints", rospy.AnyMsg, rate.callback_hz, callback_args="/look/joints")
bandwidth = rostopic.ROSTopicBandwidth()
second = rospy.Subscriber("/look/joints", rospy.AnyMsg, bandwidth.callback)
while len(bandwidth.sizes) < 5 or len(rate.get_times("/look/joints")) < 3:
    publisher.publish(JointState())
    rospy.sleep(0.02)
found = rate.get_hz("/look/joints")
print(found[0] > 0, found[1] <= found[2], found[4] > 3, set(bandwidth.sizes))

print("/lookups" in rosnode.get_node_names(), rosnode.get_node_names("/nowhere"))
print(rosnode.rosnode_ping("/lookups", max_count=1), rosnode.rosnode_ping("/nobody", max_count=1))
print("/lookups" in rosnode.rosnode_ping_all()[0], rosnode.kill_nodes(["/nobody"]))
print(rosnode.get_api_uri(rosgraph.Master("/x"), "/lookups") == rospy.get_node_uri())
print(rosnode.get_node_info_description("/lookups").replace("[unknown type]", "[*]"))
print(len(rosnode.get_machines_by_nodes()))
print(rosnode.get_nodes_by_machine("localhost") == rosnode.get_nodes_by_machine("127.0.0.1") != [])

print(rosservice.get_service_type("/look/set"), rosservice.get_service_type("/none"))
print(
    rosservice.get_service_class_by_name("/look/set") is SetBool,
    rosservice.rosservice_find("std_srvs/SetBool"),
)
print(rosservice.get_service_node("/look/set"), rosservice.get_service_list(namespace="/look"))
print("/look/set" in rosservice.get_service_list(), rosservice.get_service_list(node="/nobody"))
print(rosservice.get_service_args("/look/set"), rosservice.has_service_args("/look/set"))
print(rosservice.get_service_uri("/look/set").startswith("rosrpc://"), rosservice.get_service_uri("/none"))
headers = rosservice.get_service_headers("/look/set", rosservice.get_service_uri("/look/set"))
print(headers["type"], headers["md5sum"] == SetBool._md5sum)
attempt("no service", lambda: rosservice.get_service_class_by_name("/none"))

pose = PoseStamped()
genpy.message.fill_message_args(
    pose, {"header": "auto", "pose": {"position": [1, 2, 3]}}, keys={"auto": Header(frame_id="x")}
)
print(pose.header.frame_id, pose.pose.position.z, genpy.message.get_printable_message_args(pose))
state = JointState()
genpy.message.fill_message_args(state, [{"name": ["a"], "header": {"stamp": {"secs": 3, "nsecs": 4}}}])
print(state.name, state.header.stamp.nsecs)
for wrong in ([{"foo": 1}], [1], [{"header": "when"}], [{"name": 3}], [{"header": 5}], None):
    attempt("fill", lambda wrong=wrong: genpy.message.fill_message_args(JointState(), wrong))
print(
    genpy.Time(1, 2),
    genpy.Duration(3),
    issubclass(String, genpy.Message),
    rosmsg.get_msg_text("std_msgs/String"),
)
attempt("no text", lambda: rosmsg.get_msg_text("std_msgs/None"))

rospy.set_param("~bytes", xmlrpc.client.Binary(b"\x00\xff"))
print(rospy.get_param("~bytes").data, type(rospy.get_param("~")["bytes"]).__name__)
print(rosgraph.Master("/x").getParam("/lookups/bytes").data)
rosparam.set_param("/look/list", "[1, 2]")
rosparam.set_param_raw("/look/tree", {"a": 1})
rosparam.upload_params("/look/tree", {"b": {"c": 2.5}})
print(
    rospy.get_param("/look"), type(rospy.get_param("/look/list")).__name__, rosparam.list_params("/look/tree")
)
attempt("keys", lambda: rosparam.set_param_raw("/look", {1: 2}))
with tempfile.TemporaryDirectory() as folder:
    file = folder + "/dump.yaml"
    rosparam.dump_params(file, "/look")
    print(rosparam.load_file(file, default_namespace="/look"))
sys.stdout.flush()
