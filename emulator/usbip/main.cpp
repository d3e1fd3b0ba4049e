// torsio_virtual_knob: a knob as a USB device without hardware, in real time, over USB/IP. Its
// output is for programs: docs/reference/usb.md lists the lines.
#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <climits>
#include <cmath>
#include <csignal>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iostream>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "emulator/usbip/hands.hpp"
#include "emulator/usbip/options.hpp"
#include "emulator/usbip/pacer.hpp"
#include "emulator/usbip/server.hpp"
#include "emulator/usbip/storage.hpp"
#include "emulator/usbip/truth_log.hpp"
#include "emulator/usbip/usb_knob.hpp"

namespace torsio::emulator::usbip {
namespace {

using std::chrono::steady_clock;
constexpr int kBadUsage = 2;
constexpr int kFailure = 1;
constexpr int kFramesPerStatus = 100;
constexpr int kFramesPerSecond = 1000;

volatile std::sig_atomic_t stop = 0;

void on_signal(int) { stop = 1; }

void stop_on_signals() {
  struct sigaction action{};
  action.sa_handler = on_signal;
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) (void)sigaction(signal, &action, nullptr);
  // The reader of our lines may go before us.
  (void)std::signal(SIGPIPE, SIG_IGN);
}

/// A line for the reader of standard output. The knob does not wait for the reader. Lines that do
/// not go out at once wait; when too many wait, new ones are left out.
class Teller {
 public:
  void tell(const std::string& line) {
    constexpr std::size_t kMostWaiting = std::size_t{1} << 16U;
    if (waiting_.size() < kMostWaiting) waiting_ += line + "\n";
    flush();
  }

  void flush() {
    while (!waiting_.empty()) {
      pollfd out{.fd = STDOUT_FILENO, .events = POLLOUT, .revents = 0};
      if (::poll(&out, 1, 0) <= 0 || (out.revents & POLLOUT) == 0) return;
      // As much as a pipe takes without waiting once it can be written to. A terminal or a file
      // may be shared, so that it is not ours to make it non-blocking.
      const std::size_t size = std::min<std::size_t>(waiting_.size(), PIPE_BUF);
      const ssize_t written = ::write(STDOUT_FILENO, waiting_.data(), size);
      if (written < 0 && errno == EINTR) continue;
      if (written <= 0) {
        waiting_.clear();  // nobody reads any more
        return;
      }
      waiting_.erase(0, static_cast<std::size_t>(written));
    }
  }

 private:
  std::string waiting_;
};

Teller teller;

void tell(const std::string& line) { teller.tell(line); }

void say(const char* what, const std::string& sentence) {
  std::cerr << "torsio_virtual_knob: " << what << ": " << sentence << std::endl;
}

Hand first_hand(const std::string& choice) {
  if (choice == "still") return still_hand();
  const std::string scripted = "scripted:";
  if (!choice.starts_with(scripted)) return NoHand{};
  const std::string path = choice.substr(scripted.size());
  std::ifstream script(path);
  if (!script) throw BadOption(path + ": cannot be read: " + std::strerror(errno));
  return read_hand(script, path);
}

/// Lines from standard input, as they come.
class Commands {
 public:
  Commands() { (void)fcntl(STDIN_FILENO, F_SETFL, fcntl(STDIN_FILENO, F_GETFL) | O_NONBLOCK); }

  /// @returns false when no more will come
  template <class Use>
  bool read(Use&& use) {
    constexpr std::size_t kLongestLine = 4096;
    char bytes[1024];
    const ssize_t count = ::read(STDIN_FILENO, bytes, sizeof bytes);
    if (count < 0) return errno == EAGAIN || errno == EINTR;
    if (count == 0) return false;
    text_.append(bytes, static_cast<std::size_t>(count));
    std::size_t begin = 0;
    for (std::size_t end; (end = text_.find('\n', begin)) != std::string::npos; begin = end + 1) {
      use(std::string_view(text_).substr(begin, end - begin));
    }
    text_.erase(0, begin);
    if (text_.size() > kLongestLine) text_.clear();
    return true;
  }

