"""Uses rosgraph and rosparam in a node, and prints the results."""

import sys

import rosgraph
import rosparam
import rospy


def attempt(label, function):
    try:
        print(label, "->", function())
    except (rosgraph.MasterException, rosparam.RosParamException) as error:
        print(label, "raises", type(error).__name__)


TEXT = "a: 1\nb: {c: [1, 2.5], d: rad(pi/2)}\n---\n_ns: below\ne: text\n"
print(rosgraph.is_master_online(), rosgraph.get_master_uri().startswith("http://"))
documents = rosparam.load_str(TEXT, "file", default_namespace="/tools")
print(documents)
for values, namespace in documents:
    rosparam.upload_params(namespace, values)
rospy.init_node("tools")
print(rosparam.get_param("/tools/b"), rosparam.list_params("/tools"), rospy.get_param("/tools/below/e"))
attempt("no file", lambda: rosparam.load_file("/nowhere/file.yaml"))
attempt("global", lambda: rosparam.upload_params("/", 5))
rosparam.set_param("/tools/a", "[1, 2]")
print(rosparam.get_param("/tools/a"))
rosparam.delete_param("/tools")
attempt("delete", lambda: rosparam.delete_param("/tools"))
master = rosgraph.Master("/tools")
publishers, subscribers, services = master.getSystemState()
print(
    [name for name, nodes in publishers if "/tools" in nodes],
    [name for name, nodes in services if "/tools" in nodes],
)
print(master.getUri() != "", master.lookupNode("/tools") == rospy.get_node_uri(), master.hasParam("/nothing"))
attempt("lookup", lambda: master.lookupNode("/nobody"))
attempt("get", lambda: master.getParam("/nothing"))
sys.stdout.flush()
