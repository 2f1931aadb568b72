// A compass rose with the wind, the Sun and the ship.

const SVG = "http://www.w3.org/2000/svg";

function shape(parent, tag, attributes) {
  const node = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) {
    node.setAttribute(name, value);
  }
  parent.append(node);
  return node;
}

const turn = (node, angle) =>
  node.setAttribute("transform", `rotate(${angle})`);

const bearing = (angle) =>
  `${String(Math.round(angle) % 360).padStart(3, "0")}°`;

export class Rose {
  constructor(svg) {
    shape(svg, "circle", { r: 44, class: "ring" });
    for (let angle = 0; angle < 360; angle += 15) {
      const long = angle % 45 === 0;
      shape(svg, "line", { y1: -44, y2: long ? -37 : -41, class: "tick",
        transform: `rotate(${angle})` });
    }
    ["N", "E", "S", "W"].forEach((letter, i) => {
      const a = i * Math.PI / 2;
      shape(svg, "text", { x: 52 * Math.sin(a), y: -52 * Math.cos(a) + 3.5,
        class: "letter" }).textContent = letter;
    });
    this.ship = shape(svg, "path",
      { d: "M0 -20 C7 -10 7 4 5.500 16 L-5.500 16 C-7 4 -7 -10 0 -20Z",
        class: "rose-ship" });
    this.wind = shape(svg, "g", {});
    shape(this.wind, "path",
      { d: "M0 -43 V-24 M-5 -29 L0 -23 L5 -29", class: "rose-wind" });
    this.sun = shape(svg, "g", {});
    shape(this.sun, "circle", { cy: -36, r: 4.5, class: "rose-sun" });
  }

  show({ wind, speed, force, sun, ship }) {
    turn(this.wind, wind);
    document.getElementById("rose-wind").textContent =
      `${bearing(wind)}, ${speed.toFixed(1)} m/s, force ${force}`;
    this.ship.style.display = ship === undefined ? "none" : "";
    turn(this.ship, ship ?? 0);
    document.getElementById("rose-ship").textContent =
      ship === undefined ? "–" : bearing(ship);
    this.sun.style.display = sun === undefined ? "none" : "";
    turn(this.sun, sun ?? 0);
    document.getElementById("rose-sun").textContent =
      sun === undefined ? "by the clock" : `in ${bearing(sun)}`;
  }
}
