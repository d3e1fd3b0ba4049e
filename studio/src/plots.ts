// The curves: torques and angle over time, and torque over angle.

import uPlot from "uplot";
import { byId, colour, element } from "./page";
import type { Ring } from "./samples";

const WINDOW_S = 5;

/** What is drawn: name, colour of the style sheet, dashes, column, and of which ring. */
const CURVES = [
  { name: "wanted", colour: "wanted", dash: [6, 4], column: 3 },
  { name: "motor command", colour: "motor", dash: [], column: 4 },
  { name: "brake capacity", colour: "brake", dash: [2, 3], column: 5 },
  { name: "spring, sensed", colour: "spring", dash: [], column: 6 },
] as const;

export class Plots {
  #time: uPlot | undefined;
  readonly #over = byId<HTMLCanvasElement>("over-angle");
  readonly #place = byId("over-time");

  constructor(private readonly samples: Ring, private readonly truth: Ring) {
    this.#build();
    new ResizeObserver(() => this.#time?.setSize(this.#size())).observe(this.#place);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.#build());
  }

  #size(): { width: number; height: number } {
    return { width: Math.max(200, this.#place.clientWidth), height: 260 };
  }

  #build(): void {
    this.#time?.destroy();
    const axis = { stroke: colour("text"), grid: { stroke: colour("grid") }, ticks: { stroke: colour("grid") } };
    this.#time = new uPlot(
      {
        ...this.#size(),
        cursor: { show: false },
        scales: { x: { time: false }, nm: {}, deg: {} },
        series: [
          { label: "time" },
          ...CURVES.map((curve) => ({
            label: curve.name, scale: "nm", stroke: colour(curve.colour), width: 1.5, dash: [...curve.dash],
            points: { show: false },
          })),
          { label: "angle", scale: "deg", stroke: colour("angle"), width: 1.5, dash: [10, 3, 2, 3], points: { show: false } },
        ],
        axes: [
          { ...axis, label: "time, s", labelSize: 18, size: 34 },
          { ...axis, scale: "nm", label: "torque, mN·m", labelSize: 18, size: 52 },
          { ...axis, scale: "deg", side: 1, label: "angle, degrees", labelSize: 18, size: 52, grid: { show: false } },
        ],
        legend: { live: false },
      },
      [[], ...CURVES.map(() => []), []],
      this.#place,
    );
  }

  draw(): void {
    const last = this.samples.last();
    if (!last) return;
    const from = last[0]! - WINDOW_S;
    const pixels = Math.max(100, this.#place.clientWidth);
    const columns = [...CURVES.map((c) => c.column), 1];
    const data = this.samples.envelope(from, Infinity, pixels, columns);
    data.forEach((values, i) => {
      const factor = i === 0 ? 1 : i <= CURVES.length ? 1e3 : 180 / Math.PI;
      for (let k = 0; k < values.length; ++k) values[k]! *= factor;
    });
    this.#time!.setData(data as uPlot.AlignedData);
    this.#drawOverAngle(from);
  }

  /** Torque of the spring over the angle: what was felt; and what the scene wanted. */
  #drawOverAngle(from: number): void {
    const canvas = this.#over;
    const scale = devicePixelRatio;
    const width = (canvas.width = canvas.clientWidth * scale);
    const height = (canvas.height = canvas.clientHeight * scale);
    const context = canvas.getContext("2d")!;
    const first = this.samples.indexOf(from), end = this.samples.size;
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
    context.fillStyle = colour("text");
    context.strokeStyle = colour("grid");
    context.beginPath();
    context.moveTo(0, y(0));
    context.lineTo(width, y(0));
    context.stroke();
    const degrees = (rad: number): string => `${((rad * 180) / Math.PI).toFixed(1)}°`;
    context.fillText(degrees(lowest), 4 * scale, height - 4 * scale);
    const right = degrees(highest);
    context.fillText(right, width - context.measureText(right).width - 4 * scale, height - 4 * scale);
    context.fillText(`${(1e3 * most).toFixed(0)} mN·m`, 4 * scale, 14 * scale);
    const line = (stroke: string, dash: number[], torque: (i: number) => number): void => {
      context.strokeStyle = colour(stroke);
      context.lineWidth = 1.5 * scale;
      context.setLineDash(dash.map((d) => d * scale));
      context.beginPath();
      for (let i = first; i < end; i += step) context.lineTo(x(this.samples.at(1, i)), y(torque(i)));
      context.stroke();
      context.setLineDash([]);
    };
    line("wanted", [6, 4], (i) => this.samples.at(3, i));
    line("spring", [], (i) => this.samples.at(4, i) + this.samples.at(6, i));
    const true_ = this.truth.size ? ", true torque beside the number" : "";
    canvas.setAttribute("aria-label", `torque over angle: wanted, and motor with spring${true_}`);
  }
}

/** What the curves mean, in words, for the legend of the second plot. */
export function legend(): HTMLElement {
  const one = (name: string, stroke: string): HTMLElement =>
    element("span", { style: `border-color: var(--${stroke})` }, name);
  return element("p", { class: "legend" }, one("wanted", "wanted"), one("felt: motor and spring", "spring"));
}
