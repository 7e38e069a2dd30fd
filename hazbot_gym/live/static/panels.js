// The panels beside the place: reward, the fuzzy expert, the observation, the end, the scores.

const $ = (id) => document.getElementById(id);
const WORDS = { DS: "very near", DE: "near", DN: "at a distance", DF: "far", VS: "slow", VF: "fast", BS: "crossing", BE: "encountering",
  BL: "leading", BF: "confronting" };
const RESULTS = { time_s: ["time", "s"], delay_s: ["delay", "s"], personal_m: ["driven in a personal zone", "m"],
  intimate_m: ["in an intimate zone", "m"], person_delay_s: ["people's delay", "s"], discomfort_s: ["discomfort", "s"], return: ["return", ""] };
const ENDS = { arrived: "Arrived", timeout: "Out of time", contact_wall: "Touched a wall" };
const MOST_RULES = 4;
const PEOPLE = 3; // in an observation

const fixed = (value, digits) => value.toFixed(digits).replace(/^-(0\.?0*)$/, "$1"); // without -0.0
const percent = (share) => `${Math.round(100 * share)} %`;
const element = (name, content = {}, ...children) => {
  const made = Object.assign(document.createElement(name), content);
  made.append(...children);
  return made;
};
const bar = () => {
  const inner = element("span");
  return [element("td", { className: "bar" }, inner), inner];
};
const setBar = (inner, share) => {
  inner.style.transform = `scaleX(${Math.max(0, Math.min(1, Math.abs(share)))})`;
  inner.classList.toggle("loss", share < 0);
};

export class Panels {
  constructor(hello) {
    this.hello = hello;
    this.names = Object.fromEntries(hello.policies.map(({ name, label }) => [name, label]));
  }

  setScene(scene) {
    this.scene = scene;
    this.makeTerms();
    this.makeFields();
    $("end").hidden = true;
    $("command").textContent = scene.command;
    $("key").textContent = `seed ${scene.settings.seed}, episode ${scene.settings.episode}`;
    $("key").title = `key ${scene.key}`;
    $("earned-who").textContent = this.names[scene.settings.policy] ?? scene.settings.policy;
    $("ghost-who").textContent = this.names[scene.settings.ghost] ?? scene.settings.ghost;
  }

  show(frame) {
    this.showScore(frame);
    this.showExpert(frame);
    this.showFields(frame);
    $("mark").hidden = !frame.is_edited;
    if (frame.results && $("end").hidden) this.showEnd(frame);
  }

  // --- reward ----------------------------------------------------------------------------------

  makeTerms() {
    this.terms = Object.keys(this.scene.weights).map((name) => {
      const [now, sum, [cell, inner]] = [element("td"), element("td"), bar()];
      return { row: element("tr", {}, element("td", { textContent: name }), now, sum, cell), now, sum, inner };
    });
    $("terms").tBodies[0].replaceChildren(...this.terms.map(({ row }) => row));
  }

  showScore(frame) {
    const largest = Math.max(10, ...frame.totals.map(Math.abs));
    this.terms.forEach(({ now, sum, inner }, i) => {
      now.textContent = fixed(frame.terms[i], 2);
      sum.textContent = fixed(frame.totals[i], 1);
      setBar(inner, frame.totals[i] / largest);
    });
    $("earned").textContent = frame.totals.reduce((sum, value) => sum + value, 0).toFixed(1);
    $("ghost-score").hidden = !frame.ghost;
    if (frame.ghost) $("ghost-earned").textContent = frame.ghost.earned.toFixed(1);
    $("gas").hidden = frame.reading === null;
    if (frame.reading !== null) $("reading").textContent = percent(frame.reading);
  }

  // --- the fuzzy expert ------------------------------------------------------------------------

