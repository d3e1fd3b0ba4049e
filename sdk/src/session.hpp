/// @file
/// The conversation with one device: requests and their acknowledgements, telemetry, signs of life,
/// and waiting, in real and in virtual time.
#pragma once

#include <array>
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "event_feed.hpp"
#include "process.hpp"
#include "protocol/codec.hpp"
#include "protocol/reports.hpp"
#include "sample_ring.hpp"
#include "telemetry_decoder.hpp"
#include "torsio/telemetry.hpp"
#include "torsio/transport.hpp"

namespace torsio {

struct TelemetryRecord;

// Full-speed USB carries a report each way once in so long.
inline constexpr std::int64_t kFrameNs = 1'000'000;

struct SessionOptions {
  std::int64_t command_timeout_ns = 1'000'000'000;
  std::size_t ring_samples = 65536;
  std::function<bool()> interrupted;
};

/// Where time is real one reader thread takes in what the device sends. Where it is virtual the
/// thread that waits does, frame by frame, so that the same calls always give the same result.
///
/// One mutex guards everything that both sides touch; it is held neither while the transport
/// writes nor while the user's code is called. Every member may be called from any thread.
class Session {
 public:
  Session(std::unique_ptr<Transport> transport, SessionOptions options);
  ~Session();  ///< as close()

  /// Disarms if `disarm_first` and the device is armed, and lets go of it. Waits for nobody but the
  /// device, and not long.
  void close(bool disarm_first) noexcept;
  /// The first of it: the torque off. Asks nobody, throws nothing.
  void disarm_quietly() noexcept;
  [[nodiscard]] bool is_open() const noexcept { return !closed_; }
  /// False in a child that was forked: nothing else of the session may be used or destroyed there.
  [[nodiscard]] bool is_here() const noexcept { return process_.is_this(); }
  void throw_unless_here() const;

  // Requests -----------------------------------------------------------------------------------

  /// Sends reports in order and waits until each is acknowledged. Their sequence numbers are
  /// filled in.
  /// @returns the acknowledgements in the same order; they may be refusals
  /// @throws Timeout, Disconnected, Closed, Interrupted
  std::vector<protocol::Acknowledgement> exchange(std::span<protocol::ReportBytes> reports);

  /// Sends one report and waits. @throws Refused, and as exchange() does
  template <class Report>
  protocol::Acknowledgement request(const Report& report) {
    std::array<protocol::ReportBytes, 1> bytes{protocol::encode(report)};
    const protocol::Acknowledgement answer = exchange(bytes).front();
    throw_if_refused(answer);
    return answer;
  }

  /// Sends a report that only an armed device takes and does not wait for an acknowledgement.
  /// Waits while the queue to the device is full.
  /// @throws Refused, without asking the device, if it is known not to be armed
  void send_while_armed(protocol::ReportBytes report);

  /// Reads a feature report. @throws Error if the device stalls, Disconnected, Closed
  template <class Report>
  Report get() {
    Report report{};
    const protocol::ReportBytes bytes = get_feature(protocol::Layout<Report>::id);
    check_feature(protocol::decode(bytes, report), protocol::Layout<Report>::id);
    return report;
  }

  /// Sets a feature report and waits for its acknowledgement. @throws Refused, as exchange() does
  template <class Report>
  void set(const Report& report) {
    set_feature(protocol::encode(report));
  }

  /// Gives an order and waits. @throws Refused, and as exchange() does
  void command(protocol::Op op);

  void throw_if_refused(const protocol::Acknowledgement& answer);

  // Time ---------------------------------------------------------------------------------------

  /// Lets time pass.
  void sleep(std::int64_t duration_ns);
  /// The same, up to a time of now_ns().
  void sleep_until(std::int64_t time_ns);
  [[nodiscard]] std::int64_t now_ns() const { return transport_->now_ns(); }

  /// See Knob::tap(). @param begin what it has already
  [[nodiscard]] std::shared_ptr<ReportTap> tap(bool with_telemetry,
                                               std::vector<LoggedReport> begin);
  /// Reads a feature report as it is. @throws as get() does
  protocol::ReportBytes get_feature(std::uint8_t id);

  /// Waits for a state. @returns false if it does not come in time
  bool wait_for(State state, std::int64_t timeout_ns);

  // Facts about the device ------------------------------------------------------------------

  [[nodiscard]] State state();
  /// Armed, and by nobody else: neither by a game nor by the dial.
  [[nodiscard]] bool drives();
  /// Takes over what a health report says.
  void note(const protocol::Health& health);
  [[nodiscard]] LinkStatistics statistics() const;
  /// How often signs of life are due while armed.
  void set_watchdog(double watchdog_s);

  /// Takes the events that were not taken yet, and waits for one. @throws Disconnected, Closed
  std::vector<Event> take_events(std::int64_t timeout_ns);
  void on_event(EventFeed::Callback callback) { events_.set_callback(std::move(callback)); }
  /// How the torque went the last time.
  [[nodiscard]] std::optional<Disarm> last_disarm();
  /// How often it went.
  [[nodiscard]] std::uint64_t disarms() const;

  // Telemetry ------------------------------------------------------------------------------------

