// Pictures in H.264 (Annex B, no B frames) as an MP4 file, ISO 14496-12 and
// -15: one track, one sample a picture, its place in time by its stamp.

const SCALE = 90000; // ticks a second
const encoder = new TextEncoder();

const u16 = (v) => [v >> 8 & 255, v & 255];
const u32 = (v) => [v >>> 24, v >>> 16 & 255, v >>> 8 & 255, v & 255];
const zeros = (n) => new Array(n).fill(0);
const MATRIX = [0x10000, 0, 0, 0, 0x10000, 0, 0, 0, 0x40000000].flatMap(u32);

function joined(parts) {
  const out = new Uint8Array(parts.reduce((n, p) => n + p.length, 0));
  let at = 0;
  for (const part of parts) {
    out.set(part, at);
    at += part.length;
  }
  return out;
}

function box(type, ...parts) {
  const body = joined(parts.map((p) => Uint8Array.from(p)));
  return joined([u32(body.length + 8), encoder.encode(type), body]);
}
const full = (type, flags, ...parts) => box(type, u32(flags), ...parts);

// The NAL units of an access unit in Annex B.
export function units(data) {
  const starts = [];
  for (let i = 0; i + 2 < data.length; i++) {
    if (data[i] === 0 && data[i + 1] === 0 && data[i + 2] === 1) {
      starts.push(i);
      i += 2;
    }
  }
  return starts.map((start, n) => {
    let end = starts[n + 1] ?? data.length;
    while (n + 1 < starts.length && data[end - 1] === 0) {
      end--; // a start code of four bytes
    }
    return data.subarray(start + 3, end);
  }).filter((unit) => unit.length > 0);
}

const kindOf = (unit) => unit[0] & 31;
const SPS = 7;
const PPS = 8;
const DELIMITER = 9;

// SPS and PPS of a key frame as one text, to see whether they have changed.
export const setsOf = (data) => units(data)
  .filter((unit) => [SPS, PPS].includes(kindOf(unit))).join(";");

// A sample: its units with their lengths, without those that stand in avcC.
const sample = (data) => joined(units(data)
  .filter((unit) => ![SPS, PPS, DELIMITER].includes(kindOf(unit)))
  .flatMap((unit) => [u32(unit.length), unit]));

function avcC(data) {
  const all = units(data);
  const sps = all.find((unit) => kindOf(unit) === SPS);
  const pps = all.find((unit) => kindOf(unit) === PPS);
  if (!sps || !pps) {
    throw new Error("the stream's first picture has no parameters");
  }
  return box("avcC", [1, sps[1], sps[2], sps[3], 0xff, 0xe1],
    u16(sps.length), sps, [1], u16(pps.length), pps);
}

// Ticks from each picture to the next; the last as long as the mean.
function durations(pictures) {
  const at = pictures.map((p) => Math.round((p.stampMs - pictures[0].stampMs) *
    SCALE / 1000));
  const each = at.slice(1).map((t, i) => Math.max(1, t - at[i]));
  const mean = each.length === 0 ? SCALE / 30
    : Math.round(at.at(-1) / each.length) || 1;
  return [...each, mean];
}

// pictures: {data, key, stampMs}, the first of them a key frame.
export function mp4(pictures, width, height) {
  const samples = pictures.map((p) => sample(p.data));
  const each = durations(pictures);
  const length = each.reduce((a, b) => a + b, 0);
  const keys = pictures.flatMap((p, i) => p.key ? [i + 1] : []);
  const ftyp = box("ftyp", encoder.encode("isom"), u32(512),
    encoder.encode("isomiso2avc1mp41"));
  const entry = box("avc1", zeros(6), u16(1), zeros(16), u16(width),
    u16(height), u32(0x480000), u32(0x480000), zeros(4), u16(1), zeros(32),
    u16(24), u16(0xffff), avcC(pictures[0].data));
  const table = (offset) => box("stbl",
    full("stsd", 0, u32(1), entry),
    full("stts", 0, u32(each.length), each.flatMap((d) => [...u32(1), ...u32(d)])),
    full("stss", 0, u32(keys.length), keys.flatMap(u32)),
    full("stsc", 0, u32(1), u32(1), u32(samples.length), u32(1)),
    full("stsz", 0, u32(0), u32(samples.length),
      samples.flatMap((s) => u32(s.length))),
    full("stco", 0, u32(1), u32(offset)));
  const media = (offset) => box("mdia",
    full("mdhd", 0, zeros(8), u32(SCALE), u32(length), u16(0x55c4), u16(0)),
    full("hdlr", 0, zeros(4), encoder.encode("vide"), zeros(12),
      encoder.encode("Pelagos\0")),
    box("minf", full("vmhd", 1, zeros(8)),
      box("dinf", full("dref", 0, u32(1), full("url ", 1))), table(offset)));
  const movie = (offset) => box("moov",
    full("mvhd", 0, zeros(8), u32(SCALE), u32(length), u32(0x10000), u16(0x100),
      zeros(10), MATRIX, zeros(24), u32(2)),
    box("trak", full("tkhd", 3, zeros(8), u32(1), zeros(4), u32(length),
      zeros(16), MATRIX, u16(width), u16(0), u16(height), u16(0)),
    media(offset)));
  const before = ftyp.length + movie(0).length;
  const data = samples.reduce((n, s) => n + s.length, 0);
  return new Blob([ftyp, movie(before + 8), Uint8Array.from(u32(data + 8)),
    encoder.encode("mdat"), ...samples], { type: "video/mp4" });
}
