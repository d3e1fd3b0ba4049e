// Types of reports.ts, the printed table.

export type Scalar = "u8" | "u16" | "u32" | "u64" | "i8" | "i16" | "i32" | "i64" | "f32";

type Example = { [name: string]: number | number[] | Example };

export interface Field {
  /** As a person writes it, with the unit as suffix. */
  name: string;
  kind: string;
  doc: string;
  /** Its name in the report; none: it does not travel by itself. */
  wire?: string;
  type?: Scalar;
  /** Of a structure inside the report. */
  fields?: Field[];
  count?: number;
  /** What C++ calls its type. */
  enumeration?: string;
  /** Names of an enumeration's values, by number. */
  values?: string[];
  /** There may be values that have no name here yet. */
  open?: boolean;
  /** Bounds on the wire; of 64-bit numbers as text. */
  low?: number | string;
  high?: number | string;
  unit?: string;
  default?: number | string | boolean;
  /** A person sees it. */
  shown?: boolean;
  /** Something solid begins at this angle. */
  surface?: boolean;
  /** The field that it must not be below. */
  notBelow?: string;
}

export interface Report {
  id: number;
  direction: string;
  title: string;
  doc: string;
  notes: string;
  /** Bytes of the fields, without the id. */
  size: number;
  fields: Field[];
  /** Values of a new effect, so that it can be felt at once; none: it begins empty. */
  example?: Example;
}

export interface Bit {
  name: string;
  bit: number;
  doc: string;
  advice: string;
}
