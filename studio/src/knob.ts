// A knob: its reports become states, answers and samples; the page's wishes become reports.

import { ask, CABLE, feature, identify, IN_TIME, LOOK_MS, whenSilent, type Identity } from "./asking";
import { decode, described, encode, MalformedReport, type Values } from "./codec";
import { fromWire, InvalidValue, sceneToWire, toWire, type Effect, type Given } from "./conversion";
import { CONFIGURATIONS, DISARM_REASONS, FAULTS, FLAGS, REPORTS, STATUSES } from "./reports";
import { TelemetryDecoder } from "./samples";
import type { Transport } from "./transport";

// Looks without a sample: a page that was busy itself has had none either.
const SILENT_LOOKS = 3;
const EASY_RATE_HZ = 3600;
// Their first fields are the sequence number, which is written in here.
const SEQUENCE_AT = 1;

const CONFIGURATION_IDS = new Set(CONFIGURATIONS.map((name) => REPORTS[name]!.id));

/** Gets every report that is sent or received. */
export interface Keeper {
  /** The row is used again for the next one. */
  sample(row: ArrayLike<number>, tick: number, counts: number, flags: number): void;
  report(newestTick: number, sent: boolean, bytes: Uint8Array): void;
}

/** The device said no. */
export class Refused extends Error {}

export interface Health {
  faults: string[];
  values: Values;
}

export class Knob {
  state = "disarmed";
  owner = "none";
  flags: string[] = [];
  /** Gets a copy of all that travels, if there is one. */
  keeper: Keeper | undefined;
  faults: string[] = [];
  undecodable = 0;
  /** Round trips of commands, the newest last, in ms. */
  readonly roundTrips: number[] = [];

  /** Gets each sample; the row is used again for the next one. */
  onSample: (row: ArrayLike<number>) => void = () => {};
  /** Called when samples came, once for all that came together. */
  onSamples: () => void = () => {};
  onChange: () => void = () => {};
  /** Gets why the torque went, in words, when nobody has asked for that. */
  onDisarmed: (why: string) => void = () => {};
  /** Gets a sentence when the device says nothing, or nonsense; undefined: all is well again. */
  onComplaint: (sentence: string | undefined) => void = () => {};
  onGone: (why: string) => void = () => {};
  /** Called when the device may have dropped its scene, with a configuration of this page. */
  onForgotten: () => void = () => {};
  /** Called when another program has configured the knob that this page looks at. */
  onConfigured: () => void = () => {};

  readonly decoder: TelemetryDecoder;
  readonly #answers = new Map<number, (answer: Values) => void>();
  readonly #written = new Map<string, string>();
  #playing: Uint8Array[] = [];
  #sequence = 0;
  #keepAlive: ReturnType<typeof setInterval> | undefined;
  #watchdogS = Number(described("control_config").fields.find((f) => f.name === "watchdog_s")!.default);
  #saidAlive = 0;
  #turn: Promise<unknown> = Promise.resolve();
  #disarms = 0;
  #disarming = false;
  #newestTick = 0;
  #looking: ReturnType<typeof setInterval> | undefined;
  #flagBits = 0;
  /** Why the knob lets go: the device names the reason before it is disarmed. */
  #fading: string | undefined;

  private constructor(readonly transport: Transport, public identity: Identity) {
    this.decoder = new TelemetryDecoder(identity);
  }

