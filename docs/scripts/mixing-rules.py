#!/usr/bin/python3
"""Draws docs/img/mixing-rules.png: every mixing rule of calor between the bounds of Reuss and Voigt and those of Hashin and
Shtrikman, as `calor run cases/wang/mixing-rules.toml` computes them.

  docs/scripts/mixing-rules.py [CALOR]      CALOR: the command, by default build/release/calor

Results go to results/wang/. Needs numpy, matplotlib and python3-vtk9."""
import pathlib
import sys
import tomllib

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "cases"))
from plotting import Paper, plt, put_legend, theme

paper = Paper(ROOT / "cases" / "wang", results="results/wang", figures=ROOT / "docs" / "img")
case = tomllib.loads((paper.folder / "mixing-rules.toml").read_text())
calor = sys.argv[1] if len(sys.argv) > 1 else str(ROOT / "build" / "release" / "calor")

curves = {}
for variant in [None] + [v["name"] for v in case["variant"]]:
    result = f"mixing-rules/{variant}" if variant else "mixing-rules"
    paper.run(calor, result)
    fraction, k = paper.on_line(result, name="conductivity")
    same = next((name for name, (_, other) in curves.items() if abs(other - k).max() < 1e-9 * k.max()), None)
    name = variant or case["material"]["mixture"]["mix"]
    curves[f"{same} = {name}" if same else name] = curves.pop(same) if same else (fraction, k)

with theme():
    figure, axes = plt.subplots(figsize=(7, 5))
    bound = {name: next(k for names, (_, k) in curves.items() if name in names.split(" = "))
             for name in ("reuss", "voigt", "hashin-shtrikman-lower", "hashin-shtrikman-upper")}
    axes.fill_between(fraction, bound["reuss"], bound["voigt"], color="0.93", linewidth=0)
    axes.fill_between(fraction, bound["hashin-shtrikman-lower"], bound["hashin-shtrikman-upper"], color="0.82", linewidth=0)
    for name, (x, k) in curves.items():
        axes.plot(x, k, label=name.replace(" = hashin", "\n= hashin"), linewidth=1.5)
    axes.set(
        title="Aluminium and zirconia: light between Reuss and Voigt, dark between Hashin and Shtrikman",
        xlabel="volume fraction of zirconia",
        ylabel="k [W/(m K)]",
        xlim=(0, 1),
        yscale="log",
    )
    put_legend(axes)
    paper.save(figure, "mixing-rules.png")
