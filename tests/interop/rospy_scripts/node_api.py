"""Uses topics, services, parameters, waiting, timers and logs in one node, and prints the results.

Started with: chatter:=/talk/other _rate:=5 _name:=karl __ns:=/robot number:=renamed
"""

# Written as users write their nodes.
# ruff: noqa: A001, BLE001, E402, UP031

import logging
import sys
import threading

import rospy
import std_msgs
from rospy.numpy_msg import numpy_msg
from std_msgs.msg import Bool, Empty, Float32MultiArray, Header, Int32, String
from std_srvs.srv import SetBool, SetBoolResponse, Trigger, TriggerResponse


def print(*values):
    # In one write, because other threads print rospy's debug messages.
    sys.stdout.write(" ".join(map(str, values)) + "\n")


def attempt(label, function):
    try:
        print(label, "->", function())
    except Exception as error:
        print(label, "raises", type(error).__name__, isinstance(error, rospy.ROSException))


class Collector:
    def __init__(self, count):
        self.messages = []
        self.count = count
        self.done = threading.Event()

    def store(self, message, argument=None):
        self.messages.append((message, argument))
        if len(self.messages) >= self.count:
            self.done.set()

    def wait(self):
        assert self.done.wait(60), "no messages"
        return self.messages


def wait_until(condition):
    for _ in range(500):
        if condition():
            return
        rospy.sleep(0.02)
    raise AssertionError("never")


class Listener(rospy.SubscribeListener):
    def __init__(self):
        self.seen = []

    def peer_subscribe(self, topic_name, topic_publish, peer_publish):
        self.seen.append(("subscribe", topic_name))
        peer_publish(String("only you"))

    def peer_unsubscribe(self, topic_name, num_peers):
        self.seen.append(("unsubscribe", topic_name, num_peers))


print(std_msgs.msg.Empty() == Empty())
early = rospy.Publisher("chatter", String, queue_size=10)
received_early = Collector(3)
early_subscriber = rospy.Subscriber("chatter", String, received_early.store, "argument")
print(early.name, early_subscriber.resolved_name, early.type)
rospy.init_node("api", log_level=rospy.DEBUG)
attempt("init twice", lambda: rospy.init_node("api", log_level=rospy.DEBUG))
attempt("init otherwise", lambda: rospy.init_node("other"))
print(rospy.get_name(), rospy.get_namespace(), rospy.resolve_name("chatter"), rospy.resolve_name("~x"))
print(
    rospy.resolve_name("number"),
    rospy.remap_name("number"),
    rospy.resolve_name("/number"),
    rospy.get_caller_id(),
)
print(rospy.get_node_uri().startswith("http://"), rospy.core.is_initialized())

# parameters
print(
    rospy.get_param("~rate"),
    rospy.get_param("~name"),
    rospy.get_param("~none", "default"),
    rospy.get_param("none", None),
)
attempt("no parameter", lambda: rospy.get_param("/none"))
rospy.set_param("~tree", {"a": 1, "b": {"c": [1, 2.5, "x", True]}})
print(
    rospy.get_param("~tree/b/c"),
    rospy.get_param("~tree"),
    rospy.has_param("~tree/a"),
    rospy.has_param("~tree/z"),
)
rospy.set_param("/top", "level")
print(rospy.search_param("top"), rospy.search_param("tree"), rospy.search_param("nothing"))
print(rospy.get_param_cached("/top"), rospy.get_param_cached("/nowhere", 3))
rospy.delete_param("/top")
attempt("delete twice", lambda: rospy.delete_param("/top"))
print(sorted(name for name in rospy.get_param_names() if name.startswith("/robot")))
print("/robot/api/rate" in rospy.get_master(), rospy.get_master()["~rate"])
print(rospy.get_master().search_param("top"))

# topics
wait_until(lambda: early.get_num_connections() == 1 and early_subscriber.get_num_connections() == 1)
for text in ("one", "two"):
    early.publish(text)
early.publish(data="three")
print([(message.data, argument) for message, argument in received_early.wait()])
header = received_early.messages[0][0]._connection_header
print({key: header[key] for key in ("callerid", "topic", "type", "md5sum")})
attempt("wrong type", lambda: early.publish(Int32(3)))
attempt("wrong value", lambda: early.publish(5))
attempt("too many", lambda: early.publish("a", "b"))
attempt("args and keywords", lambda: early.publish("a", data="b"))

latched = rospy.Publisher("latched", Header, latch=True, queue_size=1)
latched.publish(Header(0, rospy.Time(3), "frame"))
print(rospy.wait_for_message("latched", Header, timeout=60))
second = Collector(1)
rospy.Subscriber("/robot/latched", Header, second.store)
print(second.wait()[0][0].frame_id)
attempt("silence", lambda: rospy.wait_for_message("silence", Bool, timeout=0.3))
attempt("silence", lambda: rospy.wait_for_message("silence", Bool, timeout=rospy.Duration(0.3)))

listener = Listener()
received_alone = Collector(1)
listened = rospy.Publisher("listened", String, subscriber_listener=listener, queue_size=5)
listening = rospy.Subscriber("listened", String, received_alone.store)
print(received_alone.wait()[0][0].data)
listening.unregister()
listening.unregister()
wait_until(lambda: len(listener.seen) == 2)
print(listener.seen, listening.get_num_connections() if listening.impl else "gone")
listened.unregister()
attempt("unregistered", lambda: listened.publish("x"))

arrays = rospy.Publisher("arrays", numpy_msg(Float32MultiArray), queue_size=5)
received_array, received_any = Collector(1), Collector(1)
rospy.Subscriber("arrays", numpy_msg(Float32MultiArray), received_array.store)
wait_until(lambda: arrays.get_num_connections() == 1)
import numpy

