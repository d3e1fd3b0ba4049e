// The scene: effects that are added, edited and taken away, played as one edits.

import { described } from "./codec";
import type { Effect } from "./conversion";
import { form } from "./form";
import { cppLines, pythonLines } from "./lines";
import { byId, element, label } from "./page";
import { EFFECTS } from "./reports";

/** What a new effect is like, so that it can be felt at once. */
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
  curve: () => ({ type: "curve", span_rad: 1, torque_nm: [0, 0.03, 0, -0.03, 0] }),
};

/** A curve drawn by hand: `points` torques along its span. */
function drawing(effect: Effect, changed: () => void): HTMLElement {
  const points = 33, most = 0.1;
  const canvas = element("canvas", { width: 264, height: 96, class: "drawing" });
  canvas.title = "draw the torque along the span: the middle is 0, top and bottom are 0.1 N m";
  const paint = (): void => {
    const context = canvas.getContext("2d")!;
    const torques = effect.torque_nm as number[];
    context.clearRect(0, 0, canvas.width, canvas.height);
    context.strokeStyle = getComputedStyle(canvas).color;
    context.beginPath();
    torques.forEach((torque, i) => {
      const x = (i / (torques.length - 1)) * canvas.width;
      context.lineTo(x, ((1 - torque / most) * canvas.height) / 2);
    });
    context.stroke();
  };
  const draw = (event: PointerEvent): void => {
    if (!event.buttons) return;
    const torques = effect.torque_nm as number[];
    const shape = torques.length === points ? torques : Array<number>(points).fill(0);
    const { left, top, width, height } = canvas.getBoundingClientRect();
    const x = Math.round(((event.clientX - left) / width) * (points - 1));
    if (x < 0 || x >= points) return;
    const torque = most * (1 - (2 * (event.clientY - top)) / height);
    shape[x] = Number(Math.max(-most, Math.min(most, torque)).toFixed(4));
    effect.torque_nm = shape;
    paint();
    changed();
  };
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    draw(event);
  });
  canvas.addEventListener("pointermove", draw);
  requestAnimationFrame(paint);
  return canvas;
}

export class SceneEditor {
  scene: Effect[] = [EXAMPLES.wall!()];
  readonly #list = byId("effects");
  #timer: ReturnType<typeof setTimeout> | undefined;

  /** @param play is called a moment after the last edit */
  constructor(private readonly play: (scene: Effect[]) => void) {
    const kinds = byId<HTMLSelectElement>("new-effect");
    kinds.append(...EFFECTS.map((name) => element("option", { value: name }, label(name))));
    byId("add-effect").addEventListener("click", () => {
      this.scene.push(EXAMPLES[kinds.value]!());
      this.#build();
    });
    for (const [button, lines] of [["copy-python", "python"], ["copy-cpp", "cpp"]] as const) {
      byId(button).addEventListener("click", () => {
        void navigator.clipboard?.writeText(byId(lines).textContent ?? "");
      });
    }
    this.#build();
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
        const changed = (): void => this.#changed();
        const card = element(
          "section",
          { class: "effect", "aria-label": title },
          element("h3", { title: doc }, title, remove),
          form(fields, effect, changed),
        );
        if (effect.type === "curve") card.append(drawing(effect, changed));
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
