// The application: what is chosen, and the parts that show it. The address bar keeps the choice.

import { loadFacade, type FacadeEntry, type Run } from "./data";
import { h } from "./dom";
import { FacadePage } from "./facadepage";
import { OpeningList } from "./list";
import { openingPanel } from "./panel";
import type { District } from "./scene/district";
import { titleOf } from "./search";
import { SearchBox } from "./searchbox";

export class App {
  facade: FacadeEntry | null = null;
  opening: string | null = null;
  page: FacadePage | null = null;
  private readonly main = h("div", { class: "main" });
  private readonly side = h("aside", { class: "side" });
  private readonly detail = h("aside", { class: "detail", hidden: true });
  private readonly toast = h("p", { class: "toast", role: "status", hidden: true });
  private readonly crumbs = h("div", { class: "crumbs" });
  private readonly search: SearchBox;
  private readonly list: OpeningList;
  district: Promise<District> | null = null;
  private shown = 0;

  constructor(readonly run: Run, root: HTMLElement) {
    this.search = new SearchBox(this);
    this.list = new OpeningList(this);
    this.side.append(this.list.element, this.leftOut());
    root.replaceChildren(
      h("header", { class: "top" }, h("a", { class: "brand", href: "#/" }, "Frontage"), this.crumbs, this.search.element),
      h("div", { class: "body" }, this.side, this.main, this.detail), this.toast);
    window.addEventListener("hashchange", () => void this.route());
    window.addEventListener("keydown", (event) => this.key(event));
    void this.route();
  }

  // Choose a facade and an opening on it; `fly` moves the view there.
  select(entry: FacadeEntry | null, opening: string | null, fly: boolean): void {
    const facade = entry ?? this.facade;
    const hash = `#/${facade ? opening ?? facade.id : ""}`;
    this.flying = fly;
    if (location.hash === hash) void this.route();
    else location.hash = hash;
  }
  private flying = true;

  notify(text: string): void {
    this.toast.textContent = text;
    this.toast.hidden = false;
    clearTimeout(this.hiding);
    this.hiding = setTimeout(() => { this.toast.hidden = true; }, 4000);
  }
  private hiding: ReturnType<typeof setTimeout> | undefined;

  private async route(): Promise<void> {
    const turn = ++this.shown, fly = this.flying;
    this.flying = true;
    const wanted = decodeURIComponent(location.hash.replace(/^#\/?/, ""));
    const entry = this.run.facades.find((f) => wanted === f.id || wanted.startsWith(`${f.id}/`)) ?? null;
    const before = this.facade;
    this.facade = entry;
    this.opening = entry && wanted !== entry.id ? wanted : null;
    this.list.draw();
    this.title();
    try {
      if (!entry) await this.showDistrict();
      else await this.showFacade(entry, turn, fly || before?.id !== entry.id);
    } catch (error) {
      this.main.replaceChildren(h("p", { class: "empty" }, error instanceof Error ? error.message : String(error)));
    }
  }

  private async showFacade(entry: FacadeEntry, turn: number, fly: boolean): Promise<void> {
    const facade = await loadFacade(entry);
    if (turn !== this.shown) return;
    if (this.page?.entry.id !== entry.id) {
      this.page?.dispose();
      this.page = new FacadePage(this, entry, facade);
      this.main.replaceChildren(this.page.element);
    }
    const opening = facade.openings?.find((o) => o.id === this.opening) ?? null;
    this.page.show(opening, fly);
    this.detail.hidden = !opening;
    this.detail.replaceChildren(...(opening ? [openingPanel(this, facade, opening)] : []));
    this.detail.scrollTop = 0;
  }

  private async showDistrict(): Promise<void> {
    this.page?.dispose();
    this.page = null;
    this.detail.hidden = true;
    this.detail.replaceChildren();
    if (!this.district) this.main.replaceChildren(h("p", { class: "empty" }, "Loading the district …"));
    this.district ??= import("./scene/district").then(({ District }) => new District(this));
    const district = await this.district;
    if (this.facade) return;
    this.main.replaceChildren(district.element);
    district.start();
  }

  private title(): void {
    const name = this.facade ? titleOf(this.run, this.facade) : this.run.name;
    document.title = `${this.opening ?? name} – Frontage`;
    const district = this.facade ? h("a", { href: "#/" }, "District") : h("span", {}, this.run.name);
    this.crumbs.replaceChildren(district, ...(this.facade ? [h("span", { class: "quiet" }, "/"), h("span", {}, name), h("span", { class: "quiet id" }, this.facade.id)] : []));
  }

  private leftOut(): HTMLElement {
    const { left_out: missing, crs, heights, frontage } = this.run;
    return h("footer", { class: "about" },
      missing.length ? h("details", {}, h("summary", {}, "What is left out"), ...missing.map((text) => h("p", {}, text))) : null,
      h("p", { class: "quiet small" }, `${crs ?? "No CRS"}; heights ${heights}. Frontage ${frontage}.`));
  }

  private key(event: KeyboardEvent): void {
    const target = event.target as HTMLElement;
    if (event.ctrlKey || event.metaKey || event.altKey || target.closest("input, select, textarea, dialog")) return;
    if (event.key === "/") { this.search.input.focus(); event.preventDefault(); return; }
    if ((event.key === "Enter" || event.key === " ") && target.closest("button, a, summary")) return;
    if (this.page?.key(event)) return event.preventDefault();
    if (event.key === "Escape" && this.opening) return this.select(this.facade, null, false);
    if (event.key === "Escape" && this.facade) { location.hash = "#/"; return; }
    if (event.key === "[" || event.key === "]") this.step(event.key === "]" ? 1 : -1);
  }

  private step(by: number): void {
    const all = this.run.facades, at = all.findIndex((f) => f.id === this.facade?.id);
    const next = all[(at + by + all.length) % all.length];
    if (next) this.select(next, null, true);
  }
}
