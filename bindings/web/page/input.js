// Pointer, touch and keys of the page, as calls of Studio's functions (apps/studio/platform/web/window.cpp).
import { ScreenKeyboard } from './keyboard.js';

const codes = {
  BracketLeft: '[', BracketRight: ']', Comma: ',', Period: '.', Slash: '/', Semicolon: ';', Quote: "'", Backquote: '`',
  Minus: '-', Equal: '=', Backslash: '\\', Space: 'Space', Escape: 'Escape', Enter: 'Enter', Tab: 'Tab',
  Backspace: 'Backspace', Insert: 'Insert', Delete: 'Delete', ArrowRight: 'Right', ArrowLeft: 'Left', ArrowDown: 'Down',
  ArrowUp: 'Up', PageUp: 'Page Up', PageDown: 'Page Down', Home: 'Home', End: 'End', Pause: 'Pause',
  NumpadDecimal: 'Numpad .', NumpadDivide: 'Numpad /', NumpadMultiply: 'Numpad *', NumpadSubtract: 'Numpad -',
  NumpadAdd: 'Numpad +', NumpadEnter: 'Numpad Enter', ShiftLeft: 'Shift', ShiftRight: 'Shift', ControlLeft: 'Ctrl',
  ControlRight: 'Ctrl', MetaLeft: 'Ctrl', MetaRight: 'Ctrl', AltLeft: 'Alt', AltRight: 'Alt', ContextMenu: 'Menu',
};

// The name that Studio has for a key (keys.h): a letter is the one that the keyboard's layout gives, all else goes by
// its place.
function keyName({ key, code }) {
  if (/^[a-z]$/i.test(key)) return key.toUpperCase();
  if (/^Key[A-Z]$/.test(code)) return code[3];
  if (/^Digit\d$/.test(code)) return code[5];
  if (/^Numpad\d$/.test(code)) return `Numpad ${code[6]}`;
  if (/^F\d+$/.test(code)) return code;
  return codes[code] ?? '';
}

const modifiersOf = (event) =>
  (event.shiftKey ? 1 : 0) | (event.ctrlKey || event.metaKey ? 2 : 0) | (event.altKey ? 4 : 0);

const left = 0;
const middle = 1;
const buttons = [left, middle, 2]; // a browser's, as Studio's MouseButton
const shift = 1;
const ctrl = 2;
const doublePress = { ms: 400, pixels: 6 };
const touchSlop = 6; // CSS pixels: a finger that has moved less may still become one of two
const touchWait = 130; // ms
const doubleTap = { ms: 400, pixels: 24 };
const tapTime = 350; // ms from the first finger's press to the last one's release
const zoomOfStep = 1.15; // of Studio's wheel

export class Input {
  constructor(module, canvas) {
    this.module = module;
    this.canvas = canvas;
    this.keyboard = new ScreenKeyboard(module, canvas, (name, down) => this.sendKey(name, down, 0));
    this.fingers = new Map();
    this.first = null; // the finger that holds the left button: where it pressed, how far it has moved
    this.scale = 1;
    this.listen();
  }

  // Of the picture, in its pixels.
  place(event) {
    const box = this.canvas.getBoundingClientRect();
    return [(event.clientX - box.left) * this.scale, (event.clientY - box.top) * this.scale];
  }

  listen() {
    const on = (name, handle, target = this.canvas) => target.addEventListener(name, handle, { passive: false });
    on('pointerdown', (event) => this.pointerDown(event));
    on('pointermove', (event) => this.pointerMove(event));
    on('pointerup', (event) => this.pointerUp(event));
    on('pointercancel', (event) => this.pointerUp(event));
    on('contextmenu', (event) => event.preventDefault());
    on('wheel', (event) => {
      event.preventDefault();
      const lines = event.deltaMode === 0 ? event.deltaY / 100 : event.deltaY / 3;
      this.module._studio_wheel(-Math.max(-3, Math.min(3, lines)), modifiersOf(event));
    });
    on('keydown', (event) => this.key(event, 1), window);
    on('keyup', (event) => this.key(event, 0), window);
  }

