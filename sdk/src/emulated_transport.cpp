#include "emulated_transport.hpp"

#include <algorithm>
#include <cctype>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <map>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <utility>

#include "conversion/configuration.hpp"
#include "conversion/field_check.hpp"
#include "emulator/emulated_device.hpp"
#include "process.hpp"
#include "session.hpp"
#include "torsio/error.hpp"

namespace torsio {
namespace {

using std::chrono::steady_clock;
using namespace std::chrono_literals;

// Named devices -----------------------------------------------------------------------------------

struct NamedDevice {
  bool open = false;
  device::StoredSlots stored = device::empty_slots();
};

struct Registry {
  std::mutex mutex;
  std::map<std::string, NamedDevice> devices;
};

Registry& registry() {
  // Never destroyed: a knob in static storage may be closed after everything else.
  static Registry& instance = *new Registry;
  return instance;
}

/// A named device's claim on its name, while it is open.
class Claim {
 public:
  explicit Claim(std::string name) : name_(std::move(name)) {
    if (name_.empty()) return;
    const bool usable = name_.size() <= 16 && std::ranges::all_of(name_, [](unsigned char c) {
                          return std::isalnum(c) != 0 || c == '-' || c == '_' || c == '.';
                        });
    if (!usable) {
      throw InvalidArgument("\"" + name_ +
                            "\" cannot name an emulated knob: use 1 to 16 letters, digits, '-', "
                            "'_' and '.'");
    }
    Registry& all = registry();
    const std::lock_guard lock(all.mutex);
    if (std::exchange(all.devices[name_].open, true)) {
      throw DeviceBusy("emulated:" + name_ + " is open already; close it there first");
    }
  }
  Claim(const Claim&) = delete;
  Claim& operator=(const Claim&) = delete;
  ~Claim() { release(nullptr); }

  [[nodiscard]] device::StoredSlots stored() const {
    if (name_.empty()) return device::empty_slots();
    Registry& all = registry();
    const std::lock_guard lock(all.mutex);
    return all.devices[name_].stored;
  }

  void release(const device::StoredSlots* stored) {
    if (name_.empty()) return;
    Registry& all = registry();
    const std::lock_guard lock(all.mutex);
    NamedDevice& device = all.devices[name_];
    device.open = false;
    if (stored != nullptr) device.stored = *stored;
    name_.clear();
  }

 private:
  std::string name_;
};

// From the user's structures to the emulator's -------------------------------------------------

std::int64_t control_period_ns(double rate_hz) {
  if (!(rate_hz >= 1e3 && rate_hz <= 20e3)) {
    throw InvalidArgument("control_rate_hz is " + number_text(rate_hz) +
                          ", allowed are 1000 to 20000 Hz");
  }
  return std::llround(1e9 / rate_hz);
}

emulator::EmulatedDeviceOptions to_emulator(const EmulatorOptions& in, const std::string& name,
                                            const device::StoredSlots& stored) {
  emulator::EmulatedDeviceOptions out;
  out.seed = in.seed;
  out.control_period_ns = control_period_ns(in.control_rate_hz);
  out.plant = in.plant;
  out.encoder = emulator::encoder_of(in.plant);
  out.hand = emulator::take_hold(in.hand);
  out.serial = !in.serial.empty() ? in.serial : !name.empty() ? name : "EMULATED";
  out.stored = stored;
  if (in.actuator) out.actuator = conversion::to_wire(*in.actuator);
  if (in.control) out.control = conversion::to_wire(*in.control);
  if (in.board) out.board = conversion::to_wire(*in.board);
  if (in.game) out.game = conversion::to_wire(*in.game);
  out.log_truth = in.log_truth;
  out.log_inputs = in.log_inputs;
  return out;
}

/// Runs `make`; what the emulator finds wrong is the user's mistake, or that of the user's hand.
template <class Make>
auto checked(Make&& make) {
  try {
    return make();
  } catch (const Error&) {
    throw;
  } catch (const std::runtime_error& error) {
    throw Error(error.what());
  } catch (const std::invalid_argument& error) {
    throw InvalidArgument(error.what());
  }
}

constexpr const char* kNoElectrics =
    "this emulated knob has no electrics: open it with a plant that names them in its "
    "EmulatorOptions";

// The world ---------------------------------------------------------------------------------------

/// The emulated device and who may touch it when: transport and emulator handle share it.
class EmulatedWorld {
 public:
  EmulatedWorld(const std::string& name, const EmulatorOptions& options)
      : claim_(name),
        paced_(options.paced),
        logs_truth_(options.log_truth),
        logs_inputs_(options.log_inputs),
        device_(checked([&] {
          return std::make_unique<emulator::EmulatedDevice>(
              to_emulator(options, name, claim_.stored()));
        })) {
    if (paced_) pacer_ = std::thread([this] { run_paced(); });
  }
  EmulatedWorld(const EmulatedWorld&) = delete;
  EmulatedWorld& operator=(const EmulatedWorld&) = delete;
  ~EmulatedWorld() { close(); }

