// The page: settings, keys and pointer; what the server sends goes to the place and the panels.

import { Form } from "./form.js";
import { searchOf, settingsOf, usual } from "./link.js";
import { Motion } from "./motion.js";
import { Panels } from "./panels.js";
import { PlaceView } from "./place.js";
import { Connection } from "./socket.js";

const YOU = "you";
const FASTER_PER_S = 0.9; // change of the throttle while a key is down
const SLOWER_PER_S = 1.6;
const LEAD_MPS = 1.6; // of a person who is led by keys
const AHEAD_M = 3; // where a key adds a person
const NARROW = 760; // CSS pixels: the view follows the robot
const IS_TOUCHED = matchMedia("(pointer: coarse)").matches;
const STILL = matchMedia("(prefers-reduced-motion: reduce)").matches;

const $ = (id) => document.getElementById(id);
const connection = new Connection();
const view = new PlaceView($("place"));
const motion = new Motion();
const keys = new Set(); // that are down
let panels;
let form;
let settings = settingsOf(location.search);
let scene = null;
let state = null; // what is shown
let isPlaying = false;
let rate = 1;
let throttle = 0;
let isAdding = false;
let isDragging = false;
let isFresh = true; // nothing was shown of this scene yet
let drawn = 0; // pictures so far

// --- messages ------------------------------------------------------------------------------------

connection.on("hello", (hello) => {
  panels = new Panels(hello);
  form = new Form(hello, configure);
  connection.send("configure", { settings });
  setPlaying(!STILL && !document.hidden);
});

connection.on("scene", (message) => {
  const isSame = scene && scene.key === message.key && JSON.stringify(scene.walls) === JSON.stringify(message.walls);
  scene = message;
  settings = message.settings;
  panels.setScene(scene);
  if (!isSame) choose(null);
  isFresh = !isSame;
  if (isFresh) view.setScene(scene);
  else view.scene = scene;
  showSettings();
  history.replaceState(null, "", location.pathname + searchOf(settings));
});

connection.on("frame", (frame) => {
  if (frame.decision === 0 || isFresh) motion.reset();
  isFresh = false;
  motion.push(frame, performance.now());
  view.note(frame);
  panels.show(frame);
  $("clock").textContent = `${frame.time_s.toFixed(1)} s`;
  if (frame.results) say($("end-title").textContent);
  if (frame.results && isPlaying && (frame.ghost?.outcome ?? "over") !== "running") setPlaying(false);
  if (view.chosen !== null && !frame.people.some(({ index }) => index === view.chosen)) choose(null);
});

connection.on("line", ({ text, is_error: isError }) => {
  say(text, isError);
  if (!isError) return;
  if (scene) {
    settings = scene.settings;
    showSettings();
  } else connection.send("configure", { settings: usual() }); // a link that cannot be used
});
connection.on("scores", (scores) => panels.showScores(scores));
connection.on("download", ({ name, text }) => {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([text]));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  say(`Saved: ${name}`);
});
connection.addEventListener("lost", () => {
  $("lost").hidden = $("line").classList.contains("error"); // a refusal says why itself
});

function say(text, isError = false) {
  $("line").textContent = text;
  $("line").classList.toggle("error", isError);
}

// --- settings ------------------------------------------------------------------------------------

function showSettings() {
  form.show(settings, scene?.decision_s ?? 0.1);
  const isYou = settings.policy === YOU;
  $("throttle-label").hidden = !isYou;
  $("take").hidden = $("end-drive").hidden = isYou;
  hint();
}

function configure(changes) {
  if (changes.policy === YOU) setThrottle(commandedShare());
  settings = { ...settings, ...changes }; // at once: another change may follow before the answer
  connection.send("configure", { settings });
}

// --- the run -------------------------------------------------------------------------------------

const lastFrame = () => motion.last;
const commandedShare = () => (lastFrame() && scene ? Math.min(1, lastFrame().command / scene.top_speed_mps) : 0);

function setPlaying(value) {
  isPlaying = value;
  $("play").textContent = isPlaying ? "Pause" : "Play";
  connection.send("play", { is_playing: isPlaying, rate });
}

function setThrottle(share) {
  throttle = Math.max(0, Math.min(1, share));
  $("throttle").value = throttle;
  connection.send("throttle", { share: Number(throttle.toFixed(3)) });
}

/** Take over from the policy, at the speed that it commands. */
function take() {
  configure({ policy: YOU });
}

const DO = {
  play() {
    if (lastFrame()?.results) DO.restart();
    else setPlaying(!isPlaying);
  },
  step() {
    setPlaying(false);
    connection.send("step");
  },
  restart: () => again(0),
  next: () => again(1),
  previous: () => again(-1),
  drive() {
    if (lastFrame()?.results) {
      settings.policy === YOU || configure({ policy: YOU });
      again(0);
    } else take();
    setPlaying(true);
    $("place").focus({ preventScroll: true });
  },
  add() {
    isAdding = !isAdding;
    hint();
  },
  remove() {
    if (view.chosen === null) say("Choose a person first: click one, or press P");
    else connection.send("remove", { person: view.chosen });
    step();
  },
  scene: () => connection.send("export", { what: "scene" }),
  run: () => connection.send("export", { what: "run" }),
  ten() {
    configure({ policy: YOU, ghost: "", episode: 0 });
    setThrottle(0);
    connection.send("restart", { by: 0 });
    connection.send("compare");
    setPlaying(true);
    $("stage").scrollIntoView({ block: "nearest" });
    $("place").focus({ preventScroll: true });
  },
};

