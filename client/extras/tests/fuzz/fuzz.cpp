// Sends a node unusual frames (any length, id and content), damaged frames and noise.
//
//   fuzz SEED FRAMES
//
// The node has endpoints of many types, whose callbacks read the whole message. After each frame, the line pauses. Then
// the node must deliver a valid message, and sometimes answer a request for the topics. Prints the number of frames,
// and how many of them reached a callback. After a failure, it prints the last input and exits with 1. Run it with
// sanitizers.
#include <diagnostic_msgs/DiagnosticArray.h>
#include <library_tests/Everything.h>
#include <library_tests/Lookup.h>
#include <nav_msgs/Odometry.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/JointState.h>
#include <sensor_msgs/PointCloud2.h>
#include <std_msgs/Empty.h>
#include <std_msgs/Float64MultiArray.h>
#include <std_msgs/Int16.h>
#include <std_msgs/Int64MultiArray.h>
#include <std_msgs/String.h>
#include <std_srvs/SetBool.h>
#include <tf/tfMessage.h>
#include <trajectory_msgs/JointTrajectory.h>

#include <array>

#include "../node/scripted_hardware.h"

static uint64_t state;
static uint32_t randomBelow(uint32_t below) {
  state ^= state << 13;
  state ^= state >> 7;
  state ^= state << 17;
  return static_cast<uint32_t>((state >> 16) % below);
}

// An archive that adds all bytes of a message to a sum, so that they are really read.
static volatile uint64_t seen;
class Look {
 public:
  template <class T>
  void value(const T& field) {
    bytes(&field, sizeof field);
  }
  void value(const bool& field) { seen = seen + (field ? 1 : 2); }
  void string(const char* text) { bytes(text, strlen(text)); }
  template <class M>
  void message(const M& part) {
    M::_fields(*this, part);
  }
  template <class T, size_t N>
  void fixed(const T (&array)[N]) {
    elements(array, N);
  }
  template <class T>
  void sequence(T* array, ros::array_length length) {
    elements(array, length);
  }
  void sequence(const ros::Float64Pointer& array, ros::array_length length) {
    for (size_t i = 0; i < length; ++i) value(static_cast<double>(array[i]));
  }
  void sequence64(const ros::unaligned_int64* array, ros::array_length length) {
    for (size_t i = 0; i < length; ++i) seen = seen + static_cast<uint64_t>(array[i]);
  }
  void sequence64(const ros::unaligned_uint64* array, ros::array_length length) {
    for (size_t i = 0; i < length; ++i) seen = seen + array[i];
  }

 private:
  void bytes(const void* start, size_t count) {
    uint64_t sum = 0;
    for (size_t i = 0; i < count; ++i) sum = sum * 31 + static_cast<const uint8_t*>(start)[i];
    seen = seen + sum;
  }
  template <class T>
  void elements(T* array, size_t length) {
    for (size_t i = 0; i < length; ++i) element(array[i], typename ros::FieldKind<typename std::remove_const<T>::type>::type());
  }
  template <class T>
  void element(const T& field, ros::BlockKind) {
    value(field);
  }
  void element(const char* text, ros::StringKind) { string(text); }
  template <class T>
  void element(const T& part, ros::MessageKind) {
    message(part);
  }
};

static unsigned long delivered;
static int last_number;
static unsigned number_count;

// A transmitter that is sometimes full, and a sketch that does much in its callbacks.
class FuzzHardware : public QueueingHardware {
 public:
  int writable() {
    const int room = QueueingHardware::writable();
    if (faulty && randomBelow(500) == 0) stuck = !stuck;
    return room;
  }

  bool canaryIsIntact() const {
    for (uint8_t byte : canary_) {
      if (byte != 0x5a) return false;
    }
    return true;
  }

  bool faulty = false;

 private:
  // The receive buffer is after these bytes, and the sanitizer checks the bytes after the buffer.
  const std::array<uint8_t, 64> canary_ = filled();

  static std::array<uint8_t, 64> filled() {
    std::array<uint8_t, 64> bytes;
    bytes.fill(0x5a);
    return bytes;
  }
};

