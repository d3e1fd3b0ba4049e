// The curves: torques and angle over time, and torque over angle.

import uPlot from "uplot";
import { byId, colour, element } from "./page";
import type { Ring } from "./samples";

const WINDOW_S = 5;
// The second plot changes slowly: every second picture is enough.
const OVER_ANGLE_EVERY = 2;

/** What is drawn over time: name, colour of the style sheet, dashes, and column of a sample. */
const CURVES = [
  { name: "wanted", colour: "wanted", dash: [6, 4], column: 3 },
  { name: "motor command", colour: "motor", dash: [], column: 4 },
  { name: "brake capacity", colour: "brake", dash: [2, 3], column: 5 },
  { name: "spring, sensed", colour: "spring", dash: [], column: 6 },
  { name: "angle, on the right", colour: "angle", dash: [10, 3, 2, 3], column: 1 },
] as const;
const ANGLE = CURVES.length - 1;

type Palette = Record<string, string>;

export class Plots {
  #time: uPlot | undefined;
  // To ask for a style is dear.
  #palette: Palette = {};
  #hidden = new Set<number>();
  #pictures = 0;
  #over = { width: 0, height: 0 };
  readonly #canvas = byId<HTMLCanvasElement>("over-angle");
  readonly #place = byId("over-time");

