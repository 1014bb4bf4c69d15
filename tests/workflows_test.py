#!/usr/bin/python3
"""Whether the workflows for hosted runners are YAML, and every command of this repository that they run exists.

Exit status 77 where Python has no YAML (Debian's python3-yaml).
"""

import os
import re
import subprocess
import sys
from pathlib import Path

try:
    import yaml
except ImportError:
    print("python3-yaml is not installed: skipped")
    sys.exit(77)

ROOT = Path(__file__).resolve().parents[1]


def commands(workflow):
    """Yields the lines that the steps of a workflow run, and the needs of its jobs."""
    jobs = workflow["jobs"]
    for name, job in jobs.items():
        needs = job.get("needs", [])
        for needed in [needs] if isinstance(needs, str) else needs:
            assert needed in jobs, f"{name} needs {needed}, which is no job"
        for step in job["steps"]:
            assert ("run" in step) != ("uses" in step), f"{name}: a step runs a command or uses an action: {step}"
            yield from step.get("run", "").splitlines()


def problem(line, known):
    """What is wrong with a command of this repository; none: nothing."""
    for command in re.findall(r"(?:^|&& )\./dev (\w+)", line):
        if command not in known:
            return f"./dev has no command {command}"
    for script in re.findall(r"(?:^|\s)((?:\.\./)*(?:tools|tests|examples|docs)/[\w./-]+)", line):
        path = ROOT / re.sub(r"^(\.\./)+", "", script)
        if not path.is_file():
            return f"there is no {script}"
        if line.split()[0] == script and not os.access(path, os.X_OK):
            return f"{script} cannot be run"
    return None


def main():
    text = subprocess.run([ROOT / "dev", "help"], check=True, capture_output=True, text=True).stdout
    known = set(re.findall(r"^  (\w+)", text, re.M))
    assert problem("./dev nonsense", known) and problem("tools/missing.sh x", known)  # that mistakes are found
    assert problem("LICENSE tools/packaging/zig.cpp", known)
    count, problems = 0, []
    for path in sorted((ROOT / ".github/workflows").glob("*.yml")):
        for line in commands(yaml.safe_load(path.read_text())):
            count += 1
            found = problem(line.strip(), known)
            if found:
                problems.append(f"{path.name}: {found}: {line}")
    print("\n".join(problems) or f"{count} commands exist")
    return 1 if problems or count == 0 else 0


sys.exit(main())
