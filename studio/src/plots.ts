// The curves: torques and angle over time, and torque over angle.

import uPlot from "uplot";
import { byId, colour, element } from "./page";
import { Steps } from "./samples";
import { type Line, Strip } from "./strip";

const WINDOW_S = 5;
// About a pixel each; what is drawn does not depend on how many samples come.
const STEPS = 420;
// Looks at all steps: every eighth picture is enough. The second plot changes slowly, and is drawn whole.
const WHOLE_EVERY = 8;

/** What is drawn over time: name, colour of the style sheet, and dashes. */
const CURVES = [
  { name: "wanted", colour: "wanted", dash: [6, 4] },
  { name: "motor command", colour: "motor", dash: [] },
  { name: "brake capacity", colour: "brake", dash: [2, 3] },
  { name: "spring, sensed", colour: "spring", dash: [] },
  { name: "angle, on the right", colour: "angle", dash: [10, 3, 2, 3] },
] as const;
const WANTED = 0, ANGLE = CURVES.length - 1;
// Scales of the plot over time, which share no curve: the least that they span, and whether 0 is always in.
const SCALES = {
  nm: { least: 20, hasZero: true, of: (i: number) => i !== ANGLE },
  deg: { least: 5, hasZero: false, of: (i: number) => i === ANGLE },
};
// And one that is drawn over the angle only.
const FELT = CURVES.length;

type Palette = Record<string, string>;

export class Plots {
  // Axes and grid, which stand still until a range changes; over them the curves.
  #time: uPlot | undefined;
  readonly #paper = element("canvas");
  readonly #ranges = { nm: [-10, 10], deg: [-2.5, 2.5] };
  // To ask for a style is dear.
  #palette: Palette = {};
  #hidden = new Set<number>();
  #pictures = 0;
  // The newest step when ranges were looked at.
  #looked = 0;
  #over = { width: 0, height: 0 };
  readonly #steps = new Steps(CURVES.length + 1, STEPS + 1, WINDOW_S / STEPS);
  readonly #strip = new Strip(this.#steps, this.#paper.getContext("2d")!);
  readonly #values = new Float64Array(CURVES.length + 1);
  readonly #canvas = byId<HTMLCanvasElement>("over-angle");
  readonly #place = byId("over-time");

  constructor() {
    this.#build();
    new ResizeObserver(() => {
      this.#time?.setSize(this.#size());
      this.#fit();
    }).observe(this.#place);
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
      this.#strip.renew();
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
        scales: { x: { time: false, range: [-WINDOW_S, 0] }, nm: { range: asGiven }, deg: { range: asGiven } },
        // They have the ranges for their values, and draw nothing.
        series: [{}, ...Object.keys(SCALES).map((scale) => ({ scale, paths: () => null, points: { show: false } }))],
        axes: [
          { ...axis, label: "time, s before now", labelSize: 18, size: 34, values: (_, times) => times.map((time) => `${-time}`) },
          { ...axis, scale: "nm", label: "torque, mN·m", labelSize: 18, size: 52 },
          { ...axis, scale: "deg", side: 1, label: "angle, degrees", labelSize: 18, size: 52, grid: { show: false } },
        ],
        legend: { show: false },
      },
      this.#data(),
      this.#place,
    );
    Object.assign(this.#paper.style, { width: "100%", height: "100%" });
    this.#time.over.append(this.#paper);
    this.#fit();
  }

  #data(): uPlot.AlignedData {
    return [[-WINDOW_S, 0], this.#ranges.nm, this.#ranges.deg];
  }

