// The page of the scenes: who drives, people who are dragged, and pictures. `DATA` is from `scenes.py`.

const YOU = "you";
const NARROW_PX = 500;
const HOLD_S = 2; // the end stays, unless you drove
const PLUME_EVERY = 5; // decisions
const [FASTER_PER_S, SLOWER_PER_S] = [0.9, 1.6]; // change of your speed while a key is down
const LEAD_MPS = 1.6; // of a person who is led by keys
const IS_TOUCHED = matchMedia("(pointer: coarse)").matches;
const STILL = matchMedia("(prefers-reduced-motion: reduce)").matches;
const ARROWS = { ArrowUp: [0, 1], ArrowDown: [0, -1], ArrowLeft: [-1, 0], ArrowRight: [1, 0] };
const $ = (id) => document.getElementById(id);

/** Return the bytes of a text: base64 of what gzip made. */
async function unpacked(text) {
  const packed = new Blob([Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0))]);
  const stream = packed.stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

class Scenes {
  view = new PlaceView($("place"));
  motion = new Motion();
  keys = new Set(); // that are down
  throttle = 0;
  isPlaying = false;
  due = 0; // time that has passed since the last decision [s]
  ended = 0; // time since the end [s]

  static async make() {
    const page = new Scenes();
    page.module = await WebAssembly.compile(await unpacked(DATA.module));
    page.shared = await unpacked(DATA.shared);
    for (const scene of Object.values(DATA.scenes)) scene.bytes = await unpacked(scene.memory);
    return page;
  }

  engine(scene) {
    return Engine.make(this.module, this.shared, scene, DATA.first);
  }

  // --- the run ---

  async choose(name) {
    const scene = DATA.scenes[name];
    const [robot, ghost] = await Promise.all([this.engine(scene), this.engine(scene)]);
    [this.scene, this.robot, this.ghost, this.index] = [scene, robot, ghost, 0];
    const options = scene.policies.map(({ name: policy, label }) => new Option(label, policy));
    $("policy").replaceChildren(...options);
    $("ghost").replaceChildren(new Option("none", ""), ...options.filter(({ value }) => value !== YOU).map((each) => each.cloneNode(true)));
    [$("policy").value, $("ghost").value] = [scene.policy, scene.ghost];
    for (const button of $("scenes").children) button.setAttribute("aria-pressed", button.textContent === name);
    this.begin();
  }

  begin(by = 0) {
    this.index = (this.index + by) % this.scene.starts.length;
    this.robot.start(this.index);
    this.ghost.start(this.index);
    [this.due, this.ended] = [0, 0];
    this.setThrottle(0);
    this.motion.reset();
    this.view.follows = innerWidth < NARROW_PX;
    this.view.setScene(this.scene.starts[this.index]);
    this.setChosen(null);
    this.show();
  }

  policy(select) {
    const found = this.scene.policies.find(({ name }) => name === $(select).value);
    return found?.name === YOU ? { share: this.throttle } : found;
  }

  /** Take a decision: the robot, and the ghost beside it. */
  step() {
    this.robot.step(this.robot.action(this.policy("policy")));
    const ghost = this.policy("ghost");
    if (ghost) this.ghost.step(this.ghost.action(ghost));
    this.show();
  }

  show() {
    const frame = this.robot.frame();
    if ($("ghost").value) frame.ghost = this.ghost.frame();
    const { plume } = this.scene.starts[this.index];
    if (plume && frame.decision % PLUME_EVERY === 0) frame.plume = this.robot.plume(plume);
    this.motion.push(frame, performance.now());
    this.view.note(frame);
    this.frame = frame;
  }

  get isOver() {
    const isGhostOver = !$("ghost").value || this.ghost.outcome !== "running";
    return this.robot.outcome !== "running" && isGhostOver;
  }

  advance(dt) {
    if (!this.isOver) {
      for (this.due += dt; this.due >= this.scene.decision_s && !this.isOver; this.due -= this.scene.decision_s) this.step();
      return;
    }
    this.ended += dt;
    if (this.ended > HOLD_S && $("policy").value !== YOU) this.begin(1);
  }

  // --- you ---

  setPlaying(value) {
    this.isPlaying = value;
    $("play").textContent = value ? "Pause" : "Play";
  }

  setThrottle(share) {
    this.throttle = Math.max(0, Math.min(1, share));
    $("throttle").value = this.throttle;
    $("throttle-label").hidden = $("policy").value !== YOU;
    this.hint();
  }

  take() {
    if ($("policy").value === YOU) return;
    $("policy").value = YOU;
    this.startThrottle();
  }

  /** Go on at the speed that was commanded last. */
  startThrottle() {
    this.setThrottle(this.frame.command / this.scene.starts[this.index].top_speed_mps);
  }

  setChosen(person) {
    if (this.view.chosen !== null) this.letGo();
    this.view.chosen = person;
    this.hint();
  }

  lead(x, y) {
    this.view.target = [x, y];
    for (const engine of [this.robot, this.ghost]) engine.lead(this.view.chosen, x, y);
  }

  letGo() {
    this.view.target = null;
    for (const engine of [this.robot, this.ghost]) engine.letGo(this.view.chosen);
  }

  choosePerson() {
    const people = this.frame.people.map(({ index }) => index);
    if (people.length) this.setChosen(people[(people.indexOf(this.view.chosen) + 1) % people.length]);
  }

  hint() {
    const texts = [
      this.view.chosen !== null && "Drag, or shift and arrows",
      $("policy").value === YOU && (IS_TOUCHED ? "The slider is your speed" : "Arrow up: faster, arrow down: slower"),
      IS_TOUCHED ? "Drag a person" : "Drag a person. Arrow up: you drive",
    ];
    $("hint").textContent = texts.find(Boolean);
  }

