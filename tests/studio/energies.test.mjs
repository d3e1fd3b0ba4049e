// The device's ledger in joules, as the page shows it.

import assert from "node:assert/strict";
import { test } from "node:test";

import { decode, encode } from "../../build/studio/modules/codec.js";
import { energiesOf } from "../../build/studio/modules/energies.js";

const NM = 2 ** 23; // of the device's torques in one N m
const close = (is, should) => assert.ok(Math.abs(is - should) <= 1e-12, `${is} in place of ${should}`);

test("work of motor and shaft becomes joules, and they close", () => {
  // The motor pushes with 0.05 N m through a quarter of 8192 counts; the shaft pulls back with 0.02 N m
  // on the way, and is left with 0.03 N m in a stiffness of 0.5 N m/rad.
  const ledger = {
    kept: "on", motor: BigInt(Math.round(0.05 * NM)) * 2048n, spring_twice: -2n * BigInt(Math.round(0.02 * NM)) * 2048n,
    spring: Math.round(0.03 * NM), spring_stiffness_nm_per_rad: 0.5,
  };
  const { motorJ, feltJ, storedJ, brakeJ } = energiesOf(decode(encode("ledger", ledger)).values, 8192);
  const wayRad = Math.PI / 2, step = 1e-6; // torques are rounded to 2^-23 N m
  assert.ok(Math.abs(motorJ - 0.05 * wayRad) < step);
  assert.ok(Math.abs(feltJ - 0.03 * wayRad) < step);
  assert.ok(Math.abs(storedJ - 0.03 ** 2 / (2 * 0.5)) < step);
  assert.ok(Math.abs(brakeJ - (0.02 * wayRad - 0.0009)) < step);
  close(motorJ, feltJ + storedJ + brakeJ);
});

test("a shaft without a spring stores nothing", () => {
  const { storedJ, brakeJ } = energiesOf({ motor: 5n, spring_twice: 0n, spring: 7, spring_stiffness_nm_per_rad: 0 }, 8192);
  assert.deepEqual([storedJ, Math.abs(brakeJ)], [0, 0]);
});
