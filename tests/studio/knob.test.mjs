// The page's words for a device that lies, speaks another protocol, or is silent.

import assert from "node:assert/strict";
import { test } from "node:test";

import { decode, encode } from "../../build/studio/modules/codec.js";
import { Knob } from "../../build/studio/modules/knob.js";
import { FINGERPRINT, REPORTS } from "../../build/studio/modules/reports.js";

const NAMES = Object.fromEntries(Object.entries(REPORTS).map(([name, { id }]) => [id, name]));
const AT_FINGERPRINT = 1;
const gone = new Error("unplugged");

/** Intervals that run when a test says so, on any Node: `tick` lets time pass, `reset` gives the real ones back. */
const timers = {
  enable() {
    this.real ??= { setInterval, clearInterval };
    this.now = 0;
    this.running = new Set();
    globalThis.setInterval = (call, every) => {
      const one = { call, every, due: this.now + every };
      this.running.add(one);
      return one;
    };
    globalThis.clearInterval = (one) => this.running.delete(one) || this.real.clearInterval(one);
  },
  tick(ms) {
    for (const end = this.now + ms; this.now < end; ) {
      this.now = Math.min(end, ...[...this.running].map((one) => one.due));
      for (const one of [...this.running].filter((one) => one.due <= this.now)) {
        one.due += one.every;
        one.call();
      }
    }
  },
  reset() {
    Object.assign(globalThis, this.real);
  },
};

/** A device that answers as one should, except the features in `lies`. */
class Device {
  title = "liar";
  closed = false;
  ops = [];
  sent = [];
  configured = 0;
  held = {}; // state and owner, as acknowledgements tell them
  #said = [];
  #wake = () => {};

  constructor(lies = {}) {
    this.lies = lies;
  }

  async getFeature(id) {
    const name = NAMES[id];
    if (name in this.lies) return this.lies[name];
    return encode(name, { ...(name === "identity" ? IDENTITY : {}), ...(name === "control_config" ? { watchdog_s: 0.25 } : {}) });
  }

  async write(report) {
    const sequence = report[1] | (report[2] << 8);
    if (report[0] === REPORTS.command.id && this.mute) return;
    this.sent.push(NAMES[report[0]]);
    if (report[0] === REPORTS.command.id) this.ops.push(decode(report).values.op);
    if (sequence) this.say(encode("acknowledgement", { ...this.held, sequence, report: report[0], status: 0, field: 255 }));
  }

  async setFeature(report) {
    ++this.configured;
    const sequence = report[1] | (report[2] << 8);
    this.say(encode("acknowledgement", { ...this.held, sequence, report: report[0] }));
    return true;
  }

  say(...reports) {
    this.#said.push(...reports);
    this.#wake();
  }

