// Calibration as guided steps: `torsio studio` measures the knob that it holds, and the page shows
// each step, the result with its pictures, and what is proposed. Nothing is kept without a yes.

import { byId, colour, element } from "./page";

type Attempt = (act: () => Promise<unknown>) => void;

interface Fit {
  title: string;
  x_label: string;
  y_label: string;
  x: number[];
  measured: number[];
  fitted: number[];
  residual_rms: number;
}

interface Found {
  kind: "found";
  seconds: number;
  /** Name, value with its uncertainty, meaning. */
  quantities: [string, string, string][];
  /** Name, value in the knob, value proposed. */
  changes: [string, number | string, number | string][];
  compared_with: string | null;
  drifted: [string, number, number][];
  fits: Fit[];
}

type Said =
  | { kind: "step"; name: string }
  | Found
  | { kind: "kept"; path: string; forgets: boolean }
  | { kind: "refused"; why: string };

// Only a knob that measures its motor's current has the circuit's.
const STEPS = ["current sensor", "signs", "torque constant", "friction and inertia", "winding", "shaft", "brake"];
const DRIFT_STEPS = ["signs", "friction and inertia", "shaft"];

function table(headings: readonly string[], rows: readonly (readonly string[])[]): HTMLElement {
  return element(
    "table", {},
    element("thead", {}, element("tr", {}, ...headings.map((text) => element("th", { scope: "col" }, text)))),
    element("tbody", {}, ...rows.map((row) => element("tr", {}, ...row.map((text) => element("td", {}, text))))),
  );
}

function digits(value: number | string): string {
  return typeof value === "number" ? value.toPrecision(4) : value;
}

/** Data as dots, the model as small squares upon them, in the style of the other curves. */
function picture(fit: Fit): HTMLElement {
  const width = 640, height = 360, margin = 28;
  const words = `${fit.title}: ${fit.y_label} over ${fit.x_label}; the model leaves ${fit.residual_rms.toPrecision(2)}`;
  const canvas = element("canvas", { width, height, role: "img", "aria-label": words });
  const context = canvas.getContext("2d")!;
  const scale = (values: readonly number[], from: number, to: number): ((value: number) => number) => {
    const low = Math.min(...values), high = Math.max(...values);
    return (value) => from + ((value - low) / (high - low || 1)) * (to - from);
  };
  const ys = [...fit.measured, ...fit.fitted];
  const x = scale(fit.x, margin, width - margin), y = scale(ys, height - margin, margin);
  const dots = (name: string, values: readonly number[], size: number): void => {
    context.fillStyle = colour(name);
    values.forEach((value, i) => context.fillRect(x(fit.x[i]!) - size / 2, y(value) - size / 2, size, size));
  };
  dots("line", fit.measured, 5);
  dots("spring", fit.fitted, 2.5);
  context.fillStyle = colour("text");
  context.font = "18px sans-serif";
  const ends = (values: readonly number[]): string[] =>
    [Math.min(...values), Math.max(...values)].map((value) => String(Number(value.toPrecision(3))));
  const [left, right] = ends(fit.x), [bottom, top] = ends(ys);
  context.fillText(`${fit.y_label}: ${bottom} to ${top}`, margin, 18);
  const under = `${fit.x_label}: ${left} to ${right}`;
  context.fillText(under, width - margin - context.measureText(under).width, height - 6);
  return element("figure", {}, canvas, element("figcaption", {}, words));
}

export class Calibrating {
  readonly #start = byId<HTMLButtonElement>("calibrate");
  readonly #clear = byId<HTMLInputElement>("calibrate-clear");
  readonly #drift = byId<HTMLInputElement>("calibrate-drift");
  readonly #supply = byId<HTMLInputElement>("calibrate-supply");
  readonly #result = byId("calibration-result");
  #socket: WebSocket | undefined;
  #can = false;

  /**
   * @param address of the server, for the calibration; undefined: nobody here can measure
   * @param letGo gives the knob to the server; @param take takes it back
   */
  constructor(
    private readonly address: () => URL | undefined,
    attempt: Attempt,
    private readonly letGo: () => Promise<void>,
    private readonly take: () => Promise<void>,
  ) {
    this.#clear.addEventListener("change", () => this.enable(this.#can));
    this.#start.addEventListener("click", () => attempt(() => this.#run()));
    byId("calibrate-stop").addEventListener("click", () => this.stop());
  }

