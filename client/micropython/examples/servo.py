# Servo: turns a hobby servo to the angle, in degrees from 0 to 180, that it receives on the topic "servo".
#
# Wiring:  servo red - VBUS (5V; a separate supply for more than one small servo), brown - GND, orange - GP15.
# Try it:  rostether serve /dev/ttyACM0          rostether topic pub -1 /servo std_msgs/UInt16 45

import time

import ros
from machine import PWM, Pin
from std_msgs.msg import UInt16

PULSE_AT_0_NS = 544_000
PULSE_AT_180_NS = 2_400_000

servo = PWM(Pin(15))
servo.freq(50)


def turn(angle):
    degrees = min(angle.data, 180)
    servo.duty_ns(PULSE_AT_0_NS + (PULSE_AT_180_NS - PULSE_AT_0_NS) * degrees // 180)


nh = ros.NodeHandle()
nh.initNode()
nh.subscribe(ros.Subscriber("servo", UInt16, turn))

while True:
    nh.spinOnce()
    time.sleep_ms(1)