  showExpert(frame) {
    $("expert-speed").textContent = `${(frame.expert_share * this.scene.top_speed_mps).toFixed(2)} m/s`;
    const person = frame.expert[Math.min(Number($("slot").value), frame.expert.length - 1)];
    $("expert-none").hidden = Boolean(person);
    $("expert-some").hidden = !person;
    if (!person) return;
    $("expert-distance").textContent = `${person.distance_m.toFixed(2)} m`;
    $("expert-walk").textContent = `${person.speed_mps.toFixed(2)} m/s`;
    $("expert-pattern").textContent = person.pattern || "no pattern";
    drawTerms($("distance-terms"), this.hello.distance_terms, person.distance_m, [1, 4], "m");
    drawTerms($("speed-terms"), this.hello.speed_terms, person.speed_mps, [0, 2], "m/s");
    const shown = person.rules.slice(0, MOST_RULES).map(({ terms, weight }) => this.rule(terms, weight));
    const why = person.kept === 0 ? "within 1.5 m: stop, whatever the rules" : person.distance_m > 3 ? "beyond 3 m: not considered" : "no rule fires";
    $("rules").replaceChildren(...(shown.length ? shown : [element("li", { className: "soft", textContent: why })]));
  }

  rule([distance, speed, pattern, kept], weight) {
    const fillBar = element("i");
    fillBar.style.transform = `scaleX(${weight})`;
    const text = `${WORDS[distance]}, ${WORDS[speed]}, ${WORDS[pattern]} → ${percent(this.hello.kept[kept])}`;
    return element("li", { title: `${distance} and ${speed} and ${pattern}: ${kept}, weight ${weight}` }, fillBar,
      element("span", { textContent: `${weight.toFixed(2)}  ${text}` }));
  }

  // --- the observation -------------------------------------------------------------------------

  makeFields() {
    this.fields = new Array(this.scene.fields.length);
    const own = [];
    const people = new Map();
    this.scene.fields.forEach((field, i) => {
      const [, slot, name] = field.name.match(/^person(\d)_(.*)$/) ?? [];
      if (slot === undefined) own.push(this.ownRow(field, i));
      else if (!people.has(name)) people.set(name, this.personRow(name, field, i));
      if (slot !== undefined) this.fields[i] = { value: people.get(name).cells[Number(slot)], field };
    });
    const half = Math.ceil(own.length / 2);
    const tables = [own.slice(0, half), own.slice(half)].map((rows) => element("table", {}, element("tbody", {}, ...rows)));
    if (people.size) {
      const head = element("tr", {}, ...["person", "nearest", "second", "third"].map((text) => element("th", { textContent: text })));
      tables.push(element("table", {}, element("thead", {}, head), element("tbody", {}, ...[...people.values()].map(({ row }) => row))));
    }
    $("fields").replaceChildren(...tables);
  }

  ownRow(field, i) {
    const [value, [cell, inner]] = [element("td"), bar()];
    this.fields[i] = { value, inner, field };
    return element("tr", { title: field.meaning }, element("td", { textContent: field.name }), value, cell);
  }

  personRow(name, field) {
    const cells = Array.from({ length: PEOPLE }, () => element("td"));
    return { cells, row: element("tr", { title: field.meaning.replace(/^person \d: /, "") }, element("td", { textContent: name }), ...cells) };
  }

  showFields(frame) {
    frame.observation.forEach((number, i) => {
      const { value, inner, field } = this.fields[i];
      value.textContent = `${fixed(number, 2)}${inner && field.unit !== "-" ? ` ${field.unit}` : ""}`;
      if (inner) setBar(inner, number / Math.max(Math.abs(field.low), Math.abs(field.high)));
    });
  }

  // --- the end and the scores --------------------------------------------------------------------