  get running(): boolean {
    return this.#socket !== undefined;
  }

  /** @param can the knob is here, disarmed, and the page may drive it */
  enable(can: boolean): void {
    this.#can = can;
    const here = this.address() !== undefined;
    byId("calibrate-elsewhere").hidden = here;
    byId("calibrate-here").hidden = !here;
    this.#start.disabled = !can || !this.#clear.checked || this.running;
    byId<HTMLButtonElement>("calibrate-stop").disabled = !this.running;
    byId<HTMLButtonElement>("connect").disabled = this.running;
  }

  /** The server stops the knob when the page goes. */
  stop(): void {
    this.#socket?.close();
  }

  async #run(): Promise<void> {
    const drift = this.#drift.checked;
    const steps = drift ? DRIFT_STEPS : STEPS;
    const places = steps.map((name) => element("li", {}, name));
    this.#result.replaceChildren(element("ol", { id: "calibration-steps" }, ...places));
    const address = this.address()!;
    await this.letGo();
    const socket = (this.#socket = new WebSocket(address));
    this.enable(false);
    const tell = (text: string): void => this.#result.append(element("p", { class: "hint" }, text));
    // The last message, for a user who did not see the end.
    let found = false;
    const supply = this.#supply.value === "" ? null : this.#supply.valueAsNumber;
    socket.onopen = () => socket.send(JSON.stringify({ do: "calibrate", drift, supply_v: supply }));
    socket.onmessage = (event: MessageEvent<string>) => {
      const said = JSON.parse(event.data) as Said;
      if (said.kind === "step") {
        const at = steps.indexOf(said.name);
        places.forEach((place, i) => {
          if (i < at && place.className === "") place.hidden = true; // this knob does without
          place.className = i < at ? "done" : i === at ? "now" : "";
        });
      } else if (said.kind === "refused") {
        found = true;
        tell(said.why);
      } else if (said.kind === "found") {
        found = true;
        for (const place of places) place.className = "done";
        this.#show(said, socket);
      } else {
        tell(said.forgets
          ? `Kept with its uncertainties in ${said.path}. The emulated knob forgets it, at the latest when torsio studio ends.`
          : `Kept in the knob, and with its uncertainties in ${said.path}.`);
      }
    };
    await new Promise<void>((resolve) => {
      socket.onclose = (event) => {
        if (!found) tell(event.reason || "Stopped: nothing was measured, and nothing has changed.");
        resolve();
      };
    });
    this.#socket = undefined;
    for (const button of this.#result.querySelectorAll("button")) button.remove();
    this.enable(false);
    await this.take();
  }

  #show(found: Found, socket: WebSocket): void {
    const drift = found.compared_with === null ? [] : [
      `Compared with ${found.compared_with}: ` + (found.drifted.length
        ? `drifted: ${found.drifted.map(([name, old, now]) => `${name} ${old.toPrecision(4)} → ${now.toPrecision(4)}`).join(", ")}`
        : "nothing has drifted"),
    ];
    const keep = element("button", { type: "button", id: "calibration-keep" }, "keep this in the knob");
    keep.addEventListener("click", () => {
      keep.disabled = true;
      socket.send(JSON.stringify({ do: "keep" }));
    });
    const leave = element("button", { type: "button", id: "calibration-leave" }, "leave it as it was");
    leave.addEventListener("click", () => {
      this.#result.append(element("p", { class: "hint" }, "Nothing has changed."));
      socket.close();
    });
    this.#result.append(
      ...[`Measured in ${found.seconds.toFixed(0)} s of the knob's time.`, ...drift].map((text) => element("p", {}, text)),
      table(["quantity", "value ± standard uncertainty", "what it is"],
        found.quantities.map(([name, value, meaning]) => [name, value.replace("+-", "±"), meaning])),
      element("div", { class: "pictures" }, ...found.fits.map(picture)),
      element("p", {}, found.changes.length ? "Proposed for the configuration; the motor's values take effect when you plug the knob in again:" : "There is nothing to change."),
      table(["field", "in the knob", "proposed"],
        found.changes.map(([name, before, after]) => [name, digits(before), digits(after)])),
      element("div", { class: "buttons" }, keep, leave),
    );
  }
}
