// Reports as objects and as bytes, by the rules of the device: docs/reference/protocol.md.

import type { Field, Report, Scalar } from "./fields";
import { REPORTS, STATUSES } from "./reports";

export const REPORT_SIZE = 64;

export type Value = number | bigint | string | Value[] | { [name: string]: Value };
export type Values = { [name: string]: Value };

/** A report that breaks a rule; `status` is the one that a device would answer. */
export class MalformedReport extends Error {
  constructor(
    readonly report: string,
    readonly status: string,
    /** Index of the offending field, nested fields opened; none if it is the whole report. */
    readonly field?: number,
  ) {
    const meaning = STATUSES.find((s) => s.name === status)?.doc ?? "";
    const place = field === undefined ? "" : `, field ${field}`;
    super(`${report || "report"}: ${status}${place} (${meaning})`);
  }
}

/** What a DataView calls them. */
const KINDS: Record<Scalar, string> = {
  u8: "Uint8", u16: "Uint16", u32: "Uint32", u64: "BigUint64", i8: "Int8", i16: "Int16", i32: "Int32", i64: "BigInt64",
  f32: "Float32",
};
type Access = Record<string, (at: number, ...rest: unknown[]) => number | bigint>;

function bitsOf(type: Scalar): number {
  return Number(type.slice(1));
}

const BY_ID = new Map(Object.entries(REPORTS).map(([name, report]) => [report.id, name]));

export function described(name: string): Report {
  const report = REPORTS[name];
  if (!report) throw new Error(`there is no report ${name}`);
  return report;
}

/** Bytes of a field, all its elements together. */
export function sizeOf(field: Field): number {
  const one = field.fields ? field.fields.reduce((sum, inner) => sum + sizeOf(inner), 0) : field.wire ? bitsOf(field.type!) / 8 : 0;
  return one * (field.count ?? 1);
}

/** Where a field stands, if the first of them stands at `begin`. */
export function offsetOf(fields: readonly Field[], wire: string, begin: number): number {
  const index = fields.findIndex((field) => field.wire === wire);
  if (index < 0) throw new Error(`there is no field ${wire}`);
  return fields.slice(0, index).reduce((at, field) => at + sizeOf(field), begin);
}

export function nameOf(id: number): string | undefined {
  return BY_ID.get(id);
}

function put(view: DataView, at: number, type: Scalar, value: Value = 0): void {
  let written: unknown = Number(value);
  if (type !== "f32") {
    const whole = typeof value !== "number" || Number.isInteger(value) ? BigInt(value as string) : undefined;
    const bits = bitsOf(type), fits = type[0] === "u" ? BigInt.asUintN : BigInt.asIntN;
    if (whole === undefined || fits(bits, whole) !== whole) throw new RangeError(`${value} does not fit into ${type}`);
    if (bits === 64) written = whole;
  }
  (view as unknown as Access)[`set${KINDS[type]}`]!(at, written, true);
}

function get(view: DataView, at: number, type: Scalar): number | bigint {
  return (view as unknown as Access)[`get${KINDS[type]}`]!(at, true);
}

function numbered(field: Field, value: Value | undefined): Value | undefined {
  const values = field.values;
  const given = value ?? field.default;
  if (!values) return given as Value | undefined;
  if (typeof given === "boolean") return Number(given);
  if (typeof given !== "string") return given;
  const index = values.indexOf(given);
  if (index < 0) throw new RangeError(`${field.name}: ${given} is none of ${values.join(", ")}`);
  return index;
}

/** The bytes of a report. Fields that are not given keep their defaults; ranges are not checked. */
export function encode(name: string, values: Values = {}): Uint8Array {
  const bytes = new Uint8Array(REPORT_SIZE);
  const view = new DataView(bytes.buffer);
  bytes[0] = described(name).id;
  let at = 1;
  const write = (fields: Field[], given: Values): void => {
    const names = new Set(fields.map((f) => f.wire));
    for (const key of Object.keys(given)) {
      if (!names.has(key)) throw new Error(`${name} has no field ${key}`);
    }
    for (const field of fields) {
      if (field.wire === undefined) continue;
      const value = given[field.wire];
      for (let i = 0; i < (field.count ?? 1); ++i) {
        const one = field.count ? (value as Value[] | undefined)?.[i] : value;
        if (field.fields) {
          write(field.fields, (one ?? {}) as Values);
        } else {
          put(view, at, field.type!, numbered(field, one));
          at += bitsOf(field.type!) / 8;
        }
      }
    }
  };
  write(described(name).fields, values);
  return bytes;
}

/** False for what is not finite, too. */
function inRange(field: Field, value: number | bigint): boolean {
  if (field.low === undefined || field.high === undefined) return true;
  if (typeof value === "bigint") return value >= BigInt(field.low) && value <= BigInt(field.high);
  const exact = field.type === "f32" ? Math.fround : Number;
  return value >= exact(Number(field.low)) && value <= exact(Number(field.high));
}

/** Reads the bytes of a report. @throws MalformedReport */
export function decode(bytes: Uint8Array): { name: string; values: Values } {
  if (bytes.length !== REPORT_SIZE) throw new MalformedReport("", "bad_length");
  const name = nameOf(bytes[0]!);
  if (name === undefined) throw new MalformedReport("", "unknown_report");
  const report = described(name);
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.length);
  for (let i = 1 + report.size; i < REPORT_SIZE; ++i) {
    if (bytes[i] !== 0) throw new MalformedReport(name, "bad_padding");
  }
  let at = 1;
  let index = 0;
  const read = (fields: Field[]): Values => {
    const values: Values = {};
    for (const field of fields) {
      if (field.wire === undefined) continue;
      const one = (): Value => {
        if (field.fields) return read(field.fields);
        const value = get(view, at, field.type!);
        at += bitsOf(field.type!) / 8;
        if (field.type === "f32" && !Number.isFinite(value)) {
          throw new MalformedReport(name, "not_finite", index);
        }
        if (field.values) {
          const known = field.values[Number(value)];
          if (known === undefined && !field.open) {
            throw new MalformedReport(name, "out_of_range", index);
          }
          return known ?? value;
        }
        if (!inRange(field, value)) throw new MalformedReport(name, "out_of_range", index);
        return value;
      };
      values[field.wire] = field.count ? Array.from({ length: field.count }, one) : one();
      if (!field.fields) ++index;
    }
    return values;
  };
  return { name, values: read(report.fields) };
}
