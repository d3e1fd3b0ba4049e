// The knob's configuration: shown, changed, compared with a file, kept.

import { described } from "./codec";
import type { Given } from "./conversion";
import { form } from "./form";
import type { Knob } from "./knob";
import { byId, element, label, saveFile } from "./page";
import { CONFIGURATIONS } from "./reports";
import { textOf } from "./text_file";

type Attempt = (act: () => Promise<unknown>) => void;

function isObject(value: unknown): boolean {
  return typeof value === "object" && value !== null && !Array.isArray(value);
}

export class Configurations {
  /** As the knob has them. */
  #known: Record<string, Given> = {};
  /** As the page shows them. */
  #shown: Record<string, Given> = {};

  constructor(private readonly knob: () => Knob | undefined, private readonly attempt: Attempt) {
    byId("save").addEventListener("click", () => attempt(async () => this.knob()?.command("save")));
    byId("export-configuration").addEventListener("click", () => this.#toFile());
    const file = byId<HTMLInputElement>("import-configuration");
    file.addEventListener("change", () => {
      const chosen = file.files?.[0];
      if (chosen) attempt(async () => this.#fromFile(await textOf(chosen)));
      file.value = "";
    });
  }

  enable(can: boolean): void {
    byId<HTMLButtonElement>("save").disabled = !can;
    byId<HTMLButtonElement>("export-configuration").disabled = !this.knob();
    for (const apply of document.querySelectorAll<HTMLButtonElement>(".apply")) apply.disabled = !can;
  }

  /** Asks the knob, and shows what it says; in those that are not `fresh` what the user has edited stays. */
  async load(fresh: readonly string[] = CONFIGURATIONS): Promise<void> {
    const knob = this.knob();
    if (!knob) return;
    for (const name of CONFIGURATIONS) {
      const before = this.#known[name], shown = this.#shown[name], now = await knob.config(name);
      this.#known[name] = now;
      const edited = !before || !shown || fresh.includes(name) ? [] : Object.keys(now).filter((f) => shown[f] !== before[f]);
      this.#shown[name] = { ...now, ...Object.fromEntries(edited.map((field) => [field, shown![field]])) };
    }
    this.#build();
  }

  #build(): void {
    const open = new Set([...document.querySelectorAll("#configurations > details[open]")].map((d) => d.id));
    byId("configurations").replaceChildren(
      ...CONFIGURATIONS.map((name) => {
        const { fields, doc, notes } = described(name);
        const differences = element("p", { class: "differences", role: "status" });
        const compare = (): void => {
          differences.textContent = this.#differences(name).join("; ");
        };
        const apply = element("button", { type: "button", class: "apply" }, "apply");
        apply.addEventListener("click", () =>
          this.attempt(async () => {
            await this.knob()?.configure(name, this.#shown[name]!);
            await this.load([name]);
          }),
        );
        const card = element(
          "details",
          { id: name, open: open.has(name) },
          element("summary", {}, label(name)),
          element("p", {}, ...`${doc} ${notes}`.split("`").map((part, i) => (i % 2 ? element("code", {}, part) : part))),
          form(fields, this.#shown[name]!, compare),
          differences,
          apply,
        );
        compare();
        return card;
      }),
    );
    this.enable(this.knob()?.state === "disarmed" && !this.knob()?.transport.readOnly);
  }

  #differences(name: string): string[] {
    const known = this.#known[name]!, shown = this.#shown[name]!;
    return Object.keys(known)
      .filter((field) => known[field] !== shown[field])
      .map((field) => `${label(field)}: ${String(known[field])} in the knob, ${String(shown[field])} here`);
  }

  #toFile(): void {
    const file = new Blob([JSON.stringify(this.#shown, null, 2) + "\n"], { type: "application/json" });
    saveFile(file, "torsio-configuration.json");
  }

  /** Shows what a file has; nothing is sent. @throws Error that says what is wrong with it */
  #fromFile(content: string): void {
    let read: Record<string, Given>;
    try {
      read = JSON.parse(content) as Record<string, Given>;
    } catch {
      throw new Error("the file is no configuration: it is not JSON");
    }
    if (!isObject(read)) throw new Error("the file is no configuration: it has no fields");
    for (const [name, config] of Object.entries(read)) {
      if (!CONFIGURATIONS.includes(name)) throw new Error(`the file has ${name}, which is no configuration`);
      if (!isObject(config)) throw new Error(`the file's ${name} is no configuration: it has no fields`);
      for (const field of Object.keys(config)) {
        if (!described(name).fields.some((f) => f.shown && f.name === field)) {
          throw new Error(`the file has ${name}.${field}, which is no field of it`);
        }
      }
    }
    for (const [name, config] of Object.entries(read)) Object.assign(this.#shown[name]!, config);
    this.#build();
  }
}
