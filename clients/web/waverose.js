// A rose of S(ω, θ): direction the waves come from around, frequency outward,
// how much there is by colour.

const MOST_HZ = 0.4;
const RINGS_HZ = [0.1, 0.2, 0.3, 0.4];
const LEAST = 0.004; // of the highest; below that, nothing
const STEPS = ["#0b2a3d", "#12506b", "#1c7f9c", "#3bb3d6", "#8fd9c8", "#ffe08a",
  "#ffb067"];

// The colour of a share 0..1, of its logarithm.
function paint(share) {
  const x = 1 + Math.log(Math.max(share, LEAST)) / -Math.log(LEAST);
  return STEPS[Math.min(STEPS.length - 1, Math.floor(x * STEPS.length))];
}

// Twice between any two directions, linearly.
function finer(list) {
  return list.flatMap((a, i) => {
    const b = list[(i + 1) % list.length];
    return [a, (2 * a + b) / 3, (a + 2 * b) / 3];
  });
}

export class WaveRose {
  constructor(canvas) {
    this.canvas = canvas;
    this.rows = [];
  }

  set(rows) {
    this.rows = rows.filter((row) => row.directional?.length > 0)
      .map(({ omega, directional }) => ({ omega,
        directional: finer(directional) }));
    this.draw();
  }

  draw() {
    const { canvas } = this;
    const side = Math.min(canvas.clientWidth, 260);
    if (side < 60) {
      return;
    }
    const ratio = Math.min(devicePixelRatio || 1, 2);
    canvas.width = canvas.height = Math.round(side * ratio);
    const g = canvas.getContext("2d");
    g.setTransform(ratio, 0, 0, ratio, 0, 0);
    g.clearRect(0, 0, side, side);
    g.translate(side / 2, side / 2);
    this.radius = side / 2 - 16;
    this.sectors(g);
    this.frame(g);
  }

  sectors(g) {
    const { rows, radius } = this;
    const most = Math.max(...rows.map((row) => Math.max(...row.directional)), 0);
    const out = (omega) => radius * omega / (2 * Math.PI) / MOST_HZ;
    if (!(most > 0)) {
      return;
    }
    rows.forEach((row, i) => {
      const inner = out(i > 0 ? Math.sqrt(rows[i - 1].omega * row.omega)
        : row.omega);
      const outer = Math.min(radius, out(i + 1 < rows.length
        ? Math.sqrt(rows[i + 1].omega * row.omega) : row.omega));
      if (inner >= radius) {
        return;
      }
      const n = row.directional.length;
      row.directional.forEach((density, k) => {
        if (density > LEAST * most) {
          const middle = 2 * Math.PI * k / n - Math.PI / 2;
          const half = Math.PI / n + 0.006; // no seams
          g.beginPath();
          g.arc(0, 0, outer + 0.4, middle - half, middle + half);
          g.arc(0, 0, inner, middle + half, middle - half, true);
          g.fillStyle = paint(density / most);
          g.fill();
        }
      });
    });
  }

  frame(g) {
    const style = getComputedStyle(this.canvas);
    const { radius } = this;
    g.strokeStyle = style.getPropertyValue("--edge") || "#345";
    g.fillStyle = style.color;
    g.font = "11px system-ui, sans-serif";
    g.textAlign = "center";
    g.textBaseline = "middle";
    g.lineWidth = 1;
    for (const hz of RINGS_HZ) {
      g.beginPath();
      g.arc(0, 0, radius * hz / MOST_HZ, 0, 2 * Math.PI);
      g.stroke();
      g.fillText(hz === MOST_HZ ? `${hz} Hz` : String(hz),
        0.71 * radius * hz / MOST_HZ + 3, 0.71 * radius * hz / MOST_HZ);
    }
    ["N", "E", "S", "W"].forEach((name, i) => {
      const a = i * Math.PI / 2;
      g.beginPath();
      g.moveTo(0, 0);
      g.lineTo(radius * Math.sin(a), -radius * Math.cos(a));
      g.stroke();
      g.fillText(name, (radius + 8) * Math.sin(a), -(radius + 8) * Math.cos(a));
    });
  }
}
