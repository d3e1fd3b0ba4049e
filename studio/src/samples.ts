// Telemetry: from reports to numbers, and to curves thinned for the screen without losing a peak.

import { MalformedReport, offsetOf, REPORT_SIZE, sizeOf } from "./codec";
import { REPORTS } from "./reports";

/** Columns of a sample, after its time. */
export const CHANNELS = [
  "angle_rad", "speed_rad_s", "desired_torque_nm", "motor_command_nm", "brake_capacity_nm",
  "spring_torque_nm",
] as const;
export type Channel = (typeof CHANNELS)[number];

export interface Units {
  controlPeriodNs: number;
  countsPerRev: number;
  torqueStepNm: number;
  speedStepRadS: number;
}

const TELEMETRY = REPORTS.telemetry!;
const SAMPLE = TELEMETRY.fields.find((field) => field.wire === "sample")!;
/** Where things stand in the report; thousands a second are read, so without an object for each. */
const AT = Object.fromEntries(TELEMETRY.fields.map((field) => [field.wire!, offsetOf(TELEMETRY.fields, field.wire!, 1)]));
const IN_SAMPLE = Object.fromEntries(SAMPLE.fields!.map((field) => [field.wire!, offsetOf(SAMPLE.fields!, field.wire!, 0)]));
const SAMPLE_BYTES = sizeOf(SAMPLE) / SAMPLE.count!;
// More ticks at once than a knob can have missed: a report that is damaged, or a device that began anew.
const LEAP_TICKS = 1e7;

/** @throws MalformedReport */
function sampleCount(report: Uint8Array, view: DataView): number {
  if (report.length !== REPORT_SIZE) throw new MalformedReport("telemetry", "bad_length");
  const count = view.getUint8(AT.axis_samples!) >> 4;
  if (count >= 1 && count <= SAMPLE.count! && report[0] === TELEMETRY.id) return count;
  throw new MalformedReport("telemetry", "out_of_range");
}

/** Makes rows (time in s, CHANNELS) of telemetry reports, and counts what is missing. */
export class TelemetryDecoder {
  lost = 0;
  received = 0;
  /** Time of the newest report. */
  flags = 0;
  decimation = 0;
  #position = 0;
  #nextTick: number | undefined;
  // One row for all samples: the caller copies it.
  readonly #row = new Float64Array(1 + CHANNELS.length);

  constructor(private units: Units) {}

  /** Telemetry begins anew; the device's position is known in full. */
  begin(units: Units, position: bigint): void {
    this.units = units;
    this.#position = Number(position);
    this.#nextTick = undefined;
  }

  /**
   * @param take gets each row, which is used again, the tick that it is of, and the position in counts
   * @throws MalformedReport
   */
  decode(report: Uint8Array, take: (row: Float64Array, tick: number, counts: number) => void): void {
    const view = new DataView(report.buffer, report.byteOffset, report.byteLength);
    const count = sampleCount(report, view);
    const { controlPeriodNs, countsPerRev, torqueStepNm, speedStepRadS } = this.units;
    const tick = Number(view.getBigUint64(AT.tick!, true));
    const decimation = view.getUint8(AT.decimation!);
    const missed = this.#nextTick === undefined || decimation !== this.decimation ? 0 : tick - this.#nextTick;
    this.#nextTick = tick + decimation * count;
    // The next one tells whether it was this one that was wrong; neither is drawn beside the others.
    if (Math.abs(missed) > LEAP_TICKS || decimation === 0 || tick > Number.MAX_SAFE_INTEGER) throw new MalformedReport("telemetry", "out_of_range");
    if (missed > 0) this.lost += Math.round(missed / decimation);
    this.decimation = decimation;
    this.flags = view.getUint8(AT.flags!);
    // The way from the last position, which 32 bits tell; a double holds the sum to the count.
    this.#position += (view.getInt32(AT.base_counts!, true) - (this.#position % 2 ** 32)) | 0;
    const row = this.#row;
    for (let i = 0, at = AT.sample!; i < count; ++i, at += SAMPLE_BYTES) {
      const position = this.#position + view.getInt16(at + IN_SAMPLE.offset_counts!, true);
      const ticks = tick + i * decimation;
      row[0] = 1e-9 * ticks * controlPeriodNs;
      row[1] = (position * 2 * Math.PI) / countsPerRev;
      row[2] = view.getInt16(at + IN_SAMPLE.speed!, true) * speedStepRadS;
      row[3] = view.getInt16(at + IN_SAMPLE.desired_torque!, true) * torqueStepNm;
      row[4] = view.getInt16(at + IN_SAMPLE.motor_command!, true) * torqueStepNm;
      row[5] = view.getInt16(at + IN_SAMPLE.brake_capacity!, true) * torqueStepNm;
      row[6] = view.getInt16(at + IN_SAMPLE.spring_torque!, true) * torqueStepNm;
      ++this.received;
      take(row, ticks, position);
    }
  }
}