  key(event, down) {
    if (this.keyboard.takes(event)) return;
    const name = keyName(event);
    if (name !== '') this.sendKey(name, down, modifiersOf(event));
    const isText = event.key.length === 1 && !event.ctrlKey && !event.metaKey;
    if (down && isText) this.module._studio_text(event.key.codePointAt(0));
    // Reloading, closing and the browser's own tools stay with the browser.
    const isBrowsers = /^F(5|11|12)$/.test(event.key) || (modifiersOf(event) & 2 && /^[rtw]$/i.test(event.key));
    if (!isBrowsers) event.preventDefault();
  }

  move(x, y, pressure, modifiers) {
    this.module._studio_pointer(x, y, pressure, modifiers);
  }

  press(button, down, x, y, modifiers, isDouble = false) {
    this.module._studio_button(button, down, x, y, modifiers, isDouble ? 1 : 0);
  }

  isSecondPress(event, x, y) {
    const last = this.lastPress;
    const { ms, pixels } = event.pointerType === 'touch' ? doubleTap : doublePress;
    const isDouble = last && event.timeStamp - last.time < ms && Math.hypot(x - last.x, y - last.y) < pixels * this.scale;
    this.lastPress = isDouble ? null : { time: event.timeStamp, x, y };
    return Boolean(isDouble);
  }

  pointerDown(event) {
    event.preventDefault();
    if (event.pointerType !== 'touch') this.canvas.focus();
    try {
      this.canvas.setPointerCapture(event.pointerId);
    } catch {
      // an event that a script made
    }
    if (event.pointerType === 'touch') return this.fingerDown(event);
    const [x, y] = this.place(event);
    this.move(x, y, this.pressure(event), modifiersOf(event));
    const isDouble = event.button === 0 && this.isSecondPress(event, x, y);
    this.press(buttons[event.button] ?? -1, 1, x, y, modifiersOf(event), isDouble);
  }

  pointerMove(event) {
    if (event.pointerType === 'touch') return this.fingerMove(event);
    const [x, y] = this.place(event);
    this.move(x, y, this.pressure(event), modifiersOf(event));
  }

  pointerUp(event) {
    if (event.pointerType === 'touch') return this.fingerUp(event);
    const [x, y] = this.place(event);
    this.press(buttons[event.button] ?? -1, 0, x, y, modifiersOf(event));
  }

  pressure(event) {
    return event.pointerType === 'pen' && event.pressure > 0 ? event.pressure : 1;
  }

  // One finger is the left button. Two orbit and pinch, three pan; a tap of two undoes, of three redoes. The press of a
  // first finger waits a moment: if a second one comes, Studio never gets it. If the second one comes later, Studio
  // gives up what the first has begun, unless it has moved. On a panel that scrolls, the press waits until the finger
  // moves, upwards or downwards to scroll, or is lifted.
  fingerDown(event) {
    const [x, y] = this.place(event);
    this.fingers.set(event.pointerId, { x, y, x0: x, y0: y });
    if (this.fingers.size === 1) this.tap = { since: event.timeStamp, fingers: 1, isStill: true };
    this.tap.fingers = Math.max(this.tap.fingers, this.fingers.size);
    if (this.fingers.size === 1) {
      this.move(x, y, 1, modifiersOf(event));
      const first = { x, y, isDouble: this.isSecondPress(event, x, y), modifiers: modifiersOf(event) };
      const scrolls = this.module._studio_scroll(x, y, 0) !== 0;
      this.waiting = { ...first, scrolls, timer: scrolls ? 0 : setTimeout(() => this.sendFirst(), touchWait) };
    } else if (!this.first || this.giveUpFirst()) {
      this.dropWaiting();
      this.endView();
      this.beginView();
    }
  }

  dropWaiting() {
    if (this.waiting) clearTimeout(this.waiting.timer);
    this.waiting = null;
  }

  sendFirst() {
    if (!this.waiting) return;
    const { x, y, modifiers, isDouble } = this.waiting;
    this.dropWaiting();
    this.first = { x, y, moved: 0 };
    this.press(left, 1, x, y, modifiers, isDouble);
  }

