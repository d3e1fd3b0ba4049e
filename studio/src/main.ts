// The page: it connects to a knob, shows it, plays the scene on it, and disarms it with one key.

import "./main.css";
import { BridgeTransport } from "./bridge_transport";
import { Calibrating } from "./calibration";
import { Configurations } from "./configurations";
import { type Effect, sceneToWire } from "./conversion";
import { Dial, showPlaces } from "./dial";
import { EmulatedDevice, TRUTH } from "./emulated_device";
import { EnergyReadouts } from "./energies";
import { entryOf } from "./entries";
import { FirstPower } from "./first_power";
import { Games } from "./games";
import { Hint } from "./hint";
import { Knob } from "./knob";
import { byId, element, show } from "./page";
import { Plots } from "./plots";
import { Recorder } from "./recorder";
import { FAULTS, FLAGS } from "./reports";
import { CHANNELS } from "./samples";
import { SceneEditor } from "./scene_editor";
import type { Transport, World } from "./transport";
import { hasWebHid, WebHidTransport } from "./webhid_transport";
import { compiled, WasmTransport } from "./wasm_transport";

// Some 28 pictures a second at most: more cost, and show nothing more. Nobody reads numbers so fast.
const PICTURE_MS = 28, NUMBERS_MS = 200;
// Limits for a scene while no knob is there.
const EMULATED = { effects: 16, curvePoints: 1024, countsPerRev: 8192, controlPeriodNs: 250_000 };
// Range of telemetry.
const MOST_STEPS = 32767;

let knob: Knob | undefined;
/** The scene that the knob has from this page. */
let playing: Effect[] | undefined;

function say(message: string): void {
  const place = byId("message");
  place.textContent = message;
  place.hidden = message === "";
}

/** Whether this page may tell the knob what to do. */
function drives(): boolean {
  return knob !== undefined && !knob.transport.readOnly && knob.state !== "disconnected";
}

/** The world round an emulated knob that this page has. */
function world(): World | undefined {
  return drives() ? knob!.transport.world : undefined;
}

async function play(scene: Effect[]): Promise<void> {
  playing = undefined;
  const played = structuredClone(scene);
  await knob!.play(scene);
  playing = played;
  // Behind all else: what fails here must not keep a scene from being played.
  void warnOfSwings(knob!).catch((error: unknown) => drives() && say((error as Error).message));
}

let judge: Promise<EmulatedDevice> | undefined;

/** Says so if the knob may swing or hum in what it plays. */
async function warnOfSwings(knob: Knob): Promise<void> {
  judge ??= compiled(new URL("knob.wasm", location.href)).then((module) => EmulatedDevice.load(module));
  // `./dev demo` makes the page without the module.
  const device = await judge.catch(() => undefined);
  if (!device) return;
  const warning = device.swingWarning(await knob.judged(), knob.identity.controlPeriodNs);
  if (warning) say(warning);
}

async function disarm(): Promise<void> {
  if (drives()) await knob!.disarm();
}

/** Does something with the knob; what goes wrong is told in a sentence. */
function attempt(act: () => Promise<unknown>): void {
  say("");
  Promise.resolve()
    .then(act)
    .catch((error: unknown) => say((error as Error).message));
}

const editor = new SceneEditor((scene) => {
  showPlaces(scene);
  showState();
  attempt(async () => {
    sceneToWire(scene, knob?.identity ?? EMULATED);
    editor.canPlay(true);
    if (!drives()) return;
    await play(scene);
    recorder.note("play", { scene });
  });
});
showPlaces(editor.scene);
const configurations = new Configurations(() => knob, attempt);
const recorder = new Recorder(() => knob, () => editor.scene, () => playing, attempt);
const firstPower = new FirstPower(
  () => knob,
  attempt,
  (scene) => {
    editor.take(scene);
    void configurations.load([]);
  },
  () => attempt(disarm),
);
new Games(() => knob);
new EnergyReadouts(() => knob);
const calibrating: Calibrating = new Calibrating(
  () => (servesKnob() || calibrating.running ? serverAddress("calibration") : undefined),
  attempt,
  () => letGo("calibrating"),
  () => connect("bridge"),
);
const dial = new Dial((turned) => world()?.hand(turned));
const hint = new Hint();
const plots = new Plots();

function button(id: string): HTMLButtonElement {
  return byId<HTMLButtonElement>(id);
}

