// ServiceServer: answers calls of the service "test_srv", in turn with "hello" and with "world".
//
// Wiring: none.
// Try it:  rostether serve /dev/ttyACM0          rostether service call /test_srv "anybody there?"

#include <ros.h>
#include <rosserial_arduino/Test.h>
#include <std_msgs/String.h>

using rosserial_arduino::Test;

ros::NodeHandle nh;

bool says_hello = false;

// The request has the caller's values. The response is sent when this function returns.
void answer(const Test::Request&, Test::Response& response) {
  says_hello = !says_hello;
  response.output = says_hello ? "hello" : "world";
}

ros::ServiceServer<Test::Request, Test::Response> server("test_srv", &answer);

std_msgs::String text;
ros::Publisher chatter("chatter", &text);

void setup() {
  nh.initNode();
  nh.advertiseService(server);
  nh.advertise(chatter);
}

void loop() {
  text.data = "hello world!";
  chatter.publish(&text);
  nh.spinOnce();
  delay(10);
}
