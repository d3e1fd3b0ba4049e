// Any telemetry from the device, to the decoder and the ring of samples. The first two bytes choose
// what the device says of itself; every 64 bytes behind them are a report as it came.
#include <array>
#include <cmath>
#include <cstring>

#include "fuzz.hpp"
#include "reports.hpp"
#include "sample_ring.hpp"
#include "telemetry_decoder.hpp"

using namespace torsio;

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned seed) {
  fuzz::FieldMaker make(seed);
  auto report = make.make<protocol::Telemetry>();
  if (make.below(2) == 0) report.tick = make.below(100'000);
  const protocol::ReportBytes bytes = protocol::encode(report);
  std::size_t at = 2 + (size < 2 ? 0 : (size - 2) / 64 * 64);
  if (at + 64 > max_size) at = 2;
  if (size < 2) data[0] = data[1] = 0;
  std::memcpy(data + at, bytes.data(), bytes.size());
  return std::max(size, at + 64);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Reader input(data, size);
  fuzz::FieldMaker make(input.word());
  protocol::Identity identity = make.make<protocol::Identity>();
  protocol::Identity checked;
  if (!protocol::decode(protocol::encode(identity), checked).ok()) checked = {};
  TelemetryDecoder decoder;
  decoder.configure(checked);
  SampleRing ring(16);
  std::uint64_t pushed = 0;
  std::uint64_t lost = 0;
  std::uint64_t popped = 0;
  while (!input.empty()) {
    protocol::ReportBytes bytes{};
    const auto given = input.bytes(bytes.size());
    std::copy(given.begin(), given.end(), bytes.begin());
    if (bytes[0] % 16 == 1) decoder.begin_stream();
    bytes[0] = protocol::Layout<protocol::Telemetry>::id;
    protocol::Telemetry report;
    if (!protocol::decode(bytes, report).ok()) continue;
    std::uint64_t last_tick = 0;
    unsigned count = 0;
    const std::uint64_t missing = decoder.decode(report, [&](const TelemetrySample& sample) {
      fuzz::require(count == 0 || sample.tick - last_tick == report.decimation,
                    "samples stand a decimation apart");
      fuzz::require(std::isfinite(sample.time_s) && sample.flags == report.flags, "it is a sample");
      last_tick = sample.tick;
      ++count;
      ++pushed;
      if (!ring.push(sample)) ++lost;
    });
    fuzz::require(count <= protocol::samples_per_report, "no more than a report holds");
    fuzz::require(missing <= report.tick, "no more is missing than there were ticks");
    std::array<TelemetrySample, 3> out{};
    popped += ring.pop(out);
  }
  fuzz::require(pushed == lost + popped + ring.size(), "every sample is read, waits or is counted");
  return 0;
}
