"""Interrupts every subcommand at random moments: it must end within half a second, with the code of an interruption or
with its whole result, and leave the file that was there before, or the new one, and no other. Run by hand:

    KNEAD=build/release/knead python3 tests/surveys/interruptions.py [--moments 100] [--seed 1] [--limit 0.5]

The moments lie between the start of a command and its end. Prints the slowest end of each command.
"""

import argparse
import hashlib
import json
import os
import pathlib
import random
import signal
import subprocess
import sys
import tempfile
import time

KNEAD = pathlib.Path(os.environ.get("KNEAD", "knead")).resolve()
SESSIONS = {
    "pull": [{"tool": "implicit", "inner": 0.2, "outer": 0.9, "path": [[0, 0, 1], [0, 0.3, 1.6], [0, 0.8, 1.9]]}],
    "slip": [
        {
            "tool": "stamp",
            "mesh": "small.ply",
            "contact": "slip",
            "pose": [[0.3, 0, 0], [0, 0.3, 0], [0, 0, 0.3]],
            "path": [[0, 0, 1.32], [0, 0, 1.2], [0.8, 0, 0.9], [1.2, 0, 0]],
        }
    ],
    "pins": [
        {
            "tool": "pins",
            "radius": 0.6,
            "points": [[x / 9 - 0.5, y / 9 - 0.5, 0.8] for x in range(10) for y in range(10)],
            "to": [[x / 9 - 0.5, y / 9 - 0.5, 0.9 + 0.01 * x] for x in range(10) for y in range(10)],
        }
    ],
}  # fmt: skip
# Words of a command; the last one is the file that it writes, if it writes one.
COMMANDS = {
    "deform": "deform large.ply pull.knead -q -o o.ply",
    "deform, double": "deform large.ply pull.knead --precision double --tolerance 1e-9 -q -o o.ply",
    "deform, checked": "deform ball.ply pull.knead --require volume=1e-3,crossings=0 -q -o o.ply",
    "deform, remeshed": "deform ball.ply pull.knead --remesh -q -o o.ply",
    "deform, frames": "deform ball.ply pull.knead --frames 60 -q -o o.glb",
    "deform, slipping": "deform large.ply slip.knead -q -o o.ply",
    "deform, pins": "deform large.ply pins.knead -q -o o.ply",
    "resolve": "resolve ball.ply slip.knead -o o.knead",
    "fit": "fit ball.ply pulled.ply --surface -q -o o.knead",
    "remesh": "remesh ball.ply --max-edge 0.01 -q -o o.ply",
    "make": "make sphere -n 3000000 -q -o o.ply",
    "render": "render ball.ply --session pull.knead --until 0,1 --size 800x600 -q -o o.png",
    "film": "render ball.ply --session pull.knead --frames 6 --size 160x120 -q -o o.gif",
    "info": "info large.ply",
    "check": "check large.ply",
    "bench": "bench",
}


def digests(folder):
    return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in folder.iterdir()}


def interrupted(folder, words, moment):
    """Sends SIGINT or SIGTERM after so many seconds. Returns the exit code and the seconds until the end."""
    process = subprocess.Popen([KNEAD, *words], cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    time.sleep(moment)
    process.send_signal(random.choice([signal.SIGINT, signal.SIGTERM]))
    began = time.perf_counter()
    code = process.wait(timeout=60)
    return code, time.perf_counter() - began


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--moments", type=int, default=100, help="of all commands together")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--limit", type=float, default=0.5, help="seconds")
    parser.add_argument("--longest", type=float, default=60, help="seconds that a command is let run")
    options = parser.parse_args()
    random.seed(options.seed)
    failures = 0
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for shape, vertices in {"small": 2562, "ball": 40_000, "large": 1_000_000}.items():
            subprocess.run([KNEAD, "make", "sphere", "-n", str(vertices), "-q", "-o", folder / f"{shape}.ply"], check=True)
        for session, strokes in SESSIONS.items():
            (folder / f"{session}.knead").write_text("\n".join(map(json.dumps, [{"knead": 1}, *strokes])) + "\n")
        pull = [KNEAD, "deform", "ball.ply", "pull.knead", "-q", "-o", "pulled.ply"]
        subprocess.run(pull, cwd=folder, check=True)
        for command, text in COMMANDS.items():
            words = text.split()
            written = words[-1] if "-o" in words else None
            process = subprocess.Popen([KNEAD, *words], cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            began = time.perf_counter()
            try:
                process.wait(options.longest)
            except subprocess.TimeoutExpired:
                process.terminate()
                process.wait()
            length = time.perf_counter() - began
            result = digests(folder)
            ends = []
            for _ in range(max(1, round(options.moments / len(COMMANDS)))):
                if written:
                    (folder / written).write_text("old")
                before = digests(folder)
                code, seconds = interrupted(folder, words, random.uniform(0, length))
                after = digests(folder)
                is_kept = after == before
                is_whole = written is None or after == {**before, written: result.get(written)}
                is_right = is_kept and code in (130, -signal.SIGINT, -signal.SIGTERM) or is_whole and code == 0
                if not is_right or seconds > options.limit:
                    failures += 1
                    changed = sorted(key for key in {*before, *after} if before.get(key) != after.get(key))
                    print(f"{command}: code {code} after {seconds:.2f} s, changed {changed}", flush=True)
                ends.append(seconds)
            print(f"{command:17} runs {length:5.1f} s; {len(ends)} ends, the slowest {max(ends):.2f} s", flush=True)
    print(f"{failures} of the ends were late or left something behind")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
