// Fewer pixels while the view moves, as far as the machine needs it; all of them when it rests.

const SLOW_MS = 60, FAST_MS = 30; // between two frames
const LEAST = 0.3; // share of the pixels of the screen, along a side
const REST_MS = 250;

export class Pace {
  scale = 1;
  private moving = false;
  private last = 0;
  private resting: ReturnType<typeof setTimeout> | undefined;

  private readonly apply: () => void;

  // `apply` takes a new share of the pixels over.
  constructor(apply: () => void) {
    this.apply = apply;
  }

  // The view was moved by hand.
  moved(): void {
    if (!this.moving) this.last = 0;
    this.moving = true;
    clearTimeout(this.resting);
    this.resting = setTimeout(() => { this.moving = false; this.set(1); }, REST_MS);
  }

  // A frame begins; frames that follow one another in a movement tell how fast the machine is.
  frame(now: number): void {
    if (!this.moving) return;
    const took = this.last ? now - this.last : 0;
    this.last = now;
    if (took > SLOW_MS && took < 4 * REST_MS) this.set(Math.max(this.scale * Math.max(Math.sqrt(SLOW_MS / took), 0.5), LEAST));
    else if (took && took < FAST_MS && this.scale < 1) this.set(Math.min(this.scale * 1.15, 1));
  }

  private set(scale: number): void {
    if (Math.abs(scale - this.scale) < 0.02) return;
    this.scale = scale;
    this.apply();
  }
}
