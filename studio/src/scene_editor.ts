// The scene: effects that are added, edited and taken away, played as one edits.

import { described } from "./codec";
import type { Effect } from "./conversion";
import { drawing } from "./drawing";
import { form } from "./form";
import { cppLines, pythonLines } from "./lines";
import { byId, element, label } from "./page";
import { EFFECTS } from "./reports";

/** An effect as one begins with it. */
function begun(type: string): Effect {
  return { type, ...structuredClone(described(type).example ?? {}) };
}

export class SceneEditor {
  scene: Effect[] = [begun("wall")];
  readonly #list = byId("effects");
  #timer: ReturnType<typeof setTimeout> | undefined;

  /** @param play is called a moment after the last edit */
  constructor(private readonly play: (scene: Effect[]) => void) {
    const kinds = byId<HTMLSelectElement>("new-effect");
    kinds.append(...EFFECTS.map((name) => element("option", { value: name }, label(name))));
    byId("add-effect").addEventListener("click", () => {
      this.scene.push(begun(kinds.value));
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
    this.canPlay(true);
  }

  /** Shows another scene, and plays it. */
  take(scene: Effect[]): void {
    this.scene = scene;
    this.#build();
  }

  /** Only lines of a scene that can be played may be copied. */
  canPlay(can: boolean): void {
    for (const id of ["copy-python", "copy-cpp"]) byId<HTMLButtonElement>(id).disabled = !can;
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
    this.canPlay(false);
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => this.play(this.scene), 60);
  }
}
