// Plays steps, read from standard input, to the emulated device in WebAssembly, as JSON; prints the
// reports that come and how the world is in the end. test_wasm.py does the same natively.

import { readFileSync } from "node:fs";

import { EmulatedDevice } from "../../build/studio/modules/emulated_device.js";

const { seed, controlPeriodNs, steps } = JSON.parse(readFileSync(0, "utf8"));
const wasm = readFileSync(new URL("../../build/studio/page/knob.wasm", import.meta.url));
const out = { reports: [], features: [], truth: [], refused: 0, error: "" };
try {
  const device = await EmulatedDevice.load(wasm, seed, controlPeriodNs);
  for (const [kind, ...given] of steps) {
    if (kind === "write") out.refused += device.write(Buffer.from(given[0], "hex")) ? 0 : 1;
    else if (kind === "hold") device.hold(...given);
    else if (kind === "push") device.push(given[0]);
    else if (kind === "let go") device.letGo();
    else if (kind === "emergency stop") device.setEmergencyStop(given[0]);
    else if (kind === "set") out.features.push(device.setFeature(Buffer.from(given[0], "hex")));
    else if (kind === "swings") {
      out.features.push(device.swingWarning(given[0].map((report) => Buffer.from(report, "hex")), controlPeriodNs));
    } else if (kind === "get") out.features.push(Buffer.from(device.getFeature(given[0])).toString("hex"));
    else if (kind === "advance") {
      device.advance(given[0]);
      out.truth.push(device.truth().slice(0, 3));
      for (let r = device.read(); r; r = device.read()) out.reports.push(Buffer.from(r).toString("hex"));
    } else throw new Error(`no step ${kind}`);
  }
  out.timeNs = device.timeNs;
} catch (error) {
  out.error = error.message;
}
process.stdout.write(JSON.stringify(out));
