// What is known of one opening, and the photos that show it.

import type { App } from "./app";
import type { Facade, Opening, PhotoView, Vec3 } from "./data";
import { h, svg } from "./dom";
import { millimetres, percent, plusMinus } from "./format";
import { kindColour } from "./overlays";
import { storey } from "./search";

export function openingPanel(app: App, facade: Facade, o: Opening): HTMLElement {
  return h("article", { class: "panel", "aria-label": o.id },
    h("header", {},
      h("div", {}, h("h2", {}, `${capital(o.kind)} ${o.number}, ${storey(o.floor)}`), h("p", { class: "quiet" }, o.id)),
      h("button", { type: "button", class: "plain", title: "Close (Esc)", "aria-label": "Close", click: () => app.select(null, null, false) }, "✕")),
    h("dl", {}, ...rows(o).flatMap(([term, value]) => [h("dt", {}, term), h("dd", {}, value)])),
    ...o.notes.map((note) => h("p", { class: "note" }, capital(note), ".")),
    h("h3", {}, `Corners on the wall (${facade.crs ?? "no CRS"})`),
    table(o.corners),
    ...(o.corners_inside ? [h("h3", {}, "Corners at its depth"), table(o.corners_inside)] : []),
    h("h3", {}, o.photos.length ? "Photos that show it" : "No photo shows it"),
    o.tested ? h("p", { class: "quiet small" }, `${capital(o.tested)}.`) : null,
    h("div", { class: "photos" }, ...o.photos.map((view) => thumbnail(app, view, o))));
}

function rows(o: Opening): [string, string][] {
  const found: [string, string][] = [
    ["Size", `${o.width.toFixed(3)} × ${o.height.toFixed(3)} m`],
    ["σ of the size", [o.sigma["width"], o.sigma["height"]].map((s) => (s ? millimetres(s) : "unknown")).join(" × ")],
    ["Area", `${o.area.toFixed(3)} m²`],
    ["Depth", o.depth === null ? "not measured" : `${o.depth.toFixed(3)} m${plusMinus(o.sigma["depth"])}`],
    ["Shape", o.shape],
    ["Bay", String(o.bay)],
    ["Provenance", `${o.provenance}, ${percent(o.confidence)} sure`],
  ];
  if (o.glazing) found.push(["Window bars", o.glazing.note ? `${o.glazing.layout} (${o.glazing.note})` : `${o.glazing.layout}, ${percent(o.glazing.confidence)} sure`]);
  found.push(["Centre", o.center.map((v) => v.toFixed(3)).join(" ")]);
  return found;
}

const CORNERS = ["lower left", "lower right", "upper right", "upper left"];

function table(corners: Vec3[]): HTMLElement {
  return h("table", {}, h("tbody", {}, ...corners.map((corner, k) =>
    h("tr", {}, h("th", { scope: "row" }, CORNERS[k] ?? ""), ...corner.map((v) => h("td", {}, v.toFixed(3)))))));
}

// The part of a photo around an opening with its outline; a click shows the whole photo.
function thumbnail(app: App, view: PhotoView, o: Opening): HTMLElement {
  const photo = app.run.photos[view.number]!;
  const us = view.outline.map((p) => p[0]), vs = view.outline.map((p) => p[1]);
  const [u0, u1, v0, v1] = [Math.min(...us), Math.max(...us), Math.min(...vs), Math.max(...vs)];
  const side = 1.7 * Math.max(u1 - u0, v1 - v0);
  const picture = framed(app, photo.path, photo.size, view, o, [(u0 + u1 - side) / 2, (v0 + v1 - side) / 2, side, side]);
  return h("button", { type: "button", class: "photo", click: () => enlarge(app, view, o) }, picture,
    h("span", {}, h("b", {}, view.photo), h("span", { class: "quiet" }, `${percent(view.visible)} visible · ${view.angle.toFixed(0)}° · ${millimetres(view.gsd)}/px`)));
}

function framed(app: App, path: string, size: [number, number], view: PhotoView, o: Opening, box: number[]): SVGElement {
  const points = view.outline.map((p) => p.join(",")).join(" ");
  const line = (colour: string, width: number) =>
    svg("polygon", { points, fill: "none", stroke: colour, "stroke-width": width, "vector-effect": "non-scaling-stroke" });
  const image = svg("image", { href: path, width: size[0], height: size[1], preserveAspectRatio: "none" });
  image.addEventListener("error", () => app.notify(`The photo ${view.photo} could not be read.`));
  return svg("svg", { viewBox: box.join(" "), role: "img", "aria-label": `${o.id} in ${view.photo}` }, image, line("#fff", 4), line(kindColour(o.kind), 2));
}

function enlarge(app: App, view: PhotoView, o: Opening): void {
  const photo = app.run.photos[view.number]!;
  const close = () => dialog.close();
  const picture = framed(app, photo.path, photo.size, view, o, [0, 0, ...photo.size]);
  picture.style.setProperty("--shape", String(photo.size[0] / photo.size[1]));
  const dialog = h("dialog", { class: "lightbox", "aria-label": view.photo },
    h("header", {}, h("b", {}, view.photo), h("span", { class: "quiet" }, o.id), h("button", { type: "button", class: "plain", "aria-label": "Close", click: close }, "✕")),
    picture);
  dialog.addEventListener("click", (event) => { if (event.target === dialog) close(); });
  dialog.addEventListener("close", () => dialog.remove());
  document.body.append(dialog);
  dialog.showModal();
}

const capital = (text: string) => text.charAt(0).toUpperCase() + text.slice(1);
