#include "virtual_knob.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <thread>

namespace torsio::test {
namespace {

const std::string kController = "/sys/devices/platform/vhci_hcd.0/";
constexpr int kFree = 4;  // VDEV_ST_NULL
constexpr int kUsed = 6;  // VDEV_ST_USED
constexpr int kFullSpeed = 2;
constexpr unsigned kDeviceId = 0x0001'0002;  // bus 1, device 2

/// Waits until `ready()`, but not for ever.
template <class Ready>
void wait_until(const char* what, Ready&& ready) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  while (!ready()) {
    if (std::chrono::steady_clock::now() > end) {
      throw std::runtime_error(std::string("waited in vain until ") + what);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
}

void write_file(const std::string& path, const std::string& text) {
  std::ofstream file(path);
  if (!(file << text << std::flush)) throw std::runtime_error("cannot write " + path);
}

struct Port {
  int number = -1;
  int status = 0;
  std::string bus_id;
};

/// The ports for full speed. The file's columns: hub port sta spd dev sockfd local_busid.
std::vector<Port> ports() {
  std::vector<Port> found;
  std::ifstream file(kController + "status");
  std::string line;
  while (std::getline(file, line)) {
    std::istringstream words(line);
    std::string hub, speed, device, socket;
    Port port;
    if (words >> hub >> port.number >> port.status >> speed >> device >> socket >> port.bus_id &&
        hub == "hs") {
      found.push_back(port);
    }
  }
  return found;
}

Port port(int number) {
  for (const Port& candidate : ports()) {
    if (candidate.number == number) return candidate;
  }
  throw std::runtime_error("the host controller has no port " + std::to_string(number));
}

/// Connects and imports bus id 1-1. @returns the socket
int import_knob(int tcp_port) {
  const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const int on = 1;
  (void)setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(tcp_port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  // Version 1.1.1, OP_REQ_IMPORT, status 0, and a bus id of 32 bytes.
  std::array<unsigned char, 40> request{0x01, 0x11, 0x80, 0x03, 0, 0, 0, 0, '1', '-', '1'};
  std::array<unsigned char, 320> answer{};  // 8 bytes of head, 312 of the device
  const bool imported =
      ::connect(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 &&
      ::send(socket, request.data(), request.size(), MSG_NOSIGNAL) ==
          static_cast<ssize_t>(request.size()) &&
      ::recv(socket, answer.data(), answer.size(), MSG_WAITALL) ==
          static_cast<ssize_t>(answer.size()) &&
      std::all_of(&answer[4], &answer[8], [](unsigned char byte) { return byte == 0; });
  if (imported) return socket;
  ::close(socket);
  throw std::runtime_error("the virtual knob cannot be imported");
}

}  // namespace

VirtualKnob::VirtualKnob(const std::vector<std::string>& arguments) {
  const char* program = std::getenv("TORSIO_VIRTUAL_KNOB");
  if (program == nullptr) throw std::runtime_error("TORSIO_VIRTUAL_KNOB is not set");
  int input[2];
  int output[2];
  if (::pipe2(input, O_CLOEXEC) != 0 || ::pipe2(output, O_CLOEXEC) != 0) {
    throw std::runtime_error("no pipe");
  }
  std::vector<std::string> words{program, "--port", "0", "--hand", "pushes"};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  program_ = ::fork();
  if (program_ == 0) {
    (void)::prctl(PR_SET_PDEATHSIG, SIGKILL);
    (void)::dup2(input[0], STDIN_FILENO);
    (void)::dup2(output[1], STDOUT_FILENO);
    (void)::execv(program, argv.data());
    ::_exit(127);
  }
  ::close(input[0]);
  ::close(output[1]);
  input_ = input[1];
  output_ = output[0];
  read_address();
}

VirtualKnob::~VirtualKnob() {
  if (vhci_port_ >= 0) unplug();
  ::close(input_);  // asks the program to end
  int status = 0;
  (void)::waitpid(program_, &status, 0);
  ::close(output_);
  if (status != 0) {
    (void)std::fprintf(stderr, "the virtual knob's program ended with wait status %d\n", status);
    std::abort();
  }
}

void VirtualKnob::read_address() {
  std::string line;
  for (char c = 0; c != '\n';) {
    if (::read(output_, &c, 1) != 1) throw std::runtime_error("the virtual knob does not listen");
    line += c;
  }
  if (std::sscanf(line.c_str(), "listening 127.0.0.1:%d", &tcp_port_) != 1) {
    throw std::runtime_error("the virtual knob says " + line);
  }
}

void VirtualKnob::plug() {
  const int socket = import_knob(tcp_port_);
  const auto all = ports();
  const auto free = std::ranges::find(all, kFree, &Port::status);
  if (free == all.end()) throw std::runtime_error("the host controller has no free port");
  vhci_port_ = free->number;
  std::ostringstream words;
  words << vhci_port_ << ' ' << socket << ' ' << kDeviceId << ' ' << kFullSpeed;
  write_file(kController + "attach", words.str());
  ::close(socket);  // the kernel has its own
  wait_until("the kernel has got to know the knob", [&] {
    const Port now = port(vhci_port_);
    bus_id_ = now.bus_id;
    return now.status == kUsed && is_bound(0) && is_bound(1);
  });
}

bool VirtualKnob::is_bound(int interface) const {
  const std::string name = bus_id_ + ":1." + std::to_string(interface);
  std::error_code ignored;
  for (const auto& entry :
       std::filesystem::directory_iterator("/sys/bus/usb/devices/" + name, ignored)) {
    // The last thing that the kernel's drivers do, behind all that they ask the device.
    if (std::filesystem::exists(entry.path() / "country", ignored)) return true;
  }
  return false;
}

void VirtualKnob::unplug() {
  write_file(kController + "detach", std::to_string(vhci_port_));
  const std::string device = "/sys/bus/usb/devices/" + bus_id_;
  wait_until("the kernel has let go of the knob", [&] {
    std::error_code ignored;
    return port(vhci_port_).status == kFree && !std::filesystem::exists(device, ignored);
  });
  vhci_port_ = -1;
}

void VirtualKnob::say(const std::string& line) const {
  const std::string text = line + "\n";
  if (::write(input_, text.data(), text.size()) != static_cast<ssize_t>(text.size())) {
    throw std::runtime_error("the virtual knob does not listen any more");
  }
}

}  // namespace torsio::test
