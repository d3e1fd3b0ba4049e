#include <doctest/doctest.h>

#include "device/telemetry_batch.hpp"

using torsio::device::LoopSample;
using torsio::device::TelemetryBatch;

namespace {

LoopSample at(std::uint64_t tick, std::int64_t counts = 0) {
  LoopSample sample;
  sample.tick = tick;
  sample.position_counts = counts;
  return sample;
}

}  // namespace

TEST_CASE("what is beyond a sample's range shows as large, with its sign") {
  for (const float sign : {1.0F, -1.0F}) {
    TelemetryBatch batch;
    LoopSample sample = at(1);
    sample.speed_rad_s = sign * 1e6F;
    sample.motor_command_nm = sign * 1e6F;
    REQUIRE(batch.add(sample, {1e-5F, 0.01F}));
    const auto report = batch.take();
    CHECK(report.sample[0].speed == static_cast<std::int16_t>(sign * 32767));
    CHECK(report.sample[0].motor_command == static_cast<std::int16_t>(sign * 32767));
  }
}

TEST_CASE(
    "a report holds samples that follow each other and lie near, and no more than have room") {
  const torsio::device::SampleSteps steps;
  TelemetryBatch batch;
  REQUIRE(batch.add(at(1), steps));
  CHECK_FALSE(batch.add(at(3), steps));         // one is missing
  CHECK_FALSE(batch.add(at(2, 32768), steps));  // too far from the first
  CHECK_FALSE(batch.add(at(2, -32769), steps));
  CHECK(batch.add(at(2, 32767), steps));
  CHECK(batch.add(at(3, -32768), steps));
  CHECK(batch.add(at(4), steps));
  CHECK(batch.due(1));  // it is full
  CHECK_FALSE(batch.add(at(5), steps));
}

TEST_CASE("a report goes before it is ten milliseconds old") {
  TelemetryBatch batch;
  REQUIRE(batch.add(at(1), {}));
  CHECK_FALSE(batch.due(1'000'000));
  CHECK(batch.due(10'000'000));
}