  hold(dt) {
    const change = (this.keys.has("ArrowUp") ? FASTER_PER_S : 0) - (this.keys.has("ArrowDown") ? SLOWER_PER_S : 0);
    if (change && $("policy").value === YOU) this.setThrottle(this.throttle + change * dt);
    const moves = Object.keys(ARROWS).filter((key) => this.keys.has(`shift ${key}`));
    const person = moves.length && this.frame.people.find(({ index }) => index === this.view.chosen);
    if (!person) return;
    let [x, y] = this.view.target ?? [person.x, person.y];
    for (const key of moves) [x, y] = [x + ARROWS[key][0] * LEAD_MPS * dt, y + ARROWS[key][1] * LEAD_MPS * dt];
    this.lead(x, y);
  }

  // --- pictures ---

  picture(now) {
    const dt = Math.min((now - (this.before ?? now)) / 1000, 0.1);
    this.before = now;
    this.hold(dt);
    if (this.isPlaying) this.advance(dt);
    this.state = STILL ? this.still() : this.motion.at(now, dt, 1, this.scene.decision_s);
    this.view.draw(this.state);
    const { outcome, earned } = this.frame;
    const end = outcome === "running" ? "" : `, ${outcome.replace("_", " ")}`;
    $("told").textContent = `${this.state.time.toFixed(1)} s, ${Math.abs(this.state.speed).toFixed(2)} m/s, return ${earned.toFixed(1)}${end}`;
    requestAnimationFrame((next) => this.picture(next));
  }

  still() {
    this.motion.shown = this.motion.last.time_s;
    return this.motion.between();
  }

  /** Return where a person is, in CSS pixels of the window. */
  pixels(index) {
    const { x, y } = this.state.people.find((person) => person.index === index);
    const box = $("place").getBoundingClientRect();
    const [cx, cy] = this.view.center;
    return [box.left + this.view.size[0] / 2 + (x - cx) * this.view.scale, box.top + this.view.size[1] / 2 - (y - cy) * this.view.scale];
  }

  listen() {
    const canvas = $("place");
    for (const name of Object.keys(DATA.scenes)) {
      const button = Object.assign(document.createElement("button"), { type: "button", textContent: name });
      button.addEventListener("click", () => this.choose(name));
      $("scenes").append(button);
    }
    $("play").addEventListener("click", () => (this.isOver ? (this.begin(), this.setPlaying(true)) : this.setPlaying(!this.isPlaying)));
    $("again").addEventListener("click", () => this.begin());
    $("next").addEventListener("click", () => this.begin(1));
    $("policy").addEventListener("change", () => {
      this.startThrottle();
      if ($("policy").value === YOU) canvas.focus({ preventScroll: true }); // arrows are for driving now
    });
    $("ghost").addEventListener("change", () => this.begin());
    $("throttle").addEventListener("input", () => this.setThrottle(Number($("throttle").value)));
    const pointOf = (event) => this.view.toMetres(event.offsetX, event.offsetY);
    let isDragging = false;
    canvas.addEventListener("pointerdown", (event) => {
      this.setChosen(this.view.personAt(this.state, ...pointOf(event)));
      if (this.view.chosen === null) return;
      isDragging = true;
      canvas.setPointerCapture(event.pointerId);
      this.lead(...pointOf(event));
    });
    const keepPage = (event) => this.view.chosen !== null && event.preventDefault(); // a person is dragged, not the page
    canvas.addEventListener("touchstart", keepPage, { passive: false });
    canvas.addEventListener("pointermove", (event) => {
      if (isDragging) this.lead(...pointOf(event));
      else canvas.style.cursor = this.view.personAt(this.state, ...pointOf(event)) === null ? "default" : "grab";
    });
    for (const kind of ["pointerup", "pointercancel"]) {
      canvas.addEventListener(kind, () => {
        if (isDragging) this.setChosen(null);
        isDragging = false;
      });
    }
    document.addEventListener("keydown", (event) => this.press(event));
    document.addEventListener("keyup", ({ key }) => {
      this.keys.delete(key);
      for (const each of Object.keys(ARROWS)) if (key === "Shift" || key === each) this.keys.delete(`shift ${each}`);
    });
    addEventListener("blur", () => this.keys.clear());
  }

  press(event) {
    const { key, target } = event;
    const isOther = target.matches("select, input") || (target.matches("button") && (key === " " || key === "Enter"));
    if (isOther || event.ctrlKey || event.metaKey || event.altKey) return;
    if (key in ARROWS && event.shiftKey && this.view.chosen !== null) this.keys.add(`shift ${key}`);
    else if (key === "ArrowUp" || key === "ArrowDown") {
      this.take();
      this.setPlaying(true);
      this.keys.add(key);
    } else if (key === " ") this.setPlaying(!this.isPlaying);
    else if (key.toLowerCase() === "p") this.choosePerson();
    else if (key === "Enter" || key === "Escape") this.setChosen(null);
    else return;
    event.preventDefault();
  }
}

function sorry(error) {
  for (const each of document.querySelectorAll("nav, #stage")) each.hidden = true;
  $("sorry").hidden = false;
  $("sorry").textContent = `This browser cannot run the scenes (${error.message}); a picture of them:`;
  $("sorry").append(Object.assign(new Image(), { src: "_images/drive.png", alt: "A robot in a doorway, among people" }));
}

new ResizeObserver(() => parent.postMessage({ scenesPx: document.body.scrollHeight }, "*")).observe(document.body);
Scenes.make().then(async (page) => {
  page.listen();
  await page.choose(Object.keys(DATA.scenes)[0]);
  page.setPlaying(!STILL);
  requestAnimationFrame((now) => page.picture(now));
  window.hazbot = page; // for tests
}).catch(sorry);
