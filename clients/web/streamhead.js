// The header of a live picture: see proto/live.md.

const KEY = 1;
const STALE = 4;
const POSES = 8;
const GROUND = 16;

export function readHead(buffer) {
  const at = new DataView(buffer);
  const flags = at.getUint8(2);
  return {
    version: at.getUint8(0),
    kind: at.getUint8(1),
    key: (flags & KEY) !== 0,
    size: at.getUint8(3),
    width: at.getUint16(4, true),
    height: at.getUint16(6, true),
    number: at.getBigUint64(8, true),
    time: at.getFloat64(16, true),
    stampMs: Number(at.getBigUint64(32, true)) / 1000,
    stale: (flags & STALE) !== 0,
    poses: (flags & POSES) !== 0,
    ground: (flags & GROUND) !== 0,
    host: Number(at.getBigUint64(24, true)),
    missed: at.getUint32(52, true),
    // When all views of the frame are to be shown, by the server's clock.
    presentMs: Number(at.getBigUint64(64, true)) / 1000,
    // Of what was rendered; later versions of the header have it.
    drawn: at.getUint8(3) >= 80
      ? [at.getUint16(72, true), at.getUint16(74, true)] : null,
  };
}
