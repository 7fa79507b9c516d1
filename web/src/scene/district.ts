// The district in 3-D: the model of the run, the facades to click, and the city model to compare with.

import { CircleGeometry, Color, Mesh, MeshBasicMaterial, Scene, Vector2, WebGLRenderer } from "three";
import { MapControls } from "three/addons/controls/MapControls.js";
import type { App } from "../app";
import { h } from "../dom";
import { counted } from "../format";
import { titleOf } from "../search";
import { Before } from "./before";
import { makeCamera, overview } from "./camera";
import { Light } from "./light";
import { Pace } from "./pace";
import { Model } from "./tiles";
import { Walls, type Hit } from "./walls";

export class District {
  readonly element = h("section", { class: "stage district" });
  readonly camera = makeCamera();
  readonly scene = new Scene();
  private readonly canvas = h("canvas", { tabindex: 0, role: "img", "aria-label": "The district in 3-D" });
  private readonly status = h("p", { class: "status", role: "status" }, "Loading the model …");
  private readonly tip = h("div", { class: "tip", hidden: true });
  private readonly divider = h("input", { class: "divider", type: "range", min: 0, max: 100, value: 50, "aria-label": "Before and after", hidden: true });
  private readonly sides = h("div", { class: "sides", hidden: true });
  private readonly renderer: WebGLRenderer | null;
  private controls: MapControls | null = null;
  private readonly walls: Walls;
  readonly model: Model | null;
  readonly before: Before | null;
  private readonly light = new Light();
  private readonly pace = new Pace(() => this.resize());
  private comparing = false;
  private queued = false;
  private placed = false;
  private hovered: string | null = null;
  frames = 0;

  constructor(private readonly app: App) {
    const { run } = app, redraw = () => this.redraw();
    this.walls = new Walls(run, run.tiles === null, redraw);
    this.model = run.tiles && new Model(run.tiles.path, run.tiles.matrix, {
      changed: redraw, failed: (url) => app.notify(`A part of the model could not be loaded: ${url.split("/").pop()}.`),
    });
    this.before = run.tiles && new Before(run.tiles.path, run.tiles.matrix, redraw);
    this.renderer = this.makeRenderer();
    this.element.append(this.canvas, this.tip, this.status);
    this.status.hidden = run.tiles === null;
    if (!this.renderer) {
      this.element.replaceChildren(h("p", { class: "empty" }, "This browser shows no 3-D (WebGL 2). The facades are in the list."));
      return;
    }
    this.fill();
    this.listen();
  }

  start(): void {
    this.resize();
    this.redraw();
  }

  private makeRenderer(): WebGLRenderer | null {
    try {
      const renderer = new WebGLRenderer({ canvas: this.canvas, context: contextOf(this.canvas) });
      renderer.autoClear = false;
      return renderer;
    } catch {
      return null;
    }
  }

  private fill(): void {
    const { run } = this.app;
    this.scene.add(this.walls.group, this.light.group);
    if (this.model) this.scene.add(this.model.tiles.group);
    const xs = run.facades.flatMap((f) => f.outline.map((p) => p[0])), ys = run.facades.flatMap((f) => f.outline.map((p) => p[1]));
    const low = Math.min(...run.buildings.map((b) => b.ground ?? Infinity), ...run.facades.flatMap((f) => f.outline.map((p) => p[2])));
    const reach = Math.max(Math.max(...xs) - Math.min(...xs), Math.max(...ys) - Math.min(...ys));
    const ground = () => {
      const mesh = new Mesh(new CircleGeometry(reach * 1.2 + 15, 96), new MeshBasicMaterial({ color: 0xffffff, name: "ground" }));
      mesh.position.set((Math.max(...xs) + Math.min(...xs)) / 2, (Math.max(...ys) + Math.min(...ys)) / 2, low - 0.1);
      return mesh;
    };
    this.grounds = [ground(), ground()];
    this.scene.add(this.grounds[0]!);
    this.before?.scene.add(this.grounds[1]!);
    if (this.before) this.compareTools(run.tiles!.before);
  }
  private grounds: Mesh<CircleGeometry, MeshBasicMaterial>[] = [];

  private compareTools(what: string): void {
    const button = h("button", { type: "button", "aria-pressed": "false", title: `Compare with ${what}`, click: () => this.compare(button) }, "Before / after");
    const home = h("button", { type: "button", title: "Whole district (0)", click: () => { this.placed = false; this.resize(); this.redraw(); } }, "Fit");
    this.sides.append(h("span", {}, `Before: ${what}`), h("span", {}, "After: this run"));
    this.divider.addEventListener("input", () => this.redraw());
    this.element.append(h("div", { class: "toolbar", role: "toolbar", "aria-label": "Tools" }, h("div", { class: "group" }, button, home)), this.sides, this.divider);
  }

  private compare(button: HTMLButtonElement): void {
    this.comparing = !this.comparing;
    button.setAttribute("aria-pressed", String(this.comparing));
    this.divider.hidden = this.sides.hidden = !this.comparing;
    if (this.comparing) this.before!.load().catch(() => this.app.notify("The city model could not be loaded."));
    this.redraw();
  }

