// Parameters: settings that are stored on the host, read once at the start. In names, "~" means the name of this node.
//
// Wiring: none.
// Try it:  rostether param set /serial_node/gains "[1.5, 0.25, 0.01]"
//          rostether param set /serial_node/name "lefty"
//          rostether serve "/dev/ttyACM0?name=serial_node"
//          rostether topic echo /gains

#include <ros.h>
#include <std_msgs/Float32MultiArray.h>
#include <std_msgs/String.h>

ros::NodeHandle nh;

float gains[3] = {1.0, 0.0, 0.1};  // used when the host has no such parameter
int period_ms = 200;
bool enabled = true;
char name[20] = "nobody";
char* name_buffer = name;

std_msgs::Float32MultiArray gains_msg;
std_msgs::String name_msg;
ros::Publisher pub_gains("gains", &gains_msg);
ros::Publisher pub_name("name", &name_msg);

void setup() {
  nh.initNode();
  nh.advertise(pub_gains);
  nh.advertise(pub_name);
  while (!nh.connected()) nh.spinOnce();  // parameters come from the host

  // Each call waits at most a second for the answer. Without an answer, it returns false, and the value is unchanged.
  if (!nh.getParam("~gains", gains, 3)) nh.loginfo("~gains is not set: 1.0, 0.0, 0.1");
  nh.getParam("~period_ms", &period_ms);
  nh.getParam("~enabled", &enabled);
  nh.getParam("~name", &name_buffer);  // room for 19 characters
}

void loop() {
  if (enabled) {
    gains_msg.data = gains;
    gains_msg.data_length = 3;
    pub_gains.publish(&gains_msg);
    name_msg.data = name;
    pub_name.publish(&name_msg);
  }
  nh.spinOnce();
  delay(period_ms);
}
