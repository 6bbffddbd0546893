// MeArm: the four servos of a MeArm, each with its angle in degrees, by one message on the topic "servo_control".
//
// Wiring:  base - pin 9, shoulder - 10, elbow - 11, claw - 12; the servos need a supply of 5 V, 2 A of their own,
//          its GND joined with the board's.
// Try it:  rostether serve "/dev/ttyACM0?baud=115200"
//          rostether topic pub -1 /servo_control mearm_model/ServoAngles "[90, 90, 90, 40]"

#include <Servo.h>
#include <mearm_model/ServoAngles.h>
#include <ros.h>

ros::NodeHandle nh;

Servo servo1;
Servo servo2;
Servo servo3;
Servo servo4;

void move(const mearm_model::ServoAngles& angles) {
  servo1.write(angles.servo1);
  servo2.write(angles.servo2);
  servo3.write(angles.servo3);
  servo4.write(angles.servo4);
}

ros::Subscriber<mearm_model::ServoAngles> sub("servo_control", &move);

void setup() {
  nh.getHardware()->setBaud(115200);  // the host must use the same
  nh.initNode();
  nh.subscribe(sub);

  servo1.attach(9);
  servo2.attach(10);
  servo3.attach(11);
  servo4.attach(12);
}

void loop() {
  nh.spinOnce();
}
