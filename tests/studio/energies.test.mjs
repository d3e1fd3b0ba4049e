// The device's ledger in joules, as the page shows it.

import assert from "node:assert/strict";
import { test } from "node:test";

import { decode, encode } from "../../build/studio/modules/codec.js";
import { energiesOf } from "../../build/studio/modules/energies.js";

const NM = 2 ** 23; // one N m in the device's units
const close = (is, should) => assert.ok(Math.abs(is - should) <= 1e-12, `${is} in place of ${should}`);

test("work of motor and shaft becomes joules, and they close", () => {
  // The motor pushes with 0.05 N m through a quarter of 8192 counts; the shaft pulls back with 0.02 N m
  // on the way, and is left with 0.03 N m, for which it has stored 2^-10 J.
  const ledger = {
    kept: "on", motor: BigInt(Math.round(0.05 * NM)) * 2048n, spring_twice: -2n * BigInt(Math.round(0.02 * NM)) * 2048n,
    spring: Math.round(0.03 * NM), stored_j: 2 ** -10,
  };
  const { motorJ, feltJ, storedJ, brakeJ } = energiesOf(decode(encode("ledger", ledger)).values, 8192);
  const wayRad = Math.PI / 2, step = 1e-6; // torques are rounded to 2^-23 N m
  assert.ok(Math.abs(motorJ - 0.05 * wayRad) < step);
  assert.ok(Math.abs(feltJ - 0.03 * wayRad) < step);
  assert.equal(storedJ, 2 ** -10);
  assert.ok(Math.abs(brakeJ - (0.02 * wayRad - 2 ** -10)) < step);
  close(motorJ, feltJ + storedJ + brakeJ);
});
