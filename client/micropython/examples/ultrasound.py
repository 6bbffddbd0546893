# Ultrasound: the distance that an HC-SR04 measures, 20 times a second on the topic "ultrasound".
#
# Wiring:  sensor VCC - VBUS (5V), GND - GND, Trig - GP3, Echo - GP2 through 1 kOhm, GP2 - GND through 2 kOhm.
# Try it:  rostether serve /dev/ttyACM0          rostether topic echo /ultrasound

import time

import ros
from machine import Pin, time_pulse_us
from sensor_msgs.msg import Range

SPEED_OF_SOUND = 343.0e-6  # meters in a microsecond, at 20 degrees Celsius
PERIOD_MS = 50  # below 25 ms, the last echo would disturb the next one
LONGEST_ECHO_US = 25000  # there and back over 4 m

trigger = Pin(3, Pin.OUT)
echo = Pin(2, Pin.IN)

nh = ros.NodeHandle()
ultrasound = ros.Publisher("ultrasound", Range)
message = Range(
    radiation_type=Range.ULTRASOUND,
    field_of_view=0.26,  # radians: 15 degrees
    min_range=0.02,  # meters
    max_range=4.0,
)
message.header.frame_id = "ultrasound"


def measure():
    """Return the distance in meters; infinity if there is no echo."""
    trigger.value(1)  # a pulse of 10 us starts a measurement
    time.sleep_us(10)
    trigger.value(0)
    echo_us = time_pulse_us(echo, 1, LONGEST_ECHO_US)
    return echo_us * SPEED_OF_SOUND / 2 if echo_us >= 0 else float("inf")


nh.initNode()
nh.advertise(ultrasound)

due_ms = time.ticks_ms()
while True:
    nh.spinOnce()
    if time.ticks_diff(time.ticks_ms(), due_ms) >= 0:
        due_ms = time.ticks_add(time.ticks_ms(), PERIOD_MS)
        message.range = measure()
        message.header.stamp = nh.now()
        ultrasound.publish(message)
