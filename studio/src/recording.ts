// A recording: what a knob said and was told, as the MCAP file that `torsio.load`, Foxglove and
// PlotJuggler open. docs/reference/studio.md has its topics; torsio/recordings/file.py writes the same.

import { McapWriter, type IWritable } from "@mcap/core";
import { decode, type Values } from "./codec";
import type { Given } from "./conversion";
import type { Keeper, Knob } from "./knob";
import { CONFIGURATIONS, FINGERPRINT, PROTOCOL_VERSION, REPORTS } from "./reports";

const CHUNK_BYTES = 256 * 1024;
// The browser may put larger pieces on the disk.
const BLOB_BYTES = 4 * 1024 * 1024;

const TOPICS = {
  telemetry: {
    tick: "integer", time_s: "number", position_counts: "integer", angle_rad: "number", speed_rad_s: "number",
    desired_torque_nm: "number", motor_command_nm: "number", brake_capacity_nm: "number",
    spring_torque_nm: "number", flags: "integer",
  },
  events: { kind: "string" },
  device_events: { kind: "string", state: "string", faults: "integer", tick: "integer" },
  drop_outs: { samples_lost: "integer" },
  reports: { tick: "integer", sent: "boolean", name: "string", bytes: "string" },
} as const;
type Topic = keyof typeof TOPICS;

class Parts implements IWritable {
  #parts: BlobPart[] = [];
  #fresh = 0;
  #size = 0;

