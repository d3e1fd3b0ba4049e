// First steps with an emulated knob: arm it, and drag it into the wall.

import type { Effect } from "./conversion";
import { byId } from "./page";

// A torque that one has felt: some steps of telemetry.
const FELT_NM = 1e-3;

export class Hint {
  readonly #place = byId("hint");
  #isFelt = false;

  /** Says what is next; nothing once the wall was felt, or where there is none. */
  show(state: string, scene: readonly Effect[]): void {
    this.#place.hidden = this.#isFelt || !scene.some(({ type }) => type === "wall") || !["armed", "disarmed"].includes(state);
    byId("hint-arm").hidden = state === "armed";
    byId("hint-text").textContent =
      `${state === "armed" ? "Drag" : "it, then drag"} the knob into the wall, the red mark.`;
  }

  /** Looks whether the hand has felt it. */
  look(isHeld: boolean, desiredTorqueNm: number): void {
    if (this.#isFelt || !isHeld || Math.abs(desiredTorqueNm) < FELT_NM) return;
    this.#isFelt = this.#place.hidden = true;
  }
}