 private:
  std::string text_;
};

const char* name_of(protocol::State state) {
  switch (state) {
    case protocol::State::disarmed:
      return "disarmed";
    case protocol::State::armed:
      return "armed";
    case protocol::State::fault:
      return "fault";
  }
  return "unknown";
}

void tell_status(EmulatedDevice& device) {
  const Truth truth = device.plant().truth();
  char line[160];
  (void)std::snprintf(line, sizeof line, "status %.3f %s %.6f %.6f %.6f %.6f",
                      1e-9 * static_cast<double>(device.time_ns()),
                      name_of(device.device().state()), device.plant().state().knob_angle_rad(),
                      truth.motor_torque_nm + 0.0, truth.brake_torque_nm + 0.0,
                      truth.hand_torque_nm + 0.0);  // no minus before a zero
  tell(line);
}

class Program {
 public:
  explicit Program(const ProgramOptions& options)
      : options_(options),
        storage_(options.storage.empty() ? std::nullopt : std::optional<Storage>(options.storage)),
        knob_({.seed = options.seed,
               .control_period_ns = std::llround(1e9 / options.rate_hz),
               .hand = first_hand(options.hand),
               .serial = options.serial,
               .stored = storage_ ? storage_->slots() : device::empty_slots(),
               .log_truth = !options.log.empty()}),
        hands_(knob_.device()),
        server_(knob_.exported(), options.address, options.port, tell) {
    if (!options.log.empty()) log_.emplace(options.log);
    if (options.commands) commands_.emplace();
    if (!is_loopback(options.address)) {
      say("warning", "anybody who reaches " + options.address +
                         " can use this knob; USB/IP has no password and no encryption");
    }
  }

  void run() {
    tell("listening " + options_.address + ":" + std::to_string(server_.port()) + " " +
         std::string(knob_.exported().record.bus_id));
    Pacer pacer(steady_clock::now());
    bool more = true;
    while (stop == 0 && more) {
      const auto wait = pacer.until_next(steady_clock::now());
      // Bring world and clock to this moment before each request.
      const auto go_on = [&] {
        knob_.go_on(std::chrono::nanoseconds(pacer.in_frame(steady_clock::now())).count());
      };
      const bool has_input = server_.serve(wait, commands_ ? STDIN_FILENO : -1, go_on);
      if (has_input) more = commands_->read([this](std::string_view line) { follow(line); });
      if (pacer.take(steady_clock::now())) frame(pacer);
    }
    if (log_) log_->flush();
    keep_storage();
  }

 private:
  /// A fault is said once, not with each try.
  void keep_storage() {
    if (!storage_) return;
    const std::string fault = storage_->keep(knob_.device().stored());
    if (!fault.empty() && fault != storage_fault_) say("warning", fault);
    storage_fault_ = fault;
  }

  void follow(std::string_view line) {
    static constexpr std::pair<std::string_view, void (HostController::*)()> kOfTheBus[] = {
        {"suspend", &HostController::suspend},
        {"reset", &HostController::reset},
        {"resume", &HostController::resume}};
    for (const auto& [word, call] : kOfTheBus) {
      if (line == word) return (knob_.host().*call)();
    }
    if (line == "unplug") {
      knob_.exported().available = false;
      server_.disconnect();
    } else if (line == "plug") {
      knob_.exported().available = true;
    } else if (line == "emergency_stop pressed" || line == "emergency_stop released") {
      knob_.device().set_emergency_stop(line.ends_with("pressed"));
    } else if (line.size() == 9 && line.starts_with("buttons ") && line[8] >= '0' &&
               line[8] <= '3') {
      knob_.device().set_buttons(static_cast<std::uint8_t>(line[8] - '0'));
    } else if (!hands_.follow(line)) {
      say("warning", "cannot follow \"" + std::string(line.substr(0, 80)) + "\"");
    }
  }

  void frame(Pacer& pacer) {
    knob_.advance();
    server_.frame();
    if (log_) log_->add(knob_.device().take_truth());
    if (knob_.has_host() != had_host_) {
      had_host_ = !had_host_;
      tell(had_host_ ? "configured" : "unconfigured");
    }
    teller.flush();
    ++frames_;
    // A failed write is tried again once a second.
    if (storage_fault_.empty() || frames_ % kFramesPerSecond == 0) keep_storage();
    if (options_.status && frames_ % kFramesPerStatus == 0) tell_status(knob_.device());
    if (frames_ % kFramesPerSecond != 0) return;
    if (log_) log_->flush();
    const auto slipped = std::chrono::round<std::chrono::milliseconds>(pacer.take_slipped());
    if (slipped.count() > 0) tell("slipped " + std::to_string(slipped.count()));
  }

  ProgramOptions options_;
  std::optional<Storage> storage_;
  std::string storage_fault_;
  UsbKnob knob_;
  HandCommands hands_;
  Server server_;
  std::optional<TruthLog> log_;
  std::optional<Commands> commands_;
  bool had_host_ = false;
  std::uint64_t frames_ = 0;
};

int run(const std::vector<std::string_view>& arguments) {
  try {
    const ProgramOptions options = read_options(arguments);
    if (options.help) {
      std::cout << usage();
      return 0;
    }
    stop_on_signals();
    Program program(options);
    program.run();
    return 0;
  } catch (const std::invalid_argument& error) {
    say("error", error.what());
    return kBadUsage;
  } catch (const std::exception& error) {
    say("error", error.what());
    return kFailure;
  }
}

}  // namespace
}  // namespace torsio::emulator::usbip

int main(int count, char** arguments) {
  return torsio::emulator::usbip::run({arguments + 1, arguments + count});
}
