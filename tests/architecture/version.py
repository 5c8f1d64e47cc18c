#!/usr/bin/env python3
"""CITATION.cff, the newest release of CHANGELOG.md and the recipes of packaging/ carry the version that CMakeLists.txt names,
and one date."""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]


def first(file, pattern):
    found = re.search(pattern, (ROOT / file).read_text(), re.MULTILINE)
    return found.groups() if found else sys.exit(f"{file}: nothing reads like {pattern}")


(version,) = first("CMakeLists.txt", r"^project\(calor VERSION (\S+)")
released, date = first("CHANGELOG.md", r"^## \[(\d\S*)\] - (\d{4}-\d{2}-\d{2})$")
(cited,) = first("CITATION.cff", r"^version: (\S+)$")
(cited_date,) = first("CITATION.cff", r"^date-released: (\S+)$")
for recipe, pattern in (("spack/package.py", r'^    version\("(\S+)"\)$'), ("conda/meta.yaml", r'^{% set version = "(\S+)" %}$')):
    (packaged,) = first(f"packaging/{recipe}", pattern)
    if packaged != version:
        sys.exit(f"CMakeLists.txt: {version}, packaging/{recipe}: {packaged}")
if (version, version, date) != (released, cited, cited_date):
    sys.exit(f"CMakeLists.txt: {version}, CHANGELOG.md: {released} of {date}, CITATION.cff: {cited} of {cited_date}")
print(f"{version} of {date}")
