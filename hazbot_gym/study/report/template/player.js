"use strict";
// Replays two policies on one scenario. Lengths are centimetres, angles degrees, speeds mm/s.
(async () => {
  if (!("DecompressionStream" in window)) return;
  const MAX_HEIGHT = 420; // of a scene, in CSS pixels
  const STEP_S = 0.1; // of an arrow key
  const CROWD = 8; // more people have no rings, which would hide the rest
  const looks = JSON.parse(document.getElementById("looks").textContent);
  const data = JSON.parse(await inflate("replay-data"));

  const player = document.getElementById("player");
  const setSelect = player.querySelector("select.set");
  const episodeSelect = document.getElementById("episode");
  const play = document.getElementById("play");
  const scrub = document.getElementById("scrub");
  const clock = document.getElementById("clock");
  const rate = document.getElementById("rate");
  const dark = window.matchMedia("(prefers-color-scheme: dark)");
  const strips = [
    { canvas: document.getElementById("speed"), title: "speed [m/s]", unit: 1e-3, values: (run) => run.speed },
    { canvas: document.getElementById("earned"), title: "cumulative reward", unit: 1e-2, values: (run) => run.earned },
    { canvas: document.getElementById("reading"), title: "gas reading, alarm from 1", unit: 1e-2, values: (run) => run.reading, mark: 1 },
  ].filter(({ canvas }) => canvas);
  const panels = [...player.querySelectorAll(".panel")].map((panel) => ({
    select: panel.querySelector("select"),
    canvas: panel.querySelector("canvas"),
    end: panel.querySelector(".end"),
  }));

  let time = 0;
  let isPlaying = false;
  let lastFrame = 0;

  const series = new WeakMap();

  /** Return the numbers that a list of steps stands for. */
  function numbers(steps) {
    if (!series.has(steps)) {
      let sum = 0;
      series.set(steps, steps.map((step) => (sum += step)));
    }
    return series.get(steps);
  }

  /** Return a series' value at a time, between two instants where both are near. */
  function at(steps, index, near) {
    const values = numbers(steps);
    const i = Math.min(Math.floor(index), values.length - 1);
    const next = values[Math.min(i + 1, values.length - 1)];
    return Math.abs(next - values[i]) < near ? values[i] + (index % 1) * (next - values[i]) : values[i];
  }

  const replay = () => data.sets[setSelect.value][episodeSelect.selectedIndex];
  const runOf = (panel) => replay().runs[panel.select.value];
  const dashOf = (panel) => looks[panel.select.value].dash.split(" ").filter(Boolean).map(Number);
  const colorOf = (panel) => looks[panel.select.value][dark.matches ? "dark" : "color"];
  const paint = (name) => getComputedStyle(player).getPropertyValue(name);
  const duration = (run) => (run.x.length - 1) * run.dt_s;
  // a millisecond of tolerance: the slider rounds its values
  const isUnderWay = (run) => time < duration(run) - 1e-3;
  const horizon = () => Math.max(...panels.map((panel) => duration(runOf(panel))));

  /** Fit a canvas to the page's pixels and return its cleared context, drawn in CSS pixels. */
  function begin(canvas, width, height) {
    const ratio = window.devicePixelRatio || 1;
    const [pixelsX, pixelsY] = [Math.round(width * ratio), Math.round(height * ratio)];
    if (canvas.width !== pixelsX || canvas.height !== pixelsY) {
      canvas.width = pixelsX;
      canvas.height = pixelsY;
      canvas.style.height = `${height}px`;
    }
    const context = canvas.getContext("2d");
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, width, height);
    return context;
  }

  function drawScene(panel) {
    const [left, bottom, right, top] = replay().box;
    const width = panel.canvas.clientWidth;
    const scale = Math.min(width / (right - left), MAX_HEIGHT / (top - bottom));
    const context = begin(panel.canvas, width, scale * (top - bottom));
    context.translate((width - scale * (right - left)) / 2, 0);
    context.scale(scale, -scale);
    context.translate(-left, -top);
    const run = runOf(panel);
    const index = Math.min(time / run.dt_s, run.x.length - 1);
    const people = peopleAt(run, index);
    drawZones(context, people);
    drawBeams(context, run, index, panel);
    drawPlace(context, scale);
    drawTrail(context, run, index, panel);
    if (replay().leak) drawLeak(context, ...replay().leak);
    people.forEach((person) => drawPerson(context, person));
    drawRobot(context, run, index, panel);
    if (run.contact.length) drawCross(context, ...run.contact, Math.max(14, 6 / scale), isUnderWay(run));
  }

  /** Draw the readings of the sonar: a cone each, with an arc where there is an echo. */
  function drawBeams(context, run, index, panel) {
    const { mount, range, axes, half_cones: halves } = replay().sonar;
    const [x, y] = [at(run.x, index, 50), at(run.y, index, 50)];
    const heading = (at(run.heading, index, 90) * Math.PI) / 180;
    axes.forEach((axis, i) => {
      const readings = numbers(run.sonar[i]);
      const reading = readings[Math.min(Math.floor(index), readings.length - 1)];
      const angle = heading + axis;
      const from = [x + mount * Math.cos(angle), y + mount * Math.sin(angle)];
      const half = halves[i];
      const arc = [...from, reading * data.sonar_cm, angle - half, angle + half];
      context.beginPath();
      context.moveTo(...from);
      context.arc(...arc);
      context.fillStyle = `${colorOf(panel)}1f`;
      context.fill();
      if (reading >= range) return;
      context.beginPath();
      context.arc(...arc);
      context.strokeStyle = colorOf(panel);
      context.lineWidth = 5;
      context.stroke();
    });
  }

  /** Draw the mark of a contact, faint while it is still to come. */
  function drawCross(context, x, y, size, isLater) {
    context.globalAlpha = isLater ? 0.4 : 1;
    for (const side of [-1, 1]) {
      line(context, [[x - size, y - side * size], [x + size, y + side * size]], paint("--alarm"), size / 2.5);
    }
    context.globalAlpha = 1;
  }

  function peopleAt(run, index) {
    return run.people
      .map(([x, y, heading]) => [at(x, index, 50), at(y, index, 50), at(heading, index, 90)])
      .filter(([x]) => x < data.nobody);
  }

  function disc(context, x, y, radius) {
    context.beginPath();
    context.arc(x, y, radius, 0, 2 * Math.PI);
  }

  function drawZones(context, people) {
    const [social, personal, intimate] = data.zones_cm.map((zone) => zone + data.person_cm);
    for (const [radius, fill] of [[personal, "#d6604d1c"], [intimate, "#d6604d38"]]) {
      context.beginPath(); // one for all people, so that what overlaps is no darker
      for (const [x, y] of people) {
        context.moveTo(x + radius, y);
        context.arc(x, y, radius, 0, 2 * Math.PI);
      }
      context.fillStyle = fill;
      context.fill();
    }
    for (const [x, y] of people.length > CROWD ? [] : people) {
      disc(context, x, y, social);
      context.strokeStyle = "#d6604d40";
      context.lineWidth = 3;
      context.stroke();
    }
  }

  function line(context, points, color, width, dash = []) {
    context.beginPath();
    points.forEach(([x, y], i) => (i ? context.lineTo(x, y) : context.moveTo(x, y)));
    context.strokeStyle = color;
    context.lineWidth = width;
    context.setLineDash(dash);
    context.stroke();
    context.setLineDash([]);
  }

  function drawPlace(context, scale) {
    const { path, walls } = replay();
    line(context, path, paint("--edge"), 1 / scale, [20, 20]);
    disc(context, ...path[path.length - 1], 12);
    context.stroke();
    for (const [x1, y1, x2, y2] of walls) {
      line(context, [[x1, y1], [x2, y2]], paint("--ink"), Math.max(8, 2 / scale));
    }
  }

  function drawTrail(context, run, index, panel) {
    const [x, y] = [numbers(run.x), numbers(run.y)];
    const points = x.slice(0, Math.floor(index) + 1).map((value, i) => [value, y[i]]);
    if (run.reading) drawSniffed(context, run, points);
    line(context, points, `${colorOf(panel)}66`, 5);
  }

  /** Cloud the trail by the reading of the gas sensor, and show where its alarm sounded. */
  function drawSniffed(context, run, points) {
    const [readings, alarms] = [numbers(run.reading), numbers(run.alarm)];
    points.slice(1).forEach((point, i) => {
      const near = readings.slice(Math.max(i - 4, 0), i + 7); // their mean has less noise
      const reading = Math.max(near.reduce((sum, each) => sum + each, 0) / near.length / 100, 0);
      const gas = `rgba(${dark.matches ? "214, 196, 120" : "96, 80, 0"}, ${(reading / (1 + reading)).toFixed(2)})`;
      line(context, [points[i], point], alarms[i + 1] ? paint("--alarm") : gas, 22);
    });
  }

  /** Draw the gas leak as a diamond. */
  function drawLeak(context, x, y) {
    context.beginPath();
    for (const [dx, dy] of [[16, 0], [0, 16], [-16, 0], [0, -16]]) context.lineTo(x + dx, y + dy);
    context.closePath();
    context.fillStyle = "#605000";
    context.fill();
    context.strokeStyle = paint("--ink");
    context.lineWidth = 4;
    context.stroke();
  }

  function drawPerson(context, [x, y, heading]) {
    const radius = data.person_cm;
    context.save();
    context.translate(x, y);
    context.rotate((heading * Math.PI) / 180);
    disc(context, 0, 0, radius);
    context.fillStyle = "#f1c9a0";
    context.fill();
    context.beginPath();
    context.ellipse(0, 0, radius / 2, radius, 0, 0, 2 * Math.PI);
    context.fillStyle = "#c97a1d";
    context.fill();
    disc(context, radius / 6, 0, 0.42 * radius);
    context.fillStyle = "#6b3d08";
    context.fill();
    context.restore();
  }

  function drawRobot(context, run, index, panel) {
    const radius = data.robot_cm;
    context.save();
    context.translate(at(run.x, index, 50), at(run.y, index, 50));
    context.rotate((at(run.heading, index, 90) * Math.PI) / 180);
    disc(context, 0, 0, radius - 2);
    context.fillStyle = paint("--paper");
    context.fill();
    context.strokeStyle = colorOf(panel);
    context.lineWidth = 5;
    context.stroke();
    context.beginPath();
    context.moveTo(0.75 * radius, 0);
    context.lineTo(0, 0.45 * radius);
    context.lineTo(0, -0.45 * radius);
    context.fillStyle = colorOf(panel);
    context.fill();
    context.restore();
  }

  /** Return the distance of the ticks of an axis: 1, 2 or 5 times a power of ten. */
  function spacing(extent) {
    const power = 10 ** Math.floor(Math.log10(extent / 3));
    return power * [5, 2, 1].find((factor) => factor * power * 2.5 <= extent);
  }

  /** Draw a quantity of both drives over time, in its unit; a mark is an alarm threshold. */
  function drawStrip({ canvas, title, unit, values, mark }) {
    canvas.hidden = !values(runOf(panels[0]));
    if (canvas.hidden) return;
    const [width, height, left, top, base] = [canvas.clientWidth, 150, 44, 24, 122];
    const context = begin(canvas, width, height);
    const runs = panels.map(runOf);
    const all = runs.flatMap((run) => numbers(values(run)));
    const low = Math.min(0, ...all) * unit;
    const high = Math.max(1.2 * (mark ?? 0), 0.1, Math.max(...all) * unit);
    const px = (seconds) => left + (seconds / horizon()) * (width - left - 8);
    const py = (value) => base - ((value - low) / (high - low)) * (base - top);
    const step = spacing(high - low);
    context.font = "12px system-ui, sans-serif";
    context.fillStyle = paint("--soft");
    context.textAlign = "right";
    for (let k = Math.ceil(low / step); k * step <= high; k += 1) {
      line(context, [[left, py(k * step)], [width - 8, py(k * step)]], paint("--line"), 1);
      context.fillText(Number((k * step).toPrecision(3)), left - 6, py(k * step) + 4);
    }
    context.textAlign = "center";
    for (let tick = 0; px(tick) < width - 24; tick += 10) context.fillText(tick, px(tick), base + 20);
    context.fillText("s", width - 8, base + 20);
    context.textAlign = "left";
    context.fillText(title, 0, 12);
    if (mark) line(context, [[left, py(mark)], [width - 8, py(mark)]], paint("--alarm"), 1, [4, 4]);
    panels.forEach((panel, i) => {
      const points = numbers(values(runs[i])).map((value, k) => [px(k * runs[i].dt_s), py(value * unit)]);
      line(context, points, colorOf(panel), 2, dashOf(panel));
      if (mark) {
        numbers(runs[i].alarm).forEach((sounds, k) => {
          if (sounds && k) line(context, points.slice(k - 1, k + 1), paint("--alarm"), 5);
        });
      }
      const [end] = points.slice(-1);
      if (runs[i].contact.length) drawCross(context, ...end, 6, isUnderWay(runs[i]));
    });
    line(context, [[px(time), top - 6], [px(time), base]], paint("--ink"), 1);
  }

  function draw() {
    panels.forEach(drawScene);
    strips.forEach(drawStrip);
    clock.textContent = `${time.toFixed(1)} s`;
    scrub.value = time;
    panels.forEach((panel) => {
      const run = runOf(panel);
      const speed = at(run.speed, Math.min(time / run.dt_s, run.speed.length - 1), 1000) / 1000;
      const sounds = run.alarm && at(run.alarm, Math.floor(Math.min(time / run.dt_s, run.x.length - 1)), 0);
      const now = `${Math.abs(speed).toFixed(2)} m/s${sounds ? ", ALARM" : ""}`;
      panel.end.textContent = isUnderWay(run) ? now : run.end;
    });
  }

  function frame(now) {
    if (!isPlaying) return;
    time = Math.min(time + ((now - lastFrame) / 1000) * Number(rate.value), horizon());
    lastFrame = now;
    if (time >= horizon()) setPlaying(false);
    draw();
    if (isPlaying) requestAnimationFrame(frame);
  }

  function setPlaying(value) {
    isPlaying = value;
    play.textContent = isPlaying ? "Pause" : "Play";
  }

  function start() {
    if (time >= horizon()) time = 0;
    setPlaying(true);
    lastFrame = performance.now();
    requestAnimationFrame(frame);
  }

  function chooseEpisode() {
    const [left, bottom, right, top] = replay().box;
    const isLong = right - left > 2.5 * (top - bottom);
    document.getElementById("panels").classList.toggle("stacked", isLong);
    time = 0;
    scrub.max = horizon();
    draw();
  }

  function chooseSet() {
    const options = data.sets[setSelect.value].map(({ number, why }) => new Option(`${number}: ${why}`));
    episodeSelect.replaceChildren(...options);
    chooseEpisode();
  }

  setSelect.addEventListener("change", chooseSet);
  setSelect.addEventListener("follow", chooseSet);
  episodeSelect.addEventListener("change", chooseEpisode);
  panels.forEach((panel) => panel.select.addEventListener("change", () => {
    scrub.max = horizon();
    time = Math.min(time, horizon());
    draw();
  }));
  play.addEventListener("click", () => (isPlaying ? setPlaying(false) : start()));
  scrub.addEventListener("input", () => {
    time = Number(scrub.value);
    draw();
  });
  window.addEventListener("resize", draw);
  dark.addEventListener("change", draw);
  player.addEventListener("keydown", (event) => {
    const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    const isChoosing = event.target.matches("select, button");
    if (event.key === " " && !isChoosing) {
      isPlaying ? setPlaying(false) : start();
    } else if (step && !event.target.matches("select")) {
      setPlaying(false);
      time = Math.min(Math.max(time + step * STEP_S, 0), horizon());
      draw();
    } else {
      return;
    }
    event.preventDefault();
  });

  player.hidden = false;
  chooseSet();
})();
