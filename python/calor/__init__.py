"""calor from Python: cases, runs and results.

    from calor import Case
    result = Case("weld.toml", method="mlpg").run(j=2)
    result.probes["near"]            # numpy; result.probes.to_pandas()
    result.plot()

docs/python.md goes through it. Needs python3-numpy; fields need python3-vtk9, pictures python3-matplotlib.
"""
from .case import Case
from .command import CalorError, CaseError, CommandError, FileError, NumbersError
from .result import Fields, Result, Table

__all__ = ["CalorError", "Case", "CaseError", "CommandError", "Fields", "FileError", "NumbersError", "Result", "Table"]