  /// Units of telemetry.
  void set_identity(const protocol::Identity& identity);
  /// The device's position in full, from now on.
  void set_position(std::int64_t counts);
  /// Starts telemetry and forgets what was not read, or stops it (0) and keeps that.
  void stream(std::uint8_t decimation, bool prompt);
  /// The same as stream(0), but asks nobody and throws nothing.
  void stop_stream_quietly() noexcept;
  /// The newest sample of the stream that runs; waits for the first. @returns none if it is late
  std::optional<TelemetrySample> latest(std::int64_t timeout_ns);
  /// Waits for samples and takes them. @returns how many; 0 if none came in time
  std::size_t read(std::span<TelemetrySample> out, std::int64_t timeout_ns);

  /// Copies what comes, from its construction until it goes out of scope. Several may run at once,
  /// beside who reads.
  class Listener {
   public:
    /// @param into gets the samples at its end, in the thread in which they arrive
    Listener(Session& session, TelemetryRecord& into);
    Listener(const Listener&) = delete;
    Listener& operator=(const Listener&) = delete;
    ~Listener();

    /// Keeps what lies in ticks [first, end), and waits for the rest of it. Nobody can read() these
    /// samples afterwards, or older ones; however this ends early they still can.
    /// @throws Timeout if for `silence_ns` none comes; Disarmed, if told to, when the torque goes
    void run(std::uint64_t first_tick, std::uint64_t end_tick, std::int64_t silence_ns,
             bool must_stay_armed);

    /// How the torque went meanwhile, if it did.
    [[nodiscard]] std::optional<Disarm> disarmed() const;

   private:
    friend class Session;
    bool take(const TelemetrySample& sample);

    Session& session_;
    TelemetryRecord& into_;
    const std::size_t had_;
    std::uint64_t disarms_before_ = 0;
    std::uint64_t first_tick_ = 0;
    std::uint64_t end_tick_ = UINT64_MAX;
    std::uint64_t received_until_tick_ = 0;  // of the newest sample, plus one
    std::exception_ptr failure_;
  };

 private:
  struct Pending {
    std::uint16_t sequence;
    std::optional<protocol::Acknowledgement> answer;
  };
  class Expectation;
  class Tap;
  class Unasked;
  /// Facts about the device from a report.
  struct Said {
    State state;
    Owner owner;
    std::uint16_t faults;
    std::uint64_t tick;
  };

  /// Lets time pass until `done()`, which is called with the lock held.
  /// @returns false if the time is over first
  bool wait_until(const std::function<bool()>& done, std::int64_t timeout_ns);
  void throw_if_gone() const;
  /// Waits for room. @throws Timeout if there is none in time
  void write(const protocol::ReportBytes& report, std::int64_t timeout_ns);
  [[noreturn]] void throw_late(const std::string& what) const;
  /// For the taps; with the lock held.
  void log(bool sent, const protocol::ReportBytes& report);
  static protocol::ReportBytes keep_alive_report();
  void pass_frame(std::int64_t now_ns, std::int64_t limit_ns);
  void take_in_virtual();

  void read_loop();
  void dispatch(const protocol::ReportBytes& report);
  void dispatch(const protocol::Telemetry& report);
  void dispatch(const protocol::Acknowledgement& answer);
  void dispatch(const protocol::Event& event);
  void become(const Said& said, DisarmReason why);
  void tell_event(std::string kind, std::uint16_t faults, std::uint64_t tick);
  void lose(const std::string& why);
  template <class Act>
  void on_transport(Act&& act);
  template <class Report>
  void say(const Report& report);
  bool send_keep_alive() noexcept;

  std::uint16_t stamp(protocol::ReportBytes& report);
  void await(Expectation& expectation);
  void set_feature(protocol::ReportBytes report);
  static void check_feature(protocol::Verdict verdict, std::uint8_t id);
  [[noreturn]] void throw_stalled(std::uint8_t id);

  const MakersProcess process_;
  const std::unique_ptr<Transport> transport_;
  const SessionOptions options_;
  std::thread reader_;
  std::atomic<bool> closing_{false};    // somebody does
  std::atomic<bool> closed_{false};     // from here on nobody uses it
  std::atomic<int> unasked_{0};         // calls that do not ask the user
  std::atomic<int> disarming_{0};       // orders to disarm that are under way
  std::atomic<bool> may_drive_{false};  // armed when it was lost, or told to arm without an answer
  std::atomic<std::uint16_t> sequence_{0};
  std::atomic<std::int64_t> keep_alive_ns_{80'000'000};
  std::atomic<std::uint64_t> reports_sent_{0};

  mutable std::mutex mutex_;  // guards all below
  std::condition_variable news_;
  bool all_closed_ = false;
  EventFeed events_;  // has locks of its own
  std::string lost_;  // why the device is gone; empty while it is there
  State state_ = State::disarmed;
  Owner owner_ = Owner::none;
  std::optional<DisarmReason> fading_;  // why the torque is going
  std::optional<Disarm> last_disarm_;
  std::uint64_t disarms_ = 0;
  std::uint64_t newest_tick_ = 0;  // of all that the device has sent
  std::uint64_t said_tick_ = 0;    // of the newest that says the state
  std::vector<std::weak_ptr<Tap>> taps_;
  std::vector<Pending> pending_;
  TelemetryDecoder decoder_;
  SampleRing ring_;
  bool stream_starts_ = false;          // with the next acknowledgement of a stream report
  std::uint64_t stream_from_tick_ = 0;  // older samples belong to the stream before
  std::optional<TelemetrySample> latest_;
  std::vector<Listener*> listeners_;
  LinkStatistics statistics_;
};

}  // namespace torsio
