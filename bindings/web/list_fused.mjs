// Lists the calls of fused multiply-adds in a program, in a section of its own at the program's end, for bindings/web/npm/fused.js:
// node list_fused.mjs PROGRAM.wasm
import { readFileSync, writeFileSync } from 'node:fs';

const sectionName = 'knead.fused';
const targets = ['knead_fused_floats', 'knead_fused_doubles'];

class Reader {
  constructor(bytes, at = 0) {
    this.bytes = bytes;
    this.at = at;
  }
  byte() {
    return this.bytes[this.at++];
  }
  number() {
    let value = 0;
    for (let shift = 0; ; shift += 7) {
      const byte = this.byte();
      value += (byte & 127) * 2 ** shift;
      if (byte < 128) return value;
    }
  }
  skip(count) {
    for (let i = 0; i < count; ++i) this.number();
  }
  text() {
    const length = this.number();
    this.at += length;
    return new TextDecoder().decode(this.bytes.subarray(this.at - length, this.at));
  }
}

function sectionsOf(bytes) {
  const reader = new Reader(bytes, 8);
  const sections = [];
  while (reader.at < bytes.length) {
    const start = reader.at;
    const id = reader.byte();
    const size = reader.number();
    sections.push({ id, start, begin: reader.at, end: reader.at + size });
    reader.at += size;
  }
  return sections;
}

// The number of the function that is exported under each name.
function exportsOf(bytes, section) {
  const reader = new Reader(bytes, section.begin);
  const found = new Map();
  for (let count = reader.number(); count > 0; --count) {
    const name = reader.text();
    const kind = reader.byte();
    const index = reader.number();
    if (kind === 0) found.set(name, index);
  }
  return found;
}

// Reads past what follows an instruction of the group 0xfd, 0xfc or 0xfe.
function skipGroup(reader, group) {
  const code = reader.number();
  if (group === 0xfc) {
    if (code < 8) return;
    reader.skip([8, 10, 12, 14].includes(code) ? 2 : 1);
  } else if (group === 0xfe) {
    reader.skip(code === 3 ? 1 : 2);
  } else if (code <= 11 || code === 92 || code === 93) {
    reader.skip(2);
  } else if (code === 12 || code === 13) {
    reader.at += 16;
  } else if (code >= 21 && code <= 34) {
    reader.at += 1;
  } else if (code >= 84 && code <= 91) {
    reader.skip(2);
    reader.at += 1;
  } else if (code >= 256) {
    throw new Error(`unknown instruction 0xfd ${code} at ${reader.at}`);
  }
}

// Reads past what follows an instruction, which is no call.
function skipInstruction(reader, code) {
  if ([0x0c, 0x0d, 0x20, 0x21, 0x22, 0x23, 0x24, 0x25, 0x26, 0x3f, 0x40, 0xd2, 0x41, 0x42, 0x02, 0x03, 0x04, 0xd0].includes(code)) {
    reader.skip(1);
  } else if (code === 0x11 || (code >= 0x28 && code <= 0x3e)) {
    reader.skip(2);
  } else if (code === 0x0e || code === 0x1c) {
    const count = reader.number();
    reader.skip(code === 0x0e ? count + 1 : count);
  } else if (code === 0x43) {
    reader.at += 4;
  } else if (code === 0x44) {
    reader.at += 8;
  } else if (code >= 0xfc && code <= 0xfe) {
    skipGroup(reader, code);
  } else if (!(code <= 1 || code === 5 || code === 0x0b || code === 0x0f || code === 0x1a || code === 0x1b ||
               (code >= 0x45 && code <= 0xc4) || code === 0xd1)) {
    throw new Error(`unknown instruction ${code} at ${reader.at}`);
  }
}

// Where the functions are called: a list of places for each.
function callsOf(bytes, section, functions) {
  const reader = new Reader(bytes, section.begin);
  const calls = functions.map(() => []);
  for (let count = reader.number(); count > 0; --count) {
    const size = reader.number();
    const end = reader.at + size;
    for (let locals = reader.number(); locals > 0; --locals) reader.skip(2);
    while (reader.at < end) {
      const at = reader.at;
      const code = reader.byte();
      if (code !== 0x10) {
        skipInstruction(reader, code);
        continue;
      }
      const target = functions.indexOf(reader.number());
      if (target < 0) continue;
      if (reader.at - at !== 3 && reader.at - at !== 4) throw new Error('calls of 3 or 4 bytes are needed');
      calls[target].push(at);
    }
    if (reader.at !== end) throw new Error('a function does not end where it should');
  }
  return calls;
}

function number(value) {
  const bytes = [];
  for (; value >= 128; value = Math.floor(value / 128)) bytes.push((value & 127) | 128);
  return [...bytes, value];
}

// How many calls, how long each is, and how far each is from the one before.
function coded(places, length) {
  const bytes = [...number(places.length), length];
  let last = 0;
  for (const place of places) {
    bytes.push(...number(place - last));
    last = place;
  }
  return bytes;
}

const file = process.argv[2];
const whole = readFileSync(file);
const sections = sectionsOf(whole);
const isOwn = (section) => section.id === 0 && new Reader(whole, section.begin).text() === sectionName;
const bytes = whole.subarray(0, sections.find(isOwn)?.start ?? whole.length);
const names = exportsOf(bytes, sections.find(({ id }) => id === 7));
const functions = targets.map((name) => names.get(name));
if (functions.includes(undefined)) throw new Error(`${file}: ${targets.join(' or ')} is not exported`);
const calls = callsOf(bytes, sections.find(({ id }) => id === 10), functions);
const content = [sectionName.length, ...Buffer.from(sectionName)];
calls.forEach((places, i) => content.push(...coded(places, 1 + number(functions[i]).length)));
writeFileSync(file, Buffer.concat([bytes, Buffer.from([0, ...number(content.length), ...content])]));
console.log(`${file}: ${calls[0].length} fused multiply-adds of floats, ${calls[1].length} of doubles`);
