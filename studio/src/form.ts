// A form for the fields of a report, from the printed table: units, ranges, words.

import type { Given } from "./conversion";
import type { Field } from "./fields";
import { element, label } from "./page";

let made = 0;

function numeric(field: Field): Element {
  const bounded = field.kind !== "angle" && field.kind !== "optional";
  return element("input", {
    type: "number",
    step: field.kind === "whole" ? 1 : "any",
    min: bounded ? field.low : undefined,
    max: bounded ? field.high : undefined,
    required: field.kind !== "optional",
  });
}

function control(field: Field): HTMLInputElement | HTMLSelectElement {
  if (field.kind === "switch") return element("input", { type: "checkbox" });
  if (field.values) return element("select", {}, ...field.values.map((v) => element("option", {}, v)));
  if (field.kind === "numbers") return element("input", { type: "text", inputmode: "decimal" });
  return numeric(field) as HTMLInputElement;
}

function show(input: HTMLInputElement | HTMLSelectElement, field: Field, value: Given[string]): void {
  if (input instanceof HTMLInputElement && input.type === "checkbox") input.checked = Boolean(value);
  else if (Array.isArray(value)) input.value = value.join(", ");
  else input.value = value === undefined ? "" : String(field.kind === "angle" ? Number(value) : value);
}

function read(input: HTMLInputElement | HTMLSelectElement, field: Field): Given[string] {
  if (input instanceof HTMLInputElement && input.type === "checkbox") return input.checked;
  if (field.values) return input.value;
  if (field.kind === "numbers") {
    return input.value.split(/[\s,;]+/).filter((part) => part !== "").map(Number);
  }
  return input.value.trim() === "" ? undefined : Number(input.value);
}

/** A row for each field, and a fold for each group of fields. Calls `changed` with every edit. */
export function form(fields: readonly Field[], given: Given, changed: () => void): HTMLElement {
  const rows = element("div", { class: "fields" });
  for (const field of fields) {
    if (!field.shown) continue;
    if (field.kind === "group") {
      const inner = (given[field.name] ??= {}) as Given;
      rows.append(
        element("details", {}, element("summary", {}, label(field.name)), form(field.fields ?? [], inner, changed)),
      );
      continue;
    }
    given[field.name] ??= field.default as Given[string];
    if (field.kind === "angle") given[field.name] = Number(given[field.name]);
    const input = control(field);
    const id = `field-${++made}`;
    input.id = id;
    input.name = field.name;
    const bounds = input.getAttribute("min") === null ? "" : ` (${field.low} to ${field.high})`;
    input.title = `${field.name}: ${field.doc}${bounds}`;
    show(input, field, given[field.name]);
    input.addEventListener("input", () => {
      given[field.name] = read(input, field);
      changed();
    });
    rows.append(
      element("label", { for: id, title: input.title }, label(field.name)),
      input,
      element("span", { class: "unit" }, field.unit ?? ""),
    );
  }
  return rows;
}
