// The keyboard of a screen, which is open while a text of Studio is edited. What it writes into a hidden field goes to
// Studio as text and as presses of Backspace.

const filler = ' '.repeat(32); // for Backspace to take away
// Of Studio: a press, a release, and the field that they have chosen. A dialog that opens and chooses its field itself
// takes more: it is not covered by a keyboard.
const stepsToEdit = 3;

export class ScreenKeyboard {
  constructor(module, canvas, sendKey) {
    this.module = module;
    this.canvas = canvas;
    this.sendKey = sendKey;
    this.field = document.getElementById('keyboard');
    this.field.addEventListener('input', () => this.take());
  }

  isOpen() {
    return document.activeElement === this.field;
  }

  // Opens or closes it. A browser allows that in the handler of a touch only, so Studio answers the touch at once.
  follow() {
    for (let i = 0; i < stepsToEdit; ++i) this.module._studio_step();
    if (this.module._studio_wants_text() === 0) return this.canvas.focus();
    this.known = this.field.value = filler;
    this.field.focus({ preventScroll: true });
    this.field.setSelectionRange(filler.length, filler.length);
  }

  // Whether the field gets this key: those that write do. A tablet may have a keyboard of keys as well, whose others
  // (arrows, Ctrl+A) are Studio's.
  takes({ key, ctrlKey, metaKey }) {
    const isWriting = Array.from(key).length === 1 || ['Backspace', 'Dead', 'Process', 'Unidentified'].includes(key);
    return this.isOpen() && isWriting && !ctrlKey && !metaKey;
  }

  take() {
    const [before, now] = [Array.from(this.known), Array.from(this.field.value)];
    let same = 0;
    while (same < before.length && before[same] === now[same]) ++same;
    for (let i = same; i < before.length; ++i) for (const down of [1, 0]) this.sendKey('Backspace', down);
    for (const letter of now.slice(same)) this.module._studio_text(letter.codePointAt(0));
    this.known = this.field.value;
  }
}
