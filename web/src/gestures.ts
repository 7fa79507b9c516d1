// Mouse, touch and pen on a picture: pan, pinch, wheel, hover and click.

import type { Point } from "./data";

export interface Gestures {
  pan(dx: number, dy: number): void;
  zoom(factor: number, at: Point): void;
  hover(at: Point | null): void;
  click(at: Point): void;
  doubleClick?(at: Point): void;
}

const STILL = 5; // CSS px: a press that moves less is a click

export function listen(element: HTMLElement, on: Gestures): void {
  const pressed = new Map<number, Point>();
  let moved = 0, pinched = false;
  const place = (event: MouseEvent): Point => {
    const box = element.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };
  element.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    element.setPointerCapture(event.pointerId);
    if (!pressed.size) [moved, pinched] = [0, false];
    pressed.set(event.pointerId, place(event));
    if (pressed.size > 1) pinched = true;
  });
  element.addEventListener("pointermove", (event) => {
    const at = place(event), before = pressed.get(event.pointerId);
    if (!before) return on.hover(at);
    const other = [...pressed].find(([id]) => id !== event.pointerId)?.[1];
    pressed.set(event.pointerId, at);
    if (other) {
      const gap = (p: Point) => Math.max(Math.hypot(p[0] - other[0], p[1] - other[1]), 1);
      const middle: Point = [(at[0] + other[0]) / 2, (at[1] + other[1]) / 2];
      on.zoom(gap(at) / gap(before), middle);
      on.pan((at[0] - before[0]) / 2, (at[1] - before[1]) / 2);
      return;
    }
    moved += Math.hypot(at[0] - before[0], at[1] - before[1]);
    if (moved > STILL) on.pan(at[0] - before[0], at[1] - before[1]);
  });
  const release = (event: PointerEvent) => {
    const was = pressed.delete(event.pointerId);
    if (was && event.type === "pointerup" && !pressed.size && moved <= STILL && !pinched) on.click(place(event));
  };
  element.addEventListener("pointerup", release);
  element.addEventListener("pointercancel", release);
  element.addEventListener("pointerleave", (event) => { if (!pressed.has(event.pointerId)) on.hover(null); });
  element.addEventListener("dblclick", (event) => on.doubleClick?.(place(event)));
  element.addEventListener("wheel", (event) => {
    event.preventDefault();
    on.zoom(Math.exp(-event.deltaY * (event.deltaMode === 1 ? 0.05 : 0.0016)), place(event));
  }, { passive: false });
}
