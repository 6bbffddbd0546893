# Blink: the LED changes each time a message arrives on the topic "toggle_led".
#
# Wiring:  none, the LED is on the Pico.
# Try it:  rostether serve /dev/ttyACM0          rostether topic pub -1 /toggle_led std_msgs/Empty

import time

import ros
from machine import Pin
from std_msgs.msg import Empty

led = Pin("LED", Pin.OUT)


def toggle(_message):
    led.value(1 - led.value())


nh = ros.NodeHandle()
nh.initNode()
nh.subscribe(ros.Subscriber("toggle_led", Empty, toggle))

while True:
    nh.spinOnce()  # calls toggle() for each received message
    time.sleep_ms(1)
