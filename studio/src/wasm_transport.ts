// A knob in the page: the emulated device in a worker, and the world round it.

import { Inbox, type Transport } from "./transport";

type Message<T> = T & { id: number };
export type ToWorker =
  | Message<{ kind: "start"; module: ArrayBuffer; seed: number }>
  | Message<{ kind: "write"; report: Uint8Array }>
  | Message<{ kind: "get"; report: number }>
  | Message<{ kind: "set"; report: Uint8Array }>
  /** The page has what came last. */
  | Message<{ kind: "taken" }>
  | Message<{ kind: "hand"; angle: number | undefined }>
  | Message<{ kind: "emergency stop"; pressed: boolean }>;
export type FromWorker =
  | { kind: "answer"; id: number; result: unknown }
  /** Rows of time in s and TRUTH, one a millisecond. */
  | { kind: "time"; reports: Uint8Array[]; truth: Float64Array }
  | { kind: "failed"; why: string };

export class WasmTransport implements Transport {
  readonly title = "emulated knob, in this page";
  /** Called with rows of time and truth. */
  onTruth: (rows: Float64Array) => void = () => {};

  readonly #worker: Worker;
  readonly #inbox = new Inbox();
  readonly #waiting = new Map<number, (result: unknown) => void>();
  #id = 0;

  private constructor(worker: Worker) {
    this.#worker = worker;
    worker.onmessage = (event: MessageEvent<FromWorker>) => this.#take(event.data);
    worker.onerror = (event) => this.#fail(event.message);
  }

  static async open(base: string | URL, seed = 1): Promise<WasmTransport> {
    const answer = await fetch(new URL("knob.wasm", base));
    if (!answer.ok) throw new Error("knob.wasm is missing beside the page: build it with ./dev studio");
    const module = await answer.arrayBuffer();
    const transport = new WasmTransport(new Worker(new URL("worker.js", base), { type: "module" }));
    await transport.#ask({ kind: "start", module, seed } as ToWorker);
    return transport;
  }

  #take(message: FromWorker): void {
    if (message.kind === "answer") {
      this.#waiting.get(message.id)?.(message.result);
      this.#waiting.delete(message.id);
    } else if (message.kind === "time") {
      this.#inbox.push(message.reports);
      this.onTruth(message.truth);
      // After the timers that are due: signs of life are on their way before time goes on.
      setTimeout(() => this.#send({ kind: "taken" }));
    } else {
      this.#fail(message.why);
    }
  }

  #fail(why: string): void {
    this.#inbox.end(`the emulated knob broke: ${why}; load the page again`);
  }

  #send(message: Omit<ToWorker, "id"> & object, id = 0): void {
    this.#worker.postMessage({ ...message, id });
  }

  #ask(message: Omit<ToWorker, "id"> & object): Promise<unknown> {
    this.#inbox.check();
    const id = ++this.#id;
    this.#send(message, id);
    return new Promise((resolve) => this.#waiting.set(id, resolve));
  }

  async write(report: Uint8Array): Promise<void> {
    await this.#ask({ kind: "write", report } as ToWorker);
  }

  read(): Promise<Uint8Array[]> {
    return this.#inbox.take();
  }

  async getFeature(id: number): Promise<Uint8Array | undefined> {
    return (await this.#ask({ kind: "get", report: id } as ToWorker)) as Uint8Array | undefined;
  }

  async setFeature(report: Uint8Array): Promise<boolean> {
    return Boolean(await this.#ask({ kind: "set", report } as ToWorker));
  }

  /** The hand means to bring the knob to this angle; undefined lets go. */
  hand(angle: number | undefined): void {
    this.#send({ kind: "hand", angle } as ToWorker);
  }

  setEmergencyStop(pressed: boolean): void {
    this.#send({ kind: "emergency stop", pressed } as ToWorker);
  }

  close(): void {
    this.#worker.terminate();
    this.#inbox.end("the emulated knob was closed");
  }
}
