// A scene as the lines of Python and C++ that play it.

import type { Effect, Given } from "./conversion";
import { described } from "./codec";
import type { Field } from "./fields";

function camel(name: string): string {
  return name.replace(/(^|_)(\w)/g, (_, __, letter: string) => letter.toUpperCase());
}

function isDefault(field: Field, value: unknown): boolean {
  return value === undefined || (field.default !== undefined && String(value) === String(field.default));
}

/** Those fields that are not at their defaults, or have none. */
function stated(fields: readonly Field[], given: Given): [Field, Given[string]][] {
  return fields
    .filter((f) => f.shown && (f.kind === "group"
      ? stated(f.fields ?? [], (given[f.name] ?? {}) as Given).length > 0
      : !isDefault(f, given[f.name])))
    .map((f) => [f, given[f.name]]);
}

function python(field: Field, value: Given[string]): string {
  if (field.kind === "group") {
    return `torsio.${camel(field.name)}(${pythonFields(field.fields ?? [], value as Given)})`;
  }
  if (Array.isArray(value)) return `[${value.join(", ")}]`;
  if (typeof value === "boolean") return value ? "True" : "False";
  return typeof value === "string" ? `"${value}"` : String(value);
}

function pythonFields(fields: readonly Field[], given: Given): string {
  return stated(fields, given).map(([f, v]) => `${f.name}=${python(f, v)}`).join(", ");
}

/** The call that plays the scene, for a `knob` that `torsio.open` gave. */
export function pythonLines(scene: readonly Effect[]): string {
  if (!scene.length) return "knob.play([])\n";
  const effects = scene.map((e) => {
    const { title, fields } = described(e.type);
    return `torsio.${title}(${pythonFields(fields, e)})`;
  });
  if (effects.length === 1) return `knob.play(${effects[0]})\n`;
  return `knob.play(\n    [\n${effects.map((e) => `        ${e},\n`).join("")}    ]\n)\n`;
}

function cpp(field: Field, value: Given[string]): string {
  if (field.kind === "group") return `{${cppFields(field.fields ?? [], value as Given)}}`;
  if (Array.isArray(value)) return `{${value.join(", ")}}`;
  if (field.values && typeof value === "string") return `torsio::${field.enumeration}::${value}`;
  return String(value);
}

function cppFields(fields: readonly Field[], given: Given): string {
  return stated(fields, given).map(([f, v]) => `.${f.name} = ${cpp(f, v)}`).join(", ");
}

/** The same for C++. */
export function cppLines(scene: readonly Effect[]): string {
  const effects = scene.map((e) => {
    const { title, fields } = described(e.type);
    return `torsio::${title}{${cppFields(fields, e)}}`;
  });
  // Two empty braces could be an effect too.
  if (!effects.length) return "knob.play(torsio::Scene{});\n";
  if (effects.length === 1) return `knob.play(${effects[0]});\n`;
  return `knob.play({\n${effects.map((e) => `    ${e},\n`).join("")}});\n`;
}
