#!/usr/bin/env python3
"""Makes a wheel of one module that is already built:

make_wheel.py PYTHON PLATFORM MODULE LICENCES OUT   (as 313 manylinux_2_17_x86_64 _knead.cpython-313-….so FOLDER out/wheels)
"""

import base64
import hashlib
import re
import sys
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
NAME = "knead3d"  # `knead` is another project on the Python index; the import is `knead`
LICENCES = "MIT AND BSD-3-Clause AND MPL-2.0 AND Apache-2.0 WITH LLVM-exception"
DATE = (2020, 1, 1, 0, 0, 0)  # of all files: the same bytes from the same content


def version():
    return re.search(r"project\(knead VERSION ([0-9.]+)", (ROOT / "CMakeLists.txt").read_text())[1]


def metadata(licences):
    project = (ROOT / "pyproject.toml").read_text()

    def value(key):
        return re.search(rf'^{key} = "(.*?)"', project, re.M)[1]

    def values(key):
        return re.findall(r'"(.*?)"', re.search(rf"^{key} = \[(.*?)\]$", project, re.M | re.S)[1])

    lines = ["Metadata-Version: 2.4", f"Name: {NAME}", f"Version: {version()}", f"Summary: {value('description')}"]
    lines += [f"License-Expression: {LICENCES}"] + [f"License-File: {path.name}" for path in licences]
    lines += [f"Classifier: {each}" for each in values("classifiers")]
    lines += [f"Requires-Python: {value('requires-python')}"] + [f"Requires-Dist: {each}" for each in values("dependencies")]
    return "\n".join([*lines, "Description-Content-Type: text/markdown", "", (ROOT / "README.md").read_text()])


def files(tag, module, licences):
    """Yields the name and the bytes of each file."""
    for path in sorted((ROOT / "bindings/python/knead").iterdir()):
        if path.suffix in (".py", ".pyi") or path.name == "py.typed":
            yield f"knead/{path.name}", path.read_bytes()
    yield f"knead/{module.name}", module.read_bytes()
    info = f"{NAME}-{version()}.dist-info"
    for path in licences:
        yield f"{info}/licenses/{path.name}", path.read_bytes()
    yield f"{info}/METADATA", metadata(licences).encode()
    yield f"{info}/WHEEL", f"Wheel-Version: 1.0\nGenerator: knead\nRoot-Is-Purelib: false\nTag: {tag}\n".encode()


def record(name, data):
    digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
    return f"{name},sha256={digest},{len(data)}\n"


def main(python, platform, module, licences, out):
    tag = f"cp{python}-cp{python}-{platform}"
    path = Path(out) / f"{NAME}-{version()}-{tag}.whl"
    path.parent.mkdir(parents=True, exist_ok=True)
    contents = list(files(tag, Path(module), sorted(Path(licences).iterdir())))
    listing = f"{NAME}-{version()}.dist-info/RECORD"
    lines = "".join(record(*each) for each in contents) + f"{listing},,\n"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as wheel:
        for name, data in [*contents, (listing, lines.encode())]:
            info = zipfile.ZipInfo(name, DATE)
            info.compress_type, info.external_attr = zipfile.ZIP_DEFLATED, 0o100644 << 16
            wheel.writestr(info, data)
    print(path)


main(*sys.argv[1:])
