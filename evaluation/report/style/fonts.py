"""The font of figures for print: DejaVu Sans without the parts that make writing a PDF slow.

A PDF embeds the letters that it shows. matplotlib has them cut out of the font for every file anew, and most of this
time goes into scripts and rules for setting them that the figures do not use.
"""

from __future__ import annotations

import tempfile
import weakref
from functools import cache
from pathlib import Path

from fontTools import subset
from matplotlib.font_manager import FontEntry, FontProperties, findfont, fontManager

FAMILY = "DejaVu Sans"
#: Letters that stay: Latin, Greek and Cyrillic, punctuation, arrows and mathematical signs.
KEPT = (*range(0x20, 0x530), *range(0x2000, 0x2300))
#: Tables that go: rules of OpenType for placing and replacing letters, and what only font editors read.
DROPPED = ("GPOS", "GSUB", "GDEF", "FFTM")


@cache
def families() -> list[str]:
    """Return the names of the font and of the whole DejaVu Sans, which has the letters that the first lacks."""
    name = f"{FAMILY} Reduced"
    folder = tempfile.TemporaryDirectory(prefix="indoor-explorers-fonts-", ignore_cleanup_errors=True)
    weakref.finalize(fontManager, folder.cleanup)  # at the latest when Python ends
    for weight in (400, 700):
        whole = findfont(FontProperties(family=FAMILY, weight=weight))
        reduced = Path(folder.name, Path(whole).name)
        _reduce(whole, reduced)
        fontManager.ttflist.append(FontEntry(fname=str(reduced), name=name, weight=weight, size="scalable"))
    return [name, FAMILY]


def _reduce(whole: str, reduced: Path) -> None:
    """Write a font with some letters of another one."""
    options = subset.Options(legacy_kern=True, glyph_names=True, name_IDs=["*"], notdef_outline=True)
    with subset.load_font(whole, options) as font:
        for table in DROPPED:
            if table in font:
                del font[table]
        letters = subset.Subsetter(options)
        letters.populate(unicodes=KEPT)
        letters.subset(font)
        font.save(reduced)
