#!/usr/bin/python3
"""run.py CALOR [quick]: the problems of problems.py by calor and by its peers, one after the other, on one core each.

Writes bench/results.md and bench/results.png: CPU seconds, errors at the nodes against the exact solutions, and ratios."""
from __future__ import annotations

import json
import math
import pathlib
import platform
import resource
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass

import matplotlib
import numpy as np
import problems

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]


@dataclass
class Run:
    problem: str
    code: str
    words: Sequence[str]  # of calor: changes to the case; of others: cells and steps
    is_quick: bool = True

    @property
    def is_calor(self) -> bool:
        return self.code.startswith("calor")


def calor(problem: str, name: str, words: Sequence[str], is_quick: bool = True) -> Run:
    return Run(problem, f"calor {name}", words, is_quick)


def runs() -> list[Run]:
    found = []
    for points, is_quick in ((41, True), (61, False), (101, False)):
        found += [calor("nonlinear-cube", "SPH", [f"cloud.points=[{points},{points},{points}]", "steady.tolerance=1e-8"], is_quick),
                  Run("nonlinear-cube", "dolfinx", [str(points - 1)], is_quick)]
    square = "cooling-square"
    for points, is_quick in ((41, True), (81, True), (161, False)):
        words = [f"cloud.points=[{points},{points}]"]
        found += [calor(square, name, [*words, f"method={method}"], is_quick) for name, method in (("SPH", "sph"), ("peridynamics", "peridynamics"))]
    for points in (81, 121):
        words = [f"cloud.points=[{points},{points}]", "time.tolerance=1 mK"]
        found += [calor(square, f"{name}, 1 mK", [*words, f"method={method}"]) for name, method in (("SPH", "sph"), ("peridynamics", "peridynamics"))]
    for points, is_quick in ((21, True), (31, True), (41, False), (81, False), (161, False)):
        found.append(calor(square, "MLPG", [f"cloud.points=[{points},{points}]", "method=mlpg"], is_quick))
    # What errs no more than dolfinx with the most nodes.
    found.append(calor(square, "MLPG, 1 mK", ["cloud.points=[61,61]", "method=mlpg", "time.tolerance=1 mK"]))
    for cells, steps, is_quick in ((40, 100, True), (60, 200, True), (80, 400, False), (160, 400, False)):
        found.append(Run(square, "dolfinx", [str(cells), str(steps)], is_quick))
    found.append(Run("cooling-square", "CalculiX", ["40", "400"], False))
    found += [calor("weld", name, [f"method={method}"]) for name, method in (("SPH", "sph"), ("MLPG", "mlpg"))]
    found += [calor("weld", "peridynamics", ["method=peridynamics"], False), calor("weld", "SPH, 1 K", ["time.tolerance=1 K"]),
              Run("weld", "dolfinx", ["6", "100"]), Run("weld", "CalculiX", ["6", "100"], False)]
    return found


def cpu_of_children() -> float:
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime


def measure(run: Run, command: str) -> dict[str, float]:
    """CPU seconds of calor from its first to its last instruction; of the others what they say of themselves."""
    if not run.is_calor:
        said = subprocess.run(["/usr/bin/python3", HERE / f"with_{run.code.lower()}.py", run.problem, *run.words], cwd=HERE,
                              capture_output=True, text=True)
        if said.returncode:
            raise SystemExit(f"{run.code} failed on {run.problem}:\n{said.stderr[-2000:]}")
        return dict(json.loads(said.stdout.splitlines()[-1]))
    with tempfile.TemporaryDirectory() as folder:
        begin = cpu_of_children()
        subprocess.run([command, "run", ROOT / "bench" / f"{run.problem}.toml", *run.words, "output.fields=false", "-o", folder, "--quiet"],
                       check=False)
        used = cpu_of_children() - begin
        x = np.loadtxt(pathlib.Path(folder) / "final.csv", delimiter=",", skiprows=1)[:, 1:]
    T = x[:, 3] - (273.15 if run.problem == "weld" else 0)
    return {"cpu": used, "points": len(x), "error": problems.rms_error(run.problem, x[:, :3], T)}


def processor() -> str:
    for line in pathlib.Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            return line.split(":")[1].strip()
    return platform.processor()


