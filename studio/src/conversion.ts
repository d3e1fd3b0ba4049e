// A person's units to the wire's and back. Ranges are checked here, in the unit that was given.

import { described, type Value, type Values } from "./codec";
import type { Field } from "./fields";
import {
  CURVE_POINTS_PER_REPORT, MAX_CYCLES_PER_TURN_Q32, MAX_SPAN_TURNS_Q32, MAX_TORQUE_NM, MAX_TURNS_Q32, MIN_SPAN_TURNS_Q32,
} from "./reports";

const TURN_RAD = 2 * Math.PI;
const Q32 = 2 ** 32;

export type Given = { [name: string]: Given | number | string | boolean | number[] | undefined };
/** An effect as a person writes it: its type, and its fields by name. */
export type Effect = { type: string } & Given;

/** A sentence on a wrong value. */
export class InvalidValue extends Error {}

export interface SceneLimits {
  effects: number;
  curvePoints: number;
  countsPerRev: number;
  controlPeriodNs: number;
}

/** A number as a person would write it. */
export function text(value: number): string {
  return String(Number(value.toPrecision(9)));
}

function bounded(field: Field, value: number): number {
  const low = Number(field.low ?? -Infinity), high = Number(field.high ?? Infinity);
  // The comparison is also false for NaN.
  if (value >= low && value <= high) return value;
  const unit = field.unit ? ` ${field.unit}` : "";
  throw new InvalidValue(`${field.name} is ${value}, allowed are ${text(low)} to ${text(high)}${unit}`);
}

function turnsQ32(name: string, rad: number): bigint {
  const turns = Math.round((rad / TURN_RAD) * Q32);
  if (Math.abs(turns) <= MAX_TURNS_Q32) return BigInt(turns);
  const limit = text((MAX_TURNS_Q32 / Q32) * TURN_RAD);
  throw new InvalidValue(`${name} is ${rad}, allowed are -${limit} to ${limit} rad`);
}

/** The fields of a report as they travel. @throws InvalidValue */
export function toWire(fields: readonly Field[], given: Given): Values {
  const wire: Values = {};
  for (const field of fields) {
    if (!field.shown || field.wire === undefined) continue;
    const value = given[field.name] ?? field.default;
    if (value === undefined && field.kind !== "group") throw new InvalidValue(`${field.name} is missing`);
    wire[field.wire] = field.fields ? toWire(field.fields, (value ?? {}) as Given) : wireValue(field, value);
  }
  return wire;
}

function wireValue(field: Field, value: Given[string]): Values[string] {
  if (field.kind === "angle") return turnsQ32(field.name, Number(value));
  if (field.values) return typeof value === "boolean" ? Number(value) : (value as string);
  if (field.kind === "whole" && !Number.isInteger(Number(value))) {
    throw new InvalidValue(`${field.name} is ${value}, which is no whole number`);
  }
  return bounded(field, Number(value));
}

/** The double that a person would write for a float: 0.1 and not 0.10000000149. */
function widened(value: number): number {
  for (let digits = 1; digits <= 9; ++digits) {
    const short = Number(value.toPrecision(digits));
    if (Math.fround(short) === value) return short;
  }
  return value;
}

/** What came, in a person's units. */
export function fromWire(fields: readonly Field[], wire: Values): Given {
  const given: Given = {};
  for (const field of fields) {
    if (!field.shown || field.wire === undefined) continue;
    const value = wire[field.wire]!;
    if (field.kind === "switch") given[field.name] = value === "on";
    else if (field.kind === "angle") given[field.name] = (Number(value) / Q32) * TURN_RAD;
    else if (field.type === "f32") given[field.name] = widened(value as number);
    else given[field.name] = value as number | string;
  }
  return given;
}

function checkTiming(effect: Effect): void {
  const of = (name: string): number => Number((effect.timing as Given | undefined)?.[name] ?? 0);
  const duration = of("duration_s");
  if (effect.type === "ramp" && duration === 0) {
    throw new InvalidValue("duration_s is 0, but a ramp needs a duration");
  }
  if (duration > 0 && of("attack_s") + of("fade_s") > duration) {
    throw new InvalidValue(
      `attack_s and fade_s together are ${of("attack_s") + of("fade_s")} s, longer than duration_s, which is ${duration} s`,
    );
  }
  if (duration === 0 && of("fade_s") > 0) {
    throw new InvalidValue("fade_s needs a duration_s: an endless effect cannot fade");
  }
}

