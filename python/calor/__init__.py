"""calor from Python: cases, runs and results.

    from calor import Case
    result = Case("weld.toml", method="mlpg").run(j=2)
    result.probes["near"]            # numpy; result.probes.to_pandas()
    result.plot()

docs/python.md goes through it. Needs python3-numpy; fields need python3-vtk9, pictures python3-matplotlib.
"""
import sys

try:
    import numpy  # noqa: F401
except ModuleNotFoundError:
    message = "calor needs python3-numpy: apt-get install python3-numpy"
    if sys.argv[:1] != ["-m"]:
        raise ModuleNotFoundError(message) from None
    print(message, file=sys.stderr)  # for the command, whose users need not see where in Python that was
    sys.exit(2)

from .case import Case
from .command import CalorError, CaseError, CommandError, FileError, NumbersError
from .result import Fields, Result, Table

__all__ = ["CalorError", "Case", "CaseError", "CommandError", "Fields", "FileError", "NumbersError", "Result", "Table"]