  async write(bytes: Uint8Array): Promise<void> {
    this.#parts.push(bytes.slice());
    this.#size += bytes.length;
    this.#fresh += bytes.length;
    if (this.#fresh < BLOB_BYTES) return;
    this.#parts = [new Blob(this.#parts)];
    this.#fresh = 0;
  }

  position(): bigint {
    return BigInt(this.#size);
  }

  get blob(): Blob {
    return new Blob(this.#parts, { type: "application/octet-stream" });
  }
}

function nowNs(): bigint {
  return BigInt(Date.now()) * 1_000_000n;
}

function text(values: unknown): string {
  return JSON.stringify(values, (_, value: unknown) => (typeof value === "bigint" ? Number(value) : value));
}

export class Recording implements Keeper {
  samples = 0;
  readonly #parts = new Parts();
  readonly #writer = new McapWriter({ writable: this.#parts, chunkSize: CHUNK_BYTES });
  readonly #channels = new Map<Topic, number>();
  readonly #sequences = new Map<Topic, number>();
  // The times of all messages are the device's, laid on the host's clock once.
  readonly #hostMinusDeviceNs: bigint;
  #newestNs: bigint;
  #lost: number;
  // The library writes one thing at a time.
  #turn: Promise<unknown> = Promise.resolve();

  private constructor(private readonly knob: Knob, deviceNs: bigint) {
    this.#newestNs = deviceNs;
    this.#hostMinusDeviceNs = nowNs() - deviceNs;
    this.#lost = knob.decoder.lost;
  }

  /** Keeps all that travels from now on. */
  static async begin(knob: Knob): Promise<Recording> {
    const configuration: Record<string, Given> = {};
    for (const name of CONFIGURATIONS) configuration[REPORTS[name]!.title] = await knob.config(name);
    const recording = new Recording(knob, (await knob.read("clock")).time_ns as bigint);
    await recording.#start(configuration);
    knob.keeper = recording;
    return recording;
  }

  async #start(configuration: Record<string, Given>): Promise<void> {
    const { identity, transport } = this.knob;
    await this.#writer.start({ profile: "torsio", library: "torsio studio" });
    const encoder = new TextEncoder();
    for (const [topic, fields] of Object.entries(TOPICS) as [Topic, Record<string, string>][]) {
      const properties = Object.fromEntries(Object.entries(fields).map(([name, type]) => [name, { type }]));
      const schema = {
        $schema: "https://json-schema.org/draft/2020-12/schema", title: `torsio.${topic}`, type: "object", properties,
        required: Object.keys(properties),
      };
      const schemaId = await this.#writer.registerSchema({
        name: `torsio.${topic}`, encoding: "jsonschema", data: encoder.encode(text(schema)),
      });
      this.#channels.set(topic, await this.#writer.registerChannel({
        schemaId, topic, messageEncoding: "json", metadata: new Map(),
      }));
    }
    const info = {
      path: transport.title, serial: identity.serial, product: "Torsio knob",
      board: identity.board === 0 ? "emulated" : `board ${identity.board}`,
      firmware_version: identity.firmware, protocol_version: PROTOCOL_VERSION, fingerprint: FINGERPRINT,
      effects: identity.effects, curve_points: identity.curvePoints,
      control_rate_hz: 1e9 / identity.controlPeriodNs, counts_per_rev: identity.countsPerRev,
      torque_step_nm: identity.torqueStepNm, speed_step_rad_s: identity.speedStepRadS,
    };
    const versions = {
      protocol: PROTOCOL_VERSION, fingerprint: FINGERPRINT, firmware: identity.firmware, studio: navigator.userAgent,
    };
    // A number of JavaScript's has too few digits.
    const clock = new Map([["host_minus_device_ns", String(this.#hostMinusDeviceNs)]]);
    await this.#writer.addMetadata({ name: "clock", metadata: clock });
    // Last the versions: who has them has all of these.
    for (const [name, values] of Object.entries({ info, configuration, versions })) {
      const metadata = new Map(Object.entries(values).map(([key, value]) => [key, text(value)]));
      await this.#writer.addMetadata({ name, metadata });
    }
  }

  #add(topic: Topic, deviceNs: bigint, message: object): void {
    const sequence = (this.#sequences.get(topic) ?? 0) + 1;
    this.#sequences.set(topic, sequence);
    const data = new TextEncoder().encode(text(message));
    const channelId = this.#channels.get(topic)!;
    const logTime = this.#hostMinusDeviceNs + deviceNs, publishTime = nowNs();
    this.#turn = this.#turn.then(() =>
      this.#writer.addMessage({ channelId, sequence, logTime, publishTime, data }),
    );
    this.#turn.catch(() => {}); // told at the end
  }

  /** An event of the user's. */
  note(kind: string, values: object = {}): void {
    this.#add("events", this.#newestNs, { kind, ...values });
  }

  sample(row: ArrayLike<number>, tick: number, counts: number, flags: number): void {
    const [time_s, angle_rad, speed_rad_s, desired_torque_nm, motor_command_nm, brake_capacity_nm, spring_torque_nm] =
      Array.from(row);
    const deviceNs = (this.#newestNs = BigInt(Math.round(1e9 * time_s!)));
    const { lost } = this.knob.decoder;
    if (lost > this.#lost) {
      this.#add("drop_outs", deviceNs, { samples_lost: lost - this.#lost });
      this.#lost = lost;
    }
    ++this.samples;
    this.#add("telemetry", deviceNs, {
      tick, time_s, position_counts: counts, angle_rad, speed_rad_s, desired_torque_nm, motor_command_nm,
      brake_capacity_nm, spring_torque_nm, flags,
    });
  }

  report(tick: number, sent: boolean, bytes: Uint8Array): void {
    let name = "", values: Values = {};
    try {
      ({ name, values } = decode(bytes));
    } catch {
      // Kept as it is.
    }
    const hex = Array.from(bytes, (byte) => byte.toString(16).padStart(2, "0")).join("");
    this.#add("reports", this.#timeNs(tick), { tick, sent, name, bytes: hex });
    if (name === "event") this.#add("device_events", this.#timeNs(Number(values.tick)), values);
  }

  #timeNs(tick: number): bigint {
    return BigInt(Math.round(tick * this.knob.identity.controlPeriodNs));
  }

  /** @throws Error if not all could be written */
  async end(): Promise<void> {
    if (this.knob.keeper === this) this.knob.keeper = undefined;
    await this.#turn;
    await this.#writer.end();
  }

  /** As far as it is written. */
  get file(): Blob {
    return this.#parts.blob;
  }
}
