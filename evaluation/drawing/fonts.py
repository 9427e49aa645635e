"""The font of figures for print: DejaVu Sans without the parts that make writing a PDF slow.

A PDF embeds the letters that it shows. matplotlib has them cut out of the font for every file anew, and most of this
time goes into scripts and rules for setting them that the figures do not use.
"""

from __future__ import annotations

import hashlib
import os
from functools import cache
from io import BytesIO
from pathlib import Path

import fontTools
from fontTools import subset
from matplotlib.font_manager import FontEntry, FontProperties, findfont, fontManager

from indoor_explorers.env.grid.compile_cache import cache_folder, write_entry

FAMILY = "DejaVu Sans"
#: Letters that stay: Latin, Greek and Cyrillic, punctuation, arrows and mathematical signs.
KEPT = (*range(0x20, 0x530), *range(0x2000, 0x2300))
#: Tables that go: rules of OpenType for placing and replacing letters, and what only font editors read.
DROPPED = ("GPOS", "GSUB", "GDEF", "FFTM")


@cache
def families() -> list[str]:
    """Return the names of the font and of the whole DejaVu Sans, which has the letters that the first lacks.

    The font is made once and kept beside the compiled code; where nothing can be kept, the whole one is all there is.
    """
    name, folder = f"{FAMILY} Reduced", cache_folder()
    if folder is None:
        return [FAMILY]
    for weight in (400, 700):
        whole = findfont(FontProperties(family=FAMILY, weight=weight))
        reduced = folder / "fonts" / _name(Path(whole))
        if reduced.exists():
            os.utime(reduced)  # still in use
        else:
            write_entry(reduced, _reduced(whole))
        fontManager.ttflist.append(FontEntry(fname=str(reduced), name=name, weight=weight, size="scalable"))
    return [name, FAMILY]


def _name(whole: Path) -> str:
    """Return the file name of the reduced font, another one for each way in which it is made."""
    made = hashlib.sha256(whole.read_bytes() + repr((KEPT, DROPPED, fontTools.version)).encode())
    return f"{whole.stem}-{made.hexdigest()[:16]}{whole.suffix}"


def _reduced(whole: str) -> bytes:
    """Return a font with some letters of another one."""
    options, made = subset.Options(legacy_kern=True, glyph_names=True, name_IDs=["*"], notdef_outline=True), BytesIO()
    with subset.load_font(whole, options) as font:
        for table in DROPPED:
            if table in font:
                del font[table]
        letters = subset.Subsetter(options)
        letters.populate(unicodes=KEPT)
        letters.subset(font)
        font.save(made)
    return made.getvalue()
