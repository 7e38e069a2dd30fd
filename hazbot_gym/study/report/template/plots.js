"use strict";
// Draws the plots; one choice of scenario set and one of policies holds for the whole page.
(async () => {
  if (!("DecompressionStream" in window)) return;
  const library = document.createElement("script");
  library.textContent = await inflate("plotly");
  document.head.append(library);
  const plots = JSON.parse(await inflate("plot-data"));
  const hidden = new Set();
  const config = { responsive: true, displaylogo: false, displayModeBar: false, scrollZoom: false };

  const plain = (text) => text.replaceAll("<", "&lt;"); // Plotly reads some HTML in names
  function draw(div) {
    const figures = plots[div.dataset.plot];
    const select = div.parentElement.querySelector("select.set");
    const { data, layout } = figures[select ? select.value : Object.keys(figures)[0]];
    const traces = data.map((trace) => ({
      ...trace,
      name: plain(trace.name),
      text: trace.text?.map(plain),
      visible: !hidden.has(trace.name),
    }));
    return Plotly.react(div, traces, structuredClone(layout), config);
  }

  const divs = [...document.querySelectorAll(".plot")];
  const selects = [...document.querySelectorAll("select.set")];
  const buttons = [...document.querySelectorAll(".key button")];

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

  for (const button of buttons) {
    button.addEventListener("click", () => {
      const { policy } = button.dataset;
      if (!hidden.delete(policy)) hidden.add(policy);
      for (const same of buttons) {
        same.setAttribute("aria-pressed", String(!hidden.has(same.dataset.policy)));
      }
      divs.forEach(draw);
    });
  }

  await Promise.all(divs.map(draw));
  document.documentElement.dataset.plots = "drawn";
})();