  async read() {
    while (!this.#said.length) await new Promise((resolve) => (this.#wake = resolve));
    if (this.#said.includes(gone)) throw gone;
    return this.#said.splice(0);
  }

  close() {
    this.closed = true;
    this.say(gone);
  }
}

const IDENTITY = {
  fingerprint: FINGERPRINT, axes: 1, effects: 16, curve_points: 1024, control_period_ns: 250000, counts_per_rev: 8192, torque_step_nm: 1e-5, speed_step_rad_s: 0.01,
};

function identity(change) {
  const bytes = encode("identity", IDENTITY);
  change(new DataView(bytes.buffer));
  return bytes;
}

async function refusal(lies) {
  try {
    (await Knob.open(new Device(lies))).close();
  } catch (error) {
    return error.message;
  }
  return "opened";
}

test("a device of another protocol is named with its version", async () => {
  const other = identity((view) => {
    view.setUint32(AT_FINGERPRINT, 0xdeadbeef, true);
    view.setUint16(AT_FINGERPRINT + 4, 7, true);
  });
  assert.match(await refusal({ identity: other }), /another protocol \(version 7, fingerprint 0xdeadbeef\)/);
});

test("reports that cannot be are named, with what to try", async () => {
  assert.match(await refusal({ identity: new Uint8Array(3) }), /identity report has 3 bytes in place of 64: try another cable/);
  assert.match(await refusal({ identity: undefined }), /does not give its identity report: is it a Torsio knob/);
  const garbage = identity((view) => new Uint8Array(view.buffer).fill(0xff, 27, 1 + REPORTS.identity.size));
  assert.match(await refusal({ identity: garbage }), /identity report makes no sense \(identity: (out_of_range|not_finite)/);
  assert.match(await refusal({ health: new Uint8Array(64) }), /health report makes no sense \(report: unknown_report/);
  assert.match(await refusal({ health: encode("clock", {}) }), /gave its clock report in place of health/);
  const limp = encode("control_config", {});
  limp.fill(0xff, 1, 1 + REPORTS.control_config.size); // numbers that are none
  assert.match(await refusal({ control_config: limp }), /control_config report makes no sense \(control_config: (not_finite|out_of_range)/);
});

test("a device that is silent from the beginning is not waited for for ever", async () => {
  timers.enable();
  const words = refusal({ clock: new Promise(() => {}) });
  for (let i = 0; i < 50; ++i) await Promise.resolve();
  await new Promise((resolve) => setImmediate(resolve));
  timers.tick(5000);
  assert.match(await words, /did not give its clock report within 5 s: try another cable/);
  timers.reset();
});

test("a page that stood still itself does not complain of an answer that is there", async () => {
  const device = new Device();
  const knob = await Knob.open(device);
  const answer = device.say.bind(device);
  // The answer has come, but timers that are due run first.
  device.say = (...reports) => {
    setImmediate(() => setImmediate(() => answer(...reports)));
    Atomics.wait(new Int32Array(new SharedArrayBuffer(4)), 0, 0, 5500);
  };
  await knob.command("arm");
  device.say = answer;
  await knob.close();
});

test("damage and silence are told while they last, and samples go on", async () => {
  timers.enable();
  const device = new Device();
  const knob = await Knob.open(device);
  const said = [], rows = [];
  knob.onComplaint = (sentence) => said.push(sentence);
  knob.onSample = (row) => rows.push([...row]);
  const second = async (...reports) => {
    if (reports.length) device.say(...reports);
    await new Promise((resolve) => setImmediate(resolve));
    timers.tick(1000);
  };
  const sample = (tick) => encode("telemetry", { axis_samples: 16, decimation: 2, tick });
  await second(sample(2n));
  assert.deepEqual(said, []);
  await second(new Uint8Array(64), new Uint8Array(5), encode("telemetry", { axis_samples: 16, decimation: 0 }), sample(4n));
  assert.match(said.at(-1), /^3 damaged reports came from the knob and were left out: try another cable/);
  await second(sample(6n));
  assert.equal(said.at(-1), undefined);
  assert.equal(rows.length, 3);
  for (let i = 0; i < 3; ++i) await second();
  assert.match(said.at(-1), /the knob has sent nothing for 3 s/);
  await second(sample(8n));
  assert.equal(said.at(-1), undefined);
  assert.equal(said.length, 4);
  timers.reset();
  await knob.close();
});

/** What is due without time passing has happened then. */
const settled = () => new Promise((resolve) => setImmediate(resolve));

test("disarming waits for nothing, and keeps the device's watchdog awake no longer", async () => {
  timers.enable();
  const device = new Device({ health: encode("health", { state: "armed", owner: "sdk" }) });
  device.held = { state: "armed", owner: "sdk" };
  const knob = await Knob.open(device);
  // From now on nothing is answered: a scene waits for it, and an arm for the scene.
  const answer = device.say.bind(device);
  device.say = () => {};
  const scene = assert.rejects(knob.play([]), /did not answer/);
  const arm = knob.arm();
  await settled();
  device.ops = [];
  const disarmed = assert.rejects(knob.disarm(), /did not answer/);
  assert.deepEqual(device.ops, ["disarm"]);
  // A report that was under way says that it is still armed.
  answer(encode("acknowledgement", { state: "armed", owner: "sdk", sequence: 999 }));
  for (let i = 0; i < 6; ++i) {
    await settled();
    timers.tick(1000);
  }
  await Promise.all([scene, arm, disarmed]);
  // No sign of life, and no late arm behind it.
  assert.deepEqual(device.ops, ["disarm"]);
  device.say = answer;
  await knob.arm();
  assert.deepEqual(device.ops.slice(0, 3), ["disarm", "arm", "keep_alive"]);
  timers.reset();
  await knob.close();
});

test("closing disarms what the page has armed, and neither a game nor the dial", async () => {
  for (const owner of ["sdk", "game", "dial"]) {
    const device = new Device({ health: encode("health", { state: "armed", owner }) });
    device.held = { state: "armed", owner };
    await (await Knob.open(device)).close();
    assert.equal(device.closed, true);
    assert.equal(device.ops.includes("disarm"), owner === "sdk", owner);
  }
});

/** A device that this page has armed, with its knob. */
async function armed() {
  const device = new Device({ health: encode("health", { state: "armed", owner: "sdk" }) });
  device.held = { state: "armed", owner: "sdk" };
  return [device, await Knob.open(device)];
}

const full = () => {
  throw new Error("full");
};

test("a recording that fails keeps no order from the device, and is told once", async () => {
  for (const order of [(knob) => knob.disarm(), (knob) => knob.configure("control_config", {})]) {
    const [device, knob] = await armed();
    const said = [];
    knob.onComplaint = (sentence) => said.push(sentence);
    knob.keeper = { sample: full, report: full };
    device.ops = [];
    await order(knob);
    assert.ok(device.configured || device.ops.includes("disarm"));
    assert.deepEqual(said, ["the recording ends here: full"]);
    await knob.close();
  }
});

test("a configuration makes the device forget the scene, which is sent whole again", async () => {
  const [device, knob] = await armed();
  const scene = [{ type: "constant", torque_nm: 0.01 }];
  for (const configures of [false, false, true]) {
    if (configures) await knob.configure("control_config", {});
    await knob.play(scene);
  }
  await knob.close();
  assert.equal(device.sent.filter((name) => name === "constant").length, 2);
});

test("samples and news of a knob outlive the recording that they break", async () => {
  const sample = encode("telemetry", { axis_samples: 16, decimation: 2, tick: 2n });
  for (const report of [sample, encode("event", { state: "armed", owner: "sdk" })]) {
    const [device, knob] = await armed();
    knob.keeper = { sample: full, report: full };
    device.say(report);
    await settled();
    assert.equal(knob.state, "armed");
    await knob.close();
  }
});

test("closing disarms before its last work, and closes when that fails", async () => {
  const [device, knob] = await armed();
  device.ops = [];
  const last = async () => {
    assert.deepEqual(device.ops, ["disarm"]);
    full();
  };
  await assert.rejects(knob.close(last), /full/);
  assert.equal(device.closed, true);
});

test("a page that breaks on what it hears lets go of the knob", async () => {
  const [device, knob] = await armed();
  knob.onChange = full;
  device.ops = [];
  let why;
  knob.onGone = (words) => {
    why = words;
    knob.onChange = () => {};
  };
  device.say(encode("event", { state: "armed", owner: "sdk" }));
  await settled();
  assert.equal(why, "full");
  assert.ok(device.ops.includes("disarm"));
  assert.equal(device.closed, true);
});
