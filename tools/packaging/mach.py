#!/usr/bin/env python3
"""Says what a program for macOS asks of the system, from the commands in its header:

mach.py FILE      prints the processor, the oldest macOS and the libraries; fails where one is not the system's
"""

import struct
import sys
from pathlib import Path

PROCESSORS = {0x01000007: "x86_64", 0x0100000C: "arm64"}
LOAD_DYLIB, LOAD_WEAK_DYLIB, REEXPORT_DYLIB, RPATH = 0x0C, 0x80000018, 0x8000001F, 0x8000001C
BUILD_VERSION, VERSION_MIN, MAIN, CODE_SIGNATURE = 0x32, 0x24, 0x80000028, 0x1D
SYSTEM = ("/usr/lib/", "/System/Library/")


def commands(data):
    """Yields the number and the bytes of each command."""
    magic, processor, _, kind, count, _, _, _ = struct.unpack_from("<8I", data)
    if magic != 0xFEEDFACF:
        raise SystemExit("mach.py: no program of 64 bits for macOS")
    yield None, (PROCESSORS[processor], kind)
    at = 32
    for _ in range(count):
        number, size = struct.unpack_from("<2I", data, at)
        yield number, data[at : at + size]
        at += size


def version(number):
    return f"{number >> 16}.{number >> 8 & 255}"


def main(path):
    processor, oldest, libraries, signed = "", "", [], False
    for number, body in commands(Path(path).read_bytes()):
        if number is None:
            processor, _ = body
        elif number in (LOAD_DYLIB, LOAD_WEAK_DYLIB, REEXPORT_DYLIB):
            start = struct.unpack_from("<I", body, 8)[0]
            libraries.append(body[start:].split(b"\0")[0].decode())
        elif number == BUILD_VERSION:
            oldest = version(struct.unpack_from("<I", body, 12)[0])
        elif number == VERSION_MIN:
            oldest = version(struct.unpack_from("<I", body, 8)[0])
        elif number == CODE_SIGNATURE:
            signed = True
    foreign = [each for each in libraries if not each.startswith(SYSTEM)]
    if foreign:
        raise SystemExit(f"mach.py: {path} needs {', '.join(foreign)}, which macOS does not have")
    if processor == "arm64" and not signed:
        raise SystemExit(f"mach.py: {path} has no signature, without which no such Mac runs it")
    print(f"{processor}, macOS {oldest}, {', '.join(Path(each).name for each in libraries)}")


main(*sys.argv[1:])
