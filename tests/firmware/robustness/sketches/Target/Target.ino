// Has endpoints of many kinds, reads everything that arrives, and sends back the numbers. The build defines BAUD.
#include <diagnostic_msgs/DiagnosticArray.h>
#include <ros.h>
#include <sensor_msgs/JointState.h>
#include <std_msgs/Float64MultiArray.h>
#include <std_msgs/Int16.h>
#include <std_msgs/String.h>
#include <std_srvs/SetBool.h>
#include <tf/tfMessage.h>

// The bytes right before and after the node must not change.
struct Guarded {
  volatile uint8_t before[8];
  ros::NodeHandle node;
  volatile uint8_t after[8];
} guarded;

std_msgs::Int16 number;
ros::Publisher numbers_out("numbers_out", &number);

volatile uint8_t seen;
static void read(const char* text) {
  while (*text) seen += *text++;
}
void hearNumber(const std_msgs::Int16& message) { numbers_out.publish(&message); }
void hearText(const std_msgs::String& message) { read(message.data); }
void hearReals(const std_msgs::Float64MultiArray& message) {
  for (uint16_t i = 0; i < message.layout.dim_length; ++i) read(message.layout.dim[i].label);
  for (uint16_t i = 0; i < message.data_length; ++i) seen += message.data[i] > 0;
}
void hearJoints(const sensor_msgs::JointState& message) {
  read(message.header.frame_id);
  for (uint16_t i = 0; i < message.name_length; ++i) read(message.name[i]);
  for (uint16_t i = 0; i < message.position_length; ++i) seen += message.position[i] > 0;
  for (uint16_t i = 0; i < message.effort_length; ++i) seen += message.effort[i] > 0;
}
void hearTransforms(const tf::tfMessage& message) {
  for (uint16_t i = 0; i < message.transforms_length; ++i) {
    read(message.transforms[i].header.frame_id);
    read(message.transforms[i].child_frame_id);
  }
}
void hearDiagnostics(const diagnostic_msgs::DiagnosticArray& message) {
  for (uint16_t i = 0; i < message.status_length; ++i) {
    read(message.status[i].name);
    for (uint16_t j = 0; j < message.status[i].values_length; ++j) read(message.status[i].values[j].value);
    // A callback that waits, so that others nest in it.
    int value;
    guarded.node.getParam("p", &value, 1, 5);
  }
}
void serve(const std_srvs::SetBoolRequest& request, std_srvs::SetBoolResponse& response) {
  response.success = request.data;
  response.message = "switched";
}

ros::Subscriber<std_msgs::Int16> numbers("numbers", &hearNumber);
ros::Subscriber<std_msgs::String> texts("texts", &hearText);
ros::Subscriber<std_msgs::Float64MultiArray> reals("reals", &hearReals);
ros::Subscriber<sensor_msgs::JointState> joints("joints", &hearJoints);
ros::Subscriber<tf::tfMessage> transforms("transforms", &hearTransforms);
ros::Subscriber<diagnostic_msgs::DiagnosticArray> diagnostics("diagnostics", &hearDiagnostics);
ros::ServiceServer<std_srvs::SetBoolRequest, std_srvs::SetBoolResponse> server("serve", &serve);

void setup() {
  guarded.node.getHardware()->setBaud(BAUD);
  guarded.node.initNode();
  guarded.node.subscribe(numbers);
  guarded.node.subscribe(texts);
  guarded.node.subscribe(reals);
  guarded.node.subscribe(joints);
  guarded.node.subscribe(transforms);
  guarded.node.subscribe(diagnostics);
  guarded.node.advertiseService(server);
  guarded.node.advertise(numbers_out);
  for (uint8_t i = 0; i < 8; ++i) guarded.before[i] = guarded.after[i] = 0x5a;
}

void loop() { guarded.node.spinOnce(); }