  void close() noexcept {
    {
      const std::lock_guard lock(mutex_);
      if (std::exchange(closed_, true)) return;
      claim_.release(&device_->stored());
    }
    news_.notify_all();
    if (pacer_.joinable()) pacer_.join();
  }

  /// Calls `use(device)` while nobody else touches it. @throws Closed
  template <class Use>
  auto with_device(Use&& use) const {
    throw_unless_here();
    const std::lock_guard lock(mutex_);
    throw_if_closed();
    throw_if_failed();
    return use(*device_);
  }

  /// As above; waits until `ready(device)` or the time is over. @returns false if it is over
  template <class Ready>
  bool wait(std::chrono::nanoseconds timeout, Ready&& ready) const {
    throw_unless_here();
    std::unique_lock lock(mutex_);
    return news_.wait_for(lock, timeout, [&] {
      throw_if_closed();
      throw_if_failed();
      return ready(*device_);
    });
  }

  void notify() const { news_.notify_all(); }
  [[nodiscard]] bool paced() const { return paced_; }
  [[nodiscard]] bool logs_truth() const { return logs_truth_; }
  [[nodiscard]] bool logs_inputs() const { return logs_inputs_; }

 private:
  void throw_unless_here() const {
    if (process_.is_this()) return;
    throw Closed("the emulated knob belongs to the process that this one was forked from");
  }

  void throw_if_closed() const {
    if (closed_) throw Closed("the emulated knob was closed; open it again");
  }

  void throw_if_failed() const {
    if (!failure_.empty()) throw Error(failure_);
  }

  void run_paced() {
    constexpr auto kFrame = std::chrono::nanoseconds(emulator::UsbLink::kFrameNs);
    constexpr auto kHopelesslyLate = 50ms;
    auto next = steady_clock::now();
    std::unique_lock lock(mutex_);
    while (!closed_) {
      try {
        device_->advance(kFrame.count());
      } catch (const std::exception& error) {
        failure_ = error.what();  // for whoever calls next
        news_.notify_all();
        return;
      }
      news_.notify_all();
      next += kFrame;
      // A machine that slept must not make the world race.
      const auto now = steady_clock::now();
      if (now - next > kHopelesslyLate) next = now;
      news_.wait_until(lock, next, [&] { return closed_ || steady_clock::now() >= next; });
    }
  }

  const MakersProcess process_;
  Claim claim_;
  const bool paced_;
  const bool logs_truth_;
  const bool logs_inputs_;
  mutable std::mutex mutex_;
  mutable std::condition_variable news_;
  std::unique_ptr<emulator::EmulatedDevice> device_;
  bool closed_ = false;
  std::string failure_;  // why time does not go on
  std::thread pacer_;
};

// The transport -----------------------------------------------------------------------------------

class EmulatedTransport final : public Transport {
 public:
  explicit EmulatedTransport(std::shared_ptr<EmulatedWorld> world) : world_(std::move(world)) {}

  void close() noexcept override { world_->close(); }

  bool write(const ReportBytes& report) override {
    bool written = false;
    const auto try_to_write = [&](emulator::EmulatedDevice& device) {
      throw_unless_connected(device);
      return written = device.write(report);
    };
    if (!world_->paced()) return world_->with_device(try_to_write);
    // As a driver does: the caller waits for its turn on the bus.
    world_->wait(1s, try_to_write);
    return written;
  }

