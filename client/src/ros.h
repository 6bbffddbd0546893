// Everything a sketch needs of ROS: `ros::NodeHandle`, publishers, subscribers, services, time.
#ifndef ROS_H_
#define ROS_H_

#include "ros/duration.h"
#include "ros/message.h"
#include "ros/node_handle.h"
#include "ros/parameters.h"
#include "ros/publisher.h"
#include "ros/service_client.h"
#include "ros/service_server.h"
#include "ros/subscriber.h"
#include "ros/time.h"

#include "ros/platform/arduino.h"

namespace ros {

#if defined(__AVR_ATmega8__) || defined(__AVR_ATmega168__)
typedef NodeHandle_<ArduinoHardware, 6, 6, 150, 150> NodeHandle;
#elif defined(__AVR_ATmega328P__) || defined(__AVR_ATmega32U4__)
typedef NodeHandle_<ArduinoHardware, 25, 25, 280, 280> NodeHandle;
#else
typedef NodeHandle_<ArduinoHardware> NodeHandle;
#endif

}  // namespace ros

#endif
