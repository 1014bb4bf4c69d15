// Fused multiply-adds as single instructions, where the browser and its processor have them: they give the same bits as
// the functions of the library that compose them, and are many times faster.

const instructions = [[0xfd, 0x85, 0x02], [0xfd, 0x87, 0x02]]; // relaxed_madd of f32x4 and f64x2
const nothing = 0x01;

// f() = a b + c by an instruction, of numbers where rounding twice gives 0.
function probe(instruction, numbers, extract, type) {
  const constant = (number) => [0xfd, 0x0c, ...new Uint8Array(numbers.of(...Array(16 / numbers.BYTES_PER_ELEMENT).fill(number)).buffer)];
  const small = numbers === Float32Array ? 2 ** -13 : 2 ** -30;
  const body = [0, ...constant(1 + small), ...constant(1 - small), ...constant(-1), ...instruction, 0xfd, extract, 0, 0x0b];
  const sections = [[1, 1, 0x60, 0, 1, type], [3, 1, 0], [7, 1, 1, 0x66, 0, 0], [10, 1, body.length, ...body]];
  const program = sections.flatMap(([id, ...content]) => [id, content.length, ...content]);
  const bytes = Uint8Array.of(0, 0x61, 0x73, 0x6d, 1, 0, 0, 0, ...program);
  return WebAssembly.validate(bytes) && new WebAssembly.Instance(new WebAssembly.Module(bytes)).exports.f() === -(small ** 2);
}

let known;
// Whether single instructions round once here.
export function hasFused() {
  known ??= probe(instructions[0], Float32Array, 0x1f, 0x7d) && probe(instructions[1], Float64Array, 0x21, 0x7c);
  return known;
}

class Reader {
  constructor(bytes, at) {
    this.bytes = bytes;
    this.at = at;
  }
  number() {
    let value = 0;
    for (let shift = 0; ; shift += 7) {
      const byte = this.bytes[this.at++];
      value += (byte & 127) * 2 ** shift;
      if (byte < 128) return value;
    }
  }
}

// Where the program's last section begins, in which `./dev web` has listed the calls.
function listOf(bytes) {
  const reader = new Reader(bytes, 8);
  let begin = 0;
  while (reader.at < bytes.length) {
    reader.at += 1;
    const size = reader.number();
    begin = reader.at;
    reader.at += size;
  }
  const name = 'knead.fused';
  const found = new TextDecoder().decode(bytes.subarray(begin + 1, begin + 1 + name.length));
  return found === name ? new Reader(bytes, begin + 1 + name.length) : null;
}

// Returns the program as this browser runs it fastest; changes the bytes.
export function withFused(program) {
  const bytes = new Uint8Array(program);
  const list = hasFused() ? listOf(bytes) : null;
  if (list === null) return bytes;
  for (const instruction of instructions) {
    const count = list.number();
    const length = list.number();
    for (let i = 0, at = 0; i < count; ++i) {
      at += list.number();
      bytes.set(instruction, at);
      bytes.fill(nothing, at + instruction.length, at + length);
    }
  }
  return bytes;
}