arrays.publish(data=numpy.array([1.5, 2.5], dtype=numpy.float32))
data = received_array.wait()[0][0].data
print(type(data).__name__, data.dtype, data.tolist())

anything = rospy.Publisher("anything", Int32, queue_size=5)
rospy.Subscriber("anything", rospy.AnyMsg, received_any.store)
wait_until(lambda: anything.get_num_connections() == 1)
anything.publish(7)
raw = received_any.wait()[0][0]
print(type(raw).__name__, raw._buff, raw._connection_header["type"])
copies = rospy.Publisher("copies", rospy.AnyMsg, queue_size=5)
print(copies.type, copies.md5sum)


def broken(message):
    raise RuntimeError("callback fails")


after = Collector(1)
rospy.Subscriber("broken", Empty, broken)
rospy.Subscriber("broken", Empty, after.store)
breaking = rospy.Publisher("broken", Empty, queue_size=1)
wait_until(lambda: breaking.get_num_connections() >= 1)
rospy.sleep(0.3)
breaking.publish()
print(len(after.wait()))


# services
def switch(request):
    if not request.data:
        raise rospy.ServiceException("no off switch")
    return SetBoolResponse(True, "on")


def trigger(request):
    returned = answers.pop(0)
    if isinstance(returned, Exception):
        raise returned
    return returned


answers = [
    (True, "tuple"),
    {"success": True, "message": "dict"},
    [False, "list"],
    None,
    TriggerResponse(True, "self"),
    (1, 2, 3),
    ValueError("oops"),
    5,
]
rospy.Service("switch", SetBool, switch)
service = rospy.Service("~trigger", Trigger, trigger)
print(service.resolved_name)
attempt("twice", lambda: rospy.Service("switch", SetBool, switch))
rospy.wait_for_service("switch", 60)
rospy.wait_for_service("~trigger", rospy.Duration(60))
call = rospy.ServiceProxy("switch", SetBool)
caller = []
rospy.Service("caller", Trigger, lambda request: caller.append(request._connection_header) or (True, ""))
rospy.ServiceProxy("caller", Trigger)()
print({key: caller[0][key] for key in ("callerid", "md5sum", "service")})
print(call(True), call(data=True).message, call(call.request_class(True)).success)
attempt("refused", lambda: call(False))
attempt("wrong type", lambda: call("x"))
attempt("too many", lambda: call(True, False))
persistent = rospy.ServiceProxy("~trigger", Trigger, persistent=True)
for _ in range(8):
    attempt("trigger", lambda: (lambda response: (response.success, response.message))(persistent()))
persistent.close()
attempt("no service", rospy.ServiceProxy("nobody", Trigger))
attempt("wait for nobody", lambda: rospy.wait_for_service("nobody", 0.5))
service.shutdown()
attempt("shut down", rospy.ServiceProxy("~trigger", Trigger))
loggers = rospy.ServiceProxy("~get_loggers", __import__("roscpp.srv").srv.GetLoggers)()
print([logger.level for logger in loggers.loggers if logger.name == "rosout"])

# time
rate = rospy.Rate(50)
start = rospy.Time.now()
for _ in range(10):
    rate.sleep()
print(0.15 < (rospy.Time.now() - start).to_sec() < 60, rate.remaining().to_sec() <= 0.02, rate.sleep_dur)
ticks = Collector(3)
timer = rospy.Timer(rospy.Duration(0.05), ticks.store)
events = [event for event, _ in ticks.wait()]
timer.shutdown()
print(events[0].last_expected, (events[1].current_expected - events[0].current_expected).to_sec())
print(events[1].last_real == events[0].current_real, events[1].last_duration < 60)
once = Collector(1)
rospy.Timer(rospy.Duration(0.01), once.store, oneshot=True)
print(len(once.wait()), abs(rospy.get_time() - rospy.get_rostime().to_sec()) < 60)

# logs
received_logs = Collector(8)
rospy.Subscriber("/rosout", __import__("rosgraph_msgs.msg").msg.Log, received_logs.store, queue_size=50)
# Until the subscriber is connected, and its connections have been logged.
wait_until(lambda: rospy.logdebug("probe") or received_logs.messages)
rospy.sleep(0.3)
received_logs.messages.clear()


class Speaker:
    def speak(self):
        rospy.logwarn("from a method")


def speak():
    rospy.logdebug("debug %s", 1)
    rospy.loginfo("info %d%%", 50)
    Speaker().speak()
    rospy.logerr("error")
    rospy.logfatal("fatal")
    for turn in range(3):
        rospy.loginfo_once("once %d", turn)
        rospy.loginfo_throttle(100, "throttled %d" % turn)
        rospy.logwarn_throttle_identical(100, "identical %d" % (turn // 2))
    rospy.logdebug("last", logger_name="child")


speak()
wait_until(lambda: any(message.msg == "last" for message, _ in received_logs.messages))
received_logs.messages = [each for each in received_logs.messages if each[0].msg != "probe"]
for message, _ in received_logs.messages:
    print(message.level, message.name, repr(message.msg), message.file, message.line, message.function)
print(sorted(set(received_logs.messages[0][0].topics)))
logging.getLogger("rosout").setLevel(logging.WARNING)
rospy.loginfo("not to be seen")

rospy.on_shutdown(lambda: print("hook", rospy.is_shutdown(), rospy.core.is_shutdown_requested()))
attempt("bad hook", lambda: rospy.on_shutdown(5))
rospy.signal_shutdown("enough")
print(rospy.is_shutdown())
rospy.spin()
attempt("publish after", lambda: early.publish("x"))
sys.stdout.flush()
