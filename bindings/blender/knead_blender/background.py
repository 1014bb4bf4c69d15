# SPDX-License-Identifier: GPL-3.0-or-later
"""Long work in a thread of its own, while the window lives: progress, and Esc stops. The library releases the GIL."""

import threading

from . import shape, state

_ERRORS = (state.Refusal, ValueError, RuntimeError, OSError)


class Job:
    """Runs work(progress) in a thread; progress(fraction) returns False once the job is stopped."""

    def __init__(self, work):
        self.fraction = 0.0
        self.result = None
        self.error = None
        self._stop = False
        self._thread = threading.Thread(target=self._run, args=(work,), daemon=True)
        self._thread.start()

    def _run(self, work):
        try:
            self.result = work(self._progress)
        except _ERRORS as error:
            self.error = str(error)

    def _progress(self, fraction):
        self.fraction = fraction
        return not self._stop

    def running(self):
        return self._thread.is_alive()

    def stop(self):
        self._stop = True
        self._thread.join()


class Background:
    """An operator that begins a job for an object; `finish(context, obj, result)` then changes the data."""

    def start(self, context, obj, work):
        self._job = Job(work)
        self._obj, self._before = obj, shape.fingerprint(shape.read(obj))
        self._timer = context.window_manager.event_timer_add(0.1, window=context.window)
        context.window_manager.progress_begin(0, 1)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type == "ESC":
            self._job.stop()
            return self._end(context, "stopped; nothing has changed")
        if event.type != "TIMER":
            return {"RUNNING_MODAL"}
        context.window_manager.progress_update(self._job.fraction)
        if self._job.running():
            return {"RUNNING_MODAL"}
        if self._job.error is not None:
            return self._end(context, self._job.error)
        if shape.fingerprint(shape.read(self._obj)) != self._before:
            return self._end(context, "the mesh changed meanwhile and stays as it is")
        try:
            self.finish(context, self._obj, self._job.result)
        except _ERRORS as error:
            return self._end(context, str(error))
        self._end(context, None)
        return {"FINISHED"}

    def _end(self, context, why):
        context.window_manager.event_timer_remove(self._timer)
        context.window_manager.progress_end()
        if why is not None:
            self.report({"WARNING"}, f"{self.bl_label}: {why}")
        return {"CANCELLED"}
