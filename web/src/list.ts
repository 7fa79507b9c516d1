// The list of facades and openings, with filters.

import type { App } from "./app";
import type { FacadeEntry, OpeningEntry } from "./data";
import { h } from "./dom";
import { counted, metres } from "./format";
import { kindColour } from "./overlays";
import { storey, titleOf } from "./search";

interface Filter { kind: string; floor: string; provenance: string }
const DRAWN = 400; // rows at once; more are drawn on demand

export class OpeningList {
  readonly element = h("nav", { class: "list", "aria-label": "Facades and openings" });
  private readonly filter: Filter = { kind: "", floor: "", provenance: "" };
  private readonly body = h("div", { class: "rows" });
  private readonly total = h("p", { class: "quiet small", "aria-live": "polite" });
  private most = DRAWN;

  constructor(private readonly app: App) {
    const all = app.run.facades.flatMap((f) => f.openings ?? []);
    const values = (of: (o: OpeningEntry) => string | number) => [...new Set(all.map(of))].sort((a, b) => (a < b ? -1 : 1));
    this.element.append(
      h("div", { class: "filters" },
        this.choice("kind", "All kinds", values((o) => o.kind).map((v) => [String(v), String(v)])),
        this.choice("floor", "All floors", values((o) => o.floor).map((v) => [String(v), storey(Number(v))])),
        this.choice("provenance", "Measured or not", values((o) => o.provenance).map((v) => [String(v), String(v)]))),
      this.total, this.body);
    this.draw();
  }

  // Show the openings of one facade, or the facades alone.
  draw(): void {
    const { run, facade, opening } = this.app;
    const filtered = Object.values(this.filter).some(Boolean);
    let drawn = 0, matching = 0;
    const groups = run.facades.map((entry) => {
      const own = (entry.openings ?? []).filter((o) => this.passes(o));
      matching += own.length;
      const unfold = entry.id === facade?.id || (filtered && own.length > 0);
      const rows = unfold ? own.slice(0, Math.max(0, this.most - drawn)) : [];
      drawn += rows.length;
      return this.group(entry, own, rows, unfold, opening);
    });
    const more = h("button", { type: "button", class: "plain more", click: () => { this.most += DRAWN; this.draw(); } }, "Show more");
    this.body.replaceChildren(...groups, ...(drawn >= this.most ? [more] : []));
    this.total.textContent = `${counted(run.facades.length, "facade")}, ${counted(matching, "opening")}${filtered ? " that match" : ""}`;
    this.body.querySelector('[aria-current="true"]')?.scrollIntoView({ block: "nearest" });
  }

  private group(entry: FacadeEntry, own: OpeningEntry[], rows: OpeningEntry[], unfold: boolean, opening: string | null): HTMLElement {
    const title = titleOf(this.app.run, entry), current = unfold && this.app.facade?.id === entry.id;
    const about = entry.openings === null ? "openings unknown" : counted(own.length, "opening");
    return h("section", { class: current ? "current" : null },
      h("button", { type: "button", class: "facade-row", "aria-expanded": unfold, "aria-current": current && !opening ? "true" : null, click: () => this.app.select(entry, null, true) },
        h("b", {}, title), h("span", { class: "quiet" }, `${entry.id} · ${about}`)),
      ...rows.map((o) => this.row(entry, o, o.id === opening)));
  }

  private row(entry: FacadeEntry, o: OpeningEntry, current: boolean): HTMLElement {
    const dot = h("i", { class: o.provenance === "inferred" ? "hollow" : null });
    dot.style.setProperty("--colour", kindColour(o.kind));
    return h("button", { type: "button", class: "opening-row", "aria-current": current ? "true" : null, "data-id": o.id, click: () => this.app.select(entry, o.id, true) },
      dot, h("span", {}, o.id.split("/").pop() ?? o.id), h("span", { class: "quiet" }, o.kind), h("span", { class: "size" }, `${o.width.toFixed(2)} × ${metres(o.height, 2)}`));
  }

  private passes(o: OpeningEntry): boolean {
    const { kind, floor, provenance } = this.filter;
    return (!kind || o.kind === kind) && (!floor || String(o.floor) === floor) && (!provenance || o.provenance === provenance);
  }

  private choice(name: keyof Filter, all: string, values: [string, string][]): HTMLSelectElement {
    const select = h("select", { "aria-label": all }, h("option", { value: "" }, all), ...values.map(([value, text]) => h("option", { value }, text)));
    select.addEventListener("change", () => { this.filter[name] = select.value; this.most = DRAWN; this.draw(); });
    return select;
  }
}