  /** @throws Error that says why these two cannot talk */
  static async open(transport: Transport): Promise<Knob> {
    const knob = new Knob(transport, await identify(transport));
    void knob.#read();
    try {
      await knob.#lookAgain();
      await knob.startTelemetry();
    } catch (error) {
      clearInterval(knob.#keepAlive);
      throw error;
    }
    knob.#watch();
    return knob;
  }

  async #read(): Promise<void> {
    try {
      for (;;) {
        const { received } = this.decoder;
        for (const report of await this.transport.read()) this.#dispatch(report);
        if (this.decoder.received !== received) this.onSamples();
        // Timers come late where much else happens.
        const late = performance.now() - this.#saidAlive > 1000 * this.#sayAliveS;
        if (late && this.#keepsAlive) this.#sayAlive();
      }
    } catch (error) {
      this.#stopTimers();
      // Nobody would read the answer.
      if (this.#isOurs) void this.#send(encode("command", { op: "disarm" })).catch(() => {});
      this.transport.close();
      this.state = "disconnected";
      this.onGone((error as Error).message);
      this.onChange();
    }
  }

  #stopTimers(): void {
    clearInterval(this.#keepAlive);
    clearInterval(this.#looking);
  }

  /** Complains of silence and of damage, once each, until it is over. */
  #watch(): void {
    let { received } = this.decoder, damaged = this.undecodable, silent = 0, complained = false;
    this.#looking = setInterval(() => {
      const fresh = this.decoder.received - received, bad = this.undecodable - damaged;
      received = this.decoder.received;
      damaged = this.undecodable;
      silent = fresh || bad || (this.transport.readOnly && received) ? 0 : silent + 1;
      if (bad) {
        this.onComplaint(`${damaged} damaged reports came from the knob and were left out: ${CABLE}`);
      } else if (silent >= SILENT_LOOKS && this.transport.readOnly) {
        this.onComplaint("the program streams no telemetry, so there is nothing to draw: call start_telemetry() in it");
      } else if (silent >= SILENT_LOOKS) {
        this.onComplaint(`the knob has sent nothing for ${silent} s: ${CABLE}, or connect again`);
      } else if (complained) {
        this.onComplaint(undefined);
      }
      complained = bad > 0 || silent >= SILENT_LOOKS;
    }, LOOK_MS);
  }

