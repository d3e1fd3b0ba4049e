// Telemetry in the page: positions that wrap, samples that are missing, peaks that must be seen; and
// scenes in the wire's units.

import assert from "node:assert/strict";
import { test } from "node:test";

import { sceneToWire } from "../../build/studio/modules/conversion.js";
import { Ring, TelemetryDecoder } from "../../build/studio/modules/samples.js";

const UNITS = { controlPeriodNs: 250_000, countsPerRev: 8192, torqueStepNm: 1e-5, speedStepRadS: 0.01 };
const LIMITS = { effects: 16, curvePoints: 1024, countsPerRev: 8192, controlPeriodNs: 250_000 };

function report(tick, base, offsets, decimation = 2) {
  const sample = (offset) => ({
    offset_counts: offset, speed: 100, desired_torque: -5000, motor_command: -2500,
    brake_capacity: 2500, spring_torque: -2400,
  });
  return {
    axis_samples: offsets.length << 4, decimation, flags: 1, tick, base_counts: base,
    sample: [...offsets, 0, 0, 0, 0].slice(0, 4).map(sample),
  };
}

test("a sample has its time, its angle and its torques in SI units", () => {
  const decoder = new TelemetryDecoder(UNITS);
  const rows = [];
  decoder.decode(report(4000n, 2048, [0, 1024]), (row) => rows.push(row));
  assert.equal(rows.length, 2);
  const [time, angle, speed, wanted] = rows[1];
  assert.ok(Math.abs(time - 1.0005) < 1e-12); // tick 4002 of 250 us
  assert.ok(Math.abs(angle - 0.75 * Math.PI) < 1e-12); // 3072 of 8192 counts
  assert.ok(Math.abs(speed - 1) < 1e-12);
  assert.ok(Math.abs(wanted + 0.05) < 1e-12);
});

test("a position goes on where its 32 bits wrap", () => {
  const decoder = new TelemetryDecoder(UNITS);
  const angles = [];
  const take = (row) => angles.push(row[1]);
  const far = 2n ** 31n - 2n;
  decoder.begin(UNITS, far);
  decoder.decode(report(0n, Number(far), [0]), take);
  decoder.decode(report(2n, -(2 ** 31) + 1, [0]), take); // three counts further
  const counts = (angles[1] - angles[0]) / ((2 * Math.PI) / 8192);
  assert.ok(Math.abs(counts - 3) < 1e-3);
});

test("what is missing between two reports is counted, and a damaged report does not divide by 0", () => {
  const decoder = new TelemetryDecoder(UNITS);
  decoder.decode(report(0n, 0, [0, 0, 0, 0]), () => {});
  decoder.decode(report(8n, 0, [0, 0, 0, 0]), () => {});
  assert.equal(decoder.lost, 0);
  decoder.decode(report(24n, 0, [0, 0, 0, 0]), () => {}); // one report of four did not come
  assert.equal(decoder.lost, 4);
  decoder.decode(report(32n, 0, [0], 0), () => {});
  assert.equal(decoder.received, 13);
});

test("no peak is lost where there are more samples than pixels", () => {
  const ring = new Ring(2, 5000);
  for (let i = 0; i < 8000; ++i) ring.push([i, i === 6543 ? 7 : i === 6600 ? -9 : 0]);
  assert.equal(ring.size, 5000);
  const [times, values] = ring.envelope(3000, Infinity, 100, [1]);
  assert.equal(times.length, 200);
  assert.equal(Math.max(...values), 7);
  assert.equal(Math.min(...values), -9);
  assert.ok(times.every((time, i) => i === 0 || time >= times[i - 1]));
  // And all as they are where there is room.
  assert.deepEqual(ring.envelope(7998, Infinity, 100, [1]), [[7998, 7999], [0, 0]]);
});

test("angles travel as turns and notches as cycles, points of curves before what reads them", () => {
  const scene = [
    { type: "wall", angle_rad: Math.PI / 2, stiffness_nm_per_rad: 1.4 },
    { type: "detents", pitch_rad: Math.PI / 12, torque_nm: 0.03 },
    { type: "curve", span_rad: Math.PI, torque_nm: Array(14).fill(0.01) },
  ];
  const { reports, effects } = sceneToWire(scene, LIMITS);
  assert.equal(effects, 3);
  assert.deepEqual(reports.map((r) => r.name), ["curve_points", "curve_points", "wall", "detents", "curve"]);
  assert.equal(reports[2].values.angle_turns_q32, 1n << 30n);
  assert.equal(reports[3].values.per_turn_q32, 24n << 32n);
  assert.equal(reports[4].values.span_turns_q32, 1n << 31n);
  assert.deepEqual([reports[1].values.first_point, reports[1].values.points], [13, 1]);
});

test("what no device can play is refused with the effect, the field and what is allowed", () => {
  const refusal = (effect) => {
    try {
      sceneToWire([effect], LIMITS);
    } catch (error) {
      return error.message;
    }
    return "";
  };
  assert.match(refusal({ type: "damper", damping_nm_s_per_rad: NaN }), /effect 0 \(damper\): damping_nm_s_per_rad is NaN, allowed are 0 to 1000/);
  assert.match(refusal({ type: "detents", torque_nm: 0.1 }), /exactly one of per_turn and pitch_rad/);
  assert.match(refusal({ type: "detents", torque_nm: 0.1, per_turn: 5000 }), /up to 4096/);
  assert.match(refusal({ type: "curve", torque_nm: [1] }), /has 1 points, allowed are 2 to 1024/);
  assert.match(refusal({ type: "wall", angle_rad: 1e30, stiffness_nm_per_rad: 1 }), /angle_rad is 1e\+30/);
  assert.match(refusal({ type: "end_stops", lower_rad: 1, upper_rad: 0, stiffness_nm_per_rad: 1 }), /below lower_rad/);
  assert.match(refusal({ type: "wall" }), /stiffness_nm_per_rad is missing/);
  assert.throws(() => sceneToWire(Array(17).fill({ type: "spring", stiffness_nm_per_rad: 1 }), LIMITS), /17 effects, the device plays up to 16/);
});
