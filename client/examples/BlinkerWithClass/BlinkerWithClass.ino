// BlinkerWithClass: subscribers and services can be members of a class. This one blinks an LED by itself.
//
// Wiring: none, the LED on pin 13 is on the board.
// Try it:  rostether serve /dev/ttyACM0
//          rostether topic pub -1 /set_blink_period std_msgs/UInt16 100        100 ms on, 100 ms off
//          rostether service call /activate_blinker false                      off

#include <ros.h>
#include <std_msgs/UInt16.h>
#include <std_srvs/SetBool.h>

using std_srvs::SetBool;

class Blinker {
 public:
  Blinker(uint8_t pin, uint16_t period_ms)
      : pin_(pin), period_ms_(period_ms), changed_ms_(0), active_(true),
        // A member function needs its object: this one.
        subscriber_("set_blink_period", &Blinker::setPeriod, this),
        server_("activate_blinker", &Blinker::activate, this) {}

  void begin(ros::NodeHandle& nh) {
    pinMode(pin_, OUTPUT);
    nh.subscribe(subscriber_);
    nh.advertiseService(server_);
  }

  void run() {
    if (!active_ || millis() - changed_ms_ < period_ms_) return;
    changed_ms_ = millis();
    digitalWrite(pin_, !digitalRead(pin_));
  }

 private:
  void setPeriod(const std_msgs::UInt16& period) { period_ms_ = period.data; }

  void activate(const SetBool::Request& request, SetBool::Response& response) {
    active_ = request.data;
    if (!active_) digitalWrite(pin_, LOW);
    response.success = true;
    response.message = active_ ? "blinking" : "dark";
  }

  const uint8_t pin_;
  uint16_t period_ms_;
  unsigned long changed_ms_;
  bool active_;
  ros::Subscriber<std_msgs::UInt16, Blinker> subscriber_;
  ros::ServiceServer<SetBool::Request, SetBool::Response, Blinker> server_;
};

ros::NodeHandle nh;
Blinker blinker(13, 500);

void setup() {
  nh.initNode();
  blinker.begin(nh);
}

void loop() {
  blinker.run();
  nh.spinOnce();
}