  #dispatch(bytes: Uint8Array): void {
    try {
      if (bytes[0] === REPORTS.telemetry!.id) this.#takeSamples(bytes);
      else this.#takeNews(bytes);
    } catch (error) {
      if (!(error instanceof MalformedReport)) throw error;
      ++this.undecodable;
    }
  }

  #takeSamples(bytes: Uint8Array): void {
    const { decoder } = this;
    decoder.decode(bytes, this.#takeSample);
    if (decoder.flags === this.#flagBits) return;
    this.#flagBits = decoder.flags;
    this.flags = FLAGS.filter(({ bit }) => decoder.flags & (1 << bit)).map((flag) => flag.name);
  }

  readonly #takeSample = (row: ArrayLike<number>, tick: number, counts: number): void => {
    this.#newestTick = tick;
    this.#keep((keeper) => keeper.sample(row, tick, counts, this.decoder.flags));
    this.onSample(row);
  };

  #takeNews(bytes: Uint8Array): void {
    const { name, values } = decode(bytes);
    this.#newestTick = Math.max(this.#newestTick, Number(values.tick ?? 0));
    this.#keep((keeper) => keeper.report(this.#newestTick, false, bytes));
    if (name === "acknowledgement") {
      this.#enter(String(values.state), String(values.owner));
      this.#answers.get(Number(values.sequence))?.(values);
      // Only a page that looks on hears of other programs' configurations.
      if (this.transport.readOnly && CONFIGURATION_IDS.has(Number(values.report))) void this.#lookAnew();
    } else if (name === "event") {
      if (values.kind !== "state_changed" && DISARM_REASONS.some((reason) => reason.name === values.kind)) {
        this.#fading = String(values.kind);
      }
      this.#enter(String(values.state), String(values.owner), Number(values.faults));
    }
  }

  #enter(state: string, owner: string, faults?: number): void {
    const idle = this.owner === "game" || this.owner === "dial" ? `${this.owner}_idle` : undefined;
    const reason = this.#disarming ? undefined : (this.#fading ?? idle);
    if (this.state === "armed" && state === "disarmed" && reason !== undefined) {
      this.onDisarmed(DISARM_REASONS.find(({ name }) => name === reason)!.doc);
    }
    if (state !== "armed") this.#fading = undefined;
    if (faults !== undefined) this.faults = namesOf(faults);
    if (state !== "fault") this.faults = [];
    this.state = state;
    this.owner = owner;
    clearInterval(this.#keepAlive);
    if (this.#keepsAlive) {
      this.#keepAlive = setInterval(() => this.#sayAlive(), 1000 * this.#sayAliveS);
      this.#sayAlive();
    }
    this.onChange();
  }

  get #keepsAlive(): boolean {
    return this.state === "armed" && !this.#disarming && !this.transport.readOnly;
  }

  get #sayAliveS(): number {
    return this.#watchdogS / 4;
  }

  #sayAlive(): void {
    this.#saidAlive = performance.now();
    // The next reader finds out that the device is gone.
    this.#send(encode("command", { op: "keep_alive" })).catch(() => {});
  }

  /** A recording that fails ends; the knob goes on. */
  #keep(keep: (keeper: Keeper) => void): void {
    try {
      if (this.keeper) keep(this.keeper);
    } catch (error) {
      this.keeper = undefined;
      this.onComplaint(`the recording ends here: ${(error as Error).message}`);
    }
  }

  #send(report: Uint8Array): Promise<void> {
    const written = this.transport.write(report);
    this.#keep((keeper) => keeper.report(this.#newestTick, true, report));
    return written;
  }

  /** One after the other: scenes and configurations must not mix. */
  #inTurn<T>(act: () => Promise<T>): Promise<T> {
    const done = this.#turn.then(act);
    this.#turn = done.catch(() => {});
    return done;
  }

  #expect(report: Uint8Array): Promise<Values> {
    this.#sequence = (this.#sequence % 0xffff) + 1;
    const sequence = this.#sequence;
    new DataView(report.buffer).setUint16(SEQUENCE_AT, sequence, true);
    const begin = performance.now();
    return new Promise<Values>((resolve, reject) => {
      const answered = whenSilent(() => {
        this.#answers.delete(sequence);
        reject(new Error(`the device did not answer ${IN_TIME}; if that goes on, plug the knob in again`));
      });
      this.#answers.set(sequence, (answer) => {
        answered();
        this.#answers.delete(sequence);
        this.roundTrips.push(performance.now() - begin);
        if (this.roundTrips.length > 100) this.roundTrips.shift();
        resolve(answer);
      });
    });
  }

  async #exchange(reports: Uint8Array[]): Promise<void> {
    const answers = reports.map((report) => this.#expect(report));
    const all = Promise.all(answers);
    all.catch(() => {}); // a write may fail first
    for (const report of reports) await this.#send(report);
    for (const answer of await all) throwIfRefused(answer);
  }

  command(op: string): Promise<void> {
    return this.#inTurn(() => this.#exchange([encode("command", { op })]));
  }

  /** Arms when `ready` has come, but not if it was disarmed since this was called. */
  async arm(ready: Promise<unknown> = Promise.resolve()): Promise<void> {
    const disarms = this.#disarms;
    await ready;
    await this.#inTurn(async () => {
      if (disarms !== this.#disarms) return;
      this.#disarming = false;
      await this.#exchange([encode("command", { op: "arm" })]);
    });
  }

  /** Passes all that waits its turn. If it is lost, the device's watchdog sees a host that is silent. */
  async disarm(): Promise<void> {
    ++this.#disarms;
    this.#disarming = true;
    clearInterval(this.#keepAlive);
    await this.#exchange([encode("command", { op: "disarm" })]);
    this.#disarming = false;
  }

  /** Plays a scene in place of the one before. Only what has changed is sent. */
  play(scene: readonly Effect[]): Promise<void> {
    const { effects, curvePoints, countsPerRev, controlPeriodNs } = this.identity;
    const wire = sceneToWire(scene, { effects, curvePoints, countsPerRev, controlPeriodNs });
    return this.#inTurn(async () => {
      const encoded = wire.reports.map(({ name, values }) => {
        const bytes = encode(name, values);
        const place = name === "curve_points" ? `points ${values.first_point}` : `slot ${(values.target as Values).slot}`;
        return { bytes, place, content: bytes.join() };
      });
      const anyPoints = encoded.some((e) => e.place.startsWith("points") && this.#written.get(e.place) !== e.content);
      const news = encoded.filter(
        (e) => this.#written.get(e.place) !== e.content || (anyPoints && e.bytes[0] === REPORTS.curve!.id),
      );
      // Until the commit is acknowledged nobody knows what of this the device has written down.
      for (const { place } of news) this.#written.delete(place);
      try {
        await this.#exchange(news.map((e) => e.bytes.slice()));
        await this.#exchange([encode("commit", { active: 2 ** wire.effects - 1 })]);
      } catch (error) {
        this.#written.clear();
        throw error;
      }
      for (const { place, content } of encoded) this.#written.set(place, content);
      this.#playing = encoded.map((e) => e.bytes);
    });
  }

  /** The scene that was played and two configurations: they decide whether the knob swings. */
  async judged(): Promise<Uint8Array[]> {
    const configurations = ["actuator_config", "control_config"].map((name) => ask(this.transport, name));
    return [...this.#playing, ...(await Promise.all(configurations))];
  }

  /** The next scene sends its earlier reports again. */
  forgetScene(): void {
    this.#written.clear();
  }

  /** A feature report, as it is. */
  read(name: string): Promise<Values> {
    return feature(this.transport, name);
  }

  /** Asks for state, counters and faults. */
  async health(): Promise<Health> {
    const values = await feature(this.transport, "health");
    const faults = namesOf(Number(values.faults));
    this.faults = faults;
    return { faults, values };
  }

  /** Looks again at who the device is and how it is: after it was configured. */
  async refresh(): Promise<void> {
    this.identity = await identify(this.transport);
    await this.#lookAgain();
  }

  /** Units and all else that a configuration has changed. */
  async #lookAnew(): Promise<void> {
    try {
      await this.refresh();
      await this.startTelemetry();
      this.onConfigured();
    } catch {
      // The reader of telemetry says that the knob is gone.
    }
  }

  async #lookAgain(): Promise<void> {
    const { values } = await this.health();
    this.#watchdogS = Number((await feature(this.transport, "control_config")).watchdog_s);
    this.#enter(String(values.state), String(values.owner), Number(values.faults));
  }

  /** Starts telemetry at the highest rate that leaves the cable room for answers; one that only
   * watches takes it as it comes. */
  async startTelemetry(): Promise<void> {
    const controlHz = 1e9 / this.identity.controlPeriodNs;
    const decimation = Math.ceil(controlHz / EASY_RATE_HZ);
    const clock = await feature(this.transport, "clock");
    this.decoder.begin(this.identity, clock.position_counts as bigint);
    if (this.transport.readOnly) return;
    await this.#inTurn(() => this.#exchange([encode("stream", { decimation })]));
  }

  /** A configuration in a person's units. */
  async config(name: string): Promise<Given> {
    return fromWire(REPORTS[name]!.fields, await feature(this.transport, name));
  }

  /** @throws InvalidValue, Refused; nothing was changed then */
  async configure(name: string, config: Given): Promise<void> {
    if (!CONFIGURATIONS.includes(name)) throw new InvalidValue(`there is no configuration ${name}`);
    const report = encode(name, toWire(REPORTS[name]!.fields, config));
    await this.#inTurn(async () => {
      const answer = this.#expect(report);
      answer.catch(() => {});
      const taken = this.transport.setFeature(report);
      this.#keep((keeper) => keeper.report(this.#newestTick, true, report));
      if (!(await taken)) {
        throw new Refused("the device refused the configuration: disarm it first");
      }
      throwIfRefused(await answer);
      this.#written.clear();
      this.onForgotten();
    });
    await this.refresh();
    await this.startTelemetry();
  }

  get sampleRateHz(): number {
    return this.decoder.decimation ? 1e9 / this.identity.controlPeriodNs / this.decoder.decimation : 0;
  }

  /** A game or a dial that is looked at keeps the actuator. */
  get #isOurs(): boolean {
    return this.state === "armed" && this.owner === "sdk" && !this.transport.readOnly;
  }

  /** @param last is done once the knob is disarmed; it closes even if that fails */
  async close(last?: () => Promise<unknown>): Promise<void> {
    try {
      if (this.#isOurs) await this.disarm().catch(() => {});
      await last?.();
    } finally {
      this.#stopTimers();
      this.transport.close();
    }
  }
}

function namesOf(faults: number): string[] {
  return FAULTS.filter(({ bit }) => faults & (1 << bit)).map((fault) => fault.name);
}

function throwIfRefused(answer: Values): void {
  const status = STATUSES[Number(answer.status)] ?? { name: `status ${answer.status}`, advice: "" };
  if (status.name !== "ok") throw new Refused(`the device refused (${status.name}): ${status.advice}`);
}
