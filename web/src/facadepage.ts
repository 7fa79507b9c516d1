// The page of one facade: the canvas with its tools, layers, scale bar and readout.

import type { App } from "./app";
import { css, hue, rampCss } from "./colours";
import type { Facade, FacadeEntry, Opening, Point } from "./data";
import { h } from "./dom";
import { FacadeView, type Layer, type Probe, type Tool } from "./facadeview";
import { millimetres, plusMinus } from "./format";
import { areaOf, lengthInSpace, lengthOf } from "./measure";

export class FacadePage {
  readonly element = h("section", { class: "stage facade" });
  readonly view: FacadeView | null;
  private readonly readout = h("output", { class: "readout", "aria-live": "off" });
  private readonly result = h("output", { class: "result", hidden: true });
  private readonly legend = h("div", { class: "legend", hidden: true });
  private readonly scaleBar = h("div", { class: "scalebar", "aria-hidden": true });
  private readonly tools: Record<Tool, HTMLButtonElement>;

  constructor(private readonly app: App, readonly entry: FacadeEntry, readonly facade: Facade) {
    const tool = (name: Tool, text: string, key: string) =>
      h("button", { type: "button", title: `${text} (${key})`, "aria-pressed": name === "look", click: () => this.use(name) }, text);
    this.tools = { look: tool("look", "Look", "V"), length: tool("length", "Distance", "M"), area: tool("area", "Area", "A") };
    if (!facade.ortho) {
      this.view = null;
      this.element.append(h("p", { class: "empty" }, `There is no ortho-image of ${facade.id}; its openings are in the list.`));
      return;
    }
    this.view = new FacadeView(app.run, entry, facade, facade.ortho, {
      probe: (probe) => this.tell(probe),
      measured: (pixels, name) => this.showMeasured(pixels, name),
      picked: (opening) => app.select(entry, opening?.id ?? null, false),
      problem: (text) => app.notify(text),
    });
    this.view.canvas.addEventListener("drawn", () => this.drawScale());
    this.element.append(
      this.view.canvas,
      h("div", { class: "toolbar", role: "toolbar", "aria-label": "Tools" },
        h("div", { class: "group" }, this.tools.look, this.tools.length, this.tools.area),
        h("div", { class: "group zoom" },
          h("button", { type: "button", title: "Zoom in (+)", "aria-label": "Zoom in", click: () => this.zoom(1.5) }, "+"),
          h("button", { type: "button", title: "Zoom out (−)", "aria-label": "Zoom out", click: () => this.zoom(1 / 1.5) }, "−"),
          h("button", { type: "button", title: "Whole facade (0)", click: () => this.fit() }, "Fit")),
        this.layers()),
      this.legend, this.scaleBar, this.result, this.readout);
    this.tell(null);
  }

  dispose(): void {
    this.view?.dispose();
  }

  show(opening: Opening | null, fly: boolean): void {
    if (!this.view) return;
    this.view.selected = opening?.id ?? null;
    if (opening && fly) this.view.flyTo(opening);
    this.view.redraw();
  }

  key(event: KeyboardEvent): boolean {
    const view = this.view;
    if (!view) return false;
    const step = 60;
    const moves: Record<string, Point> = { ArrowLeft: [step, 0], ArrowRight: [-step, 0], ArrowUp: [0, step], ArrowDown: [0, -step] };
    const move = moves[event.key];
    if (move) view.view.pan(...move);
    else if (event.key === "+" || event.key === "=") view.view.zoom(1.5);
    else if (event.key === "-") view.view.zoom(1 / 1.5);
    else if (event.key === "0") view.view.fit();
    else if (event.key === "v") this.use("look");
    else if (event.key === "m") this.use("length");
    else if (event.key === "a") this.use("area");
    else if (event.key === "Enter") view.finish();
    else if (event.key === "Escape") return view.cancel();
    else return false;
    view.redraw();
    return true;
  }

  private layers(): HTMLElement {
    const view = this.view!, choices: [string, string, Layer][] = [["photo", "Picture", "photo"]];
    if (this.facade.ortho!.relief) choices.push(["depth", "Depth", "depth"]);
    choices.push(["sources", "Sources", "sources"], ["resolution", "Resolution", "resolution"]);
    for (const p of this.facade.pictures) choices.push([p.name, p.name === "evidence" ? "Evidence" : p.name, p]);
    const select = h("select", { title: "What is drawn on the facade" }, ...choices.map(([value, text]) => h("option", { value }, text)));
    const slider = h("input", { type: "range", min: 0.1, max: 1, step: 0.05, value: view.opacity, "aria-label": "Opacity of the layer", disabled: true });
    select.addEventListener("change", () => {
      view.layer = choices.find(([value]) => value === select.value)![2];
      slider.disabled = view.layer === "photo";
      view.redraw();
    });
    slider.addEventListener("input", () => { view.opacity = Number(slider.value); view.redraw(); });
    const box = (name: keyof typeof view.shown, text: string) => {
      const input = h("input", { type: "checkbox", checked: view.shown[name] });
      input.addEventListener("change", () => { view.shown[name] = input.checked; view.redraw(); });
      return h("label", {}, input, text);
    };
    return h("details", { class: "group layers" },
      h("summary", {}, "Layers"),
      h("div", { class: "popover" }, h("label", { class: "row" }, "Layer", select), h("label", { class: "row" }, "Opacity", slider),
        box("openings", "Openings"), box("bars", "Window bars"), box("protrusions", "Protrusions"),
        box("errors", "Uncertainty of borders, ± 2 σ")));
  }