  giveUpFirst() {
    const { x, y, moved } = this.first;
    if (moved > touchSlop * this.scale) return false;
    for (const down of [1, 0]) this.sendKey('Escape', down, 0);
    this.press(left, 0, x, y, 0);
    this.first = null;
    return true;
  }

  sendKey(name, down, modifiers) {
    this.module.ccall('studio_key', null, ['string', 'number', 'number'], [name, down, modifiers]);
  }

  middleOfFingers() {
    const all = [...this.fingers.values()];
    const x = all.reduce((sum, finger) => sum + finger.x, 0) / all.length;
    const y = all.reduce((sum, finger) => sum + finger.y, 0) / all.length;
    return { x, y, spread: Math.hypot(all[0].x - all[1].x, all[0].y - all[1].y) };
  }

  beginView() {
    const at = this.middleOfFingers();
    this.view = { spread: at.spread, modifiers: this.fingers.size > 2 ? shift : 0 };
    this.move(at.x, at.y, 1, this.view.modifiers);
    this.press(middle, 1, at.x, at.y, this.view.modifiers);
  }

  endView() {
    if (!this.view) return;
    this.press(middle, 0, this.view.x ?? 0, this.view.y ?? 0, this.view.modifiers);
    this.view = null;
  }

  fingerMove(event) {
    const finger = this.fingers.get(event.pointerId);
    if (!finger) return;
    [finger.x, finger.y] = this.place(event);
    if (Math.hypot(finger.x - finger.x0, finger.y - finger.y0) > touchSlop * this.scale) this.tap.isStill = false;
    if (this.view) return this.moveView();
    if (this.scrolled) return this.scroll(finger.y);
    const waiting = this.waiting;
    if (waiting && Math.hypot(finger.x - waiting.x, finger.y - waiting.y) > touchSlop * this.scale) {
      if (waiting.scrolls && Math.abs(finger.y - waiting.y) > Math.abs(finger.x - waiting.x)) return this.beginScroll(finger.y);
      this.sendFirst();
    }
    if (!this.first) return;
    this.first.moved = Math.max(this.first.moved, Math.hypot(finger.x - this.first.x, finger.y - this.first.y));
    this.move(finger.x, finger.y, 1, modifiersOf(event));
  }

  beginScroll(y) {
    this.scrolled = { x: this.waiting.x, y: this.waiting.y, last: this.waiting.y };
    this.dropWaiting();
    this.scroll(y);
  }

  scroll(y) {
    this.move(this.scrolled.x, this.scrolled.y, 1, 0);
    this.module._studio_scroll(this.scrolled.x, this.scrolled.y, y - this.scrolled.last);
    this.scrolled.last = y;
  }

  moveView() {
    const at = this.middleOfFingers();
    Object.assign(this.view, { x: at.x, y: at.y });
    this.move(at.x, at.y, 1, this.view.modifiers);
    const steps = Math.log(at.spread / this.view.spread) / Math.log(zoomOfStep);
    if (Math.abs(steps) < 0.2) return;
    this.view.spread = at.spread;
    this.module._studio_wheel(steps, 0);
  }

  fingerUp(event) {
    const finger = this.fingers.get(event.pointerId);
    if (!finger) return;
    this.sendFirst();
    this.fingers.delete(event.pointerId);
    if (this.first && this.fingers.size === 0) {
      this.press(left, 0, finger.x, finger.y, modifiersOf(event));
      this.first = null;
    }
    if (this.fingers.size < 2) this.endView();
    if (this.fingers.size > 0) return;
    this.scrolled = null;
    this.module._studio_lift();
    if (this.tap.isStill || this.keyboard.isOpen()) this.keyboard.follow();
    if (event.type === 'pointerup') this.endTap(event.timeStamp);
  }

  endTap(now) {
    if (!this.tap.isStill || this.tap.fingers < 2 || now - this.tap.since > tapTime) return;
    for (const down of [1, 0]) this.sendKey('Z', down, this.tap.fingers === 2 ? ctrl : ctrl | shift);
  }
}
