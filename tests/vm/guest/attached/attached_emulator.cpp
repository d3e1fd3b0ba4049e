// Stands in for the SDK's emulated_transport.cpp: "emulated" opens a virtual USB knob that is
// plugged into this computer, through hidapi and the kernel, so that the tests written for the
// emulated device run over USB as they are. What only the device inside the process can do throws.
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <map>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <utility>

#include "config_encoding.hpp"
#include "emulated_transport.hpp"
#include "field_check.hpp"
#include "hid_transport.hpp"
#include "session.hpp"
#include "torsio/error.hpp"
#include "virtual_knob.hpp"

namespace torsio {
namespace {

using test::VirtualKnob;

[[noreturn]] void only_in_process(const char* what) {
  throw std::logic_error(std::string(what) + " needs the device inside the process");
}

std::shared_ptr<VirtualKnob> start(const std::string& name, const EmulatorOptions& options) {
  if (options.log_truth) only_in_process("log_truth");
  const std::string serial = !options.serial.empty() ? options.serial
                             : name.empty()          ? "EMULATED"
                                                     : name;
  return std::make_shared<VirtualKnob>(
      std::vector<std::string>{"--rate-hz", number_text(options.control_rate_hz), "--seed",
                               std::to_string(options.seed), "--serial", serial});
}

/// A named knob goes on running when it is closed, and so keeps what it saved.
std::shared_ptr<VirtualKnob> find_or_start(const std::string& name,
                                           const EmulatorOptions& options) {
  static std::mutex mutex;
  static std::map<std::string, std::shared_ptr<VirtualKnob>> running;
  if (name.empty()) return start(name, options);
  const std::lock_guard lock(mutex);
  auto& knob = running[name];
  if (knob == nullptr) knob = start(name, options);
  return knob;
}

/// What hidapi's backend, whichever it is, calls the knob on a bus id.
std::string path_of(const std::string& bus_id) {
  for (const HidListing& listing : list_hid()) {
    if (listing.path.starts_with(bus_id + ":")) return listing.path;
    const std::string name = listing.path.substr(listing.path.rfind('/') + 1);
    const std::string device = "/sys/class/hidraw/" + name + "/device/../..";
    std::error_code failed;
    const auto usb = std::filesystem::canonical(device, failed);
    if (!failed && usb.filename() == bus_id) return listing.path;
  }
  throw std::runtime_error("hidapi does not list the knob at " + bus_id);
}

struct HandWriter {
  std::ostream& out;

  void write(const char* kind, const Profile& profile) const {
    out.precision(17);
    out << kind << '\n';
    for (const Knot& knot : profile) out << knot.time_s << ' ' << knot.value << '\n';
  }
  void operator()(const NoHand&) const {}
  void operator()(const TorqueHand& hand) const { write("torque_nm", hand.torque_nm); }
  void operator()(const ImpedanceHand&) const { only_in_process("ImpedanceHand"); }
  void operator()(const PrescribedMotion& hand) const { write("motion_rad", hand.angle_rad); }
};

void set_hand_of(const VirtualKnob& knob, const Hand& hand) {
  if (std::holds_alternative<NoHand>(hand)) {
    knob.say("free");
    return;
  }
  static int scripts = 0;
  const std::string path =
      "/tmp/hand-" + std::to_string(::getpid()) + "-" + std::to_string(++scripts);
  std::ofstream file(path);
  std::visit(HandWriter{file}, hand);
  file.close();
  knob.say("script " + path);
}

}  // namespace

class EmulatedWorld {
 public:
  EmulatedWorld(const std::string& name, const EmulatorOptions& options)
      : knob_(find_or_start(name, options)) {
    set_hand_of(*knob_, options.hand);
    knob_->plug();
  }
  EmulatedWorld(const EmulatedWorld&) = delete;
  EmulatedWorld& operator=(const EmulatedWorld&) = delete;
  ~EmulatedWorld() {
    if (plugged_) knob_->unplug();
  }

  void unplug() {
    knob_->unplug();
    plugged_ = false;
  }
  [[nodiscard]] const VirtualKnob& knob() const { return *knob_; }

 private:
  std::shared_ptr<VirtualKnob> knob_;
  bool plugged_ = true;
};

EmulatedConnection open_emulated(const std::string& name, const EmulatorOptions& options) {
  auto world = std::make_shared<EmulatedWorld>(name, options);
  auto transport = open_hid(path_of(world->knob().bus_id()));
  const auto set = [&](const protocol::ReportBytes& report) {
    if (!transport->set_feature(report)) throw std::runtime_error("a configuration is refused");
  };
  if (options.actuator) set(protocol::encode(to_wire(*options.actuator)));
  if (options.control) set(protocol::encode(to_wire(*options.control)));
  return {std::move(world), std::move(transport)};
}

struct Emulator::Impl {
  std::shared_ptr<EmulatedWorld> world;
  Session& session;
};

std::unique_ptr<Emulator> make_emulator(std::shared_ptr<EmulatedWorld> world, Session& session) {
  return std::make_unique<Emulator>(
      std::unique_ptr<Emulator::Impl>(new Emulator::Impl{std::move(world), session}));
}

Emulator::Emulator(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Emulator::~Emulator() = default;

void Emulator::set_hand(const Hand& hand) { set_hand_of(impl_->world->knob(), hand); }

void Emulator::advance(double duration_s) {
  impl_->session.sleep(whole_ns("duration_s", duration_s));
}

void Emulator::unplug() {
  impl_->world->unplug();
  // The kernel has let go; the thread that reads has yet to hear of it.
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
}

void Emulator::set_emergency_stop(bool pressed) {
  impl_->world->knob().say(pressed ? "emergency_stop pressed" : "emergency_stop released");
}

double Emulator::time_s() const { only_in_process("time_s"); }
std::vector<TruthSample> Emulator::truth() { only_in_process("truth"); }
void Emulator::set_actuator_fault(bool) { only_in_process("set_actuator_fault"); }
void Emulator::freeze_encoder(bool) { only_in_process("freeze_encoder"); }
void Emulator::jump_encoder(std::int32_t) { only_in_process("jump_encoder"); }
void Emulator::skip_ticks(std::uint32_t) { only_in_process("skip_ticks"); }
void Emulator::set_link_faults(const LinkFaults&) { only_in_process("set_link_faults"); }
void Emulator::cut_power_in_next_save(std::uint32_t) { only_in_process("cut_power_in_next_save"); }
ActuatorConfig matching_config(const PlantParams&) { return {}; }

}  // namespace torsio
