// TcpHelloWorld: HelloWorld without a serial cable, through an Ethernet shield.
//
// Wiring:  an Ethernet shield (W5100, W5500) on the board, a cable to the network of the host.
// Try it:  rostether serve tcp://0.0.0.0:11411          rostether topic echo /chatter

#include <SPI.h>
#include <Ethernet.h>

#define ROSSERIAL_ARDUINO_TCP  // before ros.h: the node's line is a TCP connection
#include <ros.h>
#include <std_msgs/String.h>

// Each board on a network needs its own values. Ask the network's administrator for a free address.
byte mac[] = {0xDE, 0xAD, 0xBE, 0xEF, 0xFE, 0xED};
IPAddress ip(192, 168, 0, 177);

// The host that `rostether serve` runs on.
IPAddress server(192, 168, 0, 11);
const uint16_t serverPort = 11411;

ros::NodeHandle nh;

std_msgs::String text;
ros::Publisher chatter("chatter", &text);
unsigned long published_ms;

void setup() {
  Serial.begin(115200);  // free for debug output: ROS does not use it
  Ethernet.begin(mac, ip);
  Serial.print(F("my address is "));
  Serial.println(Ethernet.localIP());

  nh.getHardware()->setConnection(server, serverPort);
  nh.initNode();
  nh.advertise(chatter);
}

void loop() {
  if (millis() - published_ms >= 1000) {
    published_ms = millis();
    text.data = "hello world!";
    chatter.publish(&text);
  }
  nh.spinOnce();
}
