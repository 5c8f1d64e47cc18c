"""python3 -m calor plot|report|certify|fit|study|optimise ...: what the command `calor` starts for what runs have written, and for many runs."""
from __future__ import annotations

import argparse
import io
import pathlib
import signal
import sys
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NoReturn

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from .result import Result

PACKAGES = {"numpy": "python3-numpy", "matplotlib": "python3-matplotlib", "vtkmodules": "python3-vtk9", "PIL": "python3-pil",
            "scipy": "python3-scipy", "openturns": "python3-openturns"}


def plane(text: str) -> tuple[str, float]:
    """("y", 0.01) of "y=10 mm"."""
    axis, _, at = text.partition("=")
    if axis not in ("x", "y", "z"):
        raise argparse.ArgumentTypeError(f"'{text}' is no plane: write it as in y=\"10 mm\"")
    from .command import CalorError
    from .quantities import in_unit
    try:
        return axis, in_unit(at, "m")
    except CalorError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


class Parser(argparse.ArgumentParser):
    """Tells what is wrong in one line."""

    def error(self, message: str) -> NoReturn:
        self.exit(2, f"{self.prog}: {message} ({self.prog} --help says more)\n")


def count(text: str) -> int:
    """Of runs side by side."""
    if not text.isdecimal() or not 1 <= int(text) <= 1000:
        raise argparse.ArgumentTypeError(f"'{text}' is no number of runs side by side: write 1, 2, ...")
    return int(text)


def numbers(text: str) -> list[float]:
    """[1, 1.5, 2] of "1,1.5,2"."""
    try:
        return [float(word) for word in text.split(",")]
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}' are no numbers with commas between: write 1,1.5,2") from None


def read_arguments(words: list[str]) -> argparse.Namespace:
    parser = Parser(prog="calor", description=__doc__)
    verbs = parser.add_subparsers(dest="verb", required=True)
    plot = verbs.add_parser("plot", help="draw pictures of a result")
    plot.add_argument("result", help="folder that calor run has written")
    plot.add_argument("what", nargs="*", default=[], help="section, surface, lines, probes, pool, balance, energy, stress, film; default: all that there are")
    plot.add_argument("-o", "--output", help="folder for the pictures (default: RESULT/pictures)")
    plot.add_argument("--field", default="temperature", help="field of sections, surfaces and films (default: temperature)")
    plot.add_argument("--time", type=float, help="of sections and surfaces, s (default: the end)")
    plot.add_argument("--plane", type=plane, help="of sections and films in 3D, e.g. y=\"10 mm\" (default: through the middle)")
    plot.add_argument("--format", default="png", choices=["png", "svg", "pdf"], help="of pictures (default: png)")
    plot.add_argument("--film", default="mp4", choices=["mp4", "gif"], help="of films (default: mp4)")
    plot.add_argument("--dark", action="store_true", help="on a dark ground")
    report = verbs.add_parser("report", help="write one page of HTML about a result")
    report.add_argument("result", help="folder that calor run has written")
    report.add_argument("-o", "--output", help="file for the page (default: RESULT/report.html)")
    for verb in (plot, report):
        verb.add_argument("--units", choices=["K", "degC", "degF"], help="of temperatures (default: that of [output])")
    certify = verbs.add_parser("certify", help="say how sure the numbers of a case are")
    certify.add_argument("case", metavar="CASE", help="case file")
    certify.add_argument("--methods", default="sph,peridynamics,mlpg", help="with commas between (default: all three)")
    certify.add_argument("--budget", default="5min", help="time that decides how many spacings there are, e.g. 90s or 1h (default: 5min)")
    certify.add_argument("--refine", type=numbers, help="in place of a budget how many times as fine as in the case, e.g. 1,1.5,2,3")
    certify.add_argument("-o", "--output", help="folder (default: results/CASE-certificate)")
    certify.add_argument("--twin", action="store_true", help="the order of the error of its twin, whose solution is known, in place of bars")
    fit = verbs.add_parser("fit", help="find unknown numbers of a case from measurements")
    fit.add_argument("case", metavar="CASE", help="case file with [[fit.unknown]] and [[fit.data]]")
    fit.add_argument("-o", "--output", help="folder (default: results/CASE-fit)")
    study = verbs.add_parser("study", help="run a case with other values of its keys")
    study.add_argument("case", metavar="CASE", help="case file, with [study] or without")
    study.add_argument("values", metavar="key=[values]", nargs="*", default=[],
                       help="such as method=[sph,mlpg] or cloud.spacing=[\"1 mm\",\"2 mm\"]; key=value changes the case, variant=NAME takes a variant")
    study.add_argument("-o", "--output", help="folder (default: results/CASE-study)")
    study.add_argument("--rows", action="store_true", help="the lists are columns of a table: run every row, not every combination")
    study.add_argument("--sobol", action="store_true", help="by which numbers of [study.range] the results vary: Sobol's indices")
    optimise = verbs.add_parser("optimise", help="find the numbers of a case for which a result is best")
    optimise.add_argument("case", metavar="CASE", help="case file with [optimise]")
    optimise.add_argument("-o", "--output", help="folder (default: results/CASE-optimum)")
    optimise.add_argument("--picture", help="file for a picture of composition, temperature and stress before and after")
    for verb in (certify, fit, optimise):
        verb.add_argument("changes", metavar="key=value", nargs="*", default=[], help="changes to the case, or variant=NAME")
    for verb in (certify, fit, study):
        verb.add_argument("-j", type=count, default=1, help="runs side by side (default: 1)")
    # argparse takes the words of a list in one row alone: those behind an option are left over.
    options, rest = parser.parse_known_args(words)
    words_of = {"plot": "what", "study": "values", "report": ""}.get(options.verb, "changes")
    if rest and (not words_of or any(word.startswith("-") for word in rest)):
        parser.error(f"unrecognized arguments: {' '.join(rest)}")
    if words_of:
        getattr(options, words_of).extend(rest)
    return options