  /** The curves' canvas has the pixels of the place between the axes. */
  #fit(): void {
    const { width, height } = this.#time!.bbox;
    this.#paper.width = Math.round(width);
    this.#paper.height = Math.round(height);
    this.#strip.renew();
  }

  /** Takes a sample: time in s, then `CHANNELS`. */
  push(row: ArrayLike<number>): void {
    const values = this.#values;
    for (let i = 0; i < ANGLE; ++i) values[i] = 1e3 * row[i + 3]!;
    values[ANGLE] = (180 / Math.PI) * row[1]!;
    values[FELT] = values[1]! + values[3]!;
    this.#steps.push(row[0]!, values, row[1]!);
  }

  clear(): void {
    this.#steps.clear();
  }

  draw(): void {
    let others = false;
    for (const name of ["nm", "deg"] as const) {
      const range = this.#range(name);
      others ||= range !== this.#ranges[name];
      this.#ranges[name] = range;
    }
    this.#looked = this.#steps.newest;
    if (others) {
      this.#time!.setData(this.#data());
      this.#strip.renew();
    }
    const lines = CURVES.flatMap(({ colour, dash }, curve): Line[] => {
      const [low, high] = this.#ranges[curve === ANGLE ? "deg" : "nm"];
      return this.#hidden.has(curve) ? [] : [{ curve, colour: this.#palette[colour]!, dash, low: low!, high: high! }];
    });
    this.#strip.draw(lines, Math.max(1, Math.round(devicePixelRatio)));
    if (++this.#pictures % WHOLE_EVERY === 0) this.#drawOverAngle();
  }

  /** The range of a scale. It stays while it fits, because a change redraws the whole picture. */
  #range(name: keyof typeof SCALES): number[] {
    const held = this.#ranges[name];
    // A range that has become too wide can wait for a later picture; what leaves it cannot.
    if (this.#pictures % WHOLE_EVERY) {
      const [low, high] = this.#extremes(name, this.#looked);
      if (low >= held[0]! && high <= held[1]!) return held;
    }
    const [low, high] = this.#extremes(name, 0), span = Math.max(SCALES[name].least, high - low);
    if (low > high || (low >= held[0]! && high <= held[1]! && held[1]! - held[0]! <= 3 * span)) return held;
    const middle = (low + high) / 2, unit = 10 ** Math.floor(Math.log10(span)) / 2;
    return [
      Math.floor((Math.min(low, middle - span / 2) - 0.05 * span) / unit) * unit,
      Math.ceil((Math.max(high, middle + span / 2) + 0.05 * span) / unit) * unit,
    ];
  }

  /** The lowest and the highest value of a scale, from a step on. */
  #extremes(name: keyof typeof SCALES, from: number): [number, number] {
    const { hasZero, of } = SCALES[name];
    let low = hasZero ? 0 : Infinity, high = hasZero ? 0 : -Infinity;
    for (let curve = 0; curve < CURVES.length; ++curve) {
      if (!of(curve) || this.#hidden.has(curve)) continue;
      this.#steps.each(curve, from, (_, lowest, highest) => {
        if (lowest < low) low = lowest;
        if (highest > high) high = highest;
      });
    }
    return [low, high];
  }

  /** Torque of motor and spring over the angle: what was felt; and what the scene wanted. */
  #drawOverAngle(): void {
    const scale = devicePixelRatio;
    const { width, height } = this.#canvas;
    const context = this.#canvas.getContext("2d")!;
    let lowest = Infinity, highest = -Infinity, most = 20;
    for (const curve of [WANTED, FELT]) {
      this.#steps.overBeside(curve, (angle, torque) => {
        lowest = Math.min(lowest, angle);
        highest = Math.max(highest, angle);
        most = Math.max(most, Math.abs(torque));
      });
    }
    if (lowest > highest) lowest = highest = 0; // no sample yet: axes alone
    const room = Math.max(0.05, 0.05 * (highest - lowest)), degree = Math.PI / 180;
    const left = 44 * scale, right = width - 10 * scale, top = 10 * scale, bottom = height - 36 * scale;
    const x = (angle: number): number => left + ((angle - lowest + room) / (highest - lowest + 2 * room)) * (right - left);
    const y = (torque: number): number => (top + bottom) / 2 - (torque / (1.1 * most)) * ((bottom - top) / 2);
    context.clearRect(0, 0, width, height);
    context.font = `${12 * scale}px sans-serif`;
    context.fillStyle = this.#palette.text!;
    context.strokeStyle = this.#palette.grid!;
    context.lineWidth = scale;
    context.textAlign = "center";
    context.fillText("angle, degrees", (left + right) / 2, height - 4 * scale);
    for (const tick of ticks((lowest - room) / degree, (highest + room) / degree)) {
      context.strokeRect(x(tick * degree), top, 0, bottom - top);
      context.fillText(`${tick}`, x(tick * degree), bottom + 15 * scale);
    }
    context.textAlign = "right";
    for (const tick of ticks(-1.1 * most, 1.1 * most)) {
      context.strokeRect(left, y(tick), right - left, 0);
      context.fillText(`${tick}`, left - 5 * scale, y(tick) + 4 * scale);
    }
    const line = (stroke: string, dash: number[], curve: number): void => {
      context.strokeStyle = this.#palette[stroke]!;
      context.lineWidth = 1.5 * scale;
      context.setLineDash(dash.map((d) => d * scale));
      context.beginPath();
      let atX = NaN, atY = NaN;
      this.#steps.overBeside(curve, (angle, torque) => {
        const nextX = x(angle), nextY = y(torque);
        // A point within a pixel of the last corner cannot be seen.
        if (Math.abs(nextX - atX) < scale && Math.abs(nextY - atY) < scale) return;
        context.lineTo((atX = nextX), (atY = nextY));
      });
      context.stroke();
      context.setLineDash([]);
    };
    line("wanted", [6, 4], WANTED);
    line("spring", [], FELT);
  }
}

/** Round numbers between two, some five of them. */
function ticks(low: number, high: number): number[] {
  const least = (high - low) / 6, unit = 10 ** Math.floor(Math.log10(least));
  const step = unit * [1, 2, 5, 10].find((times) => times * unit >= least)!;
  const first = Math.ceil(low / step);
  return Array.from({ length: Math.floor(high / step) - first + 1 }, (_, i) => Number(((first + i) * step).toPrecision(6)));
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

const asGiven: uPlot.Scale.Range = (_, low, high) => [low, high];