  bool read(ReportBytes& report, std::chrono::nanoseconds timeout) override {
    const auto try_to_read = [&](emulator::EmulatedDevice& device) {
      if (device.read(report)) return true;
      throw_unless_connected(device);
      return false;
    };
    return world_->paced() ? world_->wait(timeout, try_to_read) : world_->with_device(try_to_read);
  }

  bool get_feature(std::uint8_t id, ReportBytes& report) override {
    return world_->with_device([&](emulator::EmulatedDevice& device) {
      throw_unless_connected(device);
      return device.get_feature(id, report) == protocol::Status::ok;
    });
  }

  bool set_feature(const ReportBytes& report) override {
    return world_->with_device([&](emulator::EmulatedDevice& device) {
      throw_unless_connected(device);
      return device.set_feature(report).ok();
    });
  }

  bool time_is_virtual() const override { return !world_->paced(); }

  std::int64_t now_ns() const override {
    if (world_->paced()) return Transport::now_ns();
    return world_->with_device([](emulator::EmulatedDevice& device) { return device.time_ns(); });
  }

  void advance_to(std::int64_t time_ns) override {
    world_->with_device([&](emulator::EmulatedDevice& device) {
      try {
        device.advance(std::max<std::int64_t>(time_ns - device.time_ns(), 0));
      } catch (const std::runtime_error& error) {
        throw Error(error.what());
      }
    });
  }

 private:
  static void throw_unless_connected(const emulator::EmulatedDevice& device) {
    if (device.connected()) return;
    throw Disconnected(
        "the emulated knob is gone: it was unplugged or lost its power; open it again");
  }

  std::shared_ptr<EmulatedWorld> world_;
};

// The user's handles ------------------------------------------------------------------------------

class EmulatedGamePort final : public GamePort {
 public:
  explicit EmulatedGamePort(std::shared_ptr<EmulatedWorld> world) : world_(std::move(world)) {}

  void write(std::span<const std::uint8_t> report) override {
    world_->with_device([&](auto& device) { (void)device.game_write(report); });
  }

  std::vector<std::uint8_t> read() override {
    return world_->with_device([](auto& device) { return device.game_read(); });
  }

  bool set_feature(std::span<const std::uint8_t> report) override {
    return world_->with_device([&](auto& device) { return device.game_set_feature(report); });
  }

  std::vector<std::uint8_t> get_feature(std::uint8_t report_id) override {
    return world_->with_device([&](auto& device) { return device.game_get_feature(report_id); });
  }

  void set_buttons(std::uint8_t pressed) override {
    world_->with_device([&](auto& device) { device.set_buttons(pressed); });
  }

 private:
  std::shared_ptr<EmulatedWorld> world_;
};

class EmulatedWorldHandle final : public Emulator {
 public:
  EmulatedWorldHandle(std::shared_ptr<EmulatedWorld> world, Session& session)
      : world_(std::move(world)), session_(session), game_(world_) {}

  void set_hand(const Hand& hand) override {
    world_->with_device([&](emulator::EmulatedDevice& device) {
      checked([&] { device.set_hand(emulator::take_hold(hand, device.next_tick_ns())); });
    });
  }

  double time_s() const override {
    return 1e-9 * static_cast<double>(world_->with_device(
                      [](emulator::EmulatedDevice& device) { return device.time_ns(); }));
  }

  void advance(double duration_s) override { session_.sleep(whole_ns("duration_s", duration_s)); }

