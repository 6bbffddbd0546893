# Imu: the acceleration and turn rate of an MPU-6050 or MPU-9150, 50 times a second on the topic "imu_data".
#
# Wiring:  sensor VCC - 3V3, GND - GND, SDA - GP4, SCL - GP5.
# Try it:  rostether serve /dev/ttyACM0          rostether topic echo /imu_data

import time
from math import pi
from struct import unpack

import ros
from machine import I2C, Pin
from sensor_msgs.msg import Imu

SENSOR = 0x68
WAKE, FILTER, GYROSCOPE, ACCELEROMETER, MEASURED = 0x6B, 0x1A, 0x1B, 0x1C, 0x3B
ACCELERATION = 4 * 9.80665 / 32768  # m/s^2 per unit, in a range of 4 g
ANGULAR_VELOCITY = 500 * pi / 180 / 32768  # rad/s per unit, in a range of 500 degrees a second
PERIOD_MS = 20

i2c = I2C(0, sda=Pin(4), scl=Pin(5), freq=400_000)
registers = bytearray(14)

nh = ros.NodeHandle()
imu_data = ros.Publisher("imu_data", Imu)
message = Imu()
message.header.frame_id = "imu_link"
message.orientation_covariance[0] = -1.0  # the sensor has no orientation
for i in (0, 4, 8):
    message.angular_velocity_covariance[i] = 1e-5  # 0.2 degrees a second
    message.linear_acceleration_covariance[i] = 0.01  # 0.1 m/s^2


def begin():
    i2c.writeto_mem(SENSOR, WAKE, b"\x01")
    i2c.writeto_mem(SENSOR, FILTER, b"\x03")  # 44 Hz
    i2c.writeto_mem(SENSOR, GYROSCOPE, b"\x08")
    i2c.writeto_mem(SENSOR, ACCELEROMETER, b"\x08")


def measure():
    i2c.readfrom_mem_into(SENSOR, MEASURED, registers)
    # The fourth value is the sensor's temperature.
    ax, ay, az, _, wx, wy, wz = unpack(">7h", registers)
    message.linear_acceleration.x = ax * ACCELERATION
    message.linear_acceleration.y = ay * ACCELERATION
    message.linear_acceleration.z = az * ACCELERATION
    message.angular_velocity.x = wx * ANGULAR_VELOCITY
    message.angular_velocity.y = wy * ANGULAR_VELOCITY
    message.angular_velocity.z = wz * ANGULAR_VELOCITY


nh.initNode()
nh.advertise(imu_data)
works = False
due_ms = time.ticks_ms()
while True:
    nh.spinOnce()
    if time.ticks_diff(time.ticks_ms(), due_ms) < 0:
        continue
    due_ms = time.ticks_add(time.ticks_ms(), PERIOD_MS)
    try:
        if not works:
            begin()
            works = True
        measure()
        message.header.stamp = nh.now()
        imu_data.publish(message)
    except OSError:
        works = False
        nh.logerror("no MPU-6050 answers on I2C")
        due_ms = time.ticks_add(time.ticks_ms(), 1000)
