// ServiceClient: calls the service "test_srv" of another node once a second, and publishes the answer on "chatter".
//
// Wiring: none. The server can be another board with the example ServiceServer.
// Try it:  rostether serve /dev/ttyACM0 /dev/ttyACM1          rostether topic echo /chatter

#include <ros.h>
#include <rosserial_arduino/Test.h>
#include <std_msgs/String.h>

using rosserial_arduino::Test;

ros::NodeHandle nh;
ros::ServiceClient<Test::Request, Test::Response> client("test_srv");

std_msgs::String text;
ros::Publisher chatter("chatter", &text);

void setup() {
  nh.initNode();
  nh.serviceClient(client);
  nh.advertise(chatter);
  while (!nh.connected()) nh.spinOnce();
  nh.loginfo("ready to call");
}

void loop() {
  Test::Request request;
  Test::Response response;
  request.input = "hello world!";
  client.call(request, response);  // waits for the answer
  text.data = response.output;
  chatter.publish(&text);
  nh.spinOnce();
  delay(1000);
}