def tell(line: str) -> None:
    print(line, file=sys.stderr, flush=True)


def picture(path: pathlib.Path, draw: Callable[[], Figure]) -> pathlib.Path:
    from . import figures
    return figures.write(path, draw)


def tell_pictures(write: Callable[[], pathlib.Path]) -> None:
    """Prints the name of what is written, or why there is nothing."""
    from .command import CommandError
    try:
        print(write())
    except ModuleNotFoundError:
        tell("pictures need python3-matplotlib: apt-get install python3-matplotlib")
    except CommandError as nothing:
        tell(f"no pictures: {nothing}")


def write_fit(options: argparse.Namespace) -> int:
    from . import fit
    from .case import Case
    found = fit.fit(Case(options.case, options.changes), options.output, j=options.j, say=tell)
    print(found.table())
    tell_pictures(lambda: picture(found.folder / "fit.png", found.plot))
    print(f"{found.folder / 'fit.json'}, {found.folder / f'{pathlib.Path(options.case).stem}-fitted.toml'}")
    return 0


def write_study(options: argparse.Namespace) -> int:
    from . import study, toml
    from .command import CommandError
    from .case import Case
    values: dict[str, list[Any]] = {}
    changes = []
    for text in options.values:
        key, value = toml.change(text)
        if isinstance(value, str) and value.startswith("[") and value.endswith("]"):  # words without quotes
            value = [word.strip() for word in value[1:-1].split(",")]
        if isinstance(value, list):
            values[key] = value
        else:
            changes.append(text)
    if options.sobol and values:
        raise CommandError("--sobol takes the ranges of the case alone: leave the values out")
    case = Case(options.case, changes)
    done = study.study(case, options.output, values=values, rows=options.rows, j=options.j, say=tell)
    again = f", {done.reused} of them from before" if done.reused else ""
    failed = sum("failed" in row for row in done.rows)
    if options.sobol:
        from . import sobol
        print(sobol.table(sobol.sobol(done, case.to_dict().get("study", {}).get("range", {}))))
    tell_pictures(lambda: picture(done.folder / "study.png", done.plot))
    print(f"{len(done.rows)} runs{again}{f', {failed} failed' if failed else ''}: {done.folder / 'study.csv'}")
    return int(failed > 0)


