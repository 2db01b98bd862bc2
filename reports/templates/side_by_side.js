// Pictures of film and simulation, one at a time, by a slider or in motion. The controls are made here, so that a page
// without scripts has none and shows the first, the middle and the last.
(() => {
  const pause = 250;  // ms between pictures
  for (const figure of document.querySelectorAll("figure.side-by-side")) {
    const pictures = [...figure.querySelectorAll("img")];
    if (pictures.length < 2) continue;
    const slider = document.createElement("input");
    Object.assign(slider, {type: "range", min: 0, max: pictures.length - 1, step: 1, value: 0});
    slider.setAttribute("aria-label", "Moment of film and simulation");
    const moment = document.createElement("output");
    const button = document.createElement("button");
    button.type = "button";
    let timer = 0;

    function show() {
      pictures.forEach((picture, i) => picture.classList.toggle("shown", i === Number(slider.value)));
      moment.textContent = pictures[slider.value].dataset.moment;
      slider.setAttribute("aria-valuetext", moment.textContent);
    }
    function stop() {
      clearInterval(timer);
      timer = 0;
      button.textContent = "Play";
    }
    function step() {
      if (Number(slider.value) === pictures.length - 1) return stop();
      slider.value = Number(slider.value) + 1;
      show();
    }
    button.addEventListener("click", () => {
      if (timer) return stop();
      if (Number(slider.value) === pictures.length - 1) slider.value = 0;
      show();
      button.textContent = "Pause";
      timer = setInterval(step, pause);
    });
    slider.addEventListener("input", () => {
      stop();
      show();
    });
    const controls = document.createElement("div");
    controls.className = "controls";
    controls.append(button, slider, moment);
    figure.insertBefore(controls, figure.querySelector("figcaption"));
    figure.classList.add("scrubbed");
    stop();
    show();
  }
})();
