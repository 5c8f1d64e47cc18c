"""Colours and fonts of pictures, in light and dark."""
from __future__ import annotations

from contextlib import contextmanager
from collections.abc import Iterator

# The colour map of all fields: even steps look even, also to the colour-blind and in grey.
COLOUR_MAP = "viridis"
# Its colours at 33 even steps, hexadecimal, for pages; straight lines between them are within 1 percent of it.
VIRIDIS = ("440154470d6048186a482374472d7b4537814240863e49893b528b375b8d33638d2f6b8e2c728e297a8e26828e23898e21918c"
           "1f988b1fa08822a78528ae8032b67a3fbc734ec36b5ec96270cf5784d44b98d83eaddc30c2df23d8e219ece51bfde725")
# Curves, apart for the colour-blind: after Okabe and Ito (2008), without their yellow, which fades on white.
CURVES = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#888888")

LIGHT = {"ink": "#1b1f24", "paper": "#ffffff", "grid": "#d8dee4"}
DARK = {"ink": "#e6e9ec", "paper": "#15191e", "grid": "#343b43"}


@contextmanager
def theme(is_dark: bool = False) -> Iterator[None]:
    """Within it all figures of matplotlib look so."""
    import matplotlib
    colours = DARK if is_dark else LIGHT
    ink, paper = colours["ink"], colours["paper"]
    with matplotlib.rc_context({
        "figure.facecolor": paper, "axes.facecolor": paper, "savefig.facecolor": paper, "axes.edgecolor": ink,
        "axes.labelcolor": ink, "axes.titlecolor": ink, "text.color": ink, "xtick.color": ink, "ytick.color": ink,
        "grid.color": colours["grid"], "grid.linewidth": 0.6, "axes.grid": True, "axes.axisbelow": True,
        "axes.spines.top": False, "axes.spines.right": False, "axes.titlesize": 10, "axes.titlelocation": "left",
        "axes.labelsize": 9, "xtick.labelsize": 8, "ytick.labelsize": 8, "legend.fontsize": 8, "legend.frameon": False,
        "font.size": 9, "lines.linewidth": 1.4, "figure.constrained_layout.use": True, "savefig.dpi": 150,
        "axes.prop_cycle": matplotlib.cycler(color=CURVES), "image.cmap": COLOUR_MAP,
    }):
        yield
