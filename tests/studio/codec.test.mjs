// The page's codec against the golden bytes, and against reports that a device must refuse.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";

import { decode, encode, MalformedReport } from "../../build/studio/modules/codec.js";

// JSON knows no 64-bit numbers: larger ones than a double holds are text.
const text = readFileSync(new URL("../golden/reports.json", import.meta.url), "utf8");
const rows = JSON.parse(text.replace(/: (-?\d{16,})(?=[,}])/g, ': "$1"'));

/** Big numbers as text, so that both sides compare. */
function plain(values) {
  return JSON.parse(JSON.stringify(values, (_, v) => (typeof v === "bigint" ? `${v}` : v)));
}

/** What the file has, with short 64-bit numbers as text too. */
function alike(golden, decoded) {
  if (Array.isArray(golden)) return golden.map((v, i) => alike(v, decoded[i]));
  if (golden && typeof golden === "object") {
    return Object.fromEntries(Object.entries(golden).map(([k, v]) => [k, alike(v, decoded[k])]));
  }
  return typeof decoded === "bigint" ? `${golden}` : golden;
}

for (const [n, row] of rows.entries()) {
  const bytes = Uint8Array.from(Buffer.from(row.hex, "hex"));
  test(`${row.report}-${n} becomes the golden bytes`, () => {
    assert.equal(Buffer.from(encode(row.report, row.values)).toString("hex"), row.hex);
  });
  test(`${row.report}-${n} is read from the golden bytes`, () => {
    const { name, values } = decode(bytes);
    assert.equal(name, row.report);
    assert.deepEqual(plain(values), alike(row.values, values));
  });
}

function refusal(bytes) {
  try {
    decode(bytes);
  } catch (error) {
    assert(error instanceof MalformedReport);
    return [error.status, error.field];
  }
  return ["ok", undefined];
}

function changed(name, change, values = {}) {
  const bytes = encode(name, values);
  change(new DataView(bytes.buffer));
  return bytes;
}

test("a report that breaks a rule is refused with the device's status and field", () => {
  assert.deepEqual(refusal(new Uint8Array(63)), ["bad_length", undefined]);
  assert.deepEqual(refusal(changed("wall", (v) => v.setUint8(0, 0xee))), ["unknown_report", undefined]);
  assert.deepEqual(refusal(changed("wall", (v) => v.setUint8(63, 1))), ["bad_padding", undefined]);
  // Bytes counted in docs/reference/protocol.md: angle at 5, side at 13, stiffness at 14.
  assert.deepEqual(refusal(changed("wall", (v) => v.setFloat32(14, NaN, true))), ["not_finite", 5]);
  assert.deepEqual(refusal(changed("wall", (v) => v.setFloat32(14, -1, true))), ["out_of_range", 5]);
  assert.deepEqual(refusal(changed("wall", (v) => v.setUint8(13, 2))), ["out_of_range", 4]);
  assert.deepEqual(
    refusal(changed("wall", (v) => v.setBigInt64(5, (1n << 58n) + 1n, true))),
    ["out_of_range", 3],
  );
});

test("a value that is not known yet is shown as a number where the list is open", () => {
  const bytes = changed("event", (v) => v.setUint8(1, 200));
  assert.equal(decode(bytes).values.kind, 200);
});

test("what cannot be written is refused by name", () => {
  assert.throws(() => encode("wall", { stifness: 1 }), /wall has no field stifness/);
  assert.throws(() => encode("wall", { side: "left" }), /left is none of above, below/);
  assert.throws(() => encode("stream", { decimation: 256 }), /256 does not fit into u8/);
  assert.throws(() => encode("no_such"), /there is no report no_such/);
});
