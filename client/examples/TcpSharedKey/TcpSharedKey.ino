// TcpSharedKey: TcpHelloWorld on an untrusted network: board and host prove to each other that they have the key.
//
// Wiring:  an Ethernet shield (W5100, W5500) on the board, a cable to the network of the host; nothing on A0.
// Try it:  rostether serve "tcp://0.0.0.0:11411?psk=board.key"          rostether topic echo /chatter
//          where board.key contains the key below; make your own with: openssl rand -hex 32 > board.key

#include <SPI.h>
#include <Ethernet.h>

#define ROSSERIAL_ARDUINO_TCP  // before ros.h: the node's line is a TCP connection
#include <ros.h>
#include <ros/keyed_client.h>
#include <std_msgs/String.h>

#define KEY "0f1e2d3c4b5a69788796a5b4c3d2e1f00f1e2d3c4b5a69788796a5b4c3d2e1f0"

byte mac[] = {0xDE, 0xAD, 0xBE, 0xEF, 0xFE, 0xEF};
IPAddress ip(192, 168, 0, 179);
IPAddress server(192, 168, 0, 11);  // the host that `rostether serve` runs on
const uint16_t serverPort = 11411;

// If the board has Wi-Fi, use WiFiClient instead of EthernetClient.
typedef ros::KeyedClient<EthernetClient> Client_;
ros::NodeHandle_<ArduinoTcpHardware<Client_>, 25, 25, 128> nh;

std_msgs::String text;
ros::Publisher chatter("chatter", &text);
unsigned long published_ms;
Client_::Refusal printed = Client_::NONE;

// Prints on the serial line why the connection to the host fails.
void explain(Client_::Refusal refusal) {
  if (refusal == printed) return;
  printed = refusal;
  if (refusal == Client_::NO_ANSWER) Serial.println(F("the host does not answer: its key may be different"));
  if (refusal == Client_::NO_HELLO) Serial.println(F("the host needs no key: serve it with psk="));
  if (refusal == Client_::WRONG_KEY) Serial.println(F("the host has a different key"));
}

void setup() {
  Serial.begin(115200);  // free for debug output: ROS does not use it
  Ethernet.begin(mac, ip);
  nh.getHardware()->client().setKey(F(KEY), analogRead(A0));
  nh.getHardware()->setConnection(server, serverPort);
  nh.initNode();
  nh.advertise(chatter);
}

void loop() {
  explain(nh.getHardware()->client().refusal());
  if (millis() - published_ms >= 1000) {
    published_ms = millis();
    text.data = "hello, friend";
    chatter.publish(&text);
  }
  nh.spinOnce();
}
