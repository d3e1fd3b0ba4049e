/// @file
/// Telemetry of one device: samples that wait to be read, and recordings.
#pragma once

#include <cstddef>
#include <cstdint>
#include <exception>
#include <optional>
#include <span>
#include <vector>

#include "device_state.hpp"
#include "link.hpp"
#include "protocol/reports.hpp"
#include "requests.hpp"
#include "sample_ring.hpp"
#include "telemetry_decoder.hpp"
#include "torsio/telemetry.hpp"

namespace torsio {

struct TelemetryRecord;

/// The link's lock guards it. Every member may be called from any thread.
class SampleFeed {
 public:
  SampleFeed(Link& link, DeviceState& device, Requests& requests, std::size_t ring_samples)
      : link_(link), device_(device), requests_(requests), ring_(ring_samples) {}

  /// The device's position in full, from now on.
  void set_position(std::int64_t counts);
  /// Starts telemetry and forgets what was not read, or stops it (0) and keeps that.
  void stream(std::uint8_t decimation, bool prompt);
  /// The same as stream(0), but asks nobody and throws nothing.
  void stop_quietly() noexcept;
  /// The newest sample of the stream that runs; waits for the first. @returns none if it is late
  std::optional<TelemetrySample> latest(std::int64_t timeout_ns);
  /// Waits for samples and takes them. @returns how many; 0 if none came in time
  std::size_t read(std::span<TelemetrySample> out, std::int64_t timeout_ns);

  /// Copies what comes, from its construction until it goes out of scope. Several may run at once,
  /// beside who reads.
  class Listener {
   public:
    /// @param into gets the samples at its end, in the thread in which they arrive
    Listener(SampleFeed& feed, TelemetryRecord& into);
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
    friend class SampleFeed;
    bool take(const Link::Locked& locked, const TelemetrySample& sample);
    void begin(std::uint64_t first_tick, std::uint64_t end_tick);
    [[noreturn]] void throw_disarmed(const Disarm& disarm) const;
    void take_what_was_read(const Link::Locked& locked);

    SampleFeed& feed_;
    TelemetryRecord& into_;
    const std::size_t had_;
    std::uint64_t disarms_before_ = 0;
    std::uint64_t first_tick_ = 0;
    std::uint64_t end_tick_ = UINT64_MAX;
    std::uint64_t received_until_tick_ = 0;  // of the newest sample, plus one
    std::exception_ptr failure_;
  };

  /// Units.
  void configure(const Link::Locked&, const protocol::Identity& identity) {
    decoder_.configure(identity);
  }
  void take(const Link::Locked& locked, const protocol::Telemetry& report);
  void take(const Link::Locked& locked, const protocol::Acknowledgement& answer);

 private:
  Link& link_;
  DeviceState& device_;
  Requests& requests_;
  TelemetryDecoder decoder_;
  SampleRing ring_;
  bool stream_starts_ = false;          // with the next acknowledgement of a stream report
  std::uint64_t stream_from_tick_ = 0;  // older samples belong to the stream before
  std::optional<TelemetrySample> latest_;
  std::vector<Listener*> listeners_;
};

}  // namespace torsio
