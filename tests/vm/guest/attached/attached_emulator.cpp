// Stands in for the SDK's sdk/src/emulated/: "emulated" opens a virtual USB knob that is
// plugged into this computer, through hidapi and the kernel, so that the tests written for the
// emulated device run over USB as they are. Calls that only a device inside the process can serve
// throw.
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

#include "conversion/configuration.hpp"
#include "conversion/field_check.hpp"
#include "emulated_transport.hpp"
#include "hid_transport.hpp"
#include "link.hpp"
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
  if (options.log_inputs) only_in_process("log_inputs");
  const std::string serial = !options.serial.empty() ? options.serial
                             : name.empty()          ? "EMULATED"
                                                     : name;
  return std::make_shared<VirtualKnob>(
      std::vector<std::string>{"--rate-hz", number_text(options.control_rate_hz), "--seed",
                               std::to_string(options.seed), "--serial", serial});
}

/// A named knob goes on running when it is closed, and so keeps its saved configuration.
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

/// The knob's name on a bus id in hidapi's present backend.
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
  void operator()(const FeedbackHand&) const { only_in_process("FeedbackHand"); }
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

class AttachedKnob {
 public:
  AttachedKnob(const std::string& name, const EmulatorOptions& options)
      : knob_(find_or_start(name, options)) {
    set_hand_of(*knob_, options.hand);
    knob_->plug();
  }
  AttachedKnob(const AttachedKnob&) = delete;
  AttachedKnob& operator=(const AttachedKnob&) = delete;
  ~AttachedKnob() {
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

class AttachedEmulator final : public Emulator {
 public:
  AttachedEmulator(std::shared_ptr<AttachedKnob> attached, Link& link)
      : attached_(std::move(attached)), link_(link) {}

  void set_hand(const Hand& hand) override { set_hand_of(attached_->knob(), hand); }

  void advance(double duration_s) override { link_.sleep(whole_ns("duration_s", duration_s)); }

  void unplug(double after_s) override {
    if (after_s > 0.0) only_in_process("unplug at a later moment");
    attached_->unplug();
    // The kernel has let go; the thread that reads has yet to hear of it.
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }

  void set_emergency_stop(bool pressed) override {
    attached_->knob().say(pressed ? "emergency_stop pressed" : "emergency_stop released");
  }

  double time_s() const override { only_in_process("time_s"); }
  std::vector<TruthSample> truth() override { only_in_process("truth"); }
  std::vector<DeviceInput> inputs() override { only_in_process("inputs"); }
  void set_actuator_fault(bool) override { only_in_process("set_actuator_fault"); }
  ElectricsState electrics() const override { only_in_process("electrics"); }
  void set_current_sensor(CurrentSensorState) override { only_in_process("set_current_sensor"); }
  void set_supply(double) override { only_in_process("set_supply"); }
  void freeze_encoder(bool) override { only_in_process("freeze_encoder"); }
  void jump_encoder(std::int32_t) override { only_in_process("jump_encoder"); }
  void skip_ticks(std::uint32_t) override { only_in_process("skip_ticks"); }
  void set_link_faults(const LinkFaults&) override { only_in_process("set_link_faults"); }
  void cut_power_in_next_save(std::uint32_t) override { only_in_process("cut_power_in_next_save"); }

  // The games' interface is the kernel's here.
  GamePort& game() override { only_in_process("game"); }

 private:
  std::shared_ptr<AttachedKnob> attached_;
  Link& link_;
};

}  // namespace

bool has_emulator() noexcept { return true; }

Connection open_emulated(const std::string& name, const EmulatorOptions& options) {
  auto attached = std::make_shared<AttachedKnob>(name, options);
  auto transport = open_hid(path_of(attached->knob().bus_id()));
  const auto set = [&](const protocol::ReportBytes& report) {
    if (!transport->set_feature(report)) throw std::runtime_error("a configuration is refused");
  };
  if (options.actuator) set(protocol::encode(conversion::to_wire(*options.actuator)));
  if (options.control) set(protocol::encode(conversion::to_wire(*options.control)));
  Connection connection;
  connection.transport = std::move(transport);
  connection.make_emulator = [attached](Link& link) {
    return std::make_unique<AttachedEmulator>(attached, link);
  };
  return connection;
}

}  // namespace torsio