  private use(name: Tool): void {
    for (const [key, button] of Object.entries(this.tools)) button.setAttribute("aria-pressed", String(key === name));
    this.view?.setTool(name);
    if (name === "length") this.say("Click the points of a path; Enter or a double click ends it.");
    if (name === "area") this.say("Click the corners of an area; Enter or a double click ends it.");
  }

  private zoom(factor: number): void {
    this.view!.view.zoom(factor);
    this.view!.redraw();
  }

  private fit(): void {
    this.view!.view.fit();
    this.view!.redraw();
  }

  private say(text: string): void {
    this.result.hidden = !text;
    this.result.replaceChildren(text);
  }

  private showMeasured(pixels: Point[], tool: Tool): void {
    const ortho = this.facade.ortho!, view = this.view;
    if (tool === "look") return this.say("");
    if (pixels.length < (tool === "length" ? 2 : 3)) return;
    if (tool === "area") {
      const { value, sigma } = areaOf(ortho, pixels);
      return this.say(`${value.toFixed(3)} m² ± ${sigma.toFixed(3)} m² on the wall`);
    }
    const { value, sigma } = lengthOf(ortho, pixels);
    const places = pixels.map((p) => view!.probeAt(p)?.world);
    const space = places.every((p) => p !== undefined) ? lengthInSpace(places) : null;
    const more = space === null ? "" : `; ${space.toFixed(3)} m in space`;
    this.say(`${value.toFixed(3)} m${plusMinus(sigma)} on the wall${more}`);
  }

  private tell(probe: Probe | null): void {
    const crs = this.facade.crs ?? "no CRS";
    if (!probe) {
      this.readout.replaceChildren(h("span", { class: "quiet" }, `Point at the facade for its coordinates (${crs}).`));
      return;
    }
    const { xyz, relief, depth, sigma } = probe.world;
    const text = xyz.map((v) => v.toFixed(3)).join("  ");
    const surface = relief ? `relief, ${millimetres(Math.abs(depth))} ${depth < 0 ? "before" : "behind"} the plane` : "on the plane";
    const details = [`${surface}`, probe.source, probe.resolution ? `${millimetres(probe.resolution)} per source pixel` : null,
      `pixel ${probe.pixel[0].toFixed(1)}, ${probe.pixel[1].toFixed(1)}`].filter((v): v is string => Boolean(v));
    this.readout.dataset["xyz"] = xyz.map((v) => v.toFixed(4)).join(" ");
    this.readout.dataset["sigma"] = String(sigma);
    this.readout.classList.toggle("pinned", probe.pinned);
    this.readout.replaceChildren(
      h("strong", {}, text), h("span", {}, `${plusMinus(sigma).trim()} across the wall`), h("span", { class: "quiet" }, details.join(" · ")),
      ...(probe.pinned ? [h("button", { type: "button", class: "plain", click: () => void this.copy(text) }, "Copy")] : []));
  }

  private async copy(text: string): Promise<void> {
    await navigator.clipboard.writeText(text.replaceAll("  ", " "));
    this.app.notify("Copied.");
  }

  private drawScale(): void {
    const view = this.view!, perMetre = view.view.scale / this.facade.ortho!.gsd;
    const nice = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50].find((m) => m * perMetre >= 70) ?? 50;
    this.scaleBar.style.width = `${nice * perMetre}px`;
    this.scaleBar.textContent = nice < 1 ? `${Math.round(nice * 100)} cm` : `${nice} m`;
    this.drawLegend();
  }

  private drawLegend(): void {
    const { layer, rasters } = this.view!;
    const name = typeof layer === "string" ? layer : layer.path;
    const range = name === "depth" || name === "resolution" ? rasters.ranges[name] : null;
    const key = `${name} ${range?.join(" ") ?? ""}`;
    if (this.legend.dataset["key"] === key) return;
    this.legend.dataset["key"] = key;
    this.legend.hidden = layer === "photo";
    if (range) {
      const bar = h("div", { class: "ramp" });
      bar.style.background = rampCss;
      const [title, low, high] = name === "depth" ? ["Depth behind the plane", range[0], range[1]] : ["Size of a source pixel on the wall", ...range];
      this.legend.replaceChildren(h("b", {}, title as string), bar, h("div", { class: "ends" }, h("span", {}, millimetres(low as number)), h("span", {}, millimetres(high as number))));
    } else if (layer === "sources") {
      this.legend.replaceChildren(h("b", {}, "Where pixels come from"), ...this.facade.ortho!.sources.map((source, k) => {
        const dot = h("i", {});
        dot.style.background = css(hue(k));
        return h("span", { class: "key" }, dot, source);
      }));
    } else if (typeof layer !== "string") {
      this.legend.replaceChildren(h("b", {}, "Evidence"), h("span", { class: "caption" }, layer.caption));
    }
  }
}
