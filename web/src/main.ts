import { App } from "./app";
import { loadRun } from "./data";
import { h } from "./dom";

const root = document.getElementById("app")!;
loadRun().then(
  (run) => { Object.assign(window, { frontage: new App(run, root) }); },
  (error: Error) => root.replaceChildren(h("p", { class: "boot" }, error.message)),
);
