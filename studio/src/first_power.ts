// First power on a bench, as steps that the page follows. It ticks off what it can see.
// docs/how-to/first-power.md has the same steps with what to measure at each.

import type { Effect, Given } from "./conversion";
import type { Knob } from "./knob";
import { byId, element } from "./page";

const NEARLY_A_TURN_RAD = 0.95 * 2 * Math.PI;
const CLEARLY_RAD = 0.5;
// The motor's push gets faster. This angle keeps it far below the speed limit, even on a late page.
const PUSHED_RAD = 0.2;
const PUSH = 1.3; // times the friction
const DRAG_NM = 0.01;
// For the time after `confirmed`, when no others hold any more.
const CAPS = { motor_torque_cap_nm: 0.015, brake_torque_cap_nm: 0.015, speed_limit_rad_s: 10 };

/** The page's view of one moment. */
export interface Seen {
  state: string;
  faults: readonly string[];
  scene: readonly Effect[];
  angleRad: number;
  brakeCapacityNm: number;
}

interface Step {
  title: string;
  text: string;
  act?: { label: string; scene(knob: Knob): Promise<Effect[]> };
  /**
   * Looks once more.
   * @param pushedRad how far the motor's push has turned the knob; undefined while none is on
   * @returns true: done; text: what one should know
   */
  look?(seen: Seen, pushedRad: number | undefined): boolean | string;
}

/** Sets the caps that first power begins with, and what else a step needs. */
async function beCareful(knob: Knob, more: Given = {}): Promise<void> {
  await knob.configure("control_config", { ...(await knob.config("control_config")), ...CAPS, ...more });
}

/** How far the knob has turned since a step's watch began. */
class Travel {
  #from: number | undefined;

  by(angleRad: number): number {
    return angleRad - (this.#from ??= angleRad);
  }

  begin(): void {
    this.#from = undefined;
  }
}

function steps(travel: Travel): Step[] {
  let stopped = false, wentBack = false;
  return [
    {
      title: "Link",
      text: "Without any power, measure from the enable line and from each bridge input to ground: 4 to 5 kilohm. " +
        "More: its pull-down is missing. Then connect USB only, no supply. The light goes on and off once a " +
        "second. If the emergency stop's contact is open, the light flickers and there is a fault. Both are right.",
      look: ({ state }) => ["disarmed", "armed", "fault"].includes(state),
    },
    {
      title: "Encoder",
      text: "Turn the knob by hand, a whole turn in your positive direction.",
      look: ({ state, angleRad }) => {
        // A motor turns it too.
        if (state === "armed") travel.begin();
        const turned = travel.by(angleRad);
        if (turned > NEARLY_A_TURN_RAD) return true;
        if (turned < -CLEARLY_RAD) return "It counts backwards: change encoder reversed, or turn the other way.";
        return `${((180 / Math.PI) * turned).toFixed(0)}° of 360°`;
      },
    },
    {
      title: "Supply",
      text: "Switch the supply on, but do not arm. Measure its voltage with a meter. It must equal supply_v of the " +
        "board's configuration: a board with low limits does not notice 24 V in place of 12. Then measure: the " +
        "enable line and all four bridge inputs have 0 V, only the bridges' own current flows, and the current " +
        "sensor's output is at its zero. Tick this off yourself.",
    },
    {
      title: "Emergency stop",
      text: "Press the emergency stop, release it, and clear the fault.",
      look: ({ state, faults }) => {
        stopped ||= faults.includes("emergency_stop");
        return stopped && (state === "disarmed" || "Pressed: now release it and clear the fault.");
      },
    },
    {
      title: "Motor",
      text: "The motor pushes a little harder than the friction, with caps of 15 mN·m and 10 rad/s. The knob keeps " +
        "these caps. It must turn to larger angles. If the current grows to its limit instead, swap the current " +
        "sensor's two wires.",
      act: {
        label: "take the caps, and the push as scene",
        scene: async (knob) => {
          // A law that brakes would hold a knob whose motor is swapped, and the step would tell nothing.
          await beCareful(knob, { law: "motor_only" });
          await knob.command("save");
          const parts = await knob.config("actuator_config");
          const friction = Number(parts.knob_coulomb_nm) + Number(parts.brake_drag_nm);
          const push = PUSH * friction;
          return [{ type: "constant", torque_nm: Number(push.toPrecision(3)) }];
        },
      },
      look: (_, pushedRad) => {
        if (pushedRad !== undefined) wentBack = pushedRad < -PUSHED_RAD;
        if (wentBack) return "It turned backwards: change motor reversed, and push once more.";
        return pushedRad === undefined ? "Then arm, a hand on the emergency stop." : pushedRad > PUSHED_RAD;
      },
    },
    {
      title: "PWM",
      text: "Look for 40 kHz on the motor's inputs. Without torque both are high. With torque one of them is low for " +
        "its share of the time. Tick this off yourself.",
    },
    {
      title: "Brake",
      text: "Motor and brake make a friction of 10 mN·m, half each with the law parallel. Turn the knob: it drags, " +
        "and the brake's coil gets 5 mN·m / constant * resistance volts.",
      act: {
        label: "take the caps and the law, and friction as scene",
        scene: async (knob) => {
          await beCareful(knob, { law: "parallel" });
          return [{ type: "friction", torque_nm: DRAG_NM }];
        },
      },
      look: ({ state, brakeCapacityNm }) =>
        (state === "armed" && brakeCapacityNm > DRAG_NM / 4) || "Then arm, and turn the knob.",
    },
    {
      title: "Silence",
      text: "Arm, and pull the USB plug: motor and brake let go at once. Plug it in, arm, and close this page: they " +
        "do the same. Tick this off yourself.",
    },
    {
      title: "Confirm",
      text: "Set a speed limit and the law motor_only in the control configuration, and turn on confirmed in the " +
        "board's. Apply and keep both. Set values_are to stated in the calibration's. Raise the motor's cap first, " +
        "and hold the knob against 30 mN·m for a second: a supply of half or twice the voltage is a fault now. Then " +
        "raise both caps, step by step, to motor_torque_max_nm and brake_torque_max_nm: calibration needs them.",
    },
    {
      title: "Calibrate",
      text: "Raise the speed limit to 160 rad/s, which the turns need, and go on under Calibrate below. The knob " +
        "turns by itself for half a minute and measures its parts.",
    },
    {
      title: "A soft wall",
      text: "0.2 N·m/rad first, and softer again at the first hum.",
      act: {
        label: "take the wall as scene",
        scene: async () => [{ type: "wall", angle_rad: 0.2, stiffness_nm_per_rad: 0.2, damping_nm_s_per_rad: 0 }],
      },
    },
  ];
}

export class FirstPower {
  readonly #fold = byId<HTMLDetailsElement>("first-power");
  readonly #travel = new Travel();
  readonly #pushed = new Travel();
  readonly #steps = steps(this.#travel);
  readonly #items: HTMLLIElement[];
  readonly #boxes: HTMLInputElement[] = [];
  readonly #hints: HTMLElement[] = [];
  readonly #acts: HTMLButtonElement[] = [];
  /** The scenes that steps have made; a step looks while its own is there. */
  readonly #scenes = new Map<string, readonly Effect[]>();

