// How often games ask for more than the knob gives, as the page tells it.

import assert from "node:assert/strict";
import { test } from "node:test";

import { clippedShare, whoHas } from "../../build/studio/modules/games.js";

test("the share of clipped ticks begins with the first look, and outlives a counter's wrap", () => {
  assert.equal(clippedShare(undefined, { tick: 1000, clipped: 1000 }), undefined);
  assert.equal(clippedShare({ tick: 1000, clipped: 1000 }, { tick: 1200, clipped: 1050 }), 0.25);
  assert.equal(clippedShare({ tick: 1000, clipped: 2 ** 32 - 20 }, { tick: 1200, clipped: 30 }), 0.25);
});

test("who has the actuator before a game has said anything is the player's own feel", () => {
  assert.equal(whoHas("game", false), "your own feel has the actuator");
  assert.equal(whoHas("game", true), "a game or your own feel has the actuator");
  assert.equal(whoHas("sdk", true), "no game has the actuator");
});