static Board<FuzzHardware, 400>* board;
static std_msgs::String text;
static ros::Publisher chatter("chatter", &text);
static ros::ServiceClient<library_tests::LookupRequest, library_tests::LookupResponse> lookup("lookup");

template <class M>
static void look(const M& message) {
  ++delivered;
  Look reader;
  reader.message(message);
  switch (randomBelow(40)) {
    case 0:
      board->node.spinOnce();
      reader.message(message);
      break;
    case 1: {
      float values[2];
      board->node.getParam("p", values, 2, 2);
      reader.message(message);
      break;
    }
    case 2: {
      char name[8];
      board->node.getParam("p", name, sizeof name, 2);
      reader.message(message);
      break;
    }
    case 3: {
      library_tests::LookupRequest request;
      library_tests::LookupResponse response;
      request.name = "thing";
      if (lookup.call(request, response, 3)) {
        chatter.publish(&text);
        reader.message(response);
      }
      reader.message(message);
      break;
    }
    case 4:
      for (int i = 0; i < 20; ++i) chatter.publish(&text);
      reader.message(message);
      break;
  }
}

template <class M>
static ros::Subscriber<M>& subscriber(const char* topic) {
  static ros::Subscriber<M> one(topic, look<M>);
  board->node.subscribe(one);
  return one;
}
static void serve(const library_tests::LookupRequest& request, library_tests::LookupResponse& response) {
  look(request);
  response.found = true;
}
static void hearNumber(const std_msgs::Int16& message) {
  last_number = message.data;
  ++number_count;
}

// Valid payloads of the types, which will be damaged.
static std::vector<Bytes> samples(const uint16_t* ids, size_t count);

static Bytes damaged(Bytes bytes) {
  for (uint32_t i = randomBelow(4) + 1; i > 0 && !bytes.empty(); --i) {
    const size_t at = randomBelow(static_cast<uint32_t>(bytes.size()));
    static const uint32_t lengths[] = {0, 1, 2, 3, 4, 7, 8, 127, 255, 256, 300, 400, 65535, 0x10000, 0x20000000, 0x7fffffff,
                                       0x80000000, 0xfffffffc, 0xffffffff};
    switch (randomBelow(6)) {
      case 0:
        bytes[at] = static_cast<uint8_t>(bytes[at] ^ 1 << randomBelow(8));
        break;
      case 1:
        bytes[at] = static_cast<uint8_t>(randomBelow(256));
        break;
      case 2:
        bytes.erase(bytes.begin() + static_cast<long>(at), bytes.begin() + static_cast<long>(at + 1 + randomBelow(static_cast<uint32_t>(bytes.size() - at))));
        break;
      case 3:
        bytes.insert(bytes.begin() + static_cast<long>(at), randomBelow(30), static_cast<uint8_t>(randomBelow(2) ? 0xff : randomBelow(256)));
        break;
      default:
        if (at + 4 > bytes.size()) break;
        memcpy(&bytes[at], &lengths[randomBelow(sizeof lengths / sizeof *lengths)], 4);
    }
  }
  return bytes;
}

static Bytes noise(uint32_t longest) {
  Bytes bytes(randomBelow(longest));
  const uint32_t flavour = randomBelow(3);
  for (size_t i = 0; i < bytes.size(); ++i) {
    bytes[i] = static_cast<uint8_t>(flavour == 0 ? randomBelow(256) : flavour == 1 ? (randomBelow(2) ? 0xff : 0xfe) : randomBelow(5));
  }
  return bytes;
}