function again(by) {
  setThrottle(0);
  connection.send("restart", { by });
  if (lastFrame()?.results && !STILL) setPlaying(true);
}

/** Show at once what a paused run is made to do. */
function step() {
  if (!isPlaying && !lastFrame()?.results) connection.send("step");
}

for (const button of document.querySelectorAll("[data-do]")) button.addEventListener("click", () => DO[button.dataset.do]());
$("rate").addEventListener("change", () => {
  rate = Number($("rate").value);
  connection.send("play", { is_playing: isPlaying, rate });
});
$("throttle").addEventListener("input", () => setThrottle(Number($("throttle").value)));
$("follow").addEventListener("change", () => {
  view.follows = $("follow").checked;
  view.prepare();
});
$("slot").addEventListener("change", () => lastFrame() && panels.show(lastFrame()));
$("link").addEventListener("click", async () => {
  try {
    await navigator.clipboard.writeText(location.href);
    say("Link copied. It works while this server runs; hazbot play --link opens the same run later.");
  } catch {
    say(location.href);
  }
});
$("open").addEventListener("change", async () => {
  const [file] = $("open").files;
  if (file) connection.send("load", { text: await file.text() });
  $("open").value = "";
  setPlaying(true);
});
document.addEventListener("visibilitychange", () => {
  if (document.hidden && isPlaying) setPlaying(false);
});

// --- people --------------------------------------------------------------------------------------

function choose(index) {
  if (view.chosen !== null && view.target) letGo();
  view.chosen = index;
  hint();
}

function lead(x, y) {
  view.target = [x, y];
  connection.send("hold", { person: view.chosen, x_m: Number(x.toFixed(3)), y_m: Number(y.toFixed(3)) });
}

function letGo() {
  if (view.target) connection.send("let_go", { person: view.chosen });
  view.target = null;
}

function addAt(x, y) {
  connection.send("add", { x_m: Number(x.toFixed(3)), y_m: Number(y.toFixed(3)) });
  isAdding = false;
  step();
  hint();
}

const pointOf = (event) => view.toMetres(event.offsetX, event.offsetY);

$("place").addEventListener("pointerdown", (event) => {
  if (!state) return;
  const [x, y] = pointOf(event);
  if (isAdding) {
    addAt(x, y);
    return;
  }
  const person = view.personAt(state, x, y);
  choose(person);
  if (person === null) return;
  isDragging = true;
  $("place").setPointerCapture(event.pointerId);
  lead(x, y);
});
$("place").addEventListener("pointermove", (event) => {
  const [x, y] = pointOf(event);
  if (isDragging) lead(x, y);
  else $("place").style.cursor = isAdding ? "copy" : state && view.personAt(state, x, y) !== null ? "grab" : "default";
});
for (const kind of ["pointerup", "pointercancel"]) {
  $("place").addEventListener(kind, () => {
    if (isDragging) letGo();
    isDragging = false;
  });
}

// --- keys ----------------------------------------------------------------------------------------

const ARROWS = { ArrowUp: [0, 1], ArrowDown: [0, -1], ArrowLeft: [-1, 0], ArrowRight: [1, 0] };
const PRESS = {
  " ": () => DO.play(),
  ".": () => DO.step(),
  r: () => DO.restart(),
  n: () => DO.next(),
  b: () => DO.previous(),
  f: () => $("follow").click(),
  p: () => choosePerson(),
  a: () => addAhead(),
  Enter: () => letGo(),
  Escape: () => {
    isAdding = false;
    choose(null);
  },
  Delete: () => DO.remove(),
};

function choosePerson() {
  const people = lastFrame()?.people.map(({ index }) => index).sort((a, b) => a - b) ?? []; // drawn or not yet
  if (people.length) choose(people[(people.indexOf(view.chosen) + 1) % people.length]);
  else say("There is nobody to choose");
}

function addAhead() {
  const [x, y] = lastFrame().pose;
  const away = scene.path.map(([px, py]) => Math.hypot(px - x, py - y));
  const here = away.indexOf(Math.min(...away));
  const ahead = scene.path.slice(here).find(([px, py]) => Math.hypot(px - x, py - y) >= AHEAD_M);
  if (ahead) addAt(ahead[0], ahead[1] + 0.45);
  else say("There is no path so far ahead");
}