  std::vector<TruthSample> truth() override {
    if (!world_->logs_truth()) {
      throw Error(
          "this emulated knob keeps no log of the truth: open it with log_truth set in its "
          "EmulatorOptions");
    }
    const std::vector<emulator::TruthSample> log =
        world_->with_device([](emulator::EmulatedDevice& device) { return device.take_truth(); });
    std::vector<TruthSample> truth;
    truth.reserve(log.size());
    for (const emulator::TruthSample& sample : log) {
      truth.push_back({.time_s = 1e-9 * static_cast<double>(sample.time_ns),
                       .angle_rad = sample.angle_rad,
                       .brake_angle_rad = sample.brake_angle_rad,
                       .speed_rad_s = sample.speed_rad_s,
                       .spring_torque_nm = sample.torque.spring_torque_nm,
                       .brake_torque_nm = sample.torque.brake_torque_nm,
                       .brake_capacity_nm = sample.torque.brake_capacity_nm,
                       .motor_torque_nm = sample.torque.motor_torque_nm,
                       .hand_torque_nm = sample.torque.hand_torque_nm});
    }
    return truth;
  }

  std::vector<DeviceInput> inputs() override {
    if (!world_->logs_inputs()) {
      throw Error(
          "this emulated knob keeps no log of its inputs: open it with log_inputs set in its "
          "EmulatorOptions");
    }
    std::vector<emulator::DeviceInput> log =
        world_->with_device([](emulator::EmulatedDevice& device) { return device.take_inputs(); });
    std::vector<DeviceInput> inputs;
    inputs.reserve(log.size());
    for (emulator::DeviceInput& input : log) {
      const auto kind = static_cast<std::size_t>(input.kind);
      inputs.push_back({.tick = input.tick,
                        .kind = std::string(emulator::kInputKinds.at(kind)),
                        .bytes = std::move(input.bytes)});
    }
    return inputs;
  }

  ElectricsState electrics() const override {
    return world_->with_device([](emulator::EmulatedDevice& device) {
      const emulator::Circuit* circuit = device.circuit();
      if (circuit == nullptr) throw Error(kNoElectrics);
      return circuit->state(device.plant());
    });
  }

  GamePort& game() override { return game_; }

  void unplug() override {
    world_->with_device([](emulator::EmulatedDevice& device) { device.set_plugged(false); });
    world_->notify();
  }

  void set_emergency_stop(bool pressed) override {
    world_->with_device([&](auto& device) { device.set_emergency_stop(pressed); });
  }

  void set_actuator_fault(bool present) override {
    world_->with_device([&](auto& device) { device.set_actuator_fault(present); });
  }

  void set_current_sensor(CurrentSensorState state) override {
    world_->with_device([&](auto& device) {
      if (device.circuit() == nullptr) throw Error(kNoElectrics);
      device.set_current_sensor(state);
    });
  }

  void set_supply(double supply_v) override {
    world_->with_device([&](auto& device) {
      if (device.circuit() == nullptr) throw Error(kNoElectrics);
      checked([&] { device.set_supply(supply_v); });
    });
  }

  void freeze_encoder(bool frozen) override {
    world_->with_device([&](auto& device) { device.freeze_encoder(frozen); });
  }

  void jump_encoder(std::int32_t counts) override {
    world_->with_device([&](auto& device) { device.jump_encoder(counts); });
  }

  void skip_ticks(std::uint32_t count) override {
    world_->with_device([&](auto& device) { device.skip_ticks(count); });
  }

  void set_link_faults(const LinkFaults& faults) override {
    world_->with_device([&](auto& device) {
      checked([&] {
        device.set_link_faults({.drop_output = faults.drop_output,
                                .corrupt_output = faults.corrupt_output,
                                .drop_input = faults.drop_input,
                                .corrupt_input = faults.corrupt_input});
      });
    });
  }

  void cut_power_in_next_save(std::uint32_t after_bytes) override {
    world_->with_device([&](auto& device) { device.cut_power_in_next_save(after_bytes); });
  }

 private:
  std::shared_ptr<EmulatedWorld> world_;
  Session& session_;
  EmulatedGamePort game_;
};

}  // namespace

bool has_emulator() noexcept { return true; }

Connection open_emulated(const std::string& name, const EmulatorOptions& options) {
  auto world = std::make_shared<EmulatedWorld>(name, options);
  Connection connection;
  connection.transport = std::make_unique<EmulatedTransport>(world);
  connection.make_emulator = [world](Session& session) {
    return std::make_unique<EmulatedWorldHandle>(world, session);
  };
  return connection;
}

}  // namespace torsio
