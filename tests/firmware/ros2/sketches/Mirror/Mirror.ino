// Publishes on out_X what it hears on in_X, answers two services, calls two, reads parameters, logs.
#include <ros.h>
#include <geometry_msgs/Twist.h>
#include <nav_msgs/Odometry.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/JointState.h>
#include <sensor_msgs/Range.h>
#include <std_msgs/Bool.h>
#include <std_msgs/Empty.h>
#include <std_msgs/String.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>

using std_srvs::SetBool;
using std_srvs::Trigger;

ros::NodeHandle_<ArduinoHardware, 15, 15, 1024, 1024> nh;

template <class M>
struct Mirror {
  Mirror(const char* in, const char* out) : publisher(out, &message), subscriber(in, &Mirror::take, this) {}

  void take(const M& heard) { publisher.publish(&heard); }

  M message;
  ros::Publisher publisher;
  ros::Subscriber<M, Mirror> subscriber;
};

Mirror<std_msgs::String> text("in_String", "out_String");
Mirror<sensor_msgs::Imu> imu("in_Imu", "out_Imu");
Mirror<sensor_msgs::Range> distance("in_Range", "out_Range");
Mirror<geometry_msgs::Twist> twist("in_Twist", "out_Twist");
Mirror<sensor_msgs::JointState> joints("in_JointState", "out_JointState");
Mirror<nav_msgs::Odometry> odometry("in_Odometry", "out_Odometry");
Mirror<sensor_msgs::CompressedImage> image("in_CompressedImage", "out_CompressedImage");

template <class M>
void mirror(Mirror<M>& each) {
  nh.advertise(each.publisher);
  nh.subscribe(each.subscriber);
}

void answerSwitch(const SetBool::Request& request, SetBool::Response& response) {
  response.success = request.data;
  response.message = request.data ? "on" : "off";
}

void answerPull(const Trigger::Request&, Trigger::Response& response) {
  response.success = true;
  response.message = "bang";
}

ros::ServiceServer<SetBool::Request, SetBool::Response> switch_server("switch", &answerSwitch);
ros::ServiceServer<Trigger::Request, Trigger::Response> pull_server("pull", &answerPull);
ros::ServiceClient<SetBool::Request, SetBool::Response> gripper("gripper");
ros::ServiceClient<Trigger::Request, Trigger::Response> horn("horn");

bool is_asked_to_call = false;
bool is_asked_to_read = false;
void rememberToCall(const std_msgs::Empty&) { is_asked_to_call = true; }
void rememberToRead(const std_msgs::Empty&) { is_asked_to_read = true; }
ros::Subscriber<std_msgs::Empty> call("call", &rememberToCall);
ros::Subscriber<std_msgs::Empty> read("read", &rememberToRead);

std_msgs::String said;
ros::Publisher answers("answers", &said);
sensor_msgs::JointState gains;
ros::Publisher parameters("parameters", &gains);

void setup() {
  nh.initNode();
  mirror(text);
  mirror(imu);
  mirror(distance);
  mirror(twist);
  mirror(joints);
  mirror(odometry);
  mirror(image);
  nh.advertiseService(switch_server);
  nh.advertiseService(pull_server);
  nh.serviceClient(gripper);
  nh.serviceClient(horn);
  nh.subscribe(call);
  nh.subscribe(read);
  nh.advertise(answers);
  nh.advertise(parameters);
}

void callBoth() {
  SetBool::Request closed;
  SetBool::Response gripped;
  closed.data = true;
  gripper.call(closed, gripped);
  said.data = gripped.message;
  answers.publish(&said);
  Trigger::Response honked;
  horn.call(Trigger::Request(), honked);
  said.data = honked.message;
  answers.publish(&said);
}

// What is not set stays as it is here.
void readParameters() {
  float values[3] = {-1, -1, -1};
  char side[16] = "nowhere";
  char* side_buffer = side;
  int count = -1;
  nh.getParam("~gains", values, 2);
  nh.getParam("~count", &count);
  nh.getParam("~side", &side_buffer);
  values[2] = count;
  gains.position = values;
  gains.position_length = 3;
  gains.header.frame_id = side;
  parameters.publish(&gains);
  nh.logwarn("parameters are read");
}

void loop() {
  nh.spinOnce();
  if (is_asked_to_call) {
    is_asked_to_call = false;
    callBoth();
  }
  if (is_asked_to_read) {
    is_asked_to_read = false;
    readParameters();
  }
}
