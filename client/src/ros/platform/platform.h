// Selects the platform and its `ros::NodeHandle`. A program with its own Hardware class for another system defines
// ROS_NO_PLATFORM before <ros.h>, and uses ros::NodeHandle_<ThatClass>.
#ifndef ROS_PLATFORM_PLATFORM_H_
#define ROS_PLATFORM_PLATFORM_H_

#include "ros/node_handle.h"

#if defined(ROS_NO_PLATFORM)
#elif defined(ROSSERIAL_ARDUINO_TCP)
#include "ros/platform/arduino_tcp.h"
#define ROS_HARDWARE ArduinoHardware
#elif defined(ROSSERIAL_ARDUINO_UDP)
#include "ros/platform/arduino_udp.h"
#define ROS_HARDWARE ArduinoHardware
#elif defined(__OPENCR__)
#include "ros/platform/opencr.h"
#define ROS_HARDWARE ArduinoHardware
#elif defined(ARDUINO)
#include "ros/platform/arduino.h"
#define ROS_HARDWARE ArduinoHardware
#elif defined(__MBED__)
#include "ros/platform/mbed.h"
#define ROS_HARDWARE MbedHardware
#elif defined(USE_HAL_DRIVER)
#include "ros/platform/stm32_hal.h"
#define ROS_HARDWARE STM32Hardware
#elif defined(PART_TM4C123GH6PM) || defined(PART_TM4C1294NCPDT) || defined(TARGET_IS_TM4C123_RA1) || \
    defined(TARGET_IS_TM4C123_RA3) || defined(TARGET_IS_TM4C123_RB1) || defined(TARGET_IS_TM4C123_RB2) ||   \
    defined(TARGET_IS_TM4C129_RA0) || defined(TARGET_IS_TM4C129_RA1) || defined(TARGET_IS_TM4C129_RA2)
#include "ros/platform/tivac.h"
#define ROS_HARDWARE TivaCHardware
#elif defined(_WIN32)
#include "ros/platform/windows_port.h"
#define ROS_HARDWARE WindowsHardware
#elif defined(__unix__) || defined(__APPLE__)
#include "ros/platform/posix.h"
#define ROS_HARDWARE EmbeddedLinuxHardware
#else
#error "ros_lib does not support this platform: define ROS_NO_PLATFORM and give ros::NodeHandle_ a Hardware class (platform/platform.h)"
#endif

#if defined(ROS_HARDWARE)
// The length of the longest message that can be received. It depends on the board's memory.
#if !defined(ROS_INPUT_SIZE)
#if defined(__AVR_ATmega8__) || defined(__AVR_ATmega168__) || defined(__AVR_ATmega168P__)
#define ROS_INPUT_SIZE 150
#elif defined(__AVR_ATmega328P__) || defined(__AVR_ATmega328__) || defined(__AVR_ATmega328PB__) || defined(__AVR_ATmega32U4__)
#define ROS_INPUT_SIZE 280
#elif !defined(ARDUINO) && (defined(_WIN32) || defined(__unix__) || defined(__APPLE__))
#define ROS_INPUT_SIZE 32768
#else
#define ROS_INPUT_SIZE 512
#endif
#endif

namespace ros {
// A sketch may define its own ros::NodeHandle, for example with a smaller INPUT_SIZE: a name in `ros` itself hides the
// one that only a using-directive adds.
namespace platform {
typedef NodeHandle_<ROS_HARDWARE, 25, 25, ROS_INPUT_SIZE, ROS_INPUT_SIZE> NodeHandle;
}  // namespace platform
using namespace platform;
}  // namespace ros
#endif

#endif
