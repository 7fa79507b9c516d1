// The search field with its suggestions.

import type { App } from "./app";
import { h } from "./dom";
import { locate, suggestions, type Suggestion } from "./search";

export class SearchBox {
  readonly input = h("input", {
    type: "search", placeholder: "Address, floor 3, window 2", "aria-label": "Search by address, floor and number, or by id",
    autocomplete: "off", spellcheck: "false", role: "combobox", "aria-expanded": "false", "aria-controls": "suggestions", enterkeyhint: "go",
  });
  private readonly options = h("ul", { id: "suggestions", role: "listbox", hidden: true });
  private readonly problem = h("p", { class: "problem", role: "alert", hidden: true });
  readonly element = h("form", { class: "search", role: "search" }, this.input, this.options, this.problem);
  private found: Suggestion[] = [];
  private active = -1;

  constructor(private readonly app: App) {
    this.input.addEventListener("input", () => this.suggest());
    this.input.addEventListener("keydown", (event) => this.key(event));
    this.input.addEventListener("blur", () => setTimeout(() => this.close(), 150));
    this.element.addEventListener("submit", (event) => { event.preventDefault(); this.submit(); });
  }

  private submit(): void {
    const chosen = this.found[this.active];
    if (chosen) return this.go(chosen);
    const answer = locate(this.app.run, this.input.value);
    this.close();
    if (!("problem" in answer)) {
      this.input.blur();
      return this.app.select(answer.facade, answer.opening?.id ?? null, true);
    }
    this.problem.textContent = answer.problem;
    this.problem.hidden = false;
  }

  private suggest(): void {
    this.problem.hidden = true;
    this.found = suggestions(this.app.run, this.input.value);
    this.active = -1;
    this.options.replaceChildren(...this.found.map((s, k) =>
      h("li", { role: "option", id: `suggestion-${k}`, pointerdown: (event: Event) => { event.preventDefault(); this.go(s); } }, h("span", {}, s.text), h("span", { class: "quiet" }, s.detail))));
    this.options.hidden = !this.found.length;
    this.input.setAttribute("aria-expanded", String(!this.options.hidden));
  }

  private key(event: KeyboardEvent): void {
    if (event.key === "Escape") { this.close(); this.input.blur(); }
    if (event.key !== "ArrowDown" && event.key !== "ArrowUp") return;
    event.preventDefault();
    const n = this.found.length;
    if (!n) return;
    this.active = (this.active + (event.key === "ArrowDown" ? 1 : -1) + n) % n;
    [...this.options.children].forEach((li, k) => li.setAttribute("aria-selected", String(k === this.active)));
    this.input.setAttribute("aria-activedescendant", `suggestion-${this.active}`);
  }

  private go(s: Suggestion): void {
    this.input.value = s.text;
    this.close();
    this.input.blur();
    this.app.select(s.facade, s.opening?.id ?? null, true);
  }

  private close(): void {
    this.options.hidden = true;
    this.problem.hidden = true;
    this.input.setAttribute("aria-expanded", "false");
  }
}