  constructor(private readonly samples: Ring, private readonly truth: Ring) {
    this.#build();
    new ResizeObserver(() => this.#time?.setSize(this.#size())).observe(this.#place);
    new ResizeObserver(() => this.#measure()).observe(this.#canvas);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.#build());
    byId("over-time-legend").append(...CURVES.map((curve, i) => this.#switch(curve.name, curve.colour, curve.dash, i)));
    byId("over-angle-legend").append(
      element("span", {}, sample("wanted", [6, 4]), "wanted"),
      element("span", {}, sample("spring", []), "felt: motor and spring"),
    );
  }

  #size(): { width: number; height: number } {
    return { width: Math.max(200, this.#place.clientWidth), height: 260 };
  }

  #measure(): void {
    this.#over = { width: this.#canvas.clientWidth, height: this.#canvas.clientHeight };
    this.#canvas.width = this.#over.width * devicePixelRatio;
    this.#canvas.height = this.#over.height * devicePixelRatio;
    this.#drawOverAngle();
  }

  /** A curve's name, which shows or hides it. */
  #switch(name: string, stroke: string, dash: readonly number[], i: number): HTMLElement {
    const button = element("button", { type: "button", "aria-pressed": "true" }, sample(stroke, dash), name);
    button.addEventListener("click", () => {
      const shown = this.#hidden.delete(i);
      if (!shown) this.#hidden.add(i);
      button.setAttribute("aria-pressed", String(shown));
      this.#time?.setSeries(i + 1, { show: shown });
    });
    return button;
  }

  #build(): void {
    for (const name of ["text", "grid", ...CURVES.map((curve) => curve.colour)]) this.#palette[name] = colour(name);
    this.#time?.destroy();
    const { text, grid } = this.#palette;
    const thin = { stroke: grid!, width: 1 };
    const axis = { stroke: text!, grid: thin, ticks: thin, labelFont: "12px sans-serif" };
    this.#time = new uPlot(
      {
        ...this.#size(),
        cursor: { show: false },
        scales: { x: { time: false }, nm: {}, deg: {} },
        series: [
          { label: "time" },
          ...CURVES.map((curve, i) => ({
            label: curve.name, scale: i === ANGLE ? "deg" : "nm", stroke: this.#palette[curve.colour]!, width: 1.5,
            dash: [...curve.dash], points: { show: false }, show: !this.#hidden.has(i),
          })),
        ],
        axes: [
          { ...axis, label: "time, s", labelSize: 18, size: 34 },
          { ...axis, scale: "nm", label: "torque, mN·m", labelSize: 18, size: 52 },
          { ...axis, scale: "deg", side: 1, label: "angle, degrees", labelSize: 18, size: 52, grid: { show: false } },
        ],
        legend: { show: false },
      },
      [[], ...CURVES.map(() => [])],
      this.#place,
    );
  }

  draw(): void {
    const last = this.samples.last();
    if (!last) return;
    const pixels = Math.max(100, this.#time!.bbox.width / devicePixelRatio);
    const data = this.samples.envelope(last[0]! - WINDOW_S, Infinity, pixels, CURVES.map((curve) => curve.column));
    data.forEach((values, i) => {
      const factor = i === 0 ? 1 : i === ANGLE + 1 ? 180 / Math.PI : 1e3;
      for (let k = 0; k < values.length; ++k) values[k]! *= factor;
    });
    this.#time!.setData(data as uPlot.AlignedData);
    if (++this.#pictures % OVER_ANGLE_EVERY === 0) this.#drawOverAngle();
  }

  /** Torque of the spring over the angle: what was felt; and what the scene wanted. */
  #drawOverAngle(): void {
    const last = this.samples.last();
    if (!last) return;
    const scale = devicePixelRatio;
    const { width, height } = this.#canvas;
    const context = this.#canvas.getContext("2d")!;
    const first = this.samples.indexOf(last[0]! - WINDOW_S), end = this.samples.size;
    const step = Math.max(1, Math.floor((end - first) / 4000));
    let lowest = Infinity, highest = -Infinity, most = 0.02;
    for (let i = first; i < end; i += step) {
      const angle = this.samples.at(1, i);
      lowest = Math.min(lowest, angle);
      highest = Math.max(highest, angle);
      most = Math.max(most, Math.abs(this.samples.at(3, i)), Math.abs(this.samples.at(4, i) + this.samples.at(6, i)));
    }
    const room = Math.max(0.05, 0.05 * (highest - lowest));
    const x = (angle: number): number => ((angle - lowest + room) / (highest - lowest + 2 * room)) * width;
    const y = (torque: number): number => height / 2 - (torque / (1.1 * most)) * (height / 2);
    context.clearRect(0, 0, width, height);
    context.font = `${12 * scale}px sans-serif`;
    context.fillStyle = this.#palette.text!;
    context.strokeStyle = this.#palette.grid!;
    context.lineWidth = scale;
    context.beginPath();
    context.moveTo(0, y(0));
    context.lineTo(width, y(0));
    context.stroke();
    const line = (stroke: string, dash: number[], torque: (i: number) => number): void => {
      context.strokeStyle = this.#palette[stroke]!;
      context.lineWidth = 1.5 * scale;
      context.setLineDash(dash.map((d) => d * scale));
      context.beginPath();
      let atX = NaN, atY = NaN;
      for (let i = first; i < end; i += step) {
        const nextX = x(this.samples.at(1, i)), nextY = y(torque(i));
        // What lies within a pixel of the last corner cannot be seen.
        if (Math.abs(nextX - atX) < scale && Math.abs(nextY - atY) < scale) continue;
        context.lineTo((atX = nextX), (atY = nextY));
      }
      context.stroke();
      context.setLineDash([]);
    };
    line("wanted", [6, 4], (i) => this.samples.at(3, i));
    line("spring", [], (i) => this.samples.at(4, i) + this.samples.at(6, i));
    const degrees = (rad: number): string => `${((rad * 180) / Math.PI).toFixed(1)}°`;
    const ends = `angle ${degrees(lowest)} to ${degrees(highest)}`;
    const write = (text: string, atRight: boolean, below: number): void => {
      const wide = context.measureText(text).width;
      const left = atRight ? width - wide - 6 * scale : 6 * scale;
      context.clearRect(left, below - 12 * scale, wide, 15 * scale);
      context.fillText(text, left, below);
    };
    write(ends, true, height - 6 * scale);
    write(`torque, ±${(1.1e3 * most).toFixed(0)} mN·m`, false, 16 * scale);
    const true_ = this.truth.size ? ", true torque beside the number" : "";
    const words = `torque over angle: wanted, and motor with spring${true_}`;
    if (this.#canvas.getAttribute("aria-label") !== words) this.#canvas.setAttribute("aria-label", words);
  }
}

/** A piece of a curve as it is drawn, so that no colour need be told apart. */
function sample(stroke: string, dash: readonly number[]): SVGElement {
  const space = "http://www.w3.org/2000/svg";
  const made = document.createElementNS(space, "svg"), line = document.createElementNS(space, "line");
  for (const [key, value] of Object.entries({ width: "30", height: "8", "aria-hidden": "true" })) made.setAttribute(key, value);
  const drawn = { x1: "0", x2: "30", y1: "4", y2: "4", "stroke-width": "2", "stroke-dasharray": dash.join(" ") };
  for (const [key, value] of Object.entries(drawn)) line.setAttribute(key, value);
  line.style.stroke = `var(--${stroke})`;
  made.append(line);
  return made;
}
