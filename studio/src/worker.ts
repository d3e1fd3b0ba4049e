// The thread that the emulated device lives in: it keeps pace with the wall clock.

import { REPORT_SIZE } from "./codec";
import { EmulatedDevice } from "./emulated_device";
import type { FromWorker, ToWorker } from "./wasm_transport";

const FRAME_NS = 1e6;
const HOPELESSLY_LATE_NS = 50e6;
// A picture's worth at a time costs the page least.
const PACE_MS = 40;
// A hand that is firm without shaking: it follows a finger within a tenth of a second.
const HAND = { inertia: 2e-5, stiffness: 0.8, damping: 8e-3 };
const FOLLOW_S = 0.03;

let device: EmulatedDevice | undefined;
/** Where the hand took the knob, in the plant's own angle, and how far it has turned since. */
let held: { from: number; turned: number } | undefined;
const toWrite: { id: number; report: Uint8Array }[] = [];

function post(message: FromWorker): void {
  self.postMessage(message);
}

function flush(): void {
  while (device && toWrite.length && device.write(toWrite[0]!.report)) {
    post({ kind: "answer", id: toWrite.shift()!.id, result: true });
  }
}

let next = 0;
// Time waits for the page: one that is late must not look like a host that has gone.
let taken = true;
function pace(): void {
  if (!device || !taken) return;
  const now = performance.now() * 1e6;
  // A machine that slept must not make the world race.
  if (now - next > HOPELESSLY_LATE_NS) next = now - HOPELESSLY_LATE_NS;
  const begin = next;
  const reports: Uint8Array[] = [];
  for (; next <= now; next += FRAME_NS) {
    flush();
    device.advance(FRAME_NS);
    for (let report = device.read(); report; report = device.read()) reports.push(report);
  }
  if (next === begin) return;
  taken = false;
  const packed = new Uint8Array(REPORT_SIZE * reports.length);
  reports.forEach((report, i) => packed.set(report, REPORT_SIZE * i));
  self.postMessage({ kind: "time", reports: packed, truth: device.truth() } satisfies FromWorker, {
    transfer: [packed.buffer],
  });
}

function move(turned: number | undefined): void {
  if (!device) return;
  if (turned === undefined) {
    held = undefined;
    device.letGo();
    return;
  }
  held ??= { from: device.truth()[0]!, turned: 0 };
  const path = [[0, held.from + held.turned], [FOLLOW_S, held.from + turned]] as const;
  held.turned = turned;
  device.hold(HAND.inertia, HAND.stiffness, HAND.damping, path);
}

async function answer(message: ToWorker): Promise<void> {
  switch (message.kind) {
    case "start":
      device = await EmulatedDevice.load(message.module, message.seed);
      next = performance.now() * 1e6;
      setInterval(pace, PACE_MS);
      post({ kind: "answer", id: message.id, result: true });
      break;
    case "write":
      toWrite.push(message);
      flush();
      // So that the answer comes soon.
      pace();
      break;
    case "get":
      post({ kind: "answer", id: message.id, result: device?.getFeature(message.report) });
      break;
    case "set":
      post({ kind: "answer", id: message.id, result: device?.setFeature(message.report) });
      break;
    case "taken":
      taken = true;
      break;
    case "hand":
      move(message.turned);
      break;
    case "emergency stop":
      device?.setEmergencyStop(message.pressed);
      break;
  }
}

self.onmessage = (event: MessageEvent<ToWorker>) => {
  answer(event.data).catch((error: unknown) => post({ kind: "failed", why: String(error) }));
};
