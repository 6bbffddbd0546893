// TcpBlink: Blink without a serial cable, through an Ethernet shield.
//
// Wiring:  an Ethernet shield on the board, a cable to the network of the host; an LED with 1 kiloohm from pin 7 to GND
//          (the shield uses pins 10 to 13, and with them the LED on the board).
// Try it:  rostether serve tcp://0.0.0.0:11411          rostether topic pub -1 /toggle_led std_msgs/Empty

#include <SPI.h>
#include <Ethernet.h>

#define ROSSERIAL_ARDUINO_TCP  // before ros.h: the node's line is a TCP connection
#include <ros.h>
#include <std_msgs/Empty.h>

byte mac[] = {0xDE, 0xAD, 0xBE, 0xEF, 0xFE, 0xEE};
IPAddress ip(192, 168, 0, 178);
IPAddress server(192, 168, 0, 11);  // the host that `rostether serve` runs on
const uint16_t serverPort = 11411;

ros::NodeHandle nh;

const int LED = 7;

void toggle(const std_msgs::Empty&) {
  digitalWrite(LED, HIGH - digitalRead(LED));
}
ros::Subscriber<std_msgs::Empty> sub("toggle_led", &toggle);

void setup() {
  pinMode(LED, OUTPUT);
  Ethernet.begin(mac, ip);
  nh.getHardware()->setConnection(server, serverPort);
  nh.initNode();
  nh.subscribe(sub);
}

void loop() {
  nh.spinOnce();
}
