// A knob in the page: the emulated device in a worker, and the world round it.

import { Gone, Inbox, reportsIn, type Transport, type World } from "./transport";

type Message<T> = T & { id: number };
export type ToWorker =
  | Message<{ kind: "start"; module: WebAssembly.Module; seed: number }>
  | Message<{ kind: "write"; report: Uint8Array }>
  | Message<{ kind: "get"; report: number }>
  | Message<{ kind: "set"; report: Uint8Array }>
  /** The page has what came last. */
  | Message<{ kind: "taken" }>
  | Message<{ kind: "hand"; turned: number | undefined }>
  | Message<{ kind: "emergency stop"; pressed: boolean }>;
export type FromWorker =
  | { kind: "answer"; id: number; result: unknown }
  /** Reports one behind the other, and TRUTH at this moment. */
  | { kind: "time"; reports: Uint8Array<ArrayBuffer>; truth: number[] }
  | { kind: "failed"; why: string };

/** @throws Error that says what to do */
export async function compiled(address: URL): Promise<WebAssembly.Module> {
  const answer = await fetch(address);
  if (!answer.ok) throw new Error("knob.wasm is missing beside the page: build it with ./dev studio");
  try {
    // Hosts need not say what it is.
    return await WebAssembly.compile(await answer.arrayBuffer());
  } catch (error) {
    throw new Error(`knob.wasm is damaged; build it again with ./dev studio (${(error as Error).message})`);
  }
}

export class WasmTransport implements Transport, World {
  readonly title = "emulated knob, in this page";
  readonly world = this;
  truth: readonly number[] = [];

  readonly #worker: Worker;
  readonly #inbox = new Inbox();
  readonly #waiting = new Map<number, { resolve(result: unknown): void; reject(why: Error): void }>();
  #id = 0;

  private constructor(worker: Worker) {
    this.#worker = worker;
    worker.onmessage = (event: MessageEvent<FromWorker>) => this.#take(event.data);
    worker.onerror = (event) => this.#fail(event.message);
  }

  static async open(base: string | URL, seed = 1): Promise<WasmTransport> {
    // The worker begins while the module is fetched and compiled.
    const worker = new Worker(new URL("worker.js", base), { type: "module" });
    const transport = new WasmTransport(worker);
    let module: WebAssembly.Module;
    try {
      module = await compiled(new URL("knob.wasm", base));
    } catch (error) {
      worker.terminate();
      throw error;
    }
    await transport.#ask({ kind: "start", module, seed } as ToWorker);
    return transport;
  }

  #take(message: FromWorker): void {
    if (message.kind === "answer") {
      this.#waiting.get(message.id)?.resolve(message.result);
      this.#waiting.delete(message.id);
    } else if (message.kind === "time") {
      this.truth = message.truth;
      this.#inbox.push(reportsIn(message.reports));
      // After the timers that are due: signs of life are on their way before time goes on.
      setTimeout(() => this.#send({ kind: "taken" }));
    } else {
      this.#fail(message.why);
    }
  }

  #fail(why: string): void {
    this.#end(`the emulated knob broke: ${why}; load the page again`);
  }

  #end(words: string): void {
    this.#inbox.end(words);
    for (const { reject } of this.#waiting.values()) reject(new Gone(words));
    this.#waiting.clear();
  }

  #send(message: Omit<ToWorker, "id"> & object, id = 0): void {
    this.#worker.postMessage({ ...message, id });
  }

  #ask(message: Omit<ToWorker, "id"> & object): Promise<unknown> {
    this.#inbox.check();
    const id = ++this.#id;
    this.#send(message, id);
    return new Promise((resolve, reject) => this.#waiting.set(id, { resolve, reject }));
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

  hand(turned: number | undefined): void {
    this.#send({ kind: "hand", turned } as ToWorker);
  }

  setEmergencyStop(pressed: boolean): void {
    this.#send({ kind: "emergency stop", pressed } as ToWorker);
  }

  close(): void {
    this.#worker.terminate();
    this.#end("the emulated knob was closed");
  }
}
