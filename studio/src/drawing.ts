// A curve drawn by hand: torques along its span, by pointer or by keys.

import type { Effect } from "./conversion";
import { element } from "./page";

const POINTS = 33, MOST_NM = 0.1;
const STEP_NM = 0.002, PAGE_NM = 0.02;

/** The drawing of a curve's torques, which stand in a field of numbers, too. */
export function drawing(
  effect: Effect,
  numbers: HTMLInputElement,
  changed: () => void,
): { canvas: HTMLCanvasElement; paint: () => void } {
  const canvas = element("canvas", {
    width: 264, height: 96, class: "drawing", tabindex: 0, role: "slider", "aria-label": "drawing of the curve",
    "aria-valuemin": -MOST_NM, "aria-valuemax": MOST_NM, "aria-valuenow": 0,
  });
  canvas.title =
    "draw the torque along the span: the middle is 0, top and bottom are 0.1 N m; " +
    "by keys: left and right choose a point, up and down change its torque";
  // The point that keys change; shown while the drawing has the focus.
  let chosen = 0;
  const torques = (): number[] => (effect.torque_nm as number[] | undefined) ?? [];

  const paint = (): void => {
    const context = canvas.getContext("2d")!, values = torques();
    const { width, height } = canvas;
    const x = (i: number): number => (i / (values.length - 1)) * width;
    const y = (torque: number): number => ((1 - torque / MOST_NM) * height) / 2;
    chosen = Math.max(0, Math.min(chosen, values.length - 1));
    context.clearRect(0, 0, width, height);
    context.strokeStyle = context.fillStyle = getComputedStyle(canvas).color;
    context.beginPath();
    values.forEach((torque, i) => context.lineTo(x(i), y(torque)));
    context.stroke();
    const torque = values[chosen] || 0;
    if (document.activeElement === canvas) context.fillRect(x(chosen) - 3, y(torque) - 3, 6, 6);
    canvas.setAttribute("aria-valuenow", String(torque));
    canvas.setAttribute("aria-valuetext", `point ${chosen + 1} of ${values.length}: ${torque} N m`);
  };
  /** Puts a torque to a point of a curve. */
  const put = (values: number[], point: number, torque: number): void => {
    // More than the picture has room for may have been typed.
    const most = Math.max(MOST_NM, Math.abs(values[point] || 0));
    values[point] = Number(Math.max(-most, Math.min(most, torque)).toFixed(4));
    effect.torque_nm = values;
    numbers.value = values.join(", ");
    changed();
  };
  const draw = (event: PointerEvent): void => {
    if (!event.buttons) return;
    const values = torques();
    const shape = values.length === POINTS ? values : Array<number>(POINTS).fill(0);
    const { left, top, width, height } = canvas.getBoundingClientRect();
    const point = Math.round(((event.clientX - left) / width) * (POINTS - 1));
    if (point < 0 || point >= POINTS) return;
    chosen = point;
    put(shape, point, MOST_NM * (1 - (2 * (event.clientY - top)) / height));
  };
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    draw(event);
  });
  canvas.addEventListener("pointermove", draw);
  canvas.addEventListener("keydown", (event) => {
    const values = torques();
    const ways = { ArrowRight: 1, ArrowLeft: -1, Home: -values.length, End: values.length };
    const torquesNm = { ArrowUp: STEP_NM, ArrowDown: -STEP_NM, PageUp: PAGE_NM, PageDown: -PAGE_NM };
    const way = ways[event.key as keyof typeof ways], more = torquesNm[event.key as keyof typeof torquesNm];
    if (way !== undefined) {
      chosen += way;
      paint();
    } else if (more !== undefined && values.length) {
      put(values, chosen, (values[chosen] || 0) + more);
    } else return;
    event.preventDefault();
  });
  for (const name of ["focus", "blur"]) canvas.addEventListener(name, paint);
  requestAnimationFrame(paint);
  return { canvas, paint };
}