/**
 * Samples for curves: the lowest and the highest value of each curve in each step of time. So no
 * peak is lost, and a picture costs the same at any rate. Each sample is looked at once.
 */
export class Steps {
  readonly #low: Float64Array[];
  readonly #high: Float64Array[];
  /** Another column where a curve was lowest, and where highest. */
  readonly #besideLow: Float64Array[];
  readonly #besideHigh: Float64Array[];
  /** Whether the highest came before the lowest. */
  readonly #falls: Uint8Array[];
  readonly #samples: Uint16Array;
  #newest = -1;
  #oldest = 0;
  #begun = 0;

  constructor(private readonly curves: number, readonly capacity: number, readonly stepS: number) {
    const columns = (): Float64Array[] => Array.from({ length: curves }, () => new Float64Array(capacity));
    this.#low = columns();
    this.#high = columns();
    this.#besideLow = columns();
    this.#besideHigh = columns();
    this.#falls = Array.from({ length: curves }, () => new Uint8Array(capacity));
    this.#samples = new Uint16Array(capacity);
  }

  clear(): void {
    this.#newest = -1;
    ++this.#begun;
    this.#samples.fill(0);
  }

  /** @param beside is kept with the extremes: the angle where they were */
  push(timeS: number, values: ArrayLike<number>, beside: number): void {
    const step = Math.floor(timeS / this.stepS);
    if (this.#newest < 0 || step < this.#newest || step - this.#newest >= this.capacity) {
      this.clear();
      this.#oldest = this.#newest = step;
    }
    // Steps without a sample stay empty.
    for (; this.#newest < step; ) this.#samples[++this.#newest % this.capacity] = 0;
    this.#oldest = Math.max(this.#oldest, step - this.capacity + 1);
    const at = step % this.capacity;
    const first = this.#samples[at] === 0;
    this.#samples[at] = Math.min(this.#samples[at]! + 1, 0xffff);
    for (let i = 0; i < this.curves; ++i) {
      const value = values[i]!;
      if (first || value < this.#low[i]![at]!) {
        this.#low[i]![at] = value;
        this.#besideLow[i]![at] = beside;
        this.#falls[i]![at] = 1;
      }
      if (first || value > this.#high[i]![at]!) {
        this.#high[i]![at] = value;
        this.#besideHigh[i]![at] = beside;
        this.#falls[i]![at] = 0;
      }
    }
  }

  /** The newest step that has samples. */
  get newest(): number {
    return this.#newest;
  }

  /** How often the steps began anew. */
  get begun(): number {
    return this.#begun;
  }

  /** The last step before another one that has samples, or else the oldest step. */
  before(step: number): number {
    do --step;
    while (step > this.#oldest && this.#samples[step % this.capacity] === 0);
    return Math.max(step, this.#oldest);
  }

  /**
   * Gives the steps that have samples, from the last one before a step on: the lowest and the highest
   * value of a curve, and whether the highest came first.
   */
  each(curve: number, from: number, take: (step: number, low: number, high: number, falls: boolean) => void): void {
    for (let step = this.before(from); step <= this.#newest; ++step) {
      const at = step % this.capacity;
      if (this.#samples[at] === 0) continue;
      take(step, this.#low[curve]![at]!, this.#high[curve]![at]!, this.#falls[curve]![at] === 1);
    }
  }

  /** The corners of a curve over what was kept beside it. */
  overBeside(curve: number, take: (beside: number, value: number) => void): void {
    for (let step = this.#oldest; step <= this.#newest; ++step) {
      const at = step % this.capacity;
      const samples = this.#samples[at]!;
      if (samples === 0) continue;
      const falls = this.#falls[curve]![at] === 1;
      if (falls || samples === 1) take(this.#besideHigh[curve]![at]!, this.#high[curve]![at]!);
      if (samples === 1) continue;
      take(this.#besideLow[curve]![at]!, this.#low[curve]![at]!);
      if (!falls) take(this.#besideHigh[curve]![at]!, this.#high[curve]![at]!);
    }
  }
}
