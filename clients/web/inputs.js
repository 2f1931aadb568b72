// What the state says of the daemon's inputs: those that led and fell silent.

const NAMES = { cigiStale: "CIGI host", modbusStale: "Modbus",
  nmeaStale: "NMEA 0183", consoleStale: "console",
  otherStale: "a client's source" };

// "CIGI host, console", or "".
export const silentInputs = (state) => Object.entries(NAMES)
  .filter(([field]) => state.sources?.[field])
  .map(([, name]) => name).join(", ");
