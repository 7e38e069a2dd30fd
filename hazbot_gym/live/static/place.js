// The place from above, on a canvas. Lengths are metres until the camera turns them into pixels.

import { reachable } from "./floor.js";
import { disc, fill, free, nearest, ring, stroke } from "./shapes.js";

export const PATTERNS = ["crossing", "encountering", "leading", "confronting"];
const LETTERS = ["C", "E", "L", "F"];
const NEAR_M = 6.5; // shown width while the view follows the robot,
const LEAST_PX = 300; // and least height
const WALL_M = 0.09; // drawn width
const BLIND = 1; // reaction of people who do not yield
const RAYS = 9; // of each sonar cone
const MOST_PX_PER_M = 130;
const MAX_SHARE = 0.56; // of the window's height

export class PlaceView {
  follows = false;
  chosen = null; // index of a person
  target = null; // where that person is led

  constructor(canvas) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d");
    this.readColors();
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
      this.readColors();
      this.prepare();
    });
    addEventListener("resize", () => this.prepare());
  }

  readColors() {
    const style = getComputedStyle(this.canvas);
    const names = ["floor", "outside", "ink", "soft", "grid", "wall", "robot", "robot-body", "ghost", "echo", "space", "gas", "loss",
      "none", ...PATTERNS];
    this.color = Object.fromEntries(names.map((name) => [name, style.getPropertyValue(`--${name}`).trim()]));
  }

  setScene(scene) {
    this.scene = scene;
    this.trail = [];
    this.ghostTrail = [];
    this.gas = null;
    this.center = null;
    this.prepare();
  }

  /** Fit the canvas to its box and draw what does not move. */
  prepare() {
    if (!this.scene) return;
    const [left, bottom, right, top] = this.scene.box;
    const [width, height] = [right - left, top - bottom];
    this.ratio = Math.min(devicePixelRatio || 1, 2);
    const cssWidth = this.canvas.parentElement.clientWidth;
    const most = Math.max(MAX_SHARE * innerHeight, LEAST_PX);
    this.scale = this.follows ? Math.min(cssWidth / NEAR_M, MOST_PX_PER_M) : Math.min(cssWidth / width, most / height);
    const cssHeight = Math.round(Math.min(most, Math.max(this.scale * height, this.follows ? LEAST_PX : 0)));
    this.canvas.style.height = `${cssHeight}px`;
    this.canvas.width = Math.round(cssWidth * this.ratio);
    this.canvas.height = Math.round(cssHeight * this.ratio);
    this.size = [cssWidth, cssHeight];
    this.center = null;
    this.makeLayers();
  }

  /** Make two canvases of the whole place: the floor, and a mask of what lies behind walls. */
  makeLayers() {
    const [left, bottom, right, top] = this.scene.box;
    const beyond = (px, length) => Math.max(0, (px / this.scale - length) / 2) + 0.05; // where the window is larger
    const [dx, dy] = [beyond(this.size[0], right - left), beyond(this.size[1], top - bottom)];
    const box = [left - dx, bottom - dy, right + dx, top + dy];
    this.origin = [box[0], box[3]];
    const floor = this.layer(box);
    floor.fillStyle = this.color.floor;
    floor.fillRect(box[0], box[1], box[2] - box[0], box[3] - box[1]);
    this.drawPath(floor);
    const mask = this.layer(box);
    mask.fillStyle = this.color.outside;
    mask.fillRect(box[0], box[1], box[2] - box[0], box[3] - box[1]);
    reachable(this.scene, this.floorBox(box), (x, y, width, height) => mask.clearRect(x, y, width, height));
    mask.lineCap = "round";
    for (const [x1, y1, x2, y2] of this.scene.walls) stroke(mask, [[x1, y1], [x2, y2]], this.color.wall, WALL_M);
    [this.floor, this.mask] = [floor.canvas, mask.canvas];
  }

  /** Return the context of a new canvas of a box, drawn in metres. */
  layer([left, bottom, right, top]) {
    const scale = this.scale * this.ratio;
    const context = new OffscreenCanvas(Math.ceil((right - left) * scale), Math.ceil((top - bottom) * scale)).getContext("2d");
    context.scale(scale, -scale);
    context.translate(-left, -top);
    return context;
  }

  /** Return the part of a box where there may be floor: no farther than the walls reach. */
  floorBox([left, bottom, right, top]) {
    const walls = this.scene.walls;
    if (walls.length < 2) return [left, bottom, right, top];
    const [xs, ys] = [walls.flatMap(([x1, , x2]) => [x1, x2]), walls.flatMap(([, y1, , y2]) => [y1, y2])];
    return [Math.max(left, Math.min(...xs)), Math.max(bottom, Math.min(...ys)), Math.min(right, Math.max(...xs)), Math.min(top, Math.max(...ys))];
  }

  drawPath(context) {
    const path = this.scene.path;
    stroke(context, path, this.color.soft, 0.025, [0.16, 0.2]);
    const [x, y] = path[path.length - 1];
    for (const [radius, color] of [[0.16, this.color.ink], [0.12, this.color.floor], [0.07, this.color.ink]]) disc(context, x, y, radius, color);
  }

  toMetres(cssX, cssY) {
    const [cx, cy] = this.center ?? [0, 0];
    return [cx + (cssX - this.size[0] / 2) / this.scale, cy - (cssY - this.size[1] / 2) / this.scale];
  }

  /** Return the person at a point, or null. */
  personAt(state, x, y) {
    const reach = Math.max(this.scene.person_m + 0.12, 18 / this.scale);
    const near = state.people.map((person) => [Math.hypot(person.x - x, person.y - y), person.index]).filter(([away]) => away < reach);
    return near.length ? near.sort((a, b) => a[0] - b[0])[0][1] : null;
  }

  aim(state) {
    const [left, bottom, right, top] = this.scene.box;
    const whole = [(left + right) / 2, (bottom + top) / 2];
    if (!this.follows) return whole;
    const [halfX, halfY] = [this.size[0] / this.scale / 2, this.size[1] / this.scale / 2];
    const [x, y, theta] = state.pose;
    const within = (value, low, high, half) => (high - low <= 2 * half ? (low + high) / 2 : Math.max(low + half, Math.min(high - half, value)));
    return [within(x + 1.5 * Math.cos(theta), left, right, halfX), within(y + 1.5 * Math.sin(theta), bottom, top, halfY)];
  }

  draw(state) {
    const wanted = this.aim(state);
    this.center = this.center ? this.center.map((value, i) => value + 0.08 * (wanted[i] - value)) : wanted;
    const context = this.context;
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.fillStyle = this.color.outside;
    context.fillRect(0, 0, this.canvas.width, this.canvas.height);
    const scale = this.scale * this.ratio;
    const [cx, cy] = this.center;
    const x0 = (this.origin[0] - cx) * scale + this.canvas.width / 2;
    const y0 = (cy - this.origin[1]) * scale + this.canvas.height / 2;
    const put = (layer) => {
      context.setTransform(1, 0, 0, 1, 0, 0);
      context.drawImage(layer, Math.round(x0), Math.round(y0));
      context.setTransform(scale, 0, 0, -scale, this.canvas.width / 2 - cx * scale, this.canvas.height / 2 + cy * scale);
    };
    put(this.floor);
    if (this.gas) this.drawGas(context);
    this.drawZones(context, state.people);
    this.drawTrails(context, state);
    this.drawSonar(context, state);
    put(this.mask);
    if (this.gas) this.drawLeak(context);
    if (state.ghost) this.drawGhost(context, state.ghost);
    for (const person of state.people) this.drawPerson(context, person);
    this.drawRobot(context, state);
    this.drawContact(context, state);
    this.drawScaleBar(context);
  }

  /** Keep the trails, one point a decision, and the gas. */
  note(frame) {
    if (frame.decision === 0) [this.trail, this.ghostTrail] = [[], []];
    this.trail.push(frame.pose.slice(0, 2));
    if (frame.ghost) this.ghostTrail.push(frame.ghost.pose.slice(0, 2));
    if (frame.plume) this.gas = this.cloud(frame.plume);
  }

  cloud(base64) {
    const { columns, rows } = this.scene.plume;
    const opacity = Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
    const [r, g, b] = [1, 3, 5].map((i) => parseInt(this.color.gas.slice(i, i + 2), 16));
    const image = new ImageData(columns, rows);
    opacity.forEach((value, i) => image.data.set([r, g, b, value], 4 * i));
    const made = new OffscreenCanvas(columns, rows);
    made.getContext("2d").putImageData(image, 0, 0);
    return made;
  }

  drawGas(context) {
    const { left_m: left, top_m: top, cell_m: cell, columns, rows } = this.scene.plume;
    context.save();
    context.translate(left, top);
    context.scale(1, -1);
    context.drawImage(this.gas, 0, 0, columns * cell, rows * cell);
    context.restore();
  }

  drawLeak(context) {
    const [x, y] = this.scene.leak;
    context.save();
    context.translate(x, y);
    context.rotate(Math.PI / 4);
    context.fillStyle = this.color.gas;
    context.fillRect(-0.1, -0.1, 0.2, 0.2);
    context.strokeStyle = this.color.ink;
    context.lineWidth = 0.03;
    context.strokeRect(-0.1, -0.1, 0.2, 0.2);
    context.restore();
  }

  drawZones(context, people) {
    const [social, personal, intimate] = this.scene.zones_m.map((zone) => zone + this.scene.person_m);
    for (const [radius, alpha] of [[personal, 0.1], [intimate, 0.2]]) {
      context.beginPath(); // one for all, so that an overlap is no darker
      for (const { x, y } of people) {
        context.moveTo(x + radius, y);
        context.arc(x, y, radius, 0, 2 * Math.PI);
      }
      context.globalAlpha = alpha;
      context.fillStyle = this.color.space;
      context.fill();
    }
    context.globalAlpha = 0.22;
    for (const { x, y } of people.length > 8 ? [] : people) ring(context, x, y, social, this.color.space, 0.02, [0.12, 0.12]);
    context.globalAlpha = 1;
  }

  drawTrails(context, { pose, ghost }) {
    context.lineCap = context.lineJoin = "round";
    context.globalAlpha = 0.45;
    stroke(context, [...this.trail.slice(0, -1), pose.slice(0, 2)], this.color.robot, 0.06);
    if (ghost) stroke(context, [...this.ghostTrail.slice(0, -1), ghost.pose.slice(0, 2)], this.color.ghost, 0.05, [0.1, 0.12]);
    context.globalAlpha = 1;
  }

  /** Draw what each sonar hears: a cone that ends at walls, and an arc where there is an echo. */
  drawSonar(context, { pose: [x, y, theta], frame }) {
    const [mount, range] = this.scene.sonar_m;
    this.scene.sensors.forEach(({ angle_rad: axis, half_rad: half }, i) => {
      const reading = frame.ranges[i];
      const [sx, sy] = [x + mount * Math.cos(theta + axis), y + mount * Math.sin(theta + axis)];
      const rim = [];
      for (let k = 0; k < RAYS; k += 1) {
        const angle = theta + axis - half + (2 * half * k) / (RAYS - 1);
        const [ux, uy] = [Math.cos(angle), Math.sin(angle)];
        const length = Math.min(reading, free(this.scene.walls, sx, sy, ux, uy));
        rim.push([sx + length * ux, sy + length * uy]);
      }
      context.globalAlpha = reading < range ? 0.3 : 0.13;
      fill(context, [[sx, sy], ...rim], this.color.echo);
      context.globalAlpha = 0.9;
      if (reading < range) stroke(context, rim, this.color.echo, 0.045);
    });
    context.globalAlpha = 1;
  }

  drawPerson(context, { index, x, y, vx, vy, facing, pattern, reaction, is_led: isLed }) {
    const radius = this.scene.person_m;
    const color = this.color[PATTERNS[pattern] ?? "none"];
    if (index === this.chosen || isLed) {
      ring(context, x, y, radius + 0.13, this.color.ink, 0.045);
      if (this.target && index === this.chosen) stroke(context, [[x, y], this.target], this.color.ink, 0.025, [0.08, 0.08]);
    }
    context.save();
    context.translate(x, y);
    context.rotate(facing);
    context.fillStyle = color;
    const tip = radius + 0.32 * Math.hypot(vx, vy);
    context.globalAlpha = 0.6;
    fill(context, [[tip, 0], [0, 0.55 * radius], [0, -0.55 * radius]], color);
    context.globalAlpha = 0.35;
    disc(context, 0, 0, radius, color);
    context.globalAlpha = 1;
    context.beginPath();
    context.ellipse(0, 0, 0.55 * radius, radius, 0, 0, 2 * Math.PI);
    context.fill();
    context.restore();
    this.letter(context, x, y, LETTERS[pattern] ?? "", radius);
    if (reaction === BLIND) {
      context.fillStyle = this.color.ink;
      context.fillRect(x + 0.72 * radius, y + 0.72 * radius, 0.5 * radius, 0.5 * radius);
    }
  }

  letter(context, x, y, text, radius) {
    if (!text || radius * this.scale < 9) return;
    context.save();
    context.translate(x, y);
    context.scale(1, -1);
    disc(context, 0, 0, 0.52 * radius, this.color.floor);
    context.fillStyle = this.color.ink;
    context.font = `700 ${0.78 * radius}px system-ui, sans-serif`;
    context.textAlign = "center";
    context.textBaseline = "middle";
    context.fillText(text, 0, 0.04 * radius);
    context.restore();
  }

  drawRobot(context, { pose: [x, y, theta] }) {
    const radius = this.scene.robot_m;
    context.save();
    context.translate(x, y);
    context.rotate(theta);
    disc(context, 0, 0, radius, this.color.robot);
    disc(context, 0, 0, radius - 0.04, this.color["robot-body"]);
    context.fillStyle = this.color.ink;
    for (const side of [-1, 1]) context.fillRect(-0.1, side * 0.2 - 0.03, 0.2, 0.06);
    fill(context, [[0.8, 0], [0.02, 0.44], [0.2, 0], [0.02, -0.44]].map((point) => point.map((value) => value * radius)), this.color.robot);
    context.restore();
  }

  drawGhost(context, { pose: [x, y, theta] }) {
    const radius = this.scene.robot_m;
    context.save();
    context.translate(x, y);
    context.rotate(theta);
    context.globalAlpha = 0.2;
    disc(context, 0, 0, radius, this.color.ghost);
    context.globalAlpha = 1;
    ring(context, 0, 0, radius - 0.02, this.color.ghost, 0.04, [0.1, 0.07]);
    fill(context, [[0.75, 0], [0.1, 0.35], [0.1, -0.35]].map((point) => point.map((value) => value * radius)), this.color.ghost);
    context.restore();
  }

  drawContact(context, { pose: [x, y], frame, people }) {
    if (!frame.outcome.startsWith("contact")) return;
    const near = frame.outcome === "contact_person" ? people.map((person) => [person.x, person.y]) : this.scene.walls.map((wall) => nearest(wall, x, y));
    const [px, py] = near.sort((a, b) => Math.hypot(a[0] - x, a[1] - y) - Math.hypot(b[0] - x, b[1] - y))[0] ?? [x, y];
    const away = Math.hypot(px - x, py - y) || 1;
    const [cx, cy] = [x + (this.scene.robot_m * (px - x)) / away, y + (this.scene.robot_m * (py - y)) / away];
    for (const side of [-1, 1]) stroke(context, [[cx - 0.16, cy - 0.16 * side], [cx + 0.16, cy + 0.16 * side]], this.color.loss, 0.08);
  }

  drawScaleBar(context) {
    context.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    const x = 16;
    const y = this.size[1] - 14;
    stroke(context, [[x, y - 4], [x, y], [x + this.scale, y], [x + this.scale, y - 4]], this.color.soft, 1.5);
    context.fillStyle = this.color.soft;
    context.font = "12px system-ui, sans-serif";
    context.textAlign = "left";
    context.fillText("1 m", x + this.scale + 6, y);
  }
}
