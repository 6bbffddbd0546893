"""A sensor node like those of the original platform, under Debian's rospy; prints the topic that it gets.

Debian's genmsg and genpy generate the service's classes from its original definition.
"""

import sys
import types

import genpy.dynamic
import rospy
from genmsg.gentools import compute_md5
from genmsg.msg_loader import MsgContext, load_srv_from_string
from std_msgs.msg import Float64

DEFINITION = """
string CAMERA=CAMERA
string ANALOG=ANALOG
string DIGITAL=DIGITAL


string platform_name
string sensor_type

---
string topic
"""

spec = load_srv_from_string(MsgContext.create_default(), DEFINITION, "sensors/RegistrationService")
message_classes = [
    genpy.dynamic.generate_dynamic(f"sensors/RegistrationService{part}", text)[
        f"sensors/RegistrationService{part}"
    ]
    for part, text in zip(("Request", "Response"), DEFINITION.split("---\n"), strict=True)
]
service = types.SimpleNamespace(
    _type="sensors/RegistrationService",
    _md5sum=compute_md5(MsgContext.create_default(), spec),
    _request_class=message_classes[0],
    _response_class=message_classes[1],
)

rospy.init_node("digital_tester")
rospy.wait_for_service("sensors_register")
proxy = rospy.ServiceProxy("sensors_register", service)
topic = proxy(sys.argv[1], "DIGITAL").topic
print("registered for", topic)
publisher = rospy.Publisher(topic, Float64, queue_size=1)
while not rospy.is_shutdown():
    publisher.publish(42.0)
    rospy.sleep(0.1)
