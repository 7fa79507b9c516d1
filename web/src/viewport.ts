// Where a picture lies on the screen: scale (CSS px per picture px) and offset, with pan and zoom.

import type { Point } from "./data";

const DEEPEST = 40; // CSS px per picture px

export class Viewport {
  scale = 1;
  x = 0;
  y = 0;
  private fitted = 1;
  private readonly above = 52; // CSS px that tools and readout cover
  private readonly below = 60;

  constructor(readonly size: Point, private shown: Point = [1, 1]) {}

  resize(width: number, height: number): void {
    const centre = this.toPicture([this.shown[0] / 2, this.shown[1] / 2]);
    const wasFitted = this.scale === this.fitted;
    this.shown = [Math.max(width, 1), Math.max(height, 1)];
    this.fitted = this.fitScale();
    if (wasFitted) this.fit();
    else this.centreOn(centre);
  }

  fit(): void {
    this.scale = this.fitted = this.fitScale();
    this.centreOn([this.size[0] / 2, this.size[1] / 2]);
    this.y += (this.above - this.below) / 2;
  }

  toScreen([column, row]: Point): Point {
    return [this.x + this.scale * column, this.y + this.scale * row];
  }

  toPicture([x, y]: Point): Point {
    return [(x - this.x) / this.scale, (y - this.y) / this.scale];
  }

  pan(dx: number, dy: number): void {
    this.x += dx;
    this.y += dy;
    this.keepInSight();
  }

  zoom(factor: number, at: Point = [this.shown[0] / 2, this.shown[1] / 2]): void {
    const scale = Math.min(Math.max(this.scale * factor, this.fitted * 0.5), Math.max(DEEPEST, this.fitted));
    const [column, row] = this.toPicture(at);
    this.scale = scale;
    this.x = at[0] - scale * column;
    this.y = at[1] - scale * row;
    this.keepInSight();
  }

  centreOn([column, row]: Point): void {
    this.x = this.shown[0] / 2 - this.scale * column;
    this.y = this.shown[1] / 2 - this.scale * row;
  }

  // Show a box of the picture with some of its surroundings.
  show([c0, r0]: Point, [c1, r1]: Point): void {
    const room = 2.6;
    const fit = Math.min(this.shown[0] / (room * (c1 - c0)), this.shown[1] / (room * (r1 - r0)));
    this.scale = Math.min(Math.max(fit, this.fitted), DEEPEST);
    this.centreOn([(c0 + c1) / 2, (r0 + r1) / 2]);
  }

  get screen(): Point {
    return this.shown;
  }

  private fitScale(): number {
    return Math.min((0.96 * this.shown[0]) / this.size[0], Math.max(this.shown[1] - this.above - this.below, 40) / this.size[1]);
  }

  private keepInSight(): void {
    const reach = 60;
    const [w, h] = [this.scale * this.size[0], this.scale * this.size[1]];
    this.x = Math.min(Math.max(this.x, reach - w), this.shown[0] - reach);
    this.y = Math.min(Math.max(this.y, reach - h), this.shown[1] - reach);
  }
}