  private listen(): void {
    this.controls = new MapControls(this.camera, this.canvas);
    this.controls.maxPolarAngle = Math.PI * 0.55;
    this.controls.addEventListener("change", () => { this.pace.moved(); this.redraw(); });
    this.controls.listenToKeyEvents(this.canvas);
    new ResizeObserver(() => this.resize()).observe(this.canvas);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.redraw());
    let pressed: [number, number] | null = null;
    this.canvas.addEventListener("pointerdown", (event) => { pressed = [event.clientX, event.clientY]; });
    this.canvas.addEventListener("pointermove", (event) => { if (!event.buttons) this.hover(event, this.hit(event)); });
    this.canvas.addEventListener("pointerleave", () => this.hover(null, null));
    this.canvas.addEventListener("pointerup", (event) => {
      const still = pressed && Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]) < 5;
      const hit = still && event.button === 0 ? this.hit(event) : null;
      if (hit) this.app.select(hit.facade, hit.opening?.id ?? null, true);
    });
    this.canvas.addEventListener("keydown", (event) => {
      if (event.key !== "0") return;
      this.placed = false;
      this.resize();
      this.redraw();
    });
  }

  private hit(event: PointerEvent): Hit | null {
    const box = this.canvas.getBoundingClientRect();
    const at = new Vector2(((event.clientX - box.left) / box.width) * 2 - 1, 1 - ((event.clientY - box.top) / box.height) * 2);
    return this.walls.pick(at, this.camera);
  }

  private hover(event: PointerEvent | null, hit: Hit | null): void {
    if ((hit?.facade.id ?? null) !== this.hovered) {
      this.hovered = hit?.facade.id ?? null;
      this.walls.highlight(this.hovered);
      this.canvas.style.cursor = hit ? "pointer" : "";
    }
    this.tip.hidden = !hit;
    if (!hit || !event) return;
    const { facade, opening } = hit, box = this.canvas.getBoundingClientRect();
    const about = opening ? `${opening.kind} ${opening.id.split("/").pop()}` : facade.openings ? counted(facade.openings.length, "opening") : facade.id;
    this.tip.replaceChildren(h("b", {}, titleOf(this.app.run, facade)), h("span", {}, `${facade.id} · ${about}`));
    this.tip.style.left = `${Math.min(event.clientX - box.left + 14, box.width - 180)}px`;
    this.tip.style.top = `${event.clientY - box.top + 14}px`;
  }

  redraw(): void {
    if (this.queued || !this.renderer) return;
    this.queued = true;
    requestAnimationFrame((now) => { this.queued = false; this.pace.frame(now); this.draw(); });
  }

  private resize(): void {
    const { clientWidth: w, clientHeight: height } = this.canvas;
    if (!this.renderer || !w || !height) return;
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio || 1, 2) * this.pace.scale);
    this.renderer.setSize(w, height, false);
    this.camera.aspect = w / height;
    this.camera.updateProjectionMatrix();
    if (!this.placed) {
      const { position, target } = overview(this.app.run, this.camera.aspect);
      this.camera.position.copy(position);
      this.controls!.target.copy(target);
      this.controls!.update();
      this.placed = true;
    }
    this.redraw();
  }

  private draw(): void {
    if (!this.element.isConnected || !this.placed) return;
    const renderer = this.renderer!, size = renderer.getSize(new Vector2());
    const style = getComputedStyle(this.element);
    const sky = new Color(style.backgroundColor), ground = new Color(style.outlineColor);
    for (const mesh of this.grounds) mesh.material.color.copy(ground);
    renderer.setClearColor(sky);
    for (const light of [this.light, this.before?.light]) light?.follow(this.camera);
    this.walls.update(this.camera, size.y);
    this.model?.update(this.camera, renderer);
    renderer.setScissorTest(false);
    renderer.clear();
    const split = this.comparing ? Math.round((size.x * Number(this.divider.value)) / 100) : 0;
    if (split) {
      renderer.setScissorTest(true);
      renderer.setScissor(0, 0, split, size.y);
      renderer.render(this.before!.scene, this.camera);
      renderer.setScissor(split, 0, size.x - split, size.y);
    }
    renderer.render(this.scene, this.camera);
    this.element.style.setProperty("--split", `${split}px`);
    this.frames += 1;
    if (this.model?.tiles.visibleTiles.size) this.status.hidden = true;
    if (this.model?.loading) this.redraw();
  }
}

// Smooth edges cost four times the pixels, which is too much where no graphics hardware draws them.
function contextOf(canvas: HTMLCanvasElement): WebGL2RenderingContext {
  const context = canvas.getContext("webgl2", { antialias: true, failIfMajorPerformanceCaveat: true })
    ?? canvas.getContext("webgl2", { antialias: false });
  if (!context) throw new Error("no WebGL 2");
  return context;
}
