// Telemetry: from reports to numbers, kept in rings, thinned for the screen without losing a peak.

import type { Values } from "./codec";

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

/** Makes rows (time in s, CHANNELS) of telemetry reports, and counts what is missing. */
export class TelemetryDecoder {
  lost = 0;
  received = 0;
  #position = 0n;
  #nextTick: bigint | undefined;
  #decimation = 0;

  constructor(private units: Units) {}

  /** Telemetry begins anew; the device's position is known in full. */
  begin(units: Units, position: bigint): void {
    this.units = units;
    this.#position = position;
    this.#nextTick = undefined;
  }

  /** @param take gets each row, the tick that it is of, and the position in counts */
  decode(report: Values, take: (row: number[], tick: number, counts: number) => void): void {
    const { controlPeriodNs, countsPerRev, torqueStepNm, speedStepRadS } = this.units;
    const tick = report.tick as bigint;
    const count = Number(report.axis_samples) >> 4;
    // 0 would be a damaged report; it must not divide.
    const decimation = Number(report.decimation) || 1;
    if (this.#nextTick !== undefined && decimation === this.#decimation && tick > this.#nextTick) {
      this.lost += Number(tick - this.#nextTick) / decimation;
    }
    this.#decimation = decimation;
    this.#nextTick = tick + BigInt(decimation * count);
    this.#position += BigInt.asIntN(32, BigInt(report.base_counts as number) - this.#position);
    for (const [i, sample] of (report.sample as Values[]).slice(0, count).entries()) {
      const position = Number(this.#position) + Number(sample.offset_counts);
      ++this.received;
      const at = Number(tick) + i * decimation;
      const row = [
        1e-9 * at * controlPeriodNs,
        (position * 2 * Math.PI) / countsPerRev,
        Number(sample.speed) * speedStepRadS,
        Number(sample.desired_torque) * torqueStepNm,
        Number(sample.motor_command) * torqueStepNm,
        Number(sample.brake_capacity) * torqueStepNm,
        Number(sample.spring_torque) * torqueStepNm,
      ];
      take(row, at, position);
    }
  }
}

/** The newest rows of several columns, the first of which is the time. */
export class Ring {
  readonly #columns: Float64Array[];
  #next = 0;
  #size = 0;

  constructor(width: number, readonly capacity: number) {
    this.#columns = Array.from({ length: width }, () => new Float64Array(capacity));
  }

  push(row: ArrayLike<number>): void {
    this.#columns.forEach((column, i) => (column[this.#next] = row[i]!));
    this.#next = (this.#next + 1) % this.capacity;
    this.#size = Math.min(this.#size + 1, this.capacity);
  }

  clear(): void {
    this.#next = this.#size = 0;
  }

  get size(): number {
    return this.#size;
  }

  /** The newest row; undefined if there is none. */
  last(): number[] | undefined {
    return this.#size ? this.#columns.map((c) => c[(this.#next + this.capacity - 1) % this.capacity]!) : undefined;
  }

  /** @param index 0 is the oldest row */
  at(column: number, index: number): number {
    return this.#columns[column]![(this.#next + this.capacity - this.#size + index) % this.capacity]!;
  }

  /** Index of the first row at or after a time. */
  indexOf(time: number): number {
    let low = 0, high = this.#size;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.at(0, middle) < time) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  /**
   * Times and columns of the rows in [from, to): where there are more than two a pixel, the lowest
   * and the highest value of each, so that no peak is lost.
   */
  envelope(from: number, to: number, pixels: number, columns: readonly number[]): number[][] {
    const first = this.indexOf(from), end = this.indexOf(to);
    const out: number[][] = [[], ...columns.map(() => [])];
    if (end - first <= 2 * pixels) {
      for (let i = first; i < end; ++i) {
        out[0]!.push(this.at(0, i));
        columns.forEach((column, c) => out[c + 1]!.push(this.at(column, i)));
      }
      return out;
    }
    for (let pixel = 0; pixel < pixels; ++pixel) {
      const begin = first + Math.floor(((end - first) * pixel) / pixels);
      const stop = first + Math.floor(((end - first) * (pixel + 1)) / pixels);
      if (begin === stop) continue;
      out[0]!.push(this.at(0, begin), this.at(0, stop - 1));
      columns.forEach((column, c) => {
        let low = Infinity, high = -Infinity;
        for (let i = begin; i < stop; ++i) {
          const value = this.at(column, i);
          if (value < low) low = value;
          if (value > high) high = value;
        }
        // In the order in which the curve goes, so that the line does not jump back and forth.
        const falls = this.at(column, begin) > this.at(column, stop - 1);
        out[c + 1]!.push(falls ? high : low, falls ? low : high);
      });
    }
    return out;
  }
}
