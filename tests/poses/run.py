"""The same answer at every scale and in every pose: usage run.py CALOR [WORDS of the kinds to run]."""
import csv
import subprocess
import sys
import tempfile
from pathlib import Path

from cases import KINDS, Pose, text_of

SCALES = (1e-9, 1e-6, 1e-3, 1.0, 1e3)
EPS = 2.0 ** -52


def poses(dimension):
    yield from (Pose(f"scale {s:g}", scale=s) for s in SCALES if s != 1)
    yield Pose("scale 0.37", scale=0.37)
    yield Pose("shifted by 1 km", shift=1e3)
    yield Pose("shifted by 1000 km", shift=1e6)
    yield Pose("mirrored", signs=(-1, 1, 1))
    if dimension > 1:
        yield Pose("axes swapped", axes=(1, 0, 2) if dimension == 2 else (1, 2, 0))
        yield Pose("turned by 90 degrees", axes=(1, 0, 2), signs=(1, -1, 1))
    yield Pose("in mm", length="mm")
    yield Pose("in degC", kelvin=False)
    yield Pose("mirrored, in mm and degC", signs=(-1, 1, 1), length="mm", kelvin=False)


def answer(calor, folder, name, method, pose):
    text, files = text_of(name, method, pose)
    if text is None:
        return None
    for file, content in files.items():
        (folder / file).write_text(content)
    (folder / "case.toml").write_text(text)
    done = subprocess.run([calor, "run", str(folder / "case.toml"), "-o", str(folder / "out")], capture_output=True,
                          text=True)
    if done.returncode != 0:
        return (done.stderr.strip() or done.stdout.strip()).replace(str(folder), "")
    with open(folder / "out" / "probes.csv") as file:
        return [float(v) for v in list(csv.reader(file))[-1][1:]]


def main():
    calor, words = sys.argv[1], sys.argv[2:]
    failed = 0
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        for name, (dimension, methods, posable, _) in KINDS.items():
            if words and not any(word in name for word in words):
                continue
            for method in methods:
                base = answer(calor, folder, name, method, Pose("base"))
                if base is None:
                    continue
                if isinstance(base, str):
                    print(f"{name}, {method}: {base}")
                    failed += 1
                    continue
                off = []
                for pose in poses(dimension):
                    if not posable and (pose.shift or min(pose.signs) < 0 or pose.axes != (0, 1, 2)):
                        continue
                    got = answer(calor, folder, name, method, pose)
                    if isinstance(got, str):
                        print(f"{name}, {method}, {pose.name}: {got}")
                        failed += 1
                        continue
                    error = max(abs(a - b) for a, b in zip(base, got)) / 100
                    # A shift costs the digits of the coordinates: eps times it over the spacing.
                    allowed = 3e-10 + 100 * EPS * pose.shift / 0.1
                    off.append((error, pose.name))
                    if not error <= allowed:
                        failed += 1
                        print(f"{name}, {method}, {pose.name}: {error:.1e} of the span, allowed {allowed:.1e}")
                if off:
                    print(f"ok {name}, {method}: {max(off)[0]:.1e} {max(off)[1]}", flush=True)
    print(f"{failed} failed")
    return failed > 0


if __name__ == "__main__":
    sys.exit(main())