def version(package: str) -> str:
    return subprocess.run(["dpkg-query", "-W", "-f=${Version}", package], capture_output=True, text=True).stdout or "?"


WHAT = {"nonlinear-cube": ("a steady cube with k = exp(2 T)", "rms error, K of 1 K"),
        "cooling-square": ("a square that cools by convection", "rms error, K of 100 K"),
        "weld": ("a Gaussian source over a plate", "rms error over the peak")}


def table(problem: str, rows: list[tuple[Run, dict[str, float]]]) -> str:
    lines = [f"## {problem}: {WHAT[problem][0]}", "", f"| code | points | CPU s | {WHAT[problem][1]} |", "|---|---|---|---|"]
    lines += [f"| {run.code} | {int(m['points']):,} | {m['cpu']:.2f} | {m['error']:.2g} |" for run, m in rows]
    return "\n".join(lines) + "\n"


def ratios(rows: list[tuple[Run, dict[str, float]]]) -> str:
    """Against the quickest run of every method of calor that is at least as right."""
    lines = []
    for run, m in rows:
        if run.is_calor:
            continue
        better: dict[str, float] = {}
        for one, other in rows:
            if one.is_calor and other["error"] <= m["error"]:
                method = one.code.removeprefix("calor ").split(",")[0]
                better[method] = min(better.get(method, math.inf), other["cpu"])
        times = " and ".join(f"{m['cpu'] / cpu:.1f} times as long as calor by {method}" for method, cpu in better.items())
        found = f"takes {times}, at least as right" if better else "is more right than every run of calor here"
        lines.append(f"- {run.code} with {int(m['points']):,} nodes {found}.")
    return "\n".join(lines) + "\n"


def draw(measured: dict[str, list[tuple[Run, dict[str, float]]]], path: pathlib.Path) -> None:
    figure, all_axes = plt.subplots(1, len(measured), figsize=(4.4 * len(measured), 3.8), layout="constrained")
    for axes, (problem, rows) in zip(all_axes, measured.items()):
        for code in dict.fromkeys(run.code for run, _ in rows):
            of_code = [m for run, m in rows if run.code == code]
            axes.loglog([m["cpu"] for m in of_code], [m["error"] for m in of_code], "o-" if code.startswith("calor") else "s--", label=code, ms=5)
        axes.set(xlabel="CPU s", ylabel=WHAT[problem][1], title=problem)
        axes.grid(True, which="both", linewidth=0.3)
        axes.legend(fontsize=8)
    figure.savefig(path, dpi=150)


def main() -> None:
    command, is_quick = sys.argv[1], sys.argv[2:] == ["quick"]
    has_calculix = shutil.which("ccx") is not None
    measured: dict[str, list[tuple[Run, dict[str, float]]]] = {}
    for run in runs():
        if (is_quick and not run.is_quick) or (run.code == "CalculiX" and not has_calculix):
            continue
        m = measure(run, command)
        print(f"{run.problem:<16} {run.code:<20} {' '.join(run.words):<40} {int(m['points']):>9,} points  {m['cpu']:8.2f} s  error {m['error']:.3g}", flush=True)
        measured.setdefault(run.problem, []).append((run, m))
    text = (f"# calor and its peers\n\nWritten by `./dev bench peers{' quick' if is_quick else ''}`; every figure from one run, codes one after the other, one core each.\n\n"
            f"{processor()}; dolfinx {version('python3-dolfinx-real')}, CalculiX {version('calculix-ccx')}. CPU seconds are those of user code: of calor from start to end, with output (the start alone takes 0.03 s); of dolfinx without its imports and the compilation of "
            "its forms; of CalculiX those of ccx. Errors are those at the nodes against the exact solutions of `bench/peers/problems.py`. dolfinx marches by Crank-Nicolson, CalculiX by backward Euler, both with elements of first order; "
            "calor with its defaults. On the nonlinear cube compare equal numbers of points: sums over pairs of a lattice are exact for it, as theta is a polynomial of second degree.\n\n![Errors over CPU seconds](results.png)\n")
    for problem, rows in measured.items():
        text += "\n" + table(problem, rows) + "\n" + ratios(rows)
    (ROOT / "bench" / "results.md").write_text(text)
    draw(measured, ROOT / "bench" / "results.png")


main()
