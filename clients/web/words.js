// Values of the schema's enums, and built-in models, in words, one way
// everywhere: a capital first, proper names as they are written.

const NAMES = { PIERSON_MOSKOWITZ: "Pierson–Moskowitz", JONSWAP: "JONSWAP",
  TMA: "TMA", FFT: "FFT cascades", OMEGA2: "ω⁻²", MEASURED: "A buoy's record",
  NORTH_ATLANTIC: "North Atlantic", BALTIC: "Baltic", TROPICAL: "Tropical",
  FREE: "With the wall clock", PACED: "Frame by frame",
  STEPPED: "By steps only", HOST: "As a simulator says",
  I: "I", IA: "IA", IB: "IB", II: "II", III: "III",
  C1: "1C", C3: "3C", C5: "5C", C7: "7C", C9: "9C",
  APART: "Apart from it", IN_THE_PICTURE: "In the picture",
  NONE_SEEN: "None is seen", rib: "RIB", usv: "USV" };

export function words(name) {
  const plain = name.toLowerCase().replace(/[_-]/g, " ")
    .replace(/ ([ab])$/, (region) => region.toUpperCase()); // IALA's
  return NAMES[name] ?? plain.charAt(0).toUpperCase() + plain.slice(1);
}

// What Beaufort numbers and degrees of Douglas's scale are called (WMO).
export const BEAUFORT = ["calm", "light air", "light breeze", "gentle breeze",
  "moderate breeze", "fresh breeze", "strong breeze", "near gale", "gale",
  "strong gale", "storm", "violent storm", "hurricane"];
export const DOUGLAS = ["glassy", "rippled", "smooth", "slight", "moderate",
  "rough", "very rough", "high", "very high", "phenomenal"];
