// A pen for tests of Studio at a true window: tells the driver `inputtest` of an X server (inputtestdrv(4)) what a
// hand does. Each line of the standard input is one of
//   move X Y PRESSURE   X and Y in pixels of a display of 1280 by 800, PRESSURE from 0 to 1
//   press, release      the first button
//   pen SOCKET
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <iostream>
#include <stdexcept>
#include <string>

namespace {

enum Message : std::uint32_t { version = 0, motion = 2, button = 4 };

constexpr double kAxisEnd = 65535;     // X and Y of the driver
constexpr double kPressureEnd = 1000;  // and of its axis "Abs Pressure"
constexpr std::size_t kPressureAxis = 4;

struct Header {
  std::uint32_t length;
  std::uint32_t message;
};

struct Valuators {
  std::uint32_t has_unaccelerated = 0;
  std::array<std::uint8_t, 8> mask{};
  alignas(8) std::array<double, 64> values{};
  std::array<double, 64> unaccelerated{};
};

struct Version {
  Header header{sizeof(Version), version};
  std::uint16_t major = 1;
  std::uint16_t minor = 1;
};

struct Motion {
  Header header{sizeof(Motion), motion};
  std::uint32_t is_absolute = 1;
  alignas(8) Valuators valuators;
};

struct Button {
  Header header{sizeof(Button), button};
  std::int32_t is_absolute = 1;
  std::int32_t number = 1;
  std::uint32_t is_press = 0;
  alignas(8) Valuators valuators;
};

static_assert(sizeof(Version) == 12 && sizeof(Motion) == 1056 && sizeof(Button) == 1064, "as the driver has them");

class Server {
 public:
  explicit Server(const std::string& path) : socket_(::socket(AF_UNIX, SOCK_STREAM, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    if (path.size() >= sizeof(address.sun_path)) throw std::runtime_error("the socket's path is too long");
    std::memcpy(address.sun_path, path.c_str(), path.size());
    if (::connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0) {
      throw std::runtime_error("no X server listens at " + path);
    }
    tell(Version());
  }
  ~Server() { ::close(socket_); }
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  // Only the version is answered.
  template <class What>
  void tell(const What& what) {
    if (::write(socket_, &what, sizeof(what)) != static_cast<ssize_t>(sizeof(what))) throw std::runtime_error("write");
    if (what.header.message != version) return;
    Header answer{};
    if (::recv(socket_, &answer, sizeof(answer), MSG_WAITALL) != static_cast<ssize_t>(sizeof(answer))) {
      throw std::runtime_error("the X server does not answer");
    }
    std::array<char, 64> rest{};
    const std::size_t more = answer.length - sizeof(answer);
    if (more > 0 && ::recv(socket_, rest.data(), more, MSG_WAITALL) != static_cast<ssize_t>(more)) {
      throw std::runtime_error("half an answer");
    }
  }

 private:
  int socket_;
};

void carry_out(Server& server, const std::string& word) {
  if (word == "move") {
    Motion motion;
    double x = 0;
    double y = 0;
    double pressure = 0;
    std::cin >> x >> y >> pressure;
    motion.valuators.mask[0] = 1U | 2U | 1U << kPressureAxis;
    motion.valuators.values[0] = x / 1280 * kAxisEnd;
    motion.valuators.values[1] = y / 800 * kAxisEnd;
    motion.valuators.values[kPressureAxis] = pressure * kPressureEnd;
    server.tell(motion);
  } else if (word == "press" || word == "release") {
    Button button;
    button.is_press = word == "press" ? 1 : 0;
    server.tell(button);
  } else {
    throw std::runtime_error("unknown word " + word);
  }
}

}  // namespace

int main(int count, char** words) {
  try {
    if (count != 2) throw std::runtime_error("pen SOCKET");
    Server server(words[1]);
    for (std::string word; std::cin >> word;) carry_out(server, word);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "pen: %s\n", error.what());
    return 1;
  }
  return 0;
}
