// The client of tests/modbus_test.py by npm's modbus-serial:
//   node modbus_serial.js PORT UNIT OUT.json
// It reads the probe, writes wind and heading, commits, is refused three
// times, and says what it saw as JSON.
"use strict";

const path = require("path");
const ModbusRTU = require(path.join(
  __dirname, "..", "build", "npm", "node_modules", "modbus-serial"));

const [port, unit] = process.argv.slice(2, 4).map(Number);
const WIND = 10, COMMIT = 5, HEADING = 64;

function floats(...values) {
  const buffer = Buffer.alloc(4 * values.length);
  values.forEach((v, i) => buffer.writeFloatBE(v, 4 * i));
  return Array.from({ length: 2 * values.length },
    (_, i) => buffer.readUInt16BE(2 * i));
}

async function refusal(promise) {
  try {
    await promise;
    return 0;
  } catch (error) {
    return error.modbusCode || String(error);
  }
}

async function main() {
  const client = new ModbusRTU();
  await client.connectTCP("127.0.0.1", { port });
  client.setID(unit);
  client.setTimeout(5000);
  const out = {};
  const probe = await client.readInputRegisters(0, 4);
  out.probe = [probe.buffer.readUInt32BE(0), probe.buffer.readFloatBE(4)];
  await client.writeRegisters(WIND, floats(7.25, 100));
  await client.writeRegisters(HEADING, floats(33.5));
  await client.writeRegister(COMMIT, 1);
  out.wind = (await client.readHoldingRegisters(WIND, 2)).buffer.readFloatBE(0);
  out.alarms = (await client.readDiscreteInputs(0, 5)).data.slice(0, 5);
  await client.writeCoil(0, true);
  out.coils = (await client.readCoils(0, 2)).data.slice(0, 2);
  await client.writeRegister(COMMIT, 0);
  out.refused = [
    await refusal(client.writeRegisters(WIND, floats(99))),
    await refusal(client.writeRegister(6, 1)),
    await refusal(client.readHoldingRegisters(5000, 20)),
  ];
  // Many at once, on one connection.
  const many = await Promise.all(Array.from({ length: 50 },
    () => client.readInputRegisters(2, 2)));
  out.many = many.filter((m) => m.buffer.readFloatBE(0) === 3.5).length;
  client.close(() => {});
  process.stdout.write(JSON.stringify(out) + "\n");
}

main().catch((error) => {
  process.stderr.write(error.stack + "\n");
  process.exitCode = 1;
});