int main(int count, char** arguments) {
  if (count != 3) return 2;
  state = strtoull(arguments[1], nullptr, 0) * 0x9e3779b97f4a7c15ULL + 1;
  const unsigned long wanted = strtoul(arguments[2], nullptr, 0);
  static Board<FuzzHardware, 400> one;
  board = &one;
  text.data = "chatter";
  const uint16_t ids[] = {0, 6, 10, 11};
  std::vector<uint16_t> known(ids, ids + 4);
  board->node.advertise(chatter);
  board->node.serviceClient(lookup);
  static ros::ServiceServer<library_tests::LookupRequest, library_tests::LookupResponse> server("serve", serve);
  board->node.advertiseService(server);
  static ros::Subscriber<std_msgs::Int16> numbers("numbers", hearNumber);
  board->node.subscribe(numbers);
  known.push_back(lookup.id_);
  known.push_back(server.id_);
  known.push_back(subscriber<std_msgs::String>("string").id_);
  known.push_back(subscriber<library_tests::Everything>("everything").id_);
  known.push_back(subscriber<sensor_msgs::JointState>("joints").id_);
  known.push_back(subscriber<tf::tfMessage>("tf").id_);
  known.push_back(subscriber<diagnostic_msgs::DiagnosticArray>("diagnostics").id_);
  known.push_back(subscriber<nav_msgs::Odometry>("odometry").id_);
  known.push_back(subscriber<sensor_msgs::PointCloud2>("cloud").id_);
  known.push_back(subscriber<std_msgs::Float64MultiArray>("floats").id_);
  known.push_back(subscriber<std_msgs::Int64MultiArray>("longs").id_);
  known.push_back(subscriber<trajectory_msgs::JointTrajectory>("trajectory").id_);
  known.push_back(subscriber<std_msgs::Empty>("empty").id_);
  board->meet();
  board->line.silence_ms = 1;
  board->node.getHardware()->faulty = true;
  board->node.getHardware()->bytes_a_look = 16;
  const std::vector<Bytes> valid = samples(&known[0], known.size());

  for (unsigned long fed = 0; fed < wanted; ++fed) {
    Bytes bytes;
    const uint16_t id = randomBelow(8) ? known[randomBelow(static_cast<uint32_t>(known.size()))] : static_cast<uint16_t>(randomBelow(65536));
    const Bytes& sample = valid[randomBelow(static_cast<uint32_t>(valid.size()))];
    switch (randomBelow(8)) {
      case 0:
        bytes = noise(700);
        break;
      case 1:
        bytes = frame(id, noise(randomBelow(10) ? 420 : 3000));
        break;
      case 2:
        bytes = damaged(sample);
        break;
      case 3:
        bytes = Bytes(sample.begin(), sample.begin() + static_cast<long>(randomBelow(static_cast<uint32_t>(sample.size()))));
        break;
      case 4:
        bytes = sample + damaged(sample) + valid[randomBelow(static_cast<uint32_t>(valid.size()))];
        break;
      default:
        // A damaged payload in a valid frame reaches the reader.
        bytes = frame(randomBelow(8) ? static_cast<uint16_t>(sample[5] | sample[6] << 8) : id,
                      damaged(Bytes(sample.begin() + 7, sample.end() - 1)));
    }
    board->line.send(bytes);
    while (!board->line.arriving.empty()) board->node.spinOnce();
    // Each topic request ends a spin.
    while (board->node.spinOnce() != ros::SPIN_OK) continue;
    // A pause, so that the next frame is separate.
    for (uint16_t before = static_cast<uint16_t>(board->node.dropped() - 1); before != board->node.dropped();) {
      before = board->node.dropped();
      board->line.now_ms += 250;
      board->node.spinOnce();
    }
    board->node.getHardware()->faulty = board->node.getHardware()->stuck = false;
    board->line.frames.clear();
    board->line.written.clear();
    board->line.noise = 0;
    const int number = static_cast<int>(randomBelow(30000));
    const unsigned before = number_count;
    // The answer to a request for the topics has all endpoints, so this is sent rarely.
    const bool asks = fed % 16 == 0;
    board->line.send(frame(numbers.id_, Payload().u16(static_cast<uint16_t>(number))) + (asks ? frame(0) : Bytes()));
    const int result = board->node.spinOnce();
    size_t announced = 0;
    for (const Frame& got : board->line.frames) announced += got.id < 6;
    EXPECT(board->node.getHardware()->canaryIsIntact());
    if (number_count != before + 1 || last_number != number || (asks && (result != ros::SPIN_ERR || announced < known.size()))) {
      const char* outcome = number_count == before ? "lost" : last_number == number ? "delivered" : "changed";
      fprintf(stderr, "after frame %lu: a valid message was %s; topics %s, %lu of at least %lu announced; the input was\n", fed,
              outcome, asks ? "requested" : "not requested", static_cast<unsigned long>(announced),
              static_cast<unsigned long>(known.size()));
      for (uint8_t byte : bytes) fprintf(stderr, "%02x", byte);
      fprintf(stderr, "\n");
      return 1;
    }
    board->line.frames.clear();
    board->line.written.clear();
    board->node.getHardware()->faulty = true;
  }
  printf("%lu frames, %lu of them delivered, %u dropped\n", wanted, delivered, board->node.dropped());
  return 0;
}

