"""A pen for Xorg's driver `inputtest`: lines of standard input move a device by its socket.

pen.py SOCKET; a line is "move X Y PRESSURE" (each from 0 to 1), "press", "release" or "sleep SECONDS". The protocol is
that of xf86-input-inputtest-protocol.h, version 1.1.
"""

import socket
import struct
import sys
import time

FULL = 65535  # of the axes x and y
MOST_PRESSURE = 1000
PRESSURE_AXIS = 4
VALUATORS = 64
CLIENT_VERSION, WAIT_FOR_SYNC, MOTION, _PROXIMITY, BUTTON = range(5)


def valuators(values):
    """The struct xf86ITValuatorData with these values by axis."""
    mask = bytearray(VALUATORS // 8)
    numbers = [0.0] * (2 * VALUATORS)
    for axis, value in values.items():
        mask[axis // 8] |= 1 << (axis % 8)
        numbers[axis] = value
    return struct.pack("<I8s4x", 0, bytes(mask)) + struct.pack(f"<{2 * VALUATORS}d", *numbers)


class Pen:
    """The connection to the driver."""

    def __init__(self, path):
        self.socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self.socket.connect(path)
        self.send(CLIENT_VERSION, struct.pack("<HH", 1, 1))
        self.receive()

    def send(self, kind, body):
        self.socket.sendall(struct.pack("<II", 8 + len(body), kind) + body)

    def receive(self):
        length, _ = struct.unpack("<II", self.socket.recv(8, socket.MSG_WAITALL))
        if length > 8:
            self.socket.recv(length - 8, socket.MSG_WAITALL)

    def sync(self):
        self.send(WAIT_FOR_SYNC, b"")
        self.receive()

    def move(self, x, y, pressure):
        axes = {0: FULL * x, 1: FULL * y, PRESSURE_AXIS: MOST_PRESSURE * pressure}
        self.send(MOTION, struct.pack("<I4x", 1) + valuators(axes))
        self.sync()

    def button(self, is_down):
        self.send(BUTTON, struct.pack("<iiI4x", 0, 1, is_down) + valuators({}))
        self.sync()


def main():
    pen = Pen(sys.argv[1])
    for line in sys.stdin:
        word, *numbers = line.split()
        if word == "move":
            pen.move(*map(float, numbers))
        elif word in ("press", "release"):
            pen.button(word == "press")
        elif word == "sleep":
            time.sleep(float(numbers[0]))
        else:
            sys.exit(f"pen.py: unknown word {word}")


main()
