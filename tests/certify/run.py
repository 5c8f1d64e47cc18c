#!/usr/bin/python3
"""How honest certificates are: problems with known answers are certified, and the answers compared with the bars.

  run.py [SECONDS A PROBLEM] [PART OF A NAME ...]

At least 95 % of what is certified has to lie within its bar, and bars have to be no wider than five times the true error
in the median.
"""
import pathlib
import statistics
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "python"))
from calor.certify import certify  # noqa: E402
from problems import ALL  # noqa: E402


def main():
    budget = float(sys.argv[1]) if len(sys.argv) > 1 else 20
    inside, ratios, total = 0, [], 0
    for problem in ALL:
        if sys.argv[2:] and not any(part in problem.__name__ for part in sys.argv[2:]):
            continue
        text, exact = problem()
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "case.toml"
            path.write_text(text)
            certificate = certify(str(path), pathlib.Path(folder) / "runs", budget=budget)
        for name, value in exact.items():
            quantity = certificate.quantities[name]
            verdict = quantity.verdict
            if verdict.certified:
                error = abs(verdict.value - value)
                total += 1
                inside += error <= verdict.bar
                if any(abs(v[-1] - v[-2]) > 1e-8 * abs(v[-1]) for v in quantity.values.values()):  # not exact at any spacing
                    ratios.append(verdict.bar / max(error, 1e-12 * abs(value)))
            print(f"{problem.__name__:<28} {name:<15} exact {value:.9g}  {quantity.statement}"
                  + (f"  error {error:.2g}, bar {verdict.bar:.2g}{'' if error <= verdict.bar else '  OUTSIDE'}" if verdict.certified else ""))
            for method, one in quantity.limits.items():
                print(f"{'':<45} {method:<13} {' '.join(f'{v - value:+.2e}' for v in quantity.values[method])}  order {one.order:.2f} "
                      f"limit {one.value - value:+.2e} bar {one.bar:.2e} {one.reason}")
            sys.stdout.flush()
    print(f"{inside} of {total} certified quantities lie within their bars; bar over error: median {statistics.median(ratios):.2g}")
    return 0 if inside >= 0.95 * total and statistics.median(ratios) <= 5 else 1


if __name__ == "__main__":
    sys.exit(main())
