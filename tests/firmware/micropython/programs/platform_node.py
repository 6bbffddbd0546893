"""A node that uses all kinds of endpoints, like platform_node.h of the C++ library.

Arguments: usb, tty PATH, or tcp HOST PORT.
"""

import sys

import ros
from std_msgs.msg import String, UInt32
from std_srvs.srv import SetBool, Trigger

tasks = []


def hardware():
    kind = sys.argv[1]
    if kind == "usb":
        return None
    if kind == "tcp":
        from ros.tcp import Tcp

        return Tcp(sys.argv[2], int(sys.argv[3]))
    from ros.uart import Uart
    from tty_uart import TtyUart

    return Uart(TtyUart(sys.argv[2]))


def on_question(question):
    if question.data in ("parameter", "service"):
        tasks.append(question.data)
    else:
        answers.publish(question)


def on_switch(request, response):
    response.success = request.data
    response.message = "on" if request.data else "off"


def do_task(task):
    if task == "parameter":
        text = nh.getParam("greeting")
    else:
        response = trigger.call(Trigger.Request())
        text = response and response.message
    answers.publish(String(text or "failed"))


nh = ros.NodeHandle(hardware())
counter = ros.Publisher("count", UInt32)
answers = ros.Publisher("answer", String)
trigger = ros.ServiceClient("trigger", Trigger)
nh.initNode()
nh.advertise(counter)
nh.advertise(answers)
nh.subscribe(ros.Subscriber("question", String, on_question))
nh.advertiseService(ros.ServiceServer("switch", SetBool, on_switch))
nh.serviceClient(trigger)

count = UInt32()
was_connected = False
counted_ms = ros.ticks.ticks_ms()
while True:
    if nh.connected() and not was_connected:
        nh.loginfo("here I am")
    was_connected = nh.connected()
    nh.spinOnce()
    if tasks:
        do_task(tasks.pop())
    now_ms = ros.ticks.ticks_ms()
    if ros.ticks.ticks_diff(now_ms, counted_ms) >= 10:
        counted_ms = now_ms
        if counter.publish(count) > 0:
            count.data += 1
    ros.ticks.sleep_ms(1)
