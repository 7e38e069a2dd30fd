// One world of the exact engine: the library's own kernels as WebAssembly, over memory that Python filled.

const PAGE = 65536; // bytes
const [LOW, HIGH] = [(value) => BigInt.asUintN(64, value), (value) => BigInt.asUintN(64, value >> 64n)];

/** The error function, by a series of positive terms: erf x = 2 / sqrt(pi) e^(-x^2) sum_n 2^n x^(2n+1) / (2n+1)!! */
function erf(x) {
  if (Math.abs(x) > 6) return Math.sign(x);
  let [term, sum] = [x, x];
  for (let n = 1; Math.abs(term) > 1e-17 * Math.abs(sum); n += 1) {
    term *= (2 * x * x) / (2 * n + 1);
    sum += term;
  }
  return (2 / Math.sqrt(Math.PI)) * Math.exp(-x * x) * sum;
}

/** What a kernel imports: memory, a stack below `first`, and functions that WebAssembly does not have. */
function environment(memory, first) {
  const { atan2, cos, exp, log, pow, sin } = Math;
  return {
    atan2, cos, erf, exp, log, pow, sin,
    __linear_memory: memory,
    __stack_pointer: new WebAssembly.Global({ value: "i32", mutable: true }, first),
    __indirect_function_table: new WebAssembly.Table({ initial: 1, element: "anyfunc" }),
    __multi3(out, aLow, aHigh, bLow, bHigh) {
      const product = ((aHigh << 64n) | LOW(aLow)) * ((bHigh << 64n) | LOW(bLow));
      const view = new DataView(memory.buffer);
      view.setBigUint64(out, LOW(product), true);
      view.setBigUint64(out + 8, HIGH(product), true);
    },
  };
}

export class Engine {
  earned = 0; // rewards so far
  outcome = "running";
  led = new Map(); // points by person

  static async make(module, shared, scene, first) {
    const memory = new WebAssembly.Memory({ initial: Math.ceil(scene.end / PAGE) });
    new Uint8Array(memory.buffer).set(shared, first);
    new Uint8Array(memory.buffer).set(scene.bytes.subarray(0, scene.end - scene.first), scene.first);
    const { exports } = await WebAssembly.instantiate(module, { env: environment(memory, first) });
    return new Engine(exports, memory, scene);
  }

  constructor(exports, memory, scene) {
    this.scene = scene;
    this.memory = memory;
    this.view = new DataView(memory.buffer);
    this.kernels = {};
    for (const [name, given] of Object.entries(scene.calls)) {
      const values = given.map((value) => (typeof value === "string" ? BigInt(value) : value)); // digits: 64 bits
      this.kernels[name] = () => exports[name](...values);
    }
  }

  read(array, i = 0, field = "") {
    const { at, size, fields } = this.scene.at[array];
    const [offset, code] = fields[field];
    return Number(this.view[`get${code}`](at + i * size + offset, true));
  }

  write(array, value, i = 0) {
    const { at, size, fields } = this.scene.at[array];
    const code = fields[""][1];
    this.view[`set${code}`](at + i * size, code.startsWith("Big") ? BigInt(value) : value, true);
  }

  /** Begin an episode, one of those that Python has drawn. */
  start(index) {
    const { bytes, first, end, state_end: stateEnd } = this.scene;
    const size = stateEnd - first;
    const at = end - first + index * size;
    new Uint8Array(this.memory.buffer).set(bytes.subarray(at, at + size), first);
    [this.earned, this.outcome] = [0, "running"];
    this.led.clear();
  }

  /** Return the action of a policy: of a kernel, or of a share of the nominal speed. */
  action({ kernel, share }) {
    if (!kernel) return Math.fround(2 * Math.fround(share) - 1);
    this.kernels[kernel]();
    return this.read("actions");
  }

  step(action) {
    if (this.outcome !== "running") return;
    for (const [person, [x, y]] of this.led) {
      this.write("person", person);
      this.write("point", x, 0);
      this.write("point", y, 1);
      this.kernels.lead();
    }
    this.write("actions", action);
    this.kernels.run_worlds();
    this.earned += this.read("reward");
    this.outcome = this.scene.outcomes[this.read("record", 0, "outcome")];
  }

  lead(person, x, y) {
    this.led.set(person, [x, y]);
  }

  letGo(person) {
    if (!this.led.delete(person)) return;
    this.write("person", person);
    this.kernels.let_go();
  }

  /** Return the present instant as the page of `hazbot play` gets it. */
  frame() {
    const robot = (field) => this.read("robot", 0, field);
    const decision = this.read("steps");
    return {
      decision,
      time_s: decision * this.scene.decision_s,
      pose: [robot("x"), robot("y"), robot("theta")],
      speed: robot("v"),
      command: robot("command"),
      people: this.people(),
      ranges: Array.from({ length: this.scene.at.ranges.count }, (_, i) => this.read("ranges", i)),
      outcome: this.outcome,
      earned: this.earned,
    };
  }

  people() {
    const everyone = Array.from({ length: this.scene.at.people.count }, (_, index) => {
      const person = (field) => this.read("people", index, field);
      return {
        index,
        status: person("status"),
        x: person("x"),
        y: person("y"),
        vx: person("vx"),
        vy: person("vy"),
        reaction: person("reaction"),
        pattern: this.read("tracks", index, "pattern"),
        is_led: this.led.has(index),
      };
    });
    return everyone.filter(({ status }) => status === this.scene.present);
  }

  /** Return the opacity of the gas in each cell of the picture, as the page gets it. */
  plume({ columns, rows }) {
    this.kernels.draw_plume();
    const letters = new Uint8Array(columns * rows);
    for (let k = 0; k < this.scene.at.cells.count; k += 1) {
      const cell = this.read("cells", k);
      if (cell >= 0) letters[cell] = this.read("opacity", k);
    }
    return btoa(String.fromCharCode(...letters));
  }
}
