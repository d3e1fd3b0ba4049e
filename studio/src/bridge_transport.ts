// A knob that `torsio studio` holds for the page, over a WebSocket. A message is a byte that names
// its kind, then a report; the device's messages may have several.

import { Gone, Inbox, reportsIn, type Transport, type World } from "./transport";

/** First byte of every message; bindings/python/torsio/studio/bridge.py has the same. */
const WRITE = 0, INPUT = 1, GET = 2, SET = 3, GOT = 4, STALLED = 5, TAKEN = 6, HAVE = 7,
  HAND = 8, PRESS = 9, TRUTH = 10;
const ANSWERS: readonly number[] = [GOT, STALLED, TAKEN];
const NONSENSE =
  "the other end does not speak as `torsio studio` does; give page and package the same version of Torsio";

interface Hello {
  title: string;
  read_only: boolean;
  is_emulated: boolean;
}

/** @throws Error if it is none */
function greeting(text: string): Hello {
  const hello = JSON.parse(text) as Hello;
  if (typeof hello.title !== "string" || typeof hello.read_only !== "boolean") throw new Error();
  return hello;
}

export class BridgeTransport implements Transport, World {
  readonly title: string;
  readonly readOnly: boolean;
  readonly world: World | undefined;
  truth: readonly number[] = [];
  readonly #socket: WebSocket;
  readonly #inbox = new Inbox();
  // Answers come in the order of the questions.
  readonly #waiting: { resolve(answer: Uint8Array): void; reject(why: Error): void }[] = [];

  private constructor(socket: WebSocket, hello: Hello) {
    this.#socket = socket;
    this.title = hello.title;
    this.readOnly = hello.read_only;
    this.world = hello.is_emulated ? this : undefined;
    socket.onmessage = (event: MessageEvent<ArrayBuffer>) => {
      const bytes = new Uint8Array(event.data);
      if (bytes[0] === INPUT) this.#takeIn(bytes);
      else if (bytes[0] === TRUTH && bytes.length % 8 === 1) this.truth = [...new Float64Array(event.data.slice(1))];
      else if (ANSWERS.includes(bytes[0]!)) this.#waiting.shift()?.resolve(bytes);
      else this.#end(NONSENSE);
    };
    socket.onclose = (event) => {
      this.#end(event.reason || "the connection to `torsio studio` was cut; start it again");
    };
  }

  #end(why: string): void {
    this.#inbox.end(why);
    for (const { reject } of this.#waiting.splice(0)) reject(new Gone(why));
    this.#socket.close();
  }

  #takeIn(message: Uint8Array): void {
    this.#inbox.push(reportsIn(message.subarray(1)));
    // No more comes than the page keeps up with.
    this.#tell(HAVE, new Uint8Array());
  }

  /** @throws Error that says why the bridge did not let the page in */
  static open(address: string | URL): Promise<BridgeTransport> {
    const socket = new WebSocket(address);
    socket.binaryType = "arraybuffer";
    return new Promise((resolve, reject) => {
      // The first message is text: it describes the other end.
      socket.onmessage = (event: MessageEvent<string>) => {
        try {
          resolve(new BridgeTransport(socket, greeting(event.data)));
        } catch {
          reject(new Error(NONSENSE));
          socket.close();
        }
      };
      socket.onclose = (event) =>
        reject(new Error(event.reason || "`torsio studio` does not answer, or refused the address: open the one that it printed"));
    });
  }

  #send(kind: number, report: Uint8Array): void {
    this.#inbox.check();
    this.#tell(kind, report);
  }

  #tell(kind: number, report: Uint8Array): void {
    const message = new Uint8Array(1 + report.length);
    message[0] = kind;
    message.set(report, 1);
    if (this.#socket.readyState === WebSocket.OPEN) this.#socket.send(message);
  }

  #ask(kind: number, report: Uint8Array): Promise<Uint8Array> {
    this.#send(kind, report);
    return new Promise((resolve, reject) => this.#waiting.push({ resolve, reject }));
  }

  async write(report: Uint8Array): Promise<void> {
    this.#send(WRITE, report);
  }

  read(): Promise<Uint8Array[]> {
    return this.#inbox.take();
  }

  async getFeature(id: number): Promise<Uint8Array | undefined> {
    const answer = await this.#ask(GET, Uint8Array.of(id));
    if (answer[0] === STALLED) return undefined;
    if (answer[0] !== GOT) throw new Error("torsio studio gave another answer than the one asked for; load the page again");
    return answer.slice(1);
  }

  async setFeature(report: Uint8Array): Promise<boolean> {
    return (await this.#ask(SET, report))[0] === TAKEN;
  }

  hand(turned: number | undefined): void {
    this.#tell(HAND, new Uint8Array(Float64Array.of(turned ?? NaN).buffer));
  }

  setEmergencyStop(pressed: boolean): void {
    this.#tell(PRESS, Uint8Array.of(pressed ? 1 : 0));
  }

  close(): void {
    this.#socket.close();
  }
}