document.addEventListener("keydown", (event) => {
  const isTyping = event.target.matches("select, input, textarea, summary");
  const isPressing = event.target.matches("button") && (event.key === " " || event.key === "Enter");
  if (isTyping || isPressing || event.ctrlKey || event.metaKey || event.altKey) return;
  if (event.key in ARROWS && event.shiftKey) {
    if (view.chosen !== null) keys.add(`shift ${event.key}`);
  } else if (event.key === "ArrowUp" || event.key === "ArrowDown") {
    if (settings.policy !== YOU && !lastFrame()?.results) take();
    if (!isPlaying && !lastFrame()?.results) setPlaying(true);
    keys.add(event.key);
  } else if (PRESS[event.key] ?? PRESS[event.key.toLowerCase()]) {
    if (!event.repeat) (PRESS[event.key] ?? PRESS[event.key.toLowerCase()])();
  } else return;
  event.preventDefault();
});
document.addEventListener("keyup", (event) => {
  keys.delete(event.key);
  keys.delete(`shift ${event.key}`);
  if (event.key === "Shift") for (const name of Object.keys(ARROWS)) keys.delete(`shift ${name}`);
});
addEventListener("blur", () => keys.clear());

function holdKeys(dt) {
  const change = (keys.has("ArrowUp") ? FASTER_PER_S : 0) - (keys.has("ArrowDown") ? SLOWER_PER_S : 0);
  if (change && settings.policy === YOU) {
    const share = Math.max(0, Math.min(1, throttle + change * dt));
    if (share !== throttle) setThrottle(share);
  }
  const moves = Object.entries(ARROWS).filter(([name]) => keys.has(`shift ${name}`)).map(([, move]) => move);
  const person = moves.length && state?.people.find(({ index }) => index === view.chosen);
  if (!person) return;
  const [x, y] = view.target ?? [person.x, person.y];
  const [dx, dy] = moves.reduce(([a, b], [c, d]) => [a + c, b + d], [0, 0]);
  lead(x + dx * LEAD_MPS * dt, y + dy * LEAD_MPS * dt);
}

function hint() {
  const texts = [
    isAdding && "Tap where the person starts",
    view.chosen !== null && "Drag, or shift and arrows; enter lets go, delete removes",
    settings.policy === YOU && (IS_TOUCHED ? "The slider is your speed" : "Arrow up: faster. Arrow down: slower"),
    IS_TOUCHED ? "Tap Drive it yourself. Drag a person" : "Press arrow up to drive. Drag a person",
  ];
  $("hint").textContent = texts.find(Boolean);
}

// --- pictures ------------------------------------------------------------------------------------

let before = performance.now();
function picture(now) {
  const dt = Math.min((now - before) / 1000, 0.1);
  before = now;
  holdKeys(dt);
  if (scene && motion.last) {
    state = STILL ? still() : motion.at(now, dt, rate, scene.decision_s);
    view.draw(state);
    $("speed-bar").style.transform = `scaleX(${Math.max(0, Math.min(1, state.speed / scene.top_speed_mps))})`;
    $("speed-text").textContent = `${Math.abs(state.speed).toFixed(2)} m/s`;
    drawn += 1;
  }
  requestAnimationFrame(picture);
}

/** Return the last instant as it is: with reduced motion nothing moves between decisions. */
function still() {
  motion.shown = motion.last.time_s;
  return motion.between();
}

const SLOW_MS = 1500; // without a frame
const WAITING = "Waiting for the server: a policy that was never used here is compiled first";
setInterval(() => {
  const isWaiting = isPlaying && motion.last && !motion.last.results && performance.now() - motion.arrived > SLOW_MS;
  if (isWaiting) say(WAITING);
  else if ($("line").textContent === WAITING) say("");
}, 500);

let told = { at: performance.now(), drawn: 0, bytes: 0 };
setInterval(() => {
  const now = performance.now();
  const seconds = (now - told.at) / 1000;
  const pace = { fps: (drawn - told.drawn) / seconds, bytesPerS: (connection.bytes - told.bytes) / seconds };
  told = { at: now, drawn, bytes: connection.bytes };
  $("pace").textContent = `${pace.fps.toFixed(0)} pictures and ${(pace.bytesPerS / 1000).toFixed(1)} kB a second.`;
  Object.assign(document.documentElement.dataset, { fps: pace.fps.toFixed(1), bytes: pace.bytesPerS.toFixed(0) });
}, 2000);

$("follow").checked = view.follows = innerWidth < NARROW;
$("legend").open = innerWidth >= NARROW;
requestAnimationFrame(picture);

// for tests of the page, which have no eyes
window.hazbot = {
  get frame() { return motion.last; },
  get scene() { return scene; },
  get settings() { return settings; },
  /** Return where a person is on the page, in CSS pixels of the window. */
  pixels(index) {
    const { x, y } = state.people.find((person) => person.index === index);
    const box = $("place").getBoundingClientRect();
    const [cx, cy] = view.center;
    return [box.left + view.size[0] / 2 + (x - cx) * view.scale, box.top + view.size[1] / 2 - (y - cy) * view.scale];
  },
};
