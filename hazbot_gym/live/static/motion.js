// Smooth motion between decisions: what is shown runs a decision behind what has arrived.

const mix = (a, b, share) => a + share * (b - a);
const turn = (a, b, share) => a + share * Math.atan2(Math.sin(b - a), Math.cos(b - a));
const CORRECTION = 0.12; // share of the clock's error that is taken away with each picture
const SLOW = 0.05; // m/s: a slower person keeps facing the same way

export class Motion {
  frames = [];
  facing = new Map(); // of people, who may stand
  shown = 0; // time that is shown [s]

  reset() {
    this.frames = [];
    this.facing.clear();
  }

  push(frame, now) {
    if (!this.frames.length) this.shown = frame.time_s;
    this.frames = [...this.frames.slice(-3), frame];
    this.arrived = now;
    for (const { index, vx, vy } of frame.people) {
      if (Math.hypot(vx, vy) > SLOW || !this.facing.has(index)) this.facing.set(index, Math.atan2(vy, vx));
    }
  }

  get last() {
    return this.frames[this.frames.length - 1];
  }

  /** Return the state to be shown, dt after the last picture [s]. */
  at(now, dt, rate, decision) {
    const last = this.last;
    if (!last) return null;
    const due = Math.min(last.time_s - decision + ((now - this.arrived) / 1000) * rate, last.time_s);
    const next = this.shown + dt * rate;
    this.shown = Math.min(next + CORRECTION * (due - next), last.time_s);
    if (Math.abs(due - this.shown) > 3 * decision) this.shown = due;
    return this.between();
  }

  between() {
    const frames = this.frames;
    let k = frames.length - 1;
    while (k > 0 && frames[k - 1].time_s > this.shown) k -= 1;
    const b = frames[k];
    const a = frames[Math.max(k - 1, 0)];
    const share = b.time_s > a.time_s ? Math.max(0, Math.min(1, (this.shown - a.time_s) / (b.time_s - a.time_s))) : 1;
    const before = new Map(a.people.map((person) => [person.index, person]));
    return {
      frame: b,
      time: mix(a.time_s, b.time_s, share),
      pose: pose(a.pose, b.pose, share),
      speed: mix(a.speed, b.speed, share),
      ghost: b.ghost && { ...b.ghost, pose: a.ghost ? pose(a.ghost.pose, b.ghost.pose, share) : b.ghost.pose },
      people: b.people.map((person) => {
        const from = before.get(person.index) ?? person;
        const facing = turn(Math.atan2(from.vy, from.vx), Math.atan2(person.vy, person.vx), share);
        const isStanding = Math.hypot(person.vx, person.vy) <= SLOW;
        return {
          ...person,
          x: mix(from.x, person.x, share),
          y: mix(from.y, person.y, share),
          facing: isStanding ? this.facing.get(person.index) : facing,
        };
      }),
    };
  }
}

function pose(a, b, share) {
  return [mix(a[0], b[0], share), mix(a[1], b[1], share), turn(a[2], b[2], share)];
}
