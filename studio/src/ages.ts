// How old samples are when the browser has painted them: for ./dev bench studio.

const KEPT = 1000;
// Some pictures tell enough.
const EVERY = 4;
// After so many messages the quickest one is forgotten, because the two clocks drift apart.
const QUICKEST_OF = 64;

/**
 * A sample's age counts from when it was made, by the knob's clock. The quickest
 * sample tells best what that clock says in the page's time.
 */
export class Ages {
  readonly #ages: number[] = [];
  readonly #painted = new MessageChannel();
  /** Page's time less the knob's, in ms. */
  #ahead = Infinity;
  #quickest = Infinity;
  #messages = 0;
  /** Times of the samples that came together, in ms of the knob: the first and the last. */
  #first = NaN;
  #last = NaN;
  #pictures = 0;

  /** Another knob, and another clock. */
  begin(): void {
    this.#ahead = this.#quickest = Infinity;
    this.#first = NaN;
  }

  sample(timeS: number): void {
    this.#last = 1e3 * timeS;
    if (Number.isNaN(this.#first)) this.#first = this.#last;
  }

  /** The samples until now are those that came together. */
  came(): void {
    const ahead = performance.now() - this.#last;
    this.#ahead = Math.min(this.#ahead, ahead);
    this.#quickest = Math.min(this.#quickest, ahead);
    if (++this.#messages % QUICKEST_OF) return;
    this.#ahead = this.#quickest;
    this.#quickest = Infinity;
  }

  /** They are all in the picture that is drawn now. */
  drawn(): void {
    const made = [this.#first, (this.#first + this.#last) / 2, this.#last].map((at) => at + this.#ahead);
    this.#first = NaN;
    if (++this.#pictures % EVERY) return;
    // Comes when the browser has painted.
    this.#painted.port1.onmessage = () => {
      this.#ages.push(...made.map((at) => performance.now() - at));
      this.#ages.splice(0, this.#ages.length - KEPT);
    };
    this.#painted.port2.postMessage(undefined);
  }

  /** The age that this part of the samples does not exceed, in ms. */
  part(part: number): number | undefined {
    return [...this.#ages].sort((a, b) => a - b)[Math.floor(part * (this.#ages.length - 1))];
  }
}
