"""Read XML from anywhere: bounded in size and depth, and without the document types that declare entities."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.maps.readers.opening import one_line, read_bytes

#: The most bytes a file may have; real ones have up to half a million.
MAX_BYTES = 2_000_000
#: The deepest nesting of elements; real files have eight levels.
MAX_DEPTH = 32


class _Builder(ElementTree.TreeBuilder):
    """Build the tree of a document that has no document type and is not nested deeply."""

    depth = 0

    def doctype(self, name: str, public: str | None, system: str | None) -> None:
        raise ValueError("a DOCTYPE, which may declare entities")

    def start(self, tag: str, attrs: dict[str, str]) -> ElementTree.Element:
        self.depth += 1
        if self.depth > MAX_DEPTH:
            raise ValueError(f"elements nested deeper than {MAX_DEPTH} levels")
        return super().start(tag, attrs)

    def end(self, tag: str) -> ElementTree.Element:
        self.depth -= 1
        return super().end(tag)


def read_xml(path: Path, root: str) -> ElementTree.Element:
    """Return the root element of an XML file, which is to be called ``root``.

    Raises :class:`InputError` with one line for what is no XML, too large, too deep, or has a document type.
    """
    text = read_bytes(path, MAX_BYTES, "an XML map")
    parser = ElementTree.XMLParser(target=_Builder())
    try:
        parser.feed(text)
        element = parser.close()
    except (ElementTree.ParseError, ValueError, LookupError) as error:
        raise InputError(f"{path}: expected plain XML, got {one_line(error)}; correct it") from error
    if element.tag != root:
        raise InputError(f"{path}: expected the element <{root}>, got <{element.tag[:40]}>; is it a floor of rooms?")
    return element
