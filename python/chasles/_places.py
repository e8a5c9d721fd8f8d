"""Recordings and results by name: paths of this machine, and URLs of fsspec (s3://, gs://, zip://, ...)."""

from __future__ import annotations

import contextlib
import fcntl
import hashlib
import os
import pathlib
import shutil
import tempfile
import uuid
from typing import Any, Iterator

from ._optional import optional


def is_url(name: str) -> bool:
    return "://" in name


def _file_system(url: str) -> tuple[Any, str]:
    """The file system of a URL, and the path in it."""
    fsspec = optional("fsspec", "fsspec")
    file_system, path = fsspec.core.url_to_fs(url)
    return file_system, path


class Place:
    """A folder for results, of this machine or behind a URL. Files come whole or not at all."""

    def __init__(self, name: str) -> None:
        self.name = name.rstrip("/")
        self._remote = _file_system(self.name) if is_url(name) else None

    @property
    def is_remote(self) -> bool:
        return self._remote is not None

    def _path(self, name: str) -> str:
        return f"{self._remote[1] if self._remote else self.name}/{name}"

    def has(self, name: str) -> bool:
        return bool(self._remote[0].exists(self._path(name))) if self._remote else os.path.exists(self._path(name))

    def names(self, folder: str) -> list[str]:
        """Of the entries of a folder; none where there is no such folder."""
        path = self._path(folder)
        if self._remote is None:
            return sorted(os.listdir(path)) if os.path.isdir(path) else []
        self._remote[0].invalidate_cache()
        try:
            entries = self._remote[0].ls(path, detail=False)
        except FileNotFoundError:  # a store has no folders: exists() knows objects alone
            return []
        return sorted(one.rstrip("/").rsplit("/", 1)[-1] for one in entries)

    def read(self, name: str) -> bytes:
        if self._remote is None:
            return pathlib.Path(self._path(name)).read_bytes()
        return bytes(self._remote[0].cat_file(self._path(name)))

    def write(self, name: str, data: bytes) -> None:
        """Replaces a file: an object of a store is there whole or not at all by itself."""
        path = self._path(name)
        if self._remote:
            self._remote[0].pipe_file(path, data)
            return
        os.makedirs(os.path.dirname(path), exist_ok=True)
        part = f"{path}.{uuid.uuid4().hex}.part"
        pathlib.Path(part).write_bytes(data)
        os.replace(part, path)

    def write_folder(self, source: pathlib.Path, name: str) -> None:
        """Replaces a folder by a copy. In a store of objects it is complete when the record of it is written."""
        path = self._path(name)
        if self._remote:
            for file in sorted(source.rglob("*")):
                if file.is_file():
                    self._remote[0].pipe_file(f"{path}/{file.relative_to(source)}", file.read_bytes())
            return
        part = f"{path}.{uuid.uuid4().hex}.part"
        os.makedirs(os.path.dirname(path), exist_ok=True)
        shutil.copytree(source, part)
        shutil.rmtree(path, ignore_errors=True)
        os.rename(part, path)

    def remove_parts(self, *folders: str) -> None:
        """What writers that were killed have left in these folders of this machine."""
        if self._remote:
            return
        for folder in folders:
            for name in self.names(folder):
                if name.endswith(".part"):
                    path = self._path(f"{folder}/{name}")
                    if os.path.isdir(path):
                        shutil.rmtree(path)
                    else:
                        os.remove(path)


class Cache:
    """Copies of remote recordings on this machine. Those that were not used for longest go when `most_bytes` are
    exceeded; one that a process uses stays."""

    def __init__(self, folder: str, most_bytes: float) -> None:
        self.folder = pathlib.Path(folder)
        self.most_bytes = most_bytes

    @contextlib.contextmanager
    def local(self, url: str) -> Iterator[str]:
        """The path of a copy, which stays for the time of the block. Raises FileNotFoundError where there is nothing."""
        entry = self.folder / hashlib.sha256(url.encode()).hexdigest()[:24]
        entry.mkdir(parents=True, exist_ok=True)
        with open(entry / "lock", "w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            copy = entry / "copy" / url.rstrip("/").rsplit("/", 1)[-1].split("::")[0]
            if not copy.exists():
                self._make_room(entry)
                _download(url, copy)
            os.utime(entry / "lock")
            fcntl.flock(lock, fcntl.LOCK_SH)
            yield str(copy)

    def _make_room(self, for_entry: pathlib.Path) -> None:
        """Before a download: the size of the new copy is known only afterwards."""
        entries = [one for one in self.folder.iterdir() if one != for_entry and (one / "copy").exists()]
        sizes = {one: sum(f.stat().st_size for f in one.rglob("*") if f.is_file()) for one in entries}
        for entry in sorted(entries, key=lambda one: (one / "lock").stat().st_mtime):
            if sum(sizes.values()) <= self.most_bytes:
                return
            with open(entry / "lock", "w") as lock:
                try:
                    fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                except BlockingIOError:
                    continue
                shutil.rmtree(entry / "copy")
                del sizes[entry]


def _download(url: str, to: pathlib.Path) -> None:
    file_system, path = _file_system(url)
    with tempfile.TemporaryDirectory(dir=to.parent.parent) as part:
        copy = os.path.join(part, to.name)
        is_folder = file_system.isdir(path)
        file_system.get(path.rstrip("/") + ("/" if is_folder else ""), copy + ("/" if is_folder else ""),
                        recursive=is_folder)
        if not os.path.exists(copy):
            raise FileNotFoundError(url)
        to.parent.mkdir(exist_ok=True)
        os.rename(copy, to)
