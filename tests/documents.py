"""The documents that users read, and the Python in them."""

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SITE = ROOT / "evaluation" / "site"
#: The README and the pages of the site.
PAGES = (ROOT / "README.md", *sorted((SITE / "pages").rglob("*.md")))
#: The documents on planners and bounds.
PLANNERS, BOUNDS = ROOT / "planners" / "PLANNERS.md", ROOT / "evaluation" / "BOUNDS.md"
#: What data and weights are for, and the documents on tests.
ON_EVIDENCE = (
    ROOT / "learners" / "MODEL_CARDS.md",
    *(ROOT / "evaluation" / f"{name}.md" for name in ("DATASHEETS", "NEXT_TEST", "STATISTICS", "SUITES")),
)


def python_of(path: Path) -> list[str]:
    """The blocks of Python in a document."""
    return re.findall(r"```python\n(.*?)```", path.read_text("utf-8"), re.DOTALL)


def printed_of(path: Path) -> list[str | None]:
    """What a document says that each of its blocks of Python prints, None where it does not say."""
    blocks = re.findall(r"```python\n.*?```(?:\n\nIt prints\n\n```text\n(.*?)```)?", path.read_text("utf-8"), re.DOTALL)
    return [printed or None for printed in blocks]
