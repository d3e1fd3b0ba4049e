// Telemetry in the page: positions that wrap, samples that are missing, peaks that must be seen; and
// scenes in the wire's units.

import assert from "node:assert/strict";
import { test } from "node:test";

import { decode, encode } from "../../build/studio/modules/codec.js";
import { sceneToWire } from "../../build/studio/modules/conversion.js";
import { Steps, TelemetryDecoder } from "../../build/studio/modules/samples.js";

const UNITS = { controlPeriodNs: 250_000, countsPerRev: 8192, torqueStepNm: 1e-5, speedStepRadS: 0.01 };
const LIMITS = { effects: 16, curvePoints: 1024, countsPerRev: 8192, controlPeriodNs: 250_000 };

function report(tick, base, offsets, decimation = 2) {
  const sample = (offset) => ({
    offset_counts: offset, speed: 100, desired_torque: -5000, motor_command: -2500,
    brake_capacity: 2500, spring_torque: -2400,
  });
  return encode("telemetry", {
    axis_samples: offsets.length << 4, decimation, flags: 1, tick, base_counts: base,
    sample: [...offsets, 0, 0, 0, 0].slice(0, 4).map(sample),
  });
}

test("a sample has its time, its angle and its torques in SI units", () => {
  const decoder = new TelemetryDecoder(UNITS);
  const rows = [];
  decoder.decode(report(4000n, 2048, [0, 1024]), (row) => rows.push([...row]));
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

test("what is missing between two reports is counted", () => {
  const decoder = new TelemetryDecoder(UNITS);
  decoder.decode(report(0n, 0, [0, 0, 0, 0]), () => {});
  decoder.decode(report(8n, 0, [0, 0, 0, 0]), () => {});
  assert.equal(decoder.lost, 0);
  decoder.decode(report(24n, 0, [0, 0, 0, 0]), () => {}); // one report of four did not come
  assert.equal(decoder.lost, 4);
  assert.equal(decoder.received, 12);
});

test("what a lying device sends is refused whole, and what follows counts again", () => {
  const decoder = new TelemetryDecoder(UNITS);
  const rows = [];
  const take = (row) => rows.push([...row]);
  decoder.decode(report(0n, 0, [0, 0, 0, 0]), take);
  const many = report(8n, 0, [0]);
  many[1] = 5 << 4;
  const lies = [
    many, // five samples, where four have room
    report(8n, 0, []),
    report(8n, 0, [0], 0), // would divide by 0
    report(8n, 0, [0]).subarray(0, 63),
    new Uint8Array(64),
    new Uint8Array(64).fill(0xff),
    report(2n ** 63n, 0, [0]),
    report(2n ** 40n, 0, [0]),
  ];
  for (const lie of lies) assert.throws(() => decoder.decode(lie, take), { name: "Error", report: "telemetry" });
  assert.throws(() => decoder.decode(report(8n, 0, [0]), take));
  decoder.decode(report(10n, 0, [0]), take);
  assert.equal(rows.length, 5);
  assert.equal(decoder.lost, 0);
});

test("samples of reports are those of the codec, whatever the bytes", () => {
  const units = { controlPeriodNs: 1e9, countsPerRev: 2 * Math.PI, torqueStepNm: 1, speedStepRadS: 1 };
  let seed = 1;
  const byte = () => (seed = (seed * 48271) % 0x7fffffff) & 0xff;
  for (let i = 0; i < 200; ++i) {
    const bytes = Uint8Array.from({ length: 64 }, byte);
    bytes[0] = 0x40;
    bytes[1] = (1 + (i % 4)) << 4;
    bytes[2] ||= 1;
    bytes.fill(0, 8, 12); // a tick that is no lie
    const { values } = decode(bytes);
    const decoder = new TelemetryDecoder(units);
    const rows = [];
    decoder.decode(bytes, (row, tick, counts) => rows.push([...row, tick, counts]));
    assert.equal(decoder.flags, values.flags);
    assert.deepEqual(rows, values.sample.slice(0, 1 + (i % 4)).map((sample, k) => {
      const tick = Number(values.tick) + k * values.decimation;
      const counts = values.base_counts + sample.offset_counts;
      const { speed, desired_torque, motor_command, brake_capacity, spring_torque } = sample;
      const torques = [desired_torque, motor_command, brake_capacity, spring_torque];
      return [1e-9 * tick * 1e9, (counts * 2 * Math.PI) / (2 * Math.PI), speed, ...torques, tick, counts];
    }));
  }
});

test("no peak is lost where there are more samples than steps, and it stands where it was", () => {
  const steps = new Steps(2, 100, 10);
  for (let i = 0; i < 2000; ++i) steps.push(i, [i === 1543 ? 7 : i === 1600 ? -9 : 0, i], 1e6 + i);
  const seen = (curve) => {
    const rows = [];
    steps.each(curve, 0, (...row) => rows.push(row));
    return rows;
  };
  const values = seen(0);
  assert.deepEqual(values.map(([step]) => step), Array.from({ length: 100 }, (_, i) => 100 + i)); // the newest
  assert.deepEqual(values[54], [154, 0, 7, false]);
  assert.deepEqual(values[60].slice(0, 3), [160, -9, 0]);
  for (const [step, low, high, falls] of seen(1)) assert.deepEqual([low, high, falls], [10 * step, 10 * step + 9, false]);
  const corners = [];
  steps.overBeside(0, (at, value) => value && corners.push([at, value]));
  assert.deepEqual(corners, [[1e6 + 1543, 7], [1e6 + 1600, -9]]);
});

test("few samples are drawn as they are, and time that begins anew clears the curves", () => {
  const steps = new Steps(1, 100, 0.01);
  const seen = () => {
    const values = [];
    steps.each(0, 0, (_, low, high) => values.push(low, high));
    return values;
  };
  for (const [time, value] of [[5, 1], [5.2, 2], [5.4, 3]]) steps.push(time, [value], 0);
  assert.deepEqual(seen(), [1, 1, 2, 2, 3, 3]);
  steps.push(0.5, [4], 0);
  assert.deepEqual(seen(), [4, 4]);
  steps.push(100, [5], 0);
  assert.deepEqual(seen(), [5, 5]);
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
  const refusal = (effect, limits = LIMITS) => {
    try {
      sceneToWire([effect], limits);
    } catch (error) {
      return error.message;
    }
    return "";
  };
  assert.match(refusal({ type: "damper", damping_nm_s_per_rad: NaN }), /effect 0 \(damper\): damping_nm_s_per_rad is NaN, allowed are 0 to 1000/);
  assert.match(refusal({ type: "detents", torque_nm: 0.1 }), /exactly one of per_turn and pitch_rad/);
  assert.match(refusal({ type: "detents", torque_nm: 0.1, per_turn: 5000 }), /up to 4096/);
  const fine = { ...LIMITS, countsPerRev: 1 << 24 };
  assert.equal(refusal({ type: "detents", torque_nm: 0.1, per_turn: 65_536 }, fine), "");
  assert.match(refusal({ type: "detents", torque_nm: 0.1, per_turn: 65_537 }, fine), /up to 65536$/);
  assert.match(refusal({ type: "curve", torque_nm: [0, 0.01], span_rad: 9e-5 }, fine), /are 1\/65536 turn to 128 turns/);
  assert.match(refusal({ type: "curve", torque_nm: [1] }), /has 1 points, allowed are 2 to 1024/);
  const wall = (turns) => refusal({ type: "wall", angle_rad: turns * 2 * Math.PI, stiffness_nm_per_rad: 1 });
  assert.equal(wall(67_108_864), ""); // 2^58 of 2^-32 turns, as in docs/reference/protocol.md
  assert.match(wall(67_108_865), /angle_rad is \d+\.\d+, allowed are -421657428 to 421657428 rad/);
  const curve = (turns) => refusal({ type: "curve", torque_nm: [0, 0.01], span_rad: turns * 2 * Math.PI });
  assert.equal(curve(128), "");
  assert.match(curve(128.001), /span_rad is \S+, allowed are two counts of the encoder to 128 turns/);
  assert.match(refusal({ type: "end_stops", lower_rad: 1, upper_rad: 0, stiffness_nm_per_rad: 1 }), /below lower_rad/);
  assert.match(refusal({ type: "wall" }), /stiffness_nm_per_rad is missing/);
  assert.throws(() => sceneToWire(Array(17).fill({ type: "spring", stiffness_nm_per_rad: 1 }), LIMITS), /17 effects, the device plays up to 16/);
});
