// The curves of the page, drawn strip by strip: the picture is the one that is drawn whole.

import assert from "node:assert/strict";
import { test } from "node:test";

import { Steps } from "../../build/studio/modules/samples.js";
import { Strip } from "../../build/studio/modules/strip.js";

/** A canvas as the standard has it, for whole pixels: the letters of what was drawn last. */
function paper(width, height) {
  const canvas = { width, height, rows: Array.from({ length: height }, () => Array(width).fill(".")) };
  const fill = (left, top, wide, tall, ink) => {
    for (let y = Math.max(0, top); y < Math.min(height, top + tall); ++y) {
      for (let x = Math.max(0, left); x < Math.min(width, left + wide); ++x) canvas.rows[y][x] = ink;
    }
  };
  return {
    canvas,
    globalCompositeOperation: "source-over",
    columns: 0,
    fillRect(...place) {
      ++this.columns;
      fill(...place, this.fillStyle);
    },
    clearRect: (...place) => fill(...place, "."),
    drawImage(image, dx, dy) {
      assert.equal(this.globalCompositeOperation, "copy"); // or old pixels shine through
      const at = (y, x) => image.rows[y - dy]?.[x - dx] ?? ".";
      canvas.rows = canvas.rows.map((row, y) => row.map((_, x) => at(y, x)));
    },
    picture: () => canvas.rows.map((row) => row.join("")),
  };
}

const LINES = [
  { curve: 0, colour: "a", dash: [6, 4], low: -10, high: 10 },
  { curve: 1, colour: "b", dash: [], low: -10, high: 10 },
];

function random(seed) {
  return () => (seed = (seed * 48271) % 0x7fffffff) / 0x7fffffff;
}

test("a picture that was moved and drawn on is the one that is drawn whole", () => {
  for (const [width, thickness] of [[97, 1], [60, 1], [25, 1], [133, 2]]) {
    const chance = random(width);
    const steps = new Steps(2, 61, 0.01);
    const moving = paper(width, 40);
    const strip = new Strip(steps, moving);
    let time = 1e3, value = 0, drawn = 0, complete = 0;
    for (let picture = 0; picture < 300; ++picture) {
      // Some steps have many samples, some one, some none.
      for (let i = 0; i < 12 * chance(); ++i) {
        time += chance() < 0.05 ? 0.03 : 0.005 * chance();
        value = Math.max(-12, Math.min(12, value + 4 * (chance() - 0.5))); // over the edges, too
        steps.push(time, [value, chance() < 0.02 ? 9 : -0.5 * value], 0);
      }
      if (steps.newest < 0) continue;
      strip.draw(LINES, thickness);
      drawn += moving.columns;
      moving.columns = 0;
      const whole = paper(width, 40);
      new Strip(steps, whole).draw(LINES, thickness);
      // Where the sample before the picture is forgotten, the line from there has been drawn and is not known.
      const seen = [];
      steps.each(0, steps.newest - 59, (step) => seen.push(step));
      const known = Math.max(0, width - Math.round(((steps.newest - seen[0]) * width) / 60) + 2);
      const [moved, drawnWhole] = [moving, whole].map((sheet) => sheet.picture().map((row) => row.slice(known)));
      assert.deepEqual(moved, drawnWhole, `picture ${picture}, ${width} wide`);
      if (known <= 2) ++complete;
    }
    assert.ok(complete > 100, `${complete}`);
    assert.ok(drawn / 300 < 0.5 * 2 * width, "and little is drawn for it");
  }
});

test("each curve stands where its values are, also a peak of one sample in a dash's gap", () => {
  const steps = new Steps(2, 101, 1);
  for (let i = 0; i < 1000; ++i) steps.push(0.1 * i, [i === 877 ? 8 : 0, -5], 0);
  const sheet = paper(100, 41);
  new Strip(steps, sheet).draw([{ ...LINES[0], dash: [1, 99] }, LINES[1]], 1);
  const rows = sheet.picture();
  // Step 87 of 0 to 99; 8 of -10 to 10 is a tenth from the top.
  assert.equal(rows.findIndex((row) => row[87] === "a"), Math.floor((41 * 2) / 20));
  // The line goes up in its own step and down from there to the next.
  assert.equal(rows[Math.floor((41 * 10) / 20)], `a${".".repeat(86)}aa${".".repeat(11)}`);
  assert.equal(rows[Math.floor((41 * 15) / 20)], "b".repeat(100));
});

test("a line goes straight on where no sample came, and begins anew with the time", () => {
  const steps = new Steps(1, 101, 1);
  const sheet = paper(100, 100);
  const strip = new Strip(steps, sheet);
  const line = [{ curve: 0, colour: "a", dash: [], low: 0, high: 100 }];
  steps.push(0, [0], 0);
  strip.draw(line, 1);
  steps.push(50, [50], 0);
  strip.draw(line, 1);
  const columns = () => Array.from({ length: 100 }, (_, x) => sheet.picture().findIndex((row) => row[x] === "a"));
  for (const [x, top] of columns().slice(50).entries()) assert.ok(Math.abs(top - (100 - x)) <= 1, `${x}: ${top}`);
  steps.push(7, [30], 0);
  strip.draw(line, 1);
  assert.deepEqual(columns(), [...Array(99).fill(-1), 70]);
});
