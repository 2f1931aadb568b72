// Places: from latitude and longitude to metres about a point and back, and
// where an entity is at a simulated time, as the server reckons it.

const RAD = Math.PI / 180;
const A = 6378137; // WGS 84
const E2 = 0.00669437999014;

export const wrap = (angle) => ((angle % 360) + 360) % 360;

// Metres in a degree of latitude and of longitude.
function degree(latitude) {
  const s = Math.sin(latitude * RAD);
  const w = Math.sqrt(1 - E2 * s * s);
  return [A * (1 - E2) / w ** 3 * RAD,
    A / w * Math.cos(latitude * RAD) * RAD];
}

// East and north of `from` in metres; for the tens of kilometres of a plan.
export function offset(from, to) {
  const [perLatitude, perLongitude] = degree(
    (from.latitude + to.latitude) / 2);
  const east = wrap(to.longitude - from.longitude + 180) - 180;
  return [east * perLongitude, (to.latitude - from.latitude) * perLatitude];
}

export function shifted(from, [east, north]) {
  const latitude = from.latitude + north / degree(from.latitude)[0];
  const [, perLongitude] = degree((from.latitude + latitude) / 2);
  return { latitude,
    longitude: wrap(from.longitude + east / perLongitude + 180) - 180 };
}

// Metres ahead and to starboard of a heading, as east and north.
export function turned([ahead, right], heading) {
  const [s, c] = [Math.sin(heading * RAD), Math.cos(heading * RAD)];
  return [ahead * s + right * c, ahead * c - right * s];
}

export function bearing([east, north]) {
  return wrap(Math.atan2(east, north) / RAD);
}

// Where an entity is, its heading, and whether it stands because its pose is
// older than clock.reckoning.
export function reckoned(entity, time, reckoning = 60) {
  const age = time - (entity.poseTime ?? time);
  const seconds = Math.max(-reckoning, Math.min(age, reckoning));
  const turn = (entity.turnRate ?? 0) * seconds;
  const half = turn / 2 * RAD;
  const chord = (entity.speed ?? 0) * seconds *
    (Math.abs(half) > 1e-9 ? Math.sin(half) / half : 1);
  const course = (entity.course ?? 0) + turn / 2;
  return { ...shifted({ latitude: entity.latitude ?? 52.6,
    longitude: entity.longitude ?? 5.2 }, turned([chord, 0], course)),
  heading: wrap((entity.heading ?? 0) + turn),
  course: wrap((entity.course ?? 0) + turn),
  stood: age > reckoning &&
    ((entity.speed ?? 0) !== 0 || (entity.turnRate ?? 0) !== 0) };
}

// Ways on which a camera moves that the page does not know by itself.
export const isSent = (view) => view.satellite !== undefined ||
  (view.waypoints ?? []).length > 0;

function orbitOf({ orbit }, state, time) {
  const about = orbit.entity === undefined ? orbit
    : (state.entities ?? []).find((e) => (e.id ?? 0) === orbit.entity);
  const angle = (orbit.azimuth ?? 180) +
    (orbit.period ? 360 * time / orbit.period : 0);
  const far = (orbit.radius ?? 500) *
    Math.cos((orbit.elevation ?? 15) * RAD);
  return about && { about, ...shifted(reckoned(about, time,
    state.clock?.reckoning), turned([far, 0], angle)), heading: angle + 180 };
}

// Where a view's camera is, and the bearing of its axis; null: the server
// alone knows.
export function cameraOf(view, state, time) {
  if (isSent(view)) {
    return null;
  }
  if (view.at || view.orbit) {
    const at = view.at ? { ...view.at, heading: 0 }
      : orbitOf(view, state, time);
    return at ? { ...at, bearing: wrap(at.heading + (view.yaw ?? 0)) } : null;
  }
  const carrier = view.entity === undefined ? undefined
    : (state.entities ?? []).find((e) => (e.id ?? 0) === view.entity);
  const from = carrier ? reckoned(carrier, time, state.clock?.reckoning)
    : { latitude: state.origin?.latitude ?? 52.6,
      longitude: state.origin?.longitude ?? 5.2, heading: 0 };
  return { ...shifted(from, turned([view.forward ?? 0, view.right ?? 0],
    from.heading)), bearing: wrap(from.heading + (view.yaw ?? 0)) };
}

export const metres = (m) => m < 995 ? `${m.toFixed(0)} m`
  : m < 9950 ? `${(m / 1000).toFixed(2)} km` : `${(m / 1000).toFixed(1)} km`;
export const three = (angle) =>
  `${String(Math.round(angle) % 360).padStart(3, "0")}°`;
export const knots = (mps) => `${(mps * 3.6 / 1.852).toFixed(1)} kn`;
