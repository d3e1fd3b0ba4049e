/// @file
/// The way to one device: reports out and in, signs of life, and waiting, in real and in virtual
/// time.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "process.hpp"
#include "protocol/codec.hpp"
#include "torsio/telemetry.hpp"
#include "torsio/transport.hpp"

namespace torsio {

// Full-speed USB carries a report each way once in so long.
inline constexpr std::int64_t kFrameNs = 1'000'000;

[[noreturn]] void throw_late(const std::string& what, std::int64_t timeout_ns);

/// Where time is real one reader thread takes in what the device sends. Where it is virtual the
/// thread that waits does, frame by frame, so that the same calls always give the same result.
///
/// Its one lock guards all that both sides touch, also what the session's other parts know. It is
/// held neither while the transport writes nor while the user's code is called. Every member may be
/// called from any thread; those that ask for Locked only with the lock, all others only without.
class Link {
 public:
  /// Has the lock while it lives.
  class Locked {
   private:
    friend class Link;
    explicit Locked(std::mutex& mutex) : lock_(mutex) {}
    std::unique_lock<std::mutex> lock_;
  };

  /// Gets what comes.
  class Receiver {
   public:
    Receiver() = default;
    Receiver(const Receiver&) = delete;
    Receiver& operator=(const Receiver&) = delete;
    virtual ~Receiver() = default;

    /// @returns false if the report makes no sense
    virtual bool take(const Locked& locked, const protocol::ReportBytes& report) = 0;
    /// The device is gone.
    virtual void lose(const Locked& locked) = 0;
    /// True while the device waits for signs of life.
    [[nodiscard]] virtual bool is_armed(const Locked& locked) const = 0;
    /// A frame of virtual time has passed.
    virtual void tell() = 0;
  };

  /// While it lives nobody asks the user: what ends a call must not be ended itself.
  class Unasked {
   public:
    explicit Unasked(Link& link) : link_(link) { ++link_.unasked_; }
    Unasked(const Unasked&) = delete;
    Unasked& operator=(const Unasked&) = delete;
    ~Unasked() { --link_.unasked_; }

   private:
    Link& link_;
  };

  Link(std::unique_ptr<Transport> transport, std::function<bool()> interrupted, Receiver& receiver);
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;
  ~Link();

  /// From here on the receiver gets what comes.
  void start();
  /// From here on all calls throw Closed, and the receiver gets nothing. Waits for the transport's
  /// read, but not for ever.
  void stop() noexcept;
  /// Lets go of the device, after stop(). If read has not come back, that happens when it does.
  void let_go() noexcept;
  /// True after stop() if read has not come back: then nothing of the session may be destroyed.
  [[nodiscard]] bool is_held() const noexcept;
  /// Waits until another thread has let go.
  void wait_until_let_go() noexcept;

  [[nodiscard]] bool is_open() const noexcept { return is_here() && !stopped_; }
  /// False in a child that was forked: nothing else of the session may be used or destroyed there.
  [[nodiscard]] bool is_here() const noexcept { return process_.is_this(); }
  void throw_unless_here() const;

  // Out and in ---------------------------------------------------------------------------------

  /// Sends a report. Waits for room. @throws Timeout if there is none in time, Disconnected, Closed
  void write(const protocol::ReportBytes& report, std::int64_t timeout_ns);
  /// Sends a report to a device that may be gone, and asks nobody before. A way that gives nothing
  /// may still take. @returns false if it has no room; throws what the transport does
  bool write_blindly(const protocol::ReportBytes& report);
  /// @returns false if the device stalls; both throw Disconnected, Closed
  bool set_feature(const protocol::ReportBytes& report);
  bool get_feature(std::uint8_t id, protocol::ReportBytes& report);

  /// See Knob::tap(). @param begin what it has already
  [[nodiscard]] std::shared_ptr<ReportTap> tap(bool with_telemetry,
                                               std::vector<LoggedReport> begin);
  /// How often signs of life are due while armed.
  void set_watchdog(double watchdog_s);

  // Time ---------------------------------------------------------------------------------------

  [[nodiscard]] bool time_is_virtual() const { return transport_->time_is_virtual(); }
  [[nodiscard]] std::int64_t now_ns() const { return transport_->now_ns(); }
  /// Lets time pass.
  void sleep(std::int64_t duration_ns);
  /// Lets time pass until `done()`.
  /// @returns false if the time is over first
  /// @throws Disconnected, Closed, Interrupted
  bool wait_until(const std::function<bool(const Locked&)>& done, std::int64_t timeout_ns);

  // For the other parts of the session ---------------------------------------------------------

  [[nodiscard]] Locked lock() const { return Locked(mutex_); }
  /// May be asked with the lock and without.
  [[nodiscard]] bool is_lost() const { return is_lost_; }
  /// Virtual time: takes in what is there, though no time passes. @throws Closed
  void look(const Locked& locked);
  /// Of all that the device has sent.
  [[nodiscard]] std::uint64_t newest_tick(const Locked&) const { return newest_tick_; }
  void note_tick(const Locked&, std::uint64_t tick) { newest_tick_ = tick; }
  void count_samples(const Locked&, std::uint64_t received, std::uint64_t lost);
  void count_refused_model(const Locked&, std::string why);
  [[nodiscard]] const LinkStatistics& statistics(const Locked&) const { return statistics_; }

 private:
  class Tap;

  void throw_if_gone(const Locked& locked) const;
  void ask_user();
  template <class Act>
  void on_transport(Act&& act);
  void log(const Locked& locked, bool sent, const protocol::ReportBytes& report);
  static protocol::ReportBytes keep_alive_report();
  bool send_keep_alive();
  void pass_frame(const Locked& locked, std::int64_t now_ns, std::int64_t limit_ns);
  void take_in_virtual(const Locked& locked);
  void read_loop();
  void take(const Locked& locked, const protocol::ReportBytes& report);
  void lose(const Locked& locked, const std::string& why);

  const MakersProcess process_;
  const std::unique_ptr<Transport> transport_;
  const std::function<bool()> interrupted_;
  Receiver& receiver_;
  std::thread reader_;
  std::atomic<bool> stopped_{false};  // from here on nobody uses it
  std::atomic<bool> is_lost_{false};
  std::atomic<int> unasked_{0};  // calls that do not ask the user
  std::atomic<std::int64_t> keep_alive_ns_{80'000'000};

  mutable std::mutex mutex_;  // guards all below, and what the other parts know
  std::condition_variable news_;
  bool let_go_ = false;
  bool reads_ = false;  // the reader thread runs
  std::string why_lost_;
  std::uint64_t newest_tick_ = 0;
  std::vector<std::weak_ptr<Tap>> taps_;
  LinkStatistics statistics_;
};

}  // namespace torsio
