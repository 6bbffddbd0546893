// The four servos of a MeArm. Turns them to the angles, in degrees, that it receives on the topics "servo_control" and
// "servo_pose_server". Ten times a second, publishes the angles that they hold on "servo_angles".
//
// Wiring:  joint_0 (base) - pin 9, joint_1 (shoulder) - 10, joint_2 (elbow) - 11, joint_3 (claw) - 12.
//          The servos need a separate supply of 5 V, 2 A. Connect its GND to the board's GND.

#include <Servo.h>
#include <mearm_model/ServoAngles.h>
#include <ros.h>

const unsigned long PERIOD_MS = 100;

ros::NodeHandle nh;

Servo servo1;
Servo servo2;
Servo servo3;
Servo servo4;

// Servo.write clamps to 0..180.
void servoCallback(const mearm_model::ServoAngles& angles) {
  servo1.write(angles.servo1);
  servo2.write(angles.servo2);
  servo3.write(angles.servo3);
  servo4.write(angles.servo4);
}

// For programs that move the servos directly, and for the node mearm_controller.
ros::Subscriber<mearm_model::ServoAngles> direct("servo_control", &servoCallback);
ros::Subscriber<mearm_model::ServoAngles> controlled("servo_pose_server", &servoCallback);

mearm_model::ServoAngles held;
ros::Publisher heldPublisher("servo_angles", &held);
unsigned long publishedAt = 0;

void setup() {
  nh.getHardware()->setBaud(115200);  // the host must use the same
  nh.initNode();
  nh.subscribe(direct);
  nh.subscribe(controlled);
  nh.advertise(heldPublisher);

  servo1.attach(9);
  servo2.attach(10);
  servo3.attach(11);
  servo4.attach(12);
}

void loop() {
  if (millis() - publishedAt >= PERIOD_MS) {
    publishedAt += PERIOD_MS;
    held.servo1 = servo1.read();
    held.servo2 = servo2.read();
    held.servo3 = servo3.read();
    held.servo4 = servo4.read();
    heldPublisher.publish(&held);
  }
  nh.spinOnce();
}
