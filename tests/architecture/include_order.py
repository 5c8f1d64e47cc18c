#!/usr/bin/env python3
"""Every room of src/ includes only from itself and from the rooms before it, in the order that docs/architecture.md
gives, and no file includes itself over others; so there is no cycle of rooms either. Only rooms that show results log.
No two classes outside of unnamed namespaces have one name, which would be two definitions of one class to the linker.
The pages of docs/ name no file that is not there.

  include_order.py [ROOT]
"""
import pathlib
import re
import sys

ROOT = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else pathlib.Path(__file__).resolve().parents[2]
GENERATED = {"app/starter.hpp"}  # by CMake, into the build folder
LOGGING = {"output", "app"}


def rooms_in_order():
    found = re.search(r"^Rooms, from the ground up: (.+)\.$", (ROOT / "docs/architecture.md").read_text(), re.MULTILINE)
    if not found:
        sys.exit("docs/architecture.md has no line 'Rooms, from the ground up: ...'")
    return found[1].split(", ")


def includes(path):
    """The quoted includes of a file: (line number, path from src/)."""
    for number, line in enumerate(path.read_text().splitlines(), 1):
        if found := re.match(r'\s*#\s*include\s+"(.+?)"', line):
            yield number, found[1]


def cycle(graph):
    """Files that include one another in a ring, or []."""
    done, way = set(), []

    def visit(file):
        if file in way:
            return [*way[way.index(file):], file]
        if file in done:
            return []
        way.append(file)
        ring = next(filter(None, map(visit, graph[file])), [])
        done.add(way.pop())
        return ring

    return next(filter(None, map(visit, graph)), [])


def classes_with_one_name(files):
    """What the namespace calor has twice: './dev odr' would find it, but takes minutes."""
    places = {}
    for file, path in files.items():
        is_unnamed = False
        for number, line in enumerate(path.read_text().splitlines(), 1):
            if line == "namespace {":
                is_unnamed = True
            elif line == "}  // namespace":
                is_unnamed = False
            elif not is_unnamed and (found := re.match(r"(?:class|struct|enum class) (\w+)(?: final)?(?: :(?!:).*| \{.*)$", line)):
                places.setdefault(found[1], []).append(f"src/{file}:{number}")
    for name, where in places.items():
        if len(where) > 1:
            yield f"{' and '.join(where)} define {name}"


def paths_without_file():
    """What the pages name and the tree does not have."""
    for page in [*sorted((ROOT / "docs").glob("*.md")), ROOT / "README.md", ROOT / "CONTRIBUTING.md"]:
        for number, line in enumerate(page.read_text().splitlines(), 1):
            for path in re.findall(r"`((?:src|tests|bench|cases|docs)/[\w./-]+)`", line):
                if not (ROOT / path).exists():
                    yield f"{page.relative_to(ROOT)}:{number}: there is no {path}"


def main():
    rooms, source = rooms_in_order(), ROOT / "src"
    files = {str(path.relative_to(source)): path for path in sorted(source.rglob("*.[ch]pp"))}
    room_of = {file: file.split("/")[0] for file in files}
    if differ := set(rooms) ^ set(room_of.values()):
        sys.exit(f"docs/architecture.md and src/ differ in the rooms {', '.join(sorted(differ))}")
    faults = []
    graph = {file: [] for file in files}
    for file, path in files.items():
        if "spdlog" in path.read_text() and room_of[file] not in LOGGING:
            faults.append(f"src/{file}: {room_of[file]} must not log; put remarks into the notes of what is built")
        for line, other in includes(path):
            if other in GENERATED:
                continue
            if other not in files:
                faults.append(f'src/{file}:{line}: there is no src/{other}; write <...> for files of others')
                continue
            graph[file].append(other)
            room, above = room_of[file], room_of[other]
            if rooms.index(above) > rooms.index(room):
                faults.append(f"src/{file}:{line}: {room} lies below {above} and must not include {other}")
    if ring := cycle(graph):
        faults.append("files that include one another: " + " -> ".join(ring))
    faults += classes_with_one_name(files)
    faults += paths_without_file()
    for fault in faults:
        print(fault)
    print(f"{len(files)} files in {len(rooms)} rooms, {len(faults)} faults")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