def write_optimum(options: argparse.Namespace) -> int:
    from . import optimise
    from .case import Case
    found = optimise.optimise(Case(options.case, options.changes), options.output, say=tell)
    print(found.table())
    print(f"{found.folder / 'optimum.json'}, {found.folder / f'{pathlib.Path(options.case).stem}-best.toml'}")
    if options.picture:
        picture(pathlib.Path(options.picture), found.plot)
    return int(not found.best.is_allowed)


def write_certificate(options: argparse.Namespace) -> int:
    from . import certify
    from .case import Case
    case, methods = Case(options.case, options.changes), options.methods.split(",")
    if options.twin:
        from . import twin
        print(twin.twin(case, options.output, methods=methods, factors=options.refine, j=options.j, say=tell).table())
        return 0
    certificate = certify.certify(case, options.output, methods=methods, budget=certify.seconds(options.budget), factors=options.refine,
                                  j=options.j, say=tell)
    print(certificate.table())
    tell_pictures(certificate.write_page)
    print(certificate.folder / "certificate.json")
    return 0


def open_result(options: argparse.Namespace) -> Result:
    from .result import Result
    result = Result(options.result)
    result.temperature_unit = options.units or result.temperature_unit
    return result


def draw(options: argparse.Namespace) -> None:
    import matplotlib
    matplotlib.use("Agg")
    from . import film, plot
    from .command import CalorError, CommandError
    result = open_result(options)
    folder = pathlib.Path(options.output) if options.output else result.folder / "pictures"
    known = [*plot.PICTURES, "film"]
    for what in options.what:
        if what not in known:
            raise CommandError(f"there is no picture '{what}'; there are {', '.join(known)}")
    folder.mkdir(parents=True, exist_ok=True)
    of_fields = {"section": {"name": options.field, "t": options.time, "plane": options.plane},
                 "surface": {"name": options.field, "t": options.time}}
    for what in options.what or plot.PICTURES:
        path = folder / f"{what}.{options.film if what == 'film' else options.format}"
        try:
            if what == "film":
                film.animate(result, path, name=options.field, plane=options.plane, dark=options.dark)
            else:
                plot.figure(result, what, dark=options.dark, **of_fields.get(what, {})).savefig(path, dpi=150)
        except CalorError:
            if options.what:
                raise
            continue
        print(path)


# What they return is the exit code.
MANY_RUNS = {"certify": write_certificate, "fit": write_fit, "study": write_study, "optimise": write_optimum}


def main(words: list[str]) -> int:
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # where it takes ASCII alone
    options = read_arguments(words)
    try:
        from .command import CalorError, CommandError, FileError
        try:
            if options.verb == "plot":
                draw(options)
            elif options.verb in MANY_RUNS:
                return MANY_RUNS[options.verb](options)
            else:
                print(open_result(options).write_page(options.output))
        except (CalorError, ValueError) as error:
            print(f"calor: {error}", file=sys.stderr)
            return getattr(error, "code", CommandError.code)
        except OSError as error:
            print(f"calor: {error.filename or 'standard output'}: {error.strerror}", file=sys.stderr)
            return FileError.code
    except KeyboardInterrupt:
        print("calor: interrupted; what has run so far is kept", file=sys.stderr)
        return 128 + signal.SIGINT
    except ModuleNotFoundError as error:
        package = PACKAGES.get((error.name or "").partition(".")[0])
        if not package:
            raise
        print(f"calor: {options.verb} needs {package}: apt-get install {package}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
