"use strict";
// Draws the plots; one choice of scenario set and one of policies holds for the whole page.
(async () => {
  if (!("DecompressionStream" in window)) return;
  const read = (id) => JSON.parse(document.getElementById(id).textContent);
  const [shades, numbers] = [read("shades"), read("numbers")];
  const firstShown = new Set(read("first-shown"));
  const hidden = {
    policies: new Set(Object.keys(numbers).filter((name) => !firstShown.has(name))),
    families: new Set(),
  };
  hideInTables();
  const library = document.createElement("script");
  library.textContent = await inflate("plotly", "gzip");
  document.head.append(library);
  const plots = JSON.parse(await inflate("plot-data"));
  const config = { responsive: true, displaylogo: false, displayModeBar: false, scrollZoom: false };
  const dark = window.matchMedia("(prefers-color-scheme: dark)");

  /** Return a figure's values in the colors of the page's theme. */
  function themed(value) {
    if (typeof value === "string") return (dark.matches && shades[value]) || value;
    if (Array.isArray(value)) return typeof value[0] === "number" ? value : value.map(themed);
    if (value === null || typeof value !== "object") return value;
    return Object.fromEntries(Object.entries(value).map(([key, inner]) => [key, themed(inner)]));
  }

  const plain = (text) => text.replaceAll("<", "&lt;"); // Plotly reads some HTML in names
  function draw(div) {
    const figures = plots[div.dataset.plot];
    const away = hidden[div.dataset.plot === "families" ? "families" : "policies"];
    const select = div.parentElement.querySelector("select.set");
    const { data, layout } = figures[select ? select.value : Object.keys(figures)[0]];
    const traces = data.map((trace) => ({
      ...themed(trace),
      name: plain(trace.name),
      text: trace.text?.map(plain),
      visible: !away.has(trace.name),
    }));
    return Plotly.react(div, traces, themed(layout), config);
  }

  const divs = [...document.querySelectorAll(".plot")];
  const selects = [...document.querySelectorAll("select.set")];
  const buttons = [...document.querySelectorAll(".key button[data-name]")];
  const all = document.querySelector(".key .all");

  for (const select of selects) {
    select.addEventListener("change", () => {
      for (const other of selects) {
        const has = [...other.options].some((option) => option.value === select.value);
        if (other !== select && has && other.value !== select.value) {
          other.value = select.value;
          other.dispatchEvent(new Event("follow"));
        }
      }
      divs.forEach(draw);
    });
  }

  /** Hide the rows and columns of hidden policies. */
  function hideInTables() {
    const classes = [...hidden.policies].map((name) => `.p${numbers[name]}`);
    document.getElementById("hidden").textContent = classes.length ? `${classes.join()} { display: none; }` : "";
  }

  function update() {
    for (const button of buttons) {
      const { kind, name } = button.dataset;
      button.setAttribute("aria-pressed", String(!hidden[kind].has(name)));
    }
    all?.setAttribute("aria-pressed", String(hidden.policies.size === 0));
    hideInTables();
    divs.forEach(draw);
  }

  for (const button of buttons) {
    button.addEventListener("click", () => {
      const { kind, name } = button.dataset;
      if (!hidden[kind].delete(name)) hidden[kind].add(name);
      update();
    });
  }
  all?.addEventListener("click", () => {
    const isAll = hidden.policies.size === 0;
    hidden.policies = new Set(isAll ? Object.keys(numbers).filter((name) => !firstShown.has(name)) : []);
    update();
  });
  dark.addEventListener("change", () => divs.forEach(draw));

  await Promise.all(divs.map(draw));
  document.documentElement.dataset.plots = "drawn";
})();
