// Where a view looks: from the state to directions and to places in its
// picture. East, north, up; angles in degrees, bearings true.

const RAD = Math.PI / 180;

const add = (a, s, b, t) => a.map((x, i) => x * s + b[i] * t);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const wrap = (angle) => ((angle % 360) + 360) % 360;

const WORLD = { ahead: [0, 1, 0], right: [1, 0, 0], up: [0, 0, 1] };

// Yaw to starboard, then pitch upward, then roll, right side down.
function turn({ ahead, right, up }, yaw, pitch, roll) {
  const [y, p, r] = [yaw * RAD, pitch * RAD, roll * RAD];
  const a1 = add(ahead, Math.cos(y), right, Math.sin(y));
  const r1 = add(right, Math.cos(y), ahead, -Math.sin(y));
  const u1 = add(up, Math.cos(p), a1, -Math.sin(p));
  return {
    ahead: add(a1, Math.cos(p), up, Math.sin(p)),
    right: add(r1, Math.cos(r), u1, -Math.sin(r)),
    up: add(u1, Math.cos(r), r1, Math.sin(r)),
  };
}

// The heading at a simulated time: poses are reckoned on by their turn rate.
function headingAt(entity, time, reckoning) {
  const since = Math.min(Math.max(time - (entity.poseTime ?? time), 0),
    reckoning ?? 60);
  return (entity.heading ?? 0) + (entity.turnRate ?? 0) * since;
}

export function direction(bearing, elevation) {
  const [b, e] = [bearing * RAD, elevation * RAD];
  return [Math.sin(b) * Math.cos(e), Math.cos(b) * Math.cos(e), Math.sin(e)];
}

export class Pose {
  constructor(view, entity, time, reckoning) {
    const ship = entity
      ? turn(WORLD, headingAt(entity, time, reckoning),
        view.level ? 0 : entity.pitch ?? 0, view.level ? 0 : entity.roll ?? 0)
      : WORLD;
    this.eye = turn(ship, view.yaw ?? 0, view.pitch ?? 0, view.roll ?? 0);
    this.bow = entity ? wrap(headingAt(entity, time, reckoning)) : undefined;
    const f = view.frustum;
    if (f) {
      [this.left, this.right, this.top, this.bottom] =
        [f.left, f.right, f.top, f.bottom].map((a) => Math.tan(a * RAD));
    } else {
      this.right = Math.tan((view.fieldOfView ?? 60) / 2 * RAD);
      this.left = -this.right;
      this.top = this.right * view.height / view.width;
      this.bottom = -this.top;
    }
    const middle = add(add(this.eye.ahead, 1, this.eye.right,
      (this.left + this.right) / 2), 1, this.eye.up,
    (this.top + this.bottom) / 2);
    const length = Math.hypot(...middle);
    this.bearing = wrap(Math.atan2(middle[0], middle[1]) / RAD);
    this.elevation = Math.asin(middle[2] / length) / RAD;
    this.roll = Math.atan2(-this.eye.right[2], this.eye.up[2]) / RAD;
    this.across = (Math.atan(this.right) - Math.atan(this.left)) / RAD;
  }

  // Where a direction is in the picture, 0 to 1 from its upper left corner;
  // null: behind the eye.
  place(towards) {
    const z = dot(towards, this.eye.ahead);
    if (z < 0.01) {
      return null;
    }
    const x = dot(towards, this.eye.right) / z;
    const y = dot(towards, this.eye.up) / z;
    return [(x - this.left) / (this.right - this.left),
      (this.top - y) / (this.top - this.bottom)];
  }
}

const KEPT = 24;
const between = (a, b, part) => a + (((b - a + 540) % 360) - 180) * part;

// How entities moved of late. Pictures are older than the state that was read
// last: their ships stood as they did then.
export class Track {
  constructor() {
    this.poses = new Map();
  }

  add(state) {
    const there = new Map();
    for (const entity of state.entities ?? []) {
      const id = entity.id ?? 0;
      const poses = (this.poses.get(id) ?? []).filter((p) =>
        (p.poseTime ?? 0) <= (entity.poseTime ?? 0)).slice(-KEPT);
      const last = poses.at(-1);
      if (last && last.poseTime === entity.poseTime) {
        poses.pop();
      }
      there.set(id, [...poses, entity]);
    }
    this.poses = there;
  }

  // The entity at a simulated time; undefined: there is none.
  at(id, time) {
    const poses = this.poses.get(id) ?? [];
    const next = poses.findIndex((p) => (p.poseTime ?? 0) > time);
    if (next < 1) {
      return next === 0 ? poses[0] : poses.at(-1);
    }
    const [a, b] = [poses[next - 1], poses[next]];
    const part = (time - a.poseTime) / (b.poseTime - a.poseTime);
    return { ...b, poseTime: time, turnRate: 0,
      heading: between(a.heading ?? 0, b.heading ?? 0, part),
      pitch: between(a.pitch ?? 0, b.pitch ?? 0, part),
      roll: between(a.roll ?? 0, b.roll ?? 0, part) };
  }
}