static void header(Payload& payload) { payload.u32(7).u32(100).u32(200).text("frame"); }
static std::vector<Bytes> samples(const uint16_t* ids, size_t count) {
  std::vector<Bytes> frames;
  frames.push_back(frame(ids[0]));
  frames.push_back(frame(ids[1], Payload().u32(0).u32(2).value(1.5f).value(2.5f).u32(0)));
  frames.push_back(frame(ids[1], Payload().u32(0).u32(0).u32(1).text("value")));
  frames.push_back(frame(ids[2], Payload().u32(1700000000).u32(5)));
  frames.push_back(frame(ids[3]));
  frames.push_back(frame(ids[4], Payload().u8(1).u32(2).text("one").text("two").u32(1).u8(1).text("part").u32(1).value(1.0)));
  frames.push_back(frame(ids[5], Payload().text("thing")));
  frames.push_back(frame(ids[6], Payload().text("hello world")));
  Payload everything;
  everything.u8(1).value(0.5).value<int64_t>(-3).u32(2).u8(1).u8(0).u32(2).text("a").text("bc").u32(1).value(2.0);
  everything.u32(1).value<int64_t>(9).u32(1).value<uint64_t>(9).u32(1).u32(1).u32(2).u32(1).u32(3).u32(4);
  everything.u32(2).u8(1).text("p").u32(1).value(1.0).u8(2).text("q").u32(0).u8(1).u8(0).u8(1).text("x").text("y");
  everything.value(1.0).value(2.0).value(3.0).value<int64_t>(1).value<int64_t>(2).u8(1).text("z").u32(0).u8(2).text("").u32(0);
  everything.u32(5).u32(6).u32(2).u8(1).u8(2).u32(1).value(1.0f).u32(2).u16(1).u16(2).u32(2).u8(9);
  frames.push_back(frame(ids[7], everything));
  Payload joints;
  header(joints);
  joints.u32(2).text("left").text("right").u32(2).value(1.0).value(2.0).u32(1).value(3.0).u32(0);
  frames.push_back(frame(ids[8], joints));
  Payload transforms;
  transforms.u32(2);
  for (int i = 0; i < 2; ++i) {
    header(transforms);
    transforms.text("child");
    for (int j = 0; j < 7; ++j) transforms.value(j / 3.0);
  }
  frames.push_back(frame(ids[9], transforms));
  Payload diagnostics;
  header(diagnostics);
  diagnostics.u32(2);
  for (int i = 0; i < 2; ++i) diagnostics.u8(1).text("n").text("m").text("h").u32(2).text("k").text("v").text("k").text("v");
  frames.push_back(frame(ids[10], diagnostics));
  Payload odometry;
  header(odometry);
  odometry.text("base");
  for (int i = 0; i < 40; ++i) odometry.value(i * 1.0);
  frames.push_back(frame(ids[11], odometry));
  Payload cloud;
  header(cloud);
  cloud.u32(1).u32(2).u32(1).text("x").u32(0).u8(7).u32(1).u8(0).u32(4).u32(8).u32(8).value(1.0f).value(2.0f).u8(1);
  frames.push_back(frame(ids[12], cloud));
  frames.push_back(frame(ids[13], Payload().u32(1).text("x").u32(2).u32(1).u32(0).u32(2).value(1.0).value(2.0)));
  frames.push_back(frame(ids[14], Payload().u32(1).text("x").u32(2).u32(1).u32(0).u32(2).value<int64_t>(1).value<int64_t>(2)));
  Payload trajectory;
  header(trajectory);
  trajectory.u32(1).text("j").u32(1).u32(1).value(1.0).u32(0).u32(0).u32(0).u32(1).u32(2);
  frames.push_back(frame(ids[15], trajectory));
  frames.push_back(frame(ids[16]));
  (void)count;
  return frames;
}
