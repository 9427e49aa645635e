"""Clones of published repositories: the commit that is expected, and the check of a folder against it."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.files import expanded


@dataclass(frozen=True, kw_only=True)
class PublishedCode:
    """A public repository at the commit that a part of this package was written for."""

    url: str
    """Address of the repository."""
    commit: str
    """The commit, 40 hexadecimal digits."""
    files: Mapping[str, str]
    """SHA-256 digests of the files that matter, by their paths in the repository."""

    @property
    def name(self) -> str:
        """The name of the folder that ``git clone`` makes."""
        return self.url.rpartition("/")[2]

    @property
    def how_to_fetch(self) -> str:
        """The command that clones the repository at the commit."""
        return f"git clone {self.url} && git -C {self.name} checkout {self.commit}"

    def with_files(self, more: Mapping[str, str]) -> PublishedCode:
        """Return the code with more files that matter, as of a part that uses more of it."""
        return replace(self, files={**self.files, **more})

    def checked(self, folder: str | Path) -> Path:
        """Return the absolute path of a clone whose files are those of the commit.

        Nothing of the clone is executed. The digests decide, so that a downloaded archive of the commit passes too.

        Args:
            folder: the clone.

        Raises:
            InputError: the folder is missing, lacks a file, or has a file of another commit.

        """
        path = expanded(folder)
        expected = f"expected a clone of {self.url} at commit {self.commit[:7]}"
        if not path.is_dir():
            raise InputError(f"{folder}: {expected}, found no folder; fetch it with `{self.how_to_fetch}`")
        for name, digest in self.files.items():
            found = _digest_of(path / name)
            if found is None:
                raise InputError(f"{folder}: {expected}, found no {name} in it; fetch it with `{self.how_to_fetch}`")
            if found != digest:
                mend = f"run `git -C {path} checkout {self.commit} -- {name}`"
                raise InputError(f"{folder}: {expected}, found another {name}; {mend}")
        return path.resolve()


def _digest_of(path: Path) -> str | None:
    try:
        return hashlib.sha256(path.read_bytes()).hexdigest()
    except OSError:
        return None
