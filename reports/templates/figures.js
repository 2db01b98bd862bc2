// Draws every figure of the page with plotly, in the colours of the style sheet, and again when those change.
// Afterwards body[data-figures-drawn] holds how many were drawn and body[data-figures-failed] how many were not.
(() => {
  const root = document.documentElement;
  const narrow = window.matchMedia("(max-width: 600px)");
  const paper_width = 900;  // px; of A4 between the margins and with the zoom of the style sheet
  const touch = window.matchMedia("(pointer: coarse)");

  // Replaces var(--name) anywhere in the figure by the style sheet's value.
  function coloured(value) {
    if (typeof value === "string") {
      return value.replace(/var\((--[\w-]+)\)/g, (_, name) => getComputedStyle(root).getPropertyValue(name).trim());
    }
    if (Array.isArray(value)) return value.map(coloured);
    if (value && typeof value === "object") {
      return Object.fromEntries(Object.entries(value).map(([key, part]) => [key, coloured(part)]));
    }
    return value;
  }

  // What all figures share. A long label on a narrow page is broken into lines instead of squeezing the plot.
  function themed(layout) {
    const axis = {gridcolor: "var(--grid)", linecolor: "var(--faint)", zerolinecolor: "var(--grid)", automargin: true, ticks: "",
                  exponentformat: "power"};
    const made = {
      font: {family: getComputedStyle(root).getPropertyValue("--sans"), size: narrow.matches ? 11 : 13, color: "var(--ink)"},
      paper_bgcolor: "rgba(0,0,0,0)",
      plot_bgcolor: "rgba(0,0,0,0)",
      margin: {l: 56, r: 12, t: 36, b: 48},
      legend: {orientation: "h", x: 0, y: 1.02, yanchor: "bottom", bgcolor: "rgba(0,0,0,0)"},
      hoverlabel: {bgcolor: "var(--paper)", bordercolor: "var(--faint)", font: {color: "var(--ink)"}},
      modebar: {bgcolor: "var(--paper)", color: "var(--faint)", activecolor: "var(--muted)"},
      dragmode: touch.matches ? false : "zoom",
      ...layout,
    };
    for (const key of Object.keys(layout).filter((name) => /^[xy]axis/.test(name))) {
      made[key] = {...axis, ...layout[key]};
      if (made[key].title) made[key].title = {standoff: 10, font: {size: made.font.size}, ...made[key].title};
      if (made[key].wrapticks) {
        made[key].ticktext = made[key].ticktext.map((text) => wrapped(text, narrow.matches ? 16 : 26));
        delete made[key].wrapticks;
      }
    }
    if (root.classList.contains("printing")) made.width = paper_width;
    return coloured(made);
  }

  function wrapped(text, width) {
    const lines = [""];
    for (const word of text.split(" ")) {
      const last = lines[lines.length - 1];
      if (last && last.length + word.length >= width) lines.push(word);
      else lines[lines.length - 1] = last ? `${last} ${word}` : word;
    }
    return lines.join("<br>");
  }

  class PlotFigure {
    constructor(element) {
      this.canvas = element.querySelector(".canvas");
      this.menu = element.querySelector("select");
      this.content = JSON.parse(element.querySelector("script").textContent);
      if (!this.menu) return;
      this.menu.addEventListener("change", () => choose(this.menu));
      for (const button of element.querySelectorAll("button")) {
        button.addEventListener("click", () => this.step(Number(button.dataset.step)));
      }
    }

    step(by) {
      const count = this.menu.options.length;
      this.menu.selectedIndex = (this.menu.selectedIndex + by + count) % count;
      choose(this.menu);
    }

    draw() {
      const traces = this.content.choices[this.menu ? this.menu.selectedIndex : 0];
      const config = {responsive: true, displaylogo: false, displayModeBar: touch.matches || narrow.matches ? false : "hover",
                      modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d"]};
      // Plotly writes into what it is given, so each drawing gets its own copy.
      return Plotly.react(this.canvas, coloured(structuredClone(traces)), themed(structuredClone(this.content.layout)), config);
    }
  }

  // Menus of the same kind ("Particle") move together, where they have the same choice.
  function choose(menu) {
    const chosen = menu.selectedOptions[0].textContent;
    for (const figure of figures) {
      if (!figure.menu || figure.menu.labels[0].textContent !== menu.labels[0].textContent) continue;
      const same = [...figure.menu.options].find((option) => option.textContent === chosen);
      if (!same) continue;
      figure.menu.selectedIndex = same.index;
      figure.draw();
    }
  }

  async function draw_all(figures) {
    let drawn = 0;
    let failed = 0;
    for (const figure of figures) {
      try {
        await figure.draw();
        ++drawn;
      } catch (error) {
        ++failed;
        figure.canvas.textContent = `This figure could not be drawn (${error.message}).`;
        console.error(error);
      }
    }
    document.body.dataset.figuresDrawn = drawn;
    document.body.dataset.figuresFailed = failed;
  }

  const figures = [...document.querySelectorAll("figure.plot")].map((element) => new PlotFigure(element));
  draw_all(figures);
  window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => draw_all(figures));
  narrow.addEventListener("change", () => draw_all(figures));
  // What is folded has no width to be drawn in.
  document.addEventListener("toggle", (event) => {
    if (!event.target.open) return;
    for (const figure of figures) if (event.target.contains(figure.canvas)) figure.draw().then(() => Plotly.Plots.resize(figure.canvas));
  }, true);
  // Paper is light, narrower than most screens, and nobody can unfold it.
  let unfolded = [];
  window.addEventListener("beforeprint", () => {
    root.classList.add("printing");
    unfolded = [...document.querySelectorAll("details:not([open])")];
    for (const fold of unfolded) fold.open = true;
    draw_all(figures);
  });
  window.addEventListener("afterprint", () => {
    root.classList.remove("printing");
    for (const fold of unfolded) fold.open = false;
    draw_all(figures);
  });
})();
