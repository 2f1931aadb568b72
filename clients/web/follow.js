// Ways in which a view goes with an entity. All of it is the view's place in
// the state: the entity it is fixed to and offsets, so a way is known again by
// its numbers, whoever set them.

const RAD = Math.PI / 180;
const half = (angle) => ((angle + 180) % 360 + 360) % 360 - 180;
const fine = (x) => Math.round(x * 100) / 100;
const AHEAD = { yaw: 0, pitch: 0, roll: 0 };
const FAR = 100000; // views.*.forward and right

export const eyeNames = (model) => (model?.eyes ?? []).map((eye, i) =>
  eye.name || `eye point ${i + 1}`);

// The eye point of a model that an entity scales to its own length.
export function eyeOf(model, index, length = model.length) {
  const eye = model.eyes[index];
  const scale = length && model.length ? length / model.length : 1;
  return { forward: fine((eye.forward ?? 0) * scale),
    right: fine((eye.right ?? 0) * scale), up: fine((eye.up ?? 0) * scale),
    ...AHEAD, level: false };
}

// Where a view that an entity carries goes when that gets this shape: from an
// eye point, from the place of a new view, or from within the shape to its first
// eye point, looking as before; from behind or around it there again. null: it
// stays.
export function taken(view, was, model, sizes) {
  const way = wayOf(view, was.model, was.sizes.length);
  const [ahead, right, up] = [view.forward ?? 0, view.right ?? 0, view.up ?? 0];
  const inside = Math.abs(ahead) <= sizes.length / 2 &&
    Math.abs(right) <= sizes.beam / 2 && up <= sizes.height;
  const fresh = ahead === 0 && right === 0;
  if (way === "chase" || way === "orbit") {
    return around(sizes, angleOf(view));
  }
  if (!model?.eyes?.length || !(inside || fresh || way.startsWith("eye"))) {
    return null;
  }
  const index = way.startsWith("eye") ? Number(way.slice(4)) : 0;
  const eye = eyeOf(model, index < model.eyes.length ? index : 0,
    sizes.length);
  return { forward: eye.forward, right: eye.right, up: eye.up, level: false };
}

// From `angle` clockwise of the bow, looking at the middle of it.
export function around(sizes, angle, distance = usual(sizes)) {
  const up = 4 + 0.28 * distance / 1.5;
  return {
    forward: fine(distance * Math.cos(angle * RAD)),
    right: fine(distance * Math.sin(angle * RAD)), up: fine(up),
    yaw: fine(half(angle + 180)), roll: 0, level: true,
    pitch: fine(-Math.atan2(up - 0.25 * sizes.height, distance) / RAD) };
}

export const usual = (sizes) =>
  Math.min(FAR, 1.5 * Math.max(sizes.length, 4) + 10);
export const angleOf = (view) =>
  (Math.atan2(view.right ?? 0, view.forward ?? 0) / RAD + 360) % 360;
export const distanceOf = (view) =>
  Math.hypot(view.right ?? 0, view.forward ?? 0);

// "eye 0", "chase", "orbit" or "free".
export function wayOf(view, model, length) {
  const near = (a, b, by) => Math.abs(a - b) <= by;
  const eyes = model?.eyes ?? [];
  for (let i = 0; i < eyes.length; i++) {
    const eye = eyeOf(model, i, length);
    if (["forward", "right", "up"].every((n) =>
      near(view[n] ?? 0, eye[n], 0.02))) {
      return `eye ${i}`;
    }
  }
  if (view.level && distanceOf(view) > 1 &&
      near(half((view.yaw ?? 0) - angleOf(view) - 180), 0, 0.5)) {
    return near(angleOf(view), 180, 0.5) ? "chase" : "orbit";
  }
  return "free";
}
