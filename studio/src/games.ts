// Games on the knob: its owner, their requests, and the effects that play.

import type { Value, Values } from "./codec";
import type { Knob } from "./knob";
import { byId, element } from "./page";

const LOOK_MS = 250;
// Effects are told of in turns; one that was not for so many looks is gone.
const TURNS = 16;
const LONGEST_SILENCE_MS = 65535;

interface Row {
  effect: Values;
  seen: number;
}

interface Clipping {
  tick: number;
  clipped: number;
}

/** The share of the ticks between two looks in which effects asked for more than they get. */
export function clippedShare(last: Clipping | undefined, now: Clipping): number | undefined {
  // The counter has 32 bits.
  return last && ((now.clipped - last.clipped) >>> 0) / (now.tick - last.tick);
}

/** Who has the actuator; a game that has said nothing cannot have it. */
export function whoHas(owner: Value | undefined, said: boolean): string {
  if (owner !== "game") return "no game has the actuator";
  return said ? "a game or your own feel has the actuator" : "your own feel has the actuator";
}

export class Games {
  readonly #fold = byId<HTMLDetailsElement>("games");
  readonly #rows = new Map<number, Row>();
  #looks = 0;
  #last: (Clipping & { knob: Knob }) | undefined;

  constructor(private readonly knob: () => Knob | undefined) {
    setInterval(() => void this.#look(), LOOK_MS);
  }

  async #look(): Promise<void> {
    const knob = this.knob();
    if (!this.#fold.open || !knob || knob.state === "disconnected") return;
    try {
      this.#show(await knob.read("game_monitor"), knob);
    } catch {
      // The reader of telemetry says that the knob is gone.
    }
  }

  #show(monitor: Values, knob: Knob): void {
    ++this.#looks;
    for (const effect of monitor.effect as Values[]) {
      if (Number(effect.block)) this.#rows.set(Number(effect.block), { effect, seen: this.#looks });
    }
    for (const [block, { seen }] of this.#rows) {
      if (!monitor.effects || this.#looks - seen > TURNS) this.#rows.delete(block);
    }
    const now = { tick: Number(monitor.tick), clipped: Number(monitor.clipped_ticks), knob };
    const often = clippedShare(this.#last?.knob === knob ? this.#last : undefined, now);
    this.#last = now;
    const milli = (torque: Value | undefined): string => (1e3 * Number(torque) * knob.identity.torqueStepNm).toFixed(1);
    byId("games-state").textContent = this.#words(monitor, often, milli).join(", ");
    const cells = (values: readonly string[]): Node[] => values.map((value) => element("td", {}, value));
    byId("game-effects").replaceChildren(
      ...[...this.#rows].sort(([a], [b]) => a - b).map(([block, { effect }]) => {
        const silent = Number(effect.silent_ms);
        return element("tr", {}, ...cells([
          String(block), String(effect.kind), String(effect.state), milli(effect.torque), String(effect.updates),
          silent >= LONGEST_SILENCE_MS ? "over 65 s" : `${silent} ms`,
        ]));
      }),
    );
  }

  #words(monitor: Values, often: number | undefined, milli: (torque: Value | undefined) => string): string[] {
    const said = Boolean(monitor.updates);
    const asked = Number(monitor.asked_percent);
    return !said && monitor.owner !== "game" ? ["no game has said anything since power-up"] : [
      whoHas(monitor.owner, said),
      ...(said ? [monitor.enabled === "on" ? "a game wants torque" : "no game wants torque"] : []),
      ...(monitor.paused === "on" ? ["paused"] : []),
      `gain ${((100 * Number(monitor.gain)) / 32767).toFixed(0)} %`,
      `together ${milli(monitor.torque)} mN·m`,
      `reports ${String(monitor.updates)}`,
      `effects ${String(monitor.effects)}`,
      ...(asked > 100 ? [
        `together they ask for ${asked} % of their limit`,
        ...(often === undefined ? [] : [`clipped ${Math.round(100 * often)} % of the time`]),
        `gain × ${(Math.floor(1e4 / asked) / 100).toFixed(2)} fits them in`,
      ] : []),
    ];
  }
}
