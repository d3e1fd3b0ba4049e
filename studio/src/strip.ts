// Curves as columns of pixels: the picture moves to the left, and only what is new is drawn.

import type { Steps } from "./samples";

/** One curve of the picture: where its values are drawn, and how. */
export interface Line {
  curve: number;
  colour: string;
  dash: readonly number[];
  /** Values at the lower and at the upper edge. */
  low: number;
  high: number;
}

/** What is asked of a canvas. */
export type Paper = Pick<CanvasRenderingContext2D, "clearRect" | "fillRect" | "drawImage" | "globalCompositeOperation"> & {
  fillStyle: unknown;
  readonly canvas: { width: number; height: number };
};

/**
 * The newest steps, the newest at the right edge. A column of pixels depends on its own step and
 * the one before, and its place depends on its time alone. So earlier columns are moved by whole
 * pixels and need not be drawn again.
 */
export class Strip {
  #drawn: number | undefined;
  #begun = -1;

  constructor(private readonly steps: Steps, private readonly paper: Paper) {}

  /** The next picture is drawn whole: size, lines or their ranges are others. */
  renew(): void {
    this.#drawn = undefined;
  }

  /** @param thickness of the lines, in pixels */
  draw(lines: readonly Line[], thickness: number): void {
    const { steps, paper } = this;
    const { canvas } = paper;
    const { width, height } = canvas;
    // The oldest step is not shown: it is where the line of the next begins.
    const shown = steps.capacity - 1;
    const x = (step: number): number => Math.round((step * width) / shown);
    const right = x(steps.newest + 1);
    const moved = this.#drawn === undefined ? width : right - x(this.#drawn + 1);
    const isWhole = steps.begun !== this.#begun || moved >= width;
    // The step that was newest may have got more samples, and with it the way to it from the last one.
    let from = isWhole ? steps.newest - shown + 1 : Math.min(this.#drawn!, steps.before(this.#drawn!) + 1);
    if (!isWhole && moved > 0) {
      paper.globalCompositeOperation = "copy";
      paper.drawImage(canvas as CanvasImageSource, -moved, 0);
      paper.globalCompositeOperation = "source-over";
    }
    // In a narrow picture steps share a column.
    while (x(from - 1) === x(from)) --from;
    this.#drawn = steps.newest;
    this.#begun = steps.begun;
    const left = right - width;
    paper.clearRect(x(from) - left, 0, width, height);
    for (const { curve, colour, dash, low: lowest, high: highest } of lines) {
      const perUnit = height / (highest - lowest);
      const period = dash.reduce((sum, part) => sum + part, 0) * thickness;
      const isInk = (column: number): boolean => {
        let at = column % period;
        // Line and gap in turn.
        for (let part = 0; part < dash.length; ++part) if ((at -= dash[part]! * thickness) < 0) return part % 2 === 0;
        return true;
      };
      paper.fillStyle = colour;
      const column = (step: number, low: number, high: number): void => {
        const top = Math.floor((highest - high) * perUnit), tall = Math.floor((highest - low) * perUnit) - top + thickness;
        const begin = x(step), end = Math.max(begin + 1, x(step + 1));
        for (let at = begin; at < end; ++at) {
          // No peak is lost in a gap.
          if (tall <= 2 * thickness && !isInk(at)) continue;
          paper.fillRect(at - left, top, 1, tall);
        }
      };
      let before = NaN, last = NaN;
      steps.each(curve, from, (step, low, high, falls) => {
        const gap = step - before, first = falls ? high : low;
        let value = last;
        // Straight on from the last value, over the steps in which no sample came.
        for (let empty = 1; empty < gap; ++empty) {
          const next = last + ((first - last) * empty) / gap;
          if (before + empty >= from) column(before + empty, Math.min(value, next), Math.max(value, next));
          value = next;
        }
        if (Number.isNaN(value)) value = low;
        if (step >= from) column(step, Math.min(low, value), Math.max(high, value));
        [before, last] = [step, falls ? low : high];
      });
    }
  }
}
