"""Ctrl-C, the GIL, and what a call leaves behind."""

import subprocess
import sys
import textwrap

import pytest

import knead

LONG = """
    import signal, sys, threading, time, os
    import numpy as np
    import knead
    strokes = [knead.Implicit(path=[[0, 0, 0], [0.3 * (-1) ** i, 0, 0]], inner=0.1, outer=1) for i in range(20000)]
    session = knead.Session(strokes)
    v = np.random.default_rng(1).uniform(-1, 1, (100_000, 3))
    before = v.copy()
"""


def run_long(code):
    code = textwrap.dedent(LONG) + textwrap.dedent(code)
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=100)


@pytest.mark.parametrize("call", ["knead.deform(v, session, out=v)", "knead.Flow(session).path(v, 3)",
                                  "knead.Flow(session).jacobian(v)", "knead.deform(v, session, faces, out=v)"])
def test_ctrl_c_ends_a_call_and_leaves_the_array(call):
    done = run_long(f"""
        faces = [[0, 1, 2]]
        sent = []
        def interrupt():
            time.sleep(1.0)
            sent.append(time.monotonic())
            os.kill(os.getpid(), signal.SIGINT)
        threading.Thread(target=interrupt, daemon=True).start()
        try:
            {call}
        except KeyboardInterrupt:
            print("interrupted", time.monotonic() - sent[0], (v == before).all())
    """)
    words = done.stdout.split()
    assert words and words[0] == "interrupted" and words[2] == "True", (done.stdout, done.stderr)
    assert float(words[1]) < 2  # 0.1 s on a machine that does nothing else


def test_other_threads_go_on_meanwhile():
    done = run_long("""
        ticks = []
        def tick():
            while True:
                ticks.append(time.monotonic())
                time.sleep(0.01)
        threading.Thread(target=tick, daemon=True).start()
        ends = time.monotonic() + 1
        print(knead.deform(v, session, progress=lambda f: time.monotonic() < ends), len(ticks))
    """)
    answer, ticks = done.stdout.split()
    assert answer == "None" and int(ticks) > 10, done.stderr


def test_a_session_that_is_wrong_far_down_leaves_the_array(sphere):
    v = sphere.vertices.copy()
    bend = knead.Bend(center=[0, 0, 0], axis=[0, 1, 0], normal=[1, 0, 0], width=1, angle_deg=70, radius=0.5)
    pull = knead.Implicit(path=[[0, 1, 0], [0, 1.4, 0]], inner=0.1, outer=0.5)
    before = v.copy()
    with pytest.raises(knead.InvalidInput, match=r"session:3: .*radius"):
        knead.deform(v, [pull, bend], sphere.faces, out=v)
    assert (v == before).all()
