# Conformance: the program that `rostether conformance` checks. It returns texts and numbers. On command, it
# calls a service, gets parameters and logs.
#
# Wiring:  none.
# Try it:  rostether conformance /dev/ttyACM0

import ros
from std_msgs.msg import Empty, Float64, String, Time, UInt8
from std_srvs.srv import SetBool, Trigger

INT_PARAMETER = "conformance/ints"
FLOAT_PARAMETER = "conformance/float"
TEXT_PARAMETER = "conformance/text"


class Conformance:
    def __init__(self, hardware=None):
        self.nh = nh = ros.NodeHandle(hardware)
        self.command = 0
        self.text_out = ros.Publisher("conformance/text_out", String)
        self.real_out = ros.Publisher("conformance/real_out", Float64)
        self.pong = ros.Publisher("conformance/pong", Time)
        self.trigger = ros.ServiceClient("conformance/trigger", Trigger)
        nh.initNode()
        nh.advertise(self.text_out)
        nh.advertise(self.real_out)
        nh.advertise(self.pong)
        nh.subscribe(ros.Subscriber("conformance/text_in", String, self.text_out.publish))
        nh.subscribe(ros.Subscriber("conformance/real_in", Float64, self.real_out.publish))
        nh.subscribe(ros.Subscriber("conformance/ping", Empty, self.send_time))
        nh.subscribe(ros.Subscriber("conformance/command", UInt8, self.keep))
        nh.advertiseService(ros.ServiceServer("conformance/switch", SetBool, self.switch))
        nh.serviceClient(self.trigger)

    def spin(self):
        while True:
            self.nh.spinOnce()
            # A service call or a parameter request blocks, so do not make it inside a callback.
            command, self.command = self.command, 0
            if command:
                self.obey(command)

    def send_time(self, _message):
        self.pong.publish(Time(self.nh.now()))

    def switch(self, request, response):
        response.success = request.data
        response.message = "on" if request.data else "off"

    def keep(self, message):
        self.command = message.data

    def obey(self, command):
        if command == 1:
            self.nh.logdebug("debug")
            self.nh.loginfo("info")
            self.nh.logwarn("warn")
            self.nh.logerror("error")
            self.nh.logfatal("fatal")
        elif command == 2:
            response = self.trigger.call(Trigger.Request())
            self.send_text(response.message if response else None)
        elif command == 3:
            self.send_numbers(self.nh.getParam(INT_PARAMETER))
        elif command == 4:
            self.send_numbers(self.nh.getParam(FLOAT_PARAMETER))
        elif command == 5:
            self.send_text(self.nh.getParam(TEXT_PARAMETER))

    def send_numbers(self, values):
        if values is None:
            self.send_text(None)
        else:
            for each in values if isinstance(values, list) else [values]:
                self.real_out.publish(Float64(each))

    def send_text(self, text):
        self.text_out.publish(String("none" if text is None else text))


if __name__ == "__main__":
    Conformance().spin()
