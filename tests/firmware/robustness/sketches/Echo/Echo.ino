// Sends back what comes in.
#include <ros.h>
#include <std_msgs/Float64MultiArray.h>
#include <std_msgs/Int64MultiArray.h>
#include <std_msgs/String.h>

ros::NodeHandle nh;

std_msgs::String text;
std_msgs::Float64MultiArray reals;
std_msgs::Int64MultiArray integers;
ros::Publisher texts_out("texts_out", &text);
ros::Publisher reals_out("reals_out", &reals);
ros::Publisher integers_out("integers_out", &integers);

void echoText(const std_msgs::String& message) { texts_out.publish(&message); }
void echoReals(const std_msgs::Float64MultiArray& message) { reals_out.publish(&message); }
void echoIntegers(const std_msgs::Int64MultiArray& message) { integers_out.publish(&message); }
ros::Subscriber<std_msgs::String> texts_in("texts_in", &echoText);
ros::Subscriber<std_msgs::Float64MultiArray> reals_in("reals_in", &echoReals);
ros::Subscriber<std_msgs::Int64MultiArray> integers_in("integers_in", &echoIntegers);

void setup() {
  nh.initNode();
  nh.advertise(texts_out);
  nh.advertise(reals_out);
  nh.advertise(integers_out);
  nh.subscribe(texts_in);
  nh.subscribe(reals_in);
  nh.subscribe(integers_in);
}

void loop() { nh.spinOnce(); }
