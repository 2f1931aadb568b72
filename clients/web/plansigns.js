// Signs of the plan: hulls, marks, what a camera sees, wind and swell.

const RAD = Math.PI / 180;
// By what a thing is, whatever its shape is called; of IALA's region B by name.
const COLOURS = { LATERAL_PORT: "#ff5f57", LATERAL_STARBOARD: "#3fd17a",
  SAFE_WATER: "#ff8f87", SPECIAL_MARK: "#ffd84d", ISOLATED_DANGER: "#ff5f57",
  CARDINAL_NORTH: "#ffd84d", CARDINAL_EAST: "#ffd84d",
  CARDINAL_SOUTH: "#ffd84d", CARDINAL_WEST: "#ffd84d", BEACON: "#f2f2f2",
  LIGHT_FLOAT: "#f2f2f2", PERSON: "#ff9d3b", LIFE_RAFT: "#ff9d3b" };
const REGION_B = { LATERAL_PORT: COLOURS.LATERAL_STARBOARD,
  LATERAL_STARBOARD: COLOURS.LATERAL_PORT };
const LIGHTS = { R: "#ff5f57", G: "#3fd17a", Y: "#ffd84d", Bu: "#7fb2ff",
  W: "#fff3b0" };

function path(g, points) {
  g.beginPath();
  points.forEach(([x, y], i) => (i ? g.lineTo(x, y) : g.moveTo(x, y)));
  g.closePath();
}

function turned(g, [x, y], angle, work) {
  g.save();
  g.translate(x, y);
  g.rotate(angle * RAD);
  work();
  g.restore();
}

// To scale where that is seen, else a wedge; hollow: it has no shape.
export function drawHull(g, at, heading, length, beam, ink, hollow) {
  const real = length > 15;
  const l = real ? length / 2 : 9;
  const b = real ? Math.max(beam / 2, 1.5) : 5;
  turned(g, at, heading, () => {
    path(g, real ? [[0, -l], [b, -l + 2.2 * b], [b, l], [-b, l],
      [-b, -l + 2.2 * b]] : [[0, -l], [b, l * 0.7], [-b, l * 0.7]]);
    g.fillStyle = hollow ? "#08202e" : ink;
    g.strokeStyle = ink;
    g.lineWidth = 1.2;
    g.globalAlpha = 0.9;
    g.fill();
    g.globalAlpha = 1;
    g.stroke();
  });
}

// A light's flare, as charts have it, of its first colour; a dot where it
// stands.
export function drawLight(g, [x, y], character) {
  const [, colour = "W"] = /\b(R|G|Y|Bu|W)/.exec(character ?? "") ?? [];
  g.fillStyle = LIGHTS[colour];
  g.strokeStyle = "#02070b";
  g.lineWidth = 0.8;
  turned(g, [x, y], 135, () => {
    path(g, [[0, 2], [3.4, -12], [0, -15], [-3.4, -12]]);
    g.fill();
    g.stroke();
  });
  g.beginPath();
  g.arc(x, y, 2, 0, 2 * Math.PI);
  g.fill();
  g.stroke();
}

// false: what it is has no sign of its own.
export function drawMark(g, [x, y], model) {
  const kind = model?.class ?? "";
  const colour = /-b$/.test(model?.name ?? "") && REGION_B[kind] ||
    COLOURS[kind];
  if (!colour) {
    return false;
  }
  g.fillStyle = colour;
  g.strokeStyle = "#02070b";
  g.lineWidth = 1;
  if (kind === "LATERAL_PORT") {
    path(g, [[x - 4, y - 5], [x + 4, y - 5], [x + 4, y + 5], [x - 4, y + 5]]);
  } else if (kind === "LATERAL_STARBOARD") {
    path(g, [[x, y - 6], [x + 5, y + 5], [x - 5, y + 5]]);
  } else if (kind.startsWith("CARDINAL")) {
    path(g, [[x, y - 6], [x + 5, y], [x, y + 6], [x - 5, y]]);
  } else {
    g.beginPath();
    g.arc(x, y, 4.5, 0, 2 * Math.PI);
  }
  g.fill();
  g.stroke();
  if (kind.startsWith("CARDINAL")) { // on the side where one passes
    const side = { NORTH: 0, EAST: 90, SOUTH: 180, WEST: 270 }[
      kind.slice("CARDINAL_".length)];
    g.fillStyle = "#02070b";
    g.beginPath();
    g.arc(x + 3 * Math.sin(side * RAD), y - 3 * Math.cos(side * RAD), 2, 0,
      2 * Math.PI);
    g.fill();
  }
  return true;
}

// bearing: on the plan; sides: of it, in degrees.
export function drawFan(g, [x, y], bearing, sides, radius, chosen) {
  const [a, b] = sides.map((side) => (bearing + side - 90) * RAD);
  const shade = g.createRadialGradient(x, y, 0, x, y, radius);
  shade.addColorStop(0, chosen ? "#3bb3d699" : "#93aebc55");
  shade.addColorStop(1, "#3bb3d600");
  g.beginPath();
  g.moveTo(x, y);
  g.arc(x, y, radius, a, b);
  g.closePath();
  g.fillStyle = shade;
  g.fill();
}

function arrow(g, radius, from, colour, width) {
  g.save();
  g.rotate(from * RAD); // it comes from there
  g.strokeStyle = colour;
  g.lineWidth = width;
  g.beginPath();
  g.moveTo(0, -radius);
  g.lineTo(0, radius * 0.55);
  g.moveTo(-4, radius * 0.55 - 6);
  g.lineTo(0, radius * 0.55);
  g.lineTo(4, radius * 0.55 - 6);
  g.stroke();
  g.restore();
}

// North, wind and swell.
export function drawRose(g, x, y, turn, state) {
  const speed = state.sea?.windSpeed ?? 0;
  g.save();
  g.translate(x, y);
  g.fillStyle = "#02070bb0";
  g.strokeStyle = "#2b475a";
  g.lineWidth = 1;
  g.beginPath();
  g.arc(0, 0, 28, 0, 2 * Math.PI);
  g.fill();
  g.stroke();
  g.rotate(-turn * RAD);
  for (const { direction = 270 } of state.sea?.swell ?? []) {
    arrow(g, 24, direction, "#8f9bff", 1.6);
  }
  if (speed > 0) {
    arrow(g, 24, state.sea.windDirection ?? 270, "#58c9ea", 2.4);
  }
  g.fillStyle = "#ff9d95";
  path(g, [[0, -34], [4, -25], [-4, -25]]);
  g.fill();
  g.restore();
  g.font = "10px system-ui, sans-serif";
  g.textAlign = "right";
  g.fillStyle = "#9fdcf0";
  g.fillText(`wind ${speed.toFixed(1)} m/s`, x + 28, y + 42);
  const swell = state.sea?.swell ?? [];
  if (swell.length > 0) {
    g.fillStyle = "#b3baff";
    g.fillText(`swell ${swell.map((t) => (t.height ?? 1).toFixed(1))
      .join(", ")} m`, x + 28, y + 54);
  }
}
