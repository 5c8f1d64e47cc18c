"""A bar for runs: HTML in notebooks, a line on terminals."""
from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from html import escape

Show = Callable[[float, str], None]


def in_notebook() -> bool:
    shell = sys.modules.get("IPython")
    return bool(shell and shell.get_ipython() and shell.get_ipython().has_trait("kernel"))


@contextmanager
def bar(wanted: bool | None) -> Iterator[Show | None]:
    """What a run tells its progress to; nothing where nobody would see it."""
    if wanted is not False and in_notebook():
        from IPython.display import HTML, display
        handle = display(HTML("<progress></progress>"), display_id=True)

        def show(part: float, line: str) -> None:
            handle.update(HTML(f'<progress value="{part}" max="1"></progress> <code>{100 * part:.0f} % {escape(line)}</code>'))

        yield show
        handle.update(HTML(""))
    elif wanted or (wanted is None and sys.stderr.isatty()):
        yield lambda part, line: print(f"\r\033[K{100 * part:5.1f} % {line}", end="", file=sys.stderr, flush=True)
        print("\r\033[K", end="", file=sys.stderr, flush=True)
    else:
        yield None
