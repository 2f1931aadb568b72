#!/usr/bin/python3
"""Packs the renderer's tests, goldens and timings into one archive that needs
nothing else but Python, a C library as new as this machine's and a driver.

    tests/gpu/pack.py [--parent BIN] OUT.tar.xz

--parent names the folder of another build's programs; their frames are timed
in turns with this build's.
"""
import argparse
import glob
import os
import re
import shutil
import subprocess
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(
    os.path.abspath(__file__))))
BIN = os.path.join(ROOT, "build/release/bin")
NAME = "gpu-check"
# The C library belongs to the machine that runs the tests, as its driver does.
OF_THE_MACHINE = re.compile(
    r"(ld-linux.*|lib(c|m|dl|rt|pthread|resolv))\.so\.\d+$")
FILES = ["tests/golden/*.png", "tests/golden/device", "shaders"]


def tests():
    """Those that draw: they include the kit whose device can be chosen."""
    kit = '#include "render/render_testkit.h"'
    for source in sorted(glob.glob(f"{ROOT}/server/*/*_test.c") +
                         glob.glob(f"{ROOT}/tests/golden/*_test.c")):
        with open(source, encoding="utf-8") as text:
            if kit in text.read():
                yield os.path.splitext(os.path.basename(source))[0]


def strip(source, target):
    subprocess.run(["strip", "-o", target, source], check=True)


def libraries(program):
    """Paths of the shared libraries that a program loads."""
    out = subprocess.run(["ldd", program], check=True, capture_output=True,
                         text=True).stdout
    for path in re.findall(r"=> (/\S+)", out):
        if not OF_THE_MACHINE.fullmatch(os.path.basename(path)):
            yield path


def pack(folder, parent):
    os.makedirs(f"{folder}/bin")
    os.makedirs(f"{folder}/lib")
    programs = {name: f"{BIN}/{name}" for name in [*tests(), "still"]}
    if parent:
        programs["still-parent"] = f"{parent}/still"
    for name, source in programs.items():
        strip(source, f"{folder}/bin/{name}")
    for library in {path for source in programs.values()
                    for path in libraries(source)}:
        shutil.copy(library, f"{folder}/lib")
    # libepoxy opens these by name.
    for pattern in ("libEGL.so.1", "libGLdispatch.so.0"):
        for path in glob.glob(f"/usr/lib/x86_64-linux-gnu/{pattern}"):
            shutil.copy(path, f"{folder}/lib")
    for pattern in FILES:
        for path in glob.glob(f"{ROOT}/{pattern}"):
            target = os.path.join(folder, os.path.relpath(path, ROOT))
            os.makedirs(os.path.dirname(target), exist_ok=True)
            if os.path.isdir(path):
                shutil.copytree(path, target)
            else:
                shutil.copy(path, target)
    shutil.copy(f"{ROOT}/tests/gpu/check.py", f"{folder}/check.py")


def main():
    parser = argparse.ArgumentParser(
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--parent", help="folder of another build's programs")
    parser.add_argument("out")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as place:
        pack(f"{place}/{NAME}", options.parent)
        # The programs share most of their bytes: a window that holds several.
        subprocess.run(
            ["tar", "-C", place, "-I", "xz -T1 --lzma2=preset=1,dict=64MiB",
             "-cf", os.path.abspath(options.out), NAME], check=True)
    size = os.path.getsize(options.out) / 2**20
    print(f"{options.out}: {size:.1f} MiB")


if __name__ == "__main__":
    main()
