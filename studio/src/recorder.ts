// The button that records: what happens from one press to the next becomes a file.

import type { Effect } from "./conversion";
import type { Knob } from "./knob";
import { byId, saveFile } from "./page";
import { Recording } from "./recording";

const LOOK_MS = 500;

export class Recorder {
  readonly #button = byId<HTMLButtonElement>("record");
  readonly #place = byId("recording");
  #recording: Recording | undefined;
  #beginning: Promise<void> | undefined;
  #timer: ReturnType<typeof setInterval> | undefined;

  constructor(
    private readonly knob: () => Knob | undefined,
    private readonly scene: () => readonly Effect[],
    private readonly playing: () => readonly Effect[] | undefined,
    attempt: (act: () => Promise<unknown>) => void,
  ) {
    this.#button.addEventListener("click", () =>
      attempt(() => (this.#recording ? this.end() : (this.#beginning = this.#begin()))),
    );
    addEventListener("beforeunload", (event) => {
      if (this.#recording) event.preventDefault();
    });
  }

  enable(can: boolean): void {
    this.#button.disabled = !can && !this.#recording;
  }

  /** Resolves when a recording that begins has all that a replay needs: who arms waits for it. */
  async ready(): Promise<void> {
    await this.#beginning?.catch(() => {});
  }

  async #begin(): Promise<void> {
    const knob = this.knob();
    if (!knob) return;
    this.#button.inert = true;
    try {
      this.#recording = await Recording.begin(knob);
      // With all that plays from the beginning on, so that the file can be replayed.
      await knob.startTelemetry();
      // The scene of an armed knob stays.
      if (knob.transport.readOnly || knob.state === "armed") {
        if (this.playing()) this.note("playing", { scene: this.playing() });
        return;
      }
      knob.forgetScene();
      await knob.play(this.scene());
      this.note("play", { scene: this.scene() });
    } finally {
      this.#button.inert = false;
      this.#show();
      if (this.#recording) this.#timer = setInterval(() => this.#show(), LOOK_MS);
    }
  }

  /** Writes an event of the user's, if a recording is under way. */
  note(kind: string, values: object = {}): void {
    this.#recording?.note(kind, values);
  }

  /** Ends the recording, if one is under way, and gives its file to the user. */
  async end(): Promise<void> {
    const recording = this.#recording;
    this.#recording = undefined;
    clearInterval(this.#timer);
    this.#show();
    if (!recording) return;
    const name = new Date().toISOString().slice(0, 19).replaceAll(":", "-");
    try {
      await recording.end();
    } finally {
      saveFile(recording.file, `torsio-${name}.mcap`);
    }
  }

  #show(): void {
    const recording = this.#recording;
    this.#button.setAttribute("aria-pressed", String(recording !== undefined));
    this.#button.textContent = recording ? "stop recording" : "record";
    this.#place.textContent = recording ? `${recording.samples} samples` : "";
  }
}
