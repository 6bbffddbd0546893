// Plays the recorded bytes of a host to a node with the endpoints of the recorded board.
//
//   session_player ENDPOINT...      each is one of: empty, text, byte, server, client; ids count up from 100
//
// Each line of the standard input is a time in milliseconds and bytes in hexadecimal. The standard output has the lines
// `heard ID` and `sent ID PAYLOAD`, and at the end `dropped N` and `now SEC`.
#include <rosserial_arduino/Test.h>
#include <std_msgs/Byte.h>
#include <std_msgs/Empty.h>
#include <std_msgs/String.h>
#include <string.h>

#include "../node/scripted_hardware.h"

typedef rosserial_arduino::TestRequest Request;
typedef rosserial_arduino::TestResponse Response;

template <class M>
static void hear(const M&) {
  printf("heard 100\n");
}
template <>
void hear(const std_msgs::Empty&) {
  printf("heard empty\n");
}
static void answer(const Request& request, Response& response) {
  printf("heard 100\n");
  response.output = request.input;
}

int main(int count, char** names) {
  static Board<> board;
  static ros::Subscriber<std_msgs::Empty> empties("empty", hear<std_msgs::Empty>);
  static ros::Subscriber<std_msgs::String> texts("text", hear<std_msgs::String>);
  static ros::Subscriber<std_msgs::Byte> bytes("byte", hear<std_msgs::Byte>);
  static ros::ServiceServer<Request, Response> server("server", answer);
  static ros::ServiceClient<Request, Response> client("client");
  static std_msgs::String text;
  static ros::Publisher chatter("chatter", &text);
  bool calls = false;
  for (int i = 1; i < count; ++i) {
    if (strcmp(names[i], "empty") == 0) board.node.subscribe(empties);
    if (strcmp(names[i], "text") == 0) board.node.subscribe(texts);
    if (strcmp(names[i], "byte") == 0) board.node.subscribe(bytes);
    if (strcmp(names[i], "server") == 0) board.node.advertiseService(server);
    if (strcmp(names[i], "client") == 0) calls = board.node.serviceClient(client);
  }
  board.node.advertise(chatter);
  board.node.initNode();
  board.line.now_ms = 0;
  board.line.silence_ms = calls ? 1 : 0;
  unsigned long at_ms;
  static char hex[1 << 17];
  while (scanf("%lu %131071s", &at_ms, hex) == 2) {
    while (board.line.now_ms < at_ms) {
      ++board.line.now_ms;
      Request request;
      Response response;
      request.input = "call";
      if (!calls || !board.node.connected()) {
        board.node.spinOnce();
      } else if (client.call(request, response, 1)) {
        printf("heard 100\n");
      }
    }
    Bytes chunk;
    for (const char* digit = hex; digit[0] && digit[1]; digit += 2) {
      unsigned byte;
      sscanf(digit, "%2x", &byte);
      chunk.push_back(static_cast<uint8_t>(byte));
    }
    board.line.send(chunk);
  }
  for (int i = 0; i < 500; ++i) ++board.line.now_ms, board.node.spinOnce();
  for (const Frame& got : board.line.frames) printf("sent %u %s\n", got.id, show(got.payload).c_str());
  printf("dropped %u\nnow %u\n", board.node.dropped(), static_cast<unsigned>(board.node.now().sec));
  return board.line.written.empty() && board.line.noise == 0 ? 0 : 1;
}