function showState(): void {
  const state = knob?.state ?? "not connected";
  const faulty = state === "fault";
  const place = byId<HTMLDataElement>("state");
  place.value = state;
  place.textContent = knob?.owner === "game" ? `${state}, by a game` : state;
  const canAct = drives();
  const canSetUp = canAct && state === "disarmed";
  button("arm").disabled = !canSetUp;
  button("disarm").disabled = !canAct || state !== "armed";
  button("clear-fault").disabled = !canAct || !faulty;
  button("zero").disabled = !canSetUp;
  configurations.enable(canSetUp);
  firstPower.enable(canSetUp);
  calibrating.enable(canSetUp);
  recorder.enable(knob !== undefined && state !== "disconnected");
  document.body.classList.toggle("has-emulator", world() !== undefined);
  document.body.classList.toggle("only-watches", knob?.transport.readOnly === true);
  dial.enabled = world() !== undefined;
  hint.show(state, editor.scene);
  if (faulty && !knob!.faults.length) void knob!.health().then(showFaults);
  showFaults();
}

let faultsShown = "";
function showFaults(): void {
  lookAtFirstPower();
  // A reader's unfolded entry stays as it is.
  const now = (knob?.faults ?? []).join();
  if (now === faultsShown) return;
  faultsShown = now;
  byId("faults").replaceChildren(
    ...(knob?.faults ?? []).map((name) => {
      const fault = FAULTS.find((f) => f.name === name);
      const advice = fault?.advice || "remove its cause, then clear the fault";
      return element("li", {}, `${name.replaceAll("_", " ")}: ${fault?.doc ?? ""}; ${advice}`, ...entryOf(name));
    }),
  );
}

/** `torsio studio` has the knob, and not another program at which one only looks. */
function servesKnob(): boolean {
  return knob?.transport instanceof BridgeTransport && !knob.transport.readOnly;
}

/** Addresses that `torsio studio` serves beside the page. */
function serverAddress(name: string): URL {
  const address = new URL(name, location.href);
  address.protocol = address.protocol === "https:" ? "wss:" : "ws:";
  address.search = location.search;
  return address;
}

async function transportTo(kind: string, hadOne: boolean): Promise<Transport> {
  if (kind === "wasm") return WasmTransport.open(location.href);
  if (kind === "bridge") return BridgeTransport.open(serverAddress("knob"));
  if (hasWebHid()) return WebHidTransport.open(hadOne);
  throw new Error("this browser has no WebHID: take Chromium or Edge, or start `torsio studio`");
}

/** Lets go of the knob, if there is one, and says what goes on. */
async function letGo(words: string): Promise<void> {
  // That it goes is no news then.
  if (knob) knob.onGone = knob.onChange = () => {};
  await knob?.close(() => recorder.end()).catch((error: unknown) => say((error as Error).message));
  knob = undefined;
  dial.letGo();
  pressStop(false);
  newest = undefined;
  plots.clear();
  // Its last message is outdated now.
  for (const place of document.querySelectorAll<HTMLDataElement>("#readouts data")) show(place.id, NaN, "");
  byId("link").textContent = "";
  showState();
  byId("who").textContent = words;
}

let connecting: { kind: string; done: Promise<void> } | undefined;

/** Only one at a time: who clicks twice wants one knob. A knob of another kind comes after it. */
function connect(kind: string): Promise<void> {
  if (connecting?.kind === kind) return connecting.done;
  const before = connecting?.done.catch(() => {}) ?? Promise.resolve();
  const mine = { kind, done: before.then(() => connectTo(kind)) };
  connecting = mine;
  return mine.done.finally(() => {
    if (connecting === mine) connecting = undefined;
  });
}

async function connectTo(kind: string): Promise<void> {
  const hadOne = knob?.transport instanceof WebHidTransport && knob.state !== "disconnected";
  await letGo("connecting");
  let transport: Transport | undefined;
  try {
    transport = await transportTo(kind, hadOne);
    knob = await Knob.open(transport);
  } catch (error) {
    transport?.close();
    byId("who").textContent = "no knob";
    throw error;
  }
  playing = undefined;
  knob.onSample = (row) => {
    newest = row;
    plots.push(row);
  };
  knob.onSamples = () => {
    // A tab that is hidden draws nothing.
    lookAtFirstPower();
    pictureSoon();
  };
  knob.onChange = showState;
  knob.onDisarmed = (why) => say(`the knob has disarmed itself: ${why}`);
  knob.onGone = (why) => {
    say(why);
    // The recording so far is not lost.
    recorder.end().catch((error: unknown) => say(`${why}; ${(error as Error).message}`));
  };
  const { serial, firmware, controlPeriodNs } = knob.identity;
  const rate = (1e6 / controlPeriodNs).toFixed(0);
  byId("who").textContent =
    `${knob.transport.title}: serial number ${serial}, firmware ${firmware}, ${rate} kHz` +
    (knob.transport.readOnly ? "; only watching" : "");
  showState();
  knob.onComplaint = (sentence) => say(sentence ?? "");
  knob.onForgotten = () => {
    playing = undefined;
  };
  knob.onConfigured = () => attempt(() => configurations.load());
  try {
    if (knob.state === "armed" && drives()) {
      say("the knob is armed and keeps its scene until you edit the scene here, or arm again");
    } else if (drives()) {
      await play(editor.scene);
    }
  } finally {
    await configurations.load();
  }
}

