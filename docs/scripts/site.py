#!/usr/bin/env python3
"""What mkdocs makes the site of: site.py CALOR FOLDER

KaTeX of libjs-katex for the formulas, the pages of docs/, README.md as the first page, CHANGELOG.md, the benchmarks, the shipped cases with their files, and the
interface of the Python package, read from its docstrings, and the notebooks with what they come to. CALOR is the command, which knows what the cases are about."""
import inspect
import os
import pathlib
import re
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "python"))
KATEX = pathlib.Path("/usr/share/javascript/katex")


def with_pages(text):
    """Links to folders of cases and to notebooks lead to their pages; where the sources are read they lead to themselves."""
    text = text.replace(".ipynb)", ".md)")
    return re.sub(r"\]\(((?:\.\./)?cases(?:/[a-z-]+)?)/?\)", r"](\1/index.md)", text)


def write_cases(calor, folder):
    listed = subprocess.run([calor, "examples"], check=True, capture_output=True, text=True).stdout
    sentences = {}
    for line in listed.splitlines():
        if new := re.match(r"(\S+/\S+) +(.*)", line):
            name, sentences[new[1]] = new[1], new[2]
        elif line.startswith(" "):
            sentences[name] += " " + line.strip()
    pages = {}
    for name, sentence in sentences.items():
        group, case = name.split("/", 1)
        source = (ROOT / "cases" / f"{name}.toml").read_text()
        pages.setdefault(group, [f"# Cases: {group}\n"]).append(f"## {case}\n\n{sentence}\n\n```toml\n{source}```\n")
    for group, parts in pages.items():
        (folder / group).mkdir(parents=True)
        (folder / group / "index.md").write_text("\n".join(parts))
    index = ["# Cases that come with calor\n", "`calor new NAME --from EXAMPLE` copies one with the files that it names.\n",
             "| case | what it is |", "|:--|:--|"]
    index += [f"| [{name}]({name.split('/')[0]}/index.md#{name.split('/', 1)[1]}) | {sentence.replace('|', chr(92) + '|')} |"
              for name, sentence in sentences.items()]
    (folder / "index.md").write_text("\n".join(index) + "\n")


def interface(item, name, level):
    """The signature and the docstring of a class with its public members, or of a function."""
    try:
        signature = str(inspect.signature(item)).replace("'", "")
    except (TypeError, ValueError):
        signature = ""
    text = f"{'#' * level} {name.rsplit('.', 1)[-1]}\n\n    {name}{signature}\n\n{inspect.getdoc(item) or ''}\n"
    if inspect.isclass(item):
        for key, member in vars(item).items():
            if key.startswith("_"):
                continue
            if isinstance(member, property) and member.fget:
                text += f"\n{'#' * (level + 1)} {key}\n\n    {name}.{key}\n\n{inspect.getdoc(member.fget) or ''}\n"
            elif inspect.isfunction(member):
                text += "\n" + interface(member, f"{name}.{key}", level + 1)
    return text


def python_page():
    import calor
    from calor import core
    of_core = (interface(getattr(core, name), f"core.{name}", 2) for name in core.__all__)
    return "# Python interface\n\n" + "\n".join([*(interface(getattr(calor, name), name, 2) for name in calor.__all__), *of_core])


def run_notebooks(folder):
    subprocess.run([sys.executable, "-m", "nbconvert", "--log-level=ERROR", "--to", "markdown", "--execute", "--output-dir", folder,
                    *sorted((ROOT / "docs" / "notebooks").glob("*.ipynb"))], check=True, stderr=subprocess.PIPE,
                   env={**os.environ, "PYTHONPATH": str(ROOT / "python")})


def main():
    calor, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(ROOT / "docs", folder / "docs", ignore=shutil.ignore_patterns("scripts", "notebooks", "*.in", "*.dox", "Doxyfile"))
    for source, page in (("README.md", "index.md"), ("CHANGELOG.md", "CHANGELOG.md"), ("CONTRIBUTING.md", "CONTRIBUTING.md"),
                         ("CITATION.cff", "CITATION.cff"), ("bench/README.md", "bench/README.md")):
        (folder / page).parent.mkdir(exist_ok=True)
        shutil.copy(ROOT / source, folder / page)
    shutil.copytree(KATEX, folder / "katex", ignore=shutil.ignore_patterns("contrib", "*.mjs", "katex.js", "katex.css", "*.ttf", "*.woff"))
    write_cases(calor, folder / "cases")
    run_notebooks(folder / "docs" / "notebooks")
    (folder / "docs" / "python-interface.md").write_text(python_page())
    for page in folder.rglob("*.md"):
        page.write_text(with_pages(page.read_text()))


if __name__ == "__main__":
    main()