function checkOrder(fields: readonly Field[], effect: Effect): void {
  for (const { name, notBelow } of fields) {
    if (notBelow !== undefined && Number(effect[name]) < Number(effect[notBelow])) {
      throw new InvalidValue(`${name} is ${effect[name]}, below ${notBelow}, which is ${effect[notBelow]}`);
    }
  }
}

function notchesQ32(effect: Effect, limits: SceneLimits): bigint {
  const given = [effect.per_turn, effect.pitch_rad].filter((v) => v !== undefined);
  if (given.length !== 1) throw new InvalidValue("give exactly one of per_turn and pitch_rad");
  const perTurn =
    effect.per_turn === undefined ? TURN_RAD / Number(effect.pitch_rad) : Number(effect.per_turn);
  const q32 = Math.round(perTurn * Q32);
  const counted = limits.countsPerRev / 2, most = Math.min(counted, MAX_CYCLES_PER_TURN_Q32 / Q32);
  if (q32 >= 1 && q32 <= most * Q32) return BigInt(q32);
  const why = most === counted ? " (a notch takes two counts of this encoder)" : "";
  throw new InvalidValue(`a turn has ${perTurn} notches, allowed are up to ${most}${why}`);
}

/** A scene on the wire: points of its curves first, then a report for each effect. */
export interface WireScene {
  reports: { name: string; values: Values }[];
  effects: number;
}

/** @throws InvalidValue that names the effect, the field and what is allowed */
export function sceneToWire(scene: readonly Effect[], limits: SceneLimits): WireScene {
  if (scene.length > limits.effects) {
    throw new InvalidValue(`the scene has ${scene.length} effects, the device plays up to ${limits.effects}`);
  }
  const pool: number[] = [];
  const effects = scene.map((effect, slot) => {
    try {
      checkTiming(effect);
      const { fields } = described(effect.type);
      const values = toWire(fields, effect);
      checkOrder(fields, effect);
      if (effect.type === "detents") values.per_turn_q32 = notchesQ32(effect, limits);
      if ((effect.type === "periodic" || effect.type === "impact") && Number(effect.frequency_hz) > 0.5e9 / limits.controlPeriodNs) {
        throw new InvalidValue(`frequency_hz is ${effect.frequency_hz}, above half of this device's control rate`);
      }
      if (effect.type === "curve") Object.assign(values, curve(effect, pool, limits));
      values.target = { slot };
      return { name: effect.type, values };
    } catch (error) {
      if (!(error instanceof InvalidValue)) throw error;
      throw new InvalidValue(`effect ${slot} (${effect.type}): ${error.message}`);
    }
  });
  const pieces: { name: string; values: Values }[] = [];
  for (let first = 0; first < pool.length; first += CURVE_POINTS_PER_REPORT) {
    const points = pool.slice(first, first + CURVE_POINTS_PER_REPORT);
    const values: Value[] = [...points];
    while (values.length < CURVE_POINTS_PER_REPORT) values.push(0);
    pieces.push({
      name: "curve_points",
      values: { first_point: first, points: points.length, torque_nm: values },
    });
  }
  return { reports: [...pieces, ...effects], effects: effects.length };
}

function curve(effect: Effect, pool: number[], limits: SceneLimits): Values {
  const torques = (effect.torque_nm as number[] | undefined) ?? [];
  const room = limits.curvePoints - pool.length;
  if (torques.length < 2 || torques.length > room) {
    throw new InvalidValue(`torque_nm has ${torques.length} points, allowed are 2 to ${room}`);
  }
  torques.forEach((torque, i) => {
    if (!(Math.abs(torque) <= MAX_TORQUE_NM)) {
      throw new InvalidValue(`torque_nm[${i}] is ${torque}, allowed are -${MAX_TORQUE_NM} to ${MAX_TORQUE_NM} N m`);
    }
  });
  const span = Math.round((Number(effect.span_rad) / TURN_RAD) * Q32);
  const counts = Math.ceil((2 * Q32) / limits.countsPerRev), least = Math.max(counts, MIN_SPAN_TURNS_Q32);
  if (!(span >= least && span <= MAX_SPAN_TURNS_Q32)) {
    const from = least === counts ? "two counts of the encoder" : `1/${Q32 / least} turn`;
    throw new InvalidValue(`span_rad is ${effect.span_rad}, allowed are ${from} to ${MAX_SPAN_TURNS_Q32 / Q32} turns`);
  }
  const first = pool.length;
  pool.push(...torques);
  return { span_turns_q32: BigInt(span), first_point: first, points: torques.length };
}