byId("flags").title = FLAGS.map((flag) => `${flag.name.replaceAll("_", " ")}: ${flag.doc}`).join("\n");

function torque(value: number): string {
  return `${(1e3 * value).toFixed(1)} mN·m`;
}

/** A torque of telemetry, where the largest number stands for all that is larger. */
function sampledTorque(value: number): string {
  const isMost = Math.abs(value) >= MOST_STEPS * (knob?.identity.torqueStepNm ?? Infinity);
  return isMost ? `beyond ${torque(value)}` : torque(value);
}

let newest: ArrayLike<number> | undefined;
let drewAt = 0, wroteAt = 0, isComing = false, written = 0;

/** Draws, but no sooner than the eye sees; without samples nothing runs. */
function pictureSoon(): void {
  if (isComing) return;
  isComing = true;
  const early = drewAt + PICTURE_MS - performance.now();
  if (early <= 0) requestAnimationFrame(draw);
  else setTimeout(() => requestAnimationFrame(draw), early);
}

function draw(now: number): void {
  isComing = false;
  drewAt = now;
  if (!newest || !knob) return;
  dial.show(newest[1]!);
  hint.look(dial.isHeld, newest[3]!);
  plots.draw();
  if (now - wroteAt >= NUMBERS_MS) {
    wroteAt = now;
    write(knob, newest);
  }
}

/** With every sample and every change of the state: a fault may come and go between two pictures. */
function lookAtFirstPower(): void {
  if (!newest || !knob) return;
  const { state, faults } = knob;
  firstPower.look({ state, faults, scene: editor.scene, angleRad: newest[1]!, brakeCapacityNm: newest[5]! });
}

/** The numbers beside the dial. */
function write(knob: Knob, row: ArrayLike<number>): void {
  const angle = row[1]!, speed = row[2]!;
  written = knob.decoder.received;
  dial.tell();
  show("angle_rad", angle, `${((180 / Math.PI) * angle).toFixed(2)}°`);
  show("speed_rad_s", speed, `${speed.toFixed(2)} rad/s`);
  CHANNELS.slice(2).forEach((name, i) => show(name, row[i + 3]!, sampledTorque(row[i + 3]!)));
  show("flags", knob.flags.length, knob.flags.map((name) => name.replaceAll("_", " ")).join(", ") || "none");
  for (const name of ["spring_torque_nm", "hand_torque_nm"] as const) {
    const actual = world()?.truth[TRUTH.indexOf(name)];
    if (actual !== undefined) show(`true_${name}`, actual, torque(actual));
  }
  const trips = [...knob.roundTrips].sort((a, b) => a - b);
  const median = trips[trips.length >> 1];
  byId("link").textContent =
    `${knob.sampleRateHz.toFixed(0)} samples/s, ${knob.decoder.lost} lost` +
    (median === undefined ? "" : `, answers in ${median.toFixed(1)} ms`);
}

let isStopPressed = false;
/** The emergency stop of an emulated knob. */
function pressStop(pressed: boolean): void {
  isStopPressed = pressed;
  const stop = button("emergency-stop");
  stop.textContent = `${pressed ? "release" : "press"} emergency stop`;
  stop.classList.toggle("is-pressed", pressed);
  world()?.setEmergencyStop(pressed);
}

const connection = byId<HTMLSelectElement>("connection");
button("connect").addEventListener("click", () => attempt(() => connect(connection.value)));
for (const id of ["arm", "hint-arm"]) {
  button(id).addEventListener("click", () =>
    attempt(() => knob!.arm(Promise.all([recorder.ready(), playing ?? play(editor.scene)]))),
  );
}
button("disarm").addEventListener("click", () => attempt(disarm));
button("clear-fault").addEventListener("click", () => attempt(() => knob!.command("clear_fault")));
button("zero").addEventListener("click", () => attempt(() => knob!.command("zero")));
button("emergency-stop").addEventListener("click", () => pressStop(!isStopPressed));
// One key disarms, wherever one is; nothing on the page takes it away.
addEventListener(
  "keydown",
  (event) => {
    if (event.key !== "Escape") return;
    calibrating.stop();
    // In any state that the page knows: an arm may be on its way.
    attempt(disarm);
  },
  { capture: true },
);
addEventListener("pagehide", () => void knob?.close());

connection.value = new URLSearchParams(location.search).has("token") ? "bridge" : "wasm";
showState();
attempt(() => connect(connection.value));
// For the tests.
Object.assign(window, {
  studio: {
    samples: () => knob?.decoder.received ?? 0,
    /** Samples until the one whose numbers are shown. */
    written: () => written,
  },
});