  showEnd(frame) {
    const who = frame.caused_by === "nobody" ? "" : `, caused by the ${frame.caused_by}`;
    const what = ENDS[frame.outcome] ?? `Contact with a person${who}`;
    $("end-title").textContent = `${what} after ${frame.time_s.toFixed(1)} s`;
    const rows = Object.entries(RESULTS).filter(([name]) => name in frame.results).flatMap(([name, [label, unit]]) => [
      element("dt", { textContent: label }), element("dd", { textContent: `${frame.results[name].toFixed(name.endsWith("_m") ? 2 : 1)} ${unit}` })]);
    $("end-results").replaceChildren(...rows);
    const [left, , right] = this.scene.box;
    $("end").classList.toggle("left", frame.pose[0] > (left + right) / 2); // away from the robot
    $("end").hidden = false;
  }

  showScores({ returns }) {
    const policies = Object.keys(returns);
    const cells = (tag, texts) => texts.map((text) => element(tag, { textContent: text }));
    const mean = (values) => {
      const driven = values.filter((value) => value !== null);
      return driven.length ? driven.reduce((sum, value) => sum + value, 0) / driven.length : null;
    };
    const shown = (value) => (value === null ? "–" : value.toFixed(1));
    const row = (label, values, isNow) => {
      const best = Math.max(...values.filter((value) => value !== null));
      const tr = element("tr", { className: isNow ? "now" : "" }, element("td", { textContent: label }));
      values.forEach((value) => tr.append(element("td", { textContent: shown(value), className: value === best ? "best" : "" })));
      return tr;
    };
    $("scores").tHead.replaceChildren(element("tr", {}, ...cells("th", ["episode", ...policies.map((name) => this.names[name])])));
    const rows = returns[policies[0]].map((_, i) => row(String(i), policies.map((name) => returns[name][i]), i === this.scene.settings.episode));
    rows.push(row("mean", policies.map((name) => mean(returns[name])), false));
    $("scores").tBodies[0].replaceChildren(...rows);
    $("scores").hidden = false;
  }
}

/** Draw fuzzy terms over their quantity, and where it is now. */
function drawTerms(canvas, terms, now, [low, high], unit) {
  const ratio = Math.min(devicePixelRatio || 1, 2);
  const [width, height] = [canvas.clientWidth, 88];
  if (canvas.width !== Math.round(width * ratio)) [canvas.width, canvas.height] = [Math.round(width * ratio), height * ratio];
  const context = canvas.getContext("2d");
  const style = getComputedStyle(canvas);
  const color = (name) => style.getPropertyValue(`--${name}`);
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  const [base, top] = [height - 18, 16];
  const x = (value) => 4 + ((value - low) / (high - low)) * (width - 8);
  const y = (membership) => base - membership * (base - top);
  context.font = "12px system-ui, sans-serif";
  context.textAlign = "center";
  for (const [name, [center, left, right]] of Object.entries(terms)) {
    const membership = (value) => Math.exp(-0.5 * ((value - center) / (value < center ? left : right)) ** 2);
    const strength = membership(now);
    context.beginPath();
    for (let k = 0; k <= 100; k += 1) context.lineTo(x(low + (k / 100) * (high - low)), y(membership(low + (k / 100) * (high - low))));
    context.strokeStyle = strength > 0.01 ? color("robot") : color("line");
    context.lineWidth = strength > 0.01 ? 1 + 2 * strength : 1.5;
    context.stroke();
    context.fillStyle = strength > 0.01 ? color("ink") : color("soft");
    context.fillText(name, Math.max(12, Math.min(width - 12, x(center))), 11);
  }
  context.fillStyle = color("soft");
  for (let k = 0; k <= 4; k += 1) {
    const value = low + (k / 4) * (high - low);
    context.textAlign = ["left", "center", "center", "center", "right"][k];
    context.fillText(`${Number(value.toFixed(2))}${k === 4 ? ` ${unit}` : ""}`, x(value), height - 4);
  }
  context.strokeStyle = color("loss");
  context.lineWidth = 2;
  context.beginPath();
  context.moveTo(x(Math.max(low, Math.min(high, now))), top - 2);
  context.lineTo(x(Math.max(low, Math.min(high, now))), base);
  context.stroke();
}