  /** @param take shows a scene and plays it; @param disarm is called when the motor has turned */
  constructor(
    private readonly knob: () => Knob | undefined,
    attempt: (act: () => Promise<unknown>) => void,
    take: (scene: Effect[]) => void,
    private readonly disarm: () => void,
  ) {
    this.#items = this.#steps.map((step, i) => {
      const box = element("input", { type: "checkbox", id: `step-${i}` });
      const hint = element("span", { class: "hint" });
      this.#boxes.push(box);
      this.#hints.push(hint);
      const item = element(
        "li", {}, box, element("label", { for: box.id }, step.title), element("p", {}, step.text, " ", hint),
      );
      box.addEventListener("change", () => this.#mark());
      const { act } = step;
      if (act) {
        const button = element("button", { type: "button" }, act.label);
        button.addEventListener("click", () =>
          attempt(async () => {
            const knob = this.knob();
            if (!knob) return;
            const scene = await act.scene(knob);
            this.#scenes.set(step.title, scene);
            take(scene);
          }),
        );
        this.#acts.push(button);
        item.append(button);
      }
      return item;
    });
    byId("first-power-steps").append(...this.#items);
    this.#fold.addEventListener("toggle", () => this.#travel.begin());
    this.#mark();
  }

  enable(can: boolean): void {
    for (const button of this.#acts) button.disabled = !can;
  }

  /** Looks whether a step is done now, and ends a push that has turned the knob. */
  look(seen: Seen): void {
    const pushedRad = this.#pushedRad(seen);
    if (this.#fold.open) this.#steps.forEach((step, i) => this.#lookAt(step, i, seen, pushedRad));
    if (Math.abs(pushedRad ?? 0) <= PUSHED_RAD) return;
    this.#pushed.begin();
    this.disarm();
  }

  #pushedRad({ state, scene, angleRad }: Seen): number | undefined {
    const isPush = scene === this.#scenes.get("Motor") && scene.every(({ type }) => type === "constant");
    if (state === "armed" && isPush) return this.#pushed.by(angleRad);
    this.#pushed.begin();
    return undefined;
  }

  #lookAt(step: Step, i: number, seen: Seen, pushedRad: number | undefined): void {
    const box = this.#boxes[i]!, hint = this.#hints[i]!;
    const isOff = box.checked || (step.act && seen.scene !== this.#scenes.get(step.title));
    const found = isOff ? undefined : step.look?.(seen, pushedRad);
    const words = typeof found === "string" ? found : "";
    if (hint.textContent !== words) hint.textContent = words;
    if (found !== true) return;
    box.checked = true;
    this.#mark();
  }

  /** Marks the step that is next. */
  #mark(): void {
    const next = this.#boxes.findIndex((box) => !box.checked);
    this.#items.forEach((item, i) => {
      if (i === next) item.setAttribute("aria-current", "step");
      else item.removeAttribute("aria-current");
    });
  }
}
