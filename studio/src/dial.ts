// The knob as one sees it, and the hand that turns it when it is an emulated one.

import { described } from "./codec";
import type { Effect } from "./conversion";
import { byId } from "./page";

const STEP_RAD = Math.PI / 90;
const SCALE_LINES = 24, MOST_NOTCHES = 180;
// Half a pixel at the rim.
const VISIBLE_RAD = 5e-3;

/** A line across the rim. */
function line(angleRad: number, from: number, to: number, name: string): SVGElement {
  const made = document.createElementNS("http://www.w3.org/2000/svg", "line");
  const degrees = (180 / Math.PI) * angleRad;
  for (const [key, value] of Object.entries({ y1: -from, y2: -to, class: name, transform: `rotate(${degrees})` })) {
    made.setAttribute(key, String(value));
  }
  return made;
}

/** Marks on the rim where walls and end stops begin. */
export function showPlaces(scene: readonly Effect[]): void {
  const places = scene.flatMap((effect) =>
    described(effect.type).fields.filter((field) => field.surface).map((field) => effect[field.name]),
  );
  byId<SVGElement>("places").replaceChildren(
    ...places.map(Number).filter(Number.isFinite).map((angle) => line(angle, 78, 96, "place")),
    ...scene.flatMap(notches).map((angle) => line(angle, 84, 92, "notch")),
  );
}

/** Where detents are in a turn; none if they are too many to be told apart. */
function notches(effect: Effect): number[] {
  if (effect.type !== "detents") return [];
  const perTurn = Number(effect.per_turn ?? (2 * Math.PI) / Number(effect.pitch_rad));
  const count = perTurn <= MOST_NOTCHES ? Math.ceil(perTurn) : 0;
  return Array.from({ length: count }, (_, i) => Number(effect.angle_rad ?? 0) + (2 * Math.PI * i) / perTurn);
}

export class Dial {
  #angle = 0;
  #shown = 0;
  #target: number | undefined;
  /** Where the hand took the knob. */
  #from = 0;
  readonly #dial = byId<SVGElement>("dial");
  readonly #pointer = byId("pointer");

  /** @param hand is told how far the hand means to turn the knob from where it took it; undefined: it lets go */
  constructor(private readonly hand: (turned: number | undefined) => void) {
    const dial = this.#dial;
    byId<SVGElement>("scale").append(
      ...Array.from({ length: SCALE_LINES }, (_, i) => line((2 * Math.PI * i) / SCALE_LINES, 80, i % 6 ? 84 : 88, "tick")),
    );
    let before = 0;
    dial.addEventListener("pointerdown", (event) => {
      if (!this.enabled) return;
      dial.setPointerCapture(event.pointerId);
      before = this.#pointed(event);
      this.#move(this.#angle);
    });
    dial.addEventListener("pointermove", (event) => {
      if (this.#target === undefined || !dial.hasPointerCapture(event.pointerId)) return;
      const now = this.#pointed(event);
      // The short way round, so that one can go on for many turns.
      this.#move(this.#target + Math.atan2(Math.sin(now - before), Math.cos(now - before)));
      before = now;
    });
    for (const end of ["pointerup", "pointercancel"]) dial.addEventListener(end, () => this.letGo());
    dial.addEventListener("blur", () => this.letGo());
    dial.addEventListener("keydown", (event) => {
      const steps = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1, PageUp: 10, PageDown: -10 }[event.key];
      if (!this.enabled) return;
      if (steps !== undefined) this.#move((this.#target ?? this.#angle) + steps * STEP_RAD);
      else if (event.key === "Backspace" || event.key === "Delete") this.letGo();
      else return;
      event.preventDefault();
    });
  }

  /** Only an emulated knob has a hand here. */
  set enabled(can: boolean) {
    this.#dial.setAttribute("aria-disabled", String(!can));
  }

  get enabled(): boolean {
    return this.#dial.getAttribute("aria-disabled") !== "true";
  }

  get isHeld(): boolean {
    return this.#target !== undefined;
  }

  letGo(): void {
    if (this.#target === undefined) return;
    this.#target = undefined;
    this.hand(undefined);
    this.#paintHand();
  }

  show(angle: number): void {
    this.#angle = angle;
    if (Math.abs(angle - this.#shown) < VISIBLE_RAD) return;
    this.#shown = angle;
    // Positive angles turn to the right, as one turns a knob up.
    this.#pointer.style.transform = `rotate(${angle}rad)`;
  }

  /** The same in words, for readers who cannot see it. */
  tell(): void {
    this.#dial.setAttribute("aria-valuenow", ((this.#shown * 180) / Math.PI).toFixed(1));
  }

  #move(target: number): void {
    if (this.#target === undefined) this.#from = this.#angle;
    this.#target = target;
    this.hand(target - this.#from);
    this.#paintHand();
  }

  #paintHand(): void {
    const hand = byId<SVGElement>("hand");
    hand.style.display = this.#target === undefined ? "none" : "";
    hand.setAttribute("transform", `rotate(${((this.#target ?? 0) * 180) / Math.PI})`);
  }

  #pointed(event: PointerEvent): number {
    const { left, top, width, height } = this.#dial.getBoundingClientRect();
    return Math.atan2(event.clientY - top - height / 2, event.clientX - left - width / 2);
  }
}
