// The node that the tests of every platform use: it has endpoints of all kinds.
#ifndef PLATFORM_NODE_H_
#define PLATFORM_NODE_H_

#include <ros.h>
#include <std_msgs/String.h>
#include <std_msgs/UInt32.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>

#include <string.h>

#if !defined(PLATFORM_NODE_HANDLE)
#define PLATFORM_NODE_HANDLE ros::NodeHandle
#endif

PLATFORM_NODE_HANDLE nh;

std_msgs::UInt32 count;
std_msgs::String answer;
ros::Publisher counter("count", &count);
ros::Publisher answers("answer", &answer);

ros::ServiceClient<std_srvs::TriggerRequest, std_srvs::TriggerResponse> trigger("trigger");

// The callback sets the task, and the loop handles it: a service call in a callback also works, but needs memory for
// the callback's message meanwhile.
enum Task { NOTHING, ASK_PARAMETER, CALL_SERVICE };
Task task = NOTHING;

void onQuestion(const std_msgs::String& question) {
  if (strcmp(question.data, "parameter") == 0) {
    task = ASK_PARAMETER;
  } else if (strcmp(question.data, "service") == 0) {
    task = CALL_SERVICE;
  } else {
    answer.data = question.data;
    answers.publish(&answer);
  }
}
ros::Subscriber<std_msgs::String> questions("question", onQuestion);

void onSwitch(const std_srvs::SetBoolRequest& request, std_srvs::SetBoolResponse& response) {
  response.success = request.data;
  response.message = request.data ? "on" : "off";
}
ros::ServiceServer<std_srvs::SetBoolRequest, std_srvs::SetBoolResponse> lamp("switch", onSwitch);

void setupNode() {
  nh.advertise(counter);
  nh.advertise(answers);
  nh.subscribe(questions);
  nh.advertiseService(lamp);
  nh.serviceClient(trigger);
}

void doTask() {
  static char text[64];
  answer.data = "failed";
  if (task == ASK_PARAMETER) {
    if (nh.getParam("greeting", text, sizeof text)) answer.data = text;
  } else {
    const std_srvs::TriggerRequest request;
    std_srvs::TriggerResponse response;
    if (trigger.call(request, response)) {
      strncpy(text, response.message, sizeof text - 1);
      answer.data = text;
    }
  }
  task = NOTHING;
  answers.publish(&answer);
}

void loopNode() {
  static bool was_connected = false;
  if (nh.connected() && !was_connected) nh.loginfo("here I am");
  was_connected = nh.connected();
  nh.spinOnce();
  if (task != NOTHING) doTask();
  ++count.data;
  counter.publish(&count);
}

#endif
