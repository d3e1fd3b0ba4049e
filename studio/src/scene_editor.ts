// The scene: effects that are added, edited and taken away, played as one edits.

import { described } from "./codec";
import type { Effect } from "./conversion";
import { drawing } from "./drawing";
import { form } from "./form";
import { cppLines, pythonLines } from "./lines";
import { byId, element, label } from "./page";
import { EFFECTS } from "./reports";

/** What a new effect is like, so that it can be felt at once; one that is not here begins empty. */
const EXAMPLES: Record<string, () => Effect> = {
  wall: () => ({ type: "wall", angle_rad: 0.3, stiffness_nm_per_rad: 1.4, damping_nm_s_per_rad: 0 }),
  spring: () => ({ type: "spring", stiffness_nm_per_rad: 0.1 }),
  damper: () => ({ type: "damper", damping_nm_s_per_rad: 2e-3 }),
  friction: () => ({ type: "friction", torque_nm: 0.02 }),
  inertia: () => ({ type: "inertia", inertia_kg_m2: 5e-5 }),
  constant: () => ({ type: "constant", torque_nm: 0.02 }),
  ramp: () => ({ type: "ramp", start_torque_nm: 0, end_torque_nm: 0.04, timing: { duration_s: 1 } }),
  periodic: () => ({ type: "periodic", amplitude_nm: 0.02, frequency_hz: 2 }),
  detents: () => ({ type: "detents", per_turn: 24, torque_nm: 0.03 }),
  end_stops: () => ({ type: "end_stops", lower_rad: -0.8, upper_rad: 0.8, stiffness_nm_per_rad: 1.4 }),
  texture: () => ({ type: "texture", grains_per_turn: 120, torque_nm: 0.01 }),
  impact: () => ({ type: "impact", angle_rad: 0.3, strength_nm_s_per_rad: 0.02, pulse_nm_s_per_rad: 0.01 }),
  curve: () => ({ type: "curve", span_rad: 1, torque_nm: [0, 0.03, 0, -0.03, 0] }),
};

export class SceneEditor {
  scene: Effect[] = [EXAMPLES.wall!()];
  readonly #list = byId("effects");
  #timer: ReturnType<typeof setTimeout> | undefined;

  /** @param play is called a moment after the last edit */
  constructor(private readonly play: (scene: Effect[]) => void) {
    const kinds = byId<HTMLSelectElement>("new-effect");
    kinds.append(...EFFECTS.map((name) => element("option", { value: name }, label(name))));
    byId("add-effect").addEventListener("click", () => {
      this.scene.push(EXAMPLES[kinds.value]?.() ?? { type: kinds.value });
      this.#build();
    });
    for (const [button, lines] of [["copy-python", "python"], ["copy-cpp", "cpp"]] as const) {
      byId(button).addEventListener("click", () => {
        void navigator.clipboard?.writeText(byId(lines).textContent ?? "");
      });
    }
    this.#build();
    // That it is there is no edit.
    clearTimeout(this.#timer);
  }

  /** Shows another scene, and plays it. */
  take(scene: Effect[]): void {
    this.scene = scene;
    this.#build();
  }

  #build(): void {
    this.#list.replaceChildren(
      ...this.scene.map((effect, i) => {
        const { title, fields, doc } = described(effect.type);
        const remove = element("button", { type: "button", "aria-label": `remove ${title}` }, "remove");
        remove.addEventListener("click", () => {
          this.scene.splice(i, 1);
          this.#build();
        });
        const changed = (): void => {
          picture?.paint();
          this.#changed();
        };
        const rows = form(fields, effect, changed);
        const numbers = rows.querySelector<HTMLInputElement>("input[name=torque_nm]");
        const picture = effect.type === "curve" ? drawing(effect, numbers!, changed) : undefined;
        const card = element(
          "section",
          { class: "effect", "aria-label": title },
          element("h3", { title: doc }, title, remove),
          rows,
          ...(picture ? [picture.canvas] : []),
        );
        return card;
      }),
    );
    this.#changed();
  }

  #changed(): void {
    byId("python").textContent = pythonLines(this.scene);
    byId("cpp").textContent = cppLines(this.scene);
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => this.play(this.scene), 60);
  }
}
