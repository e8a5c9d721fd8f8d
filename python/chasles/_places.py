"""Recordings and results by name: paths of this machine, and URLs of fsspec (s3://, gs://, zip://, ...)."""

from __future__ import annotations

import contextlib
import fcntl
import hashlib
import os
import pathlib
import re
import shutil
import tempfile
import uuid
from typing import Any, Iterator

from ._optional import optional


_PARTS = ".parts"


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

    def _part(self) -> str:
        """A name for what is written beside, and then renamed."""
        os.makedirs(self._path(_PARTS), exist_ok=True)
        return self._path(f"{_PARTS}/{uuid.uuid4().hex}")

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
        """Replaces a file. An object of a store is there whole or not at all by itself; on ssh:// and the like it is not."""
        path = self._path(name)
        if self._remote:
            self._remote[0].pipe_file(path, data)
            return
        os.makedirs(os.path.dirname(path), exist_ok=True)
        part = self._part()
        with open(part, "wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        os.replace(part, path)

    def write_folder(self, source: pathlib.Path, name: str) -> None:
        """Replaces a folder by a copy. In a store of objects it is complete when the record of it is written."""
        path = self._path(name)
        if self._remote:
            for file in sorted(source.rglob("*")):
                if file.is_file():
                    self._remote[0].pipe_file(f"{path}/{file.relative_to(source)}", file.read_bytes())
            return
        part = self._part()
        os.makedirs(os.path.dirname(path), exist_ok=True)
        shutil.copytree(source, part)
        shutil.rmtree(path, ignore_errors=True)
        os.rename(part, path)

    def remove_parts(self) -> None:
        """What writers that were killed have left on this machine."""
        if not self._remote:
            shutil.rmtree(self._path(_PARTS), ignore_errors=True)


class NotThere(Exception):
    """There is nothing at a URL."""


class Cache:
    """Copies of remote recordings on this machine. Those that were not used for longest go when `most_bytes` are
    exceeded; one that a process uses stays. A copy is made again when the original has another size or time."""

    def __init__(self, folder: str, most_bytes: float) -> None:
        self.folder = pathlib.Path(folder)
        self.most_bytes = most_bytes

    @contextlib.contextmanager
    def local(self, url: str) -> Iterator[str]:
        """The path of a copy, which stays for the time of the block. Raises NotThere."""
        file_system, path = _file_system(url)
        if not file_system.exists(path) and not file_system.isdir(path):
            raise NotThere(url)
        # A lock of the whole cache: between the look at an entry and the hold of it, nothing may be removed.
        self.folder.mkdir(parents=True, exist_ok=True)
        entry = self.folder / hashlib.sha256(f"{url} {_version_of(file_system, path)}".encode()).hexdigest()[:24]
        with open(self.folder / "lock", "w") as lock, contextlib.ExitStack() as held:
            fcntl.flock(lock, fcntl.LOCK_EX)
            copy = entry / "copy" / name_of(url)
            if not copy.exists():
                self._make_room()
                _download(file_system, path, copy)
            used = held.enter_context(open(entry / "used", "a"))
            os.utime(entry / "used")
            fcntl.flock(used, fcntl.LOCK_SH)
            fcntl.flock(lock, fcntl.LOCK_UN)
            yield str(copy)

    def _make_room(self) -> None:
        """Under the lock of the cache, and before a download: the size of the new copy is known only afterwards."""
        entries = [one for one in self.folder.iterdir() if one.is_dir()]
        for entry in entries:
            if not (entry / "used").exists():  # of a download that was killed
                shutil.rmtree(entry)
        entries = [one for one in entries if one.exists()]
        sizes = {one: sum(f.stat().st_size for f in one.rglob("*") if f.is_file()) for one in entries}
        for entry in sorted(entries, key=lambda one: (one / "used").stat().st_mtime):
            if sum(sizes.values()) <= self.most_bytes:
                return
            with open(entry / "used") as used:
                try:
                    fcntl.flock(used, fcntl.LOCK_EX | fcntl.LOCK_NB)
                except BlockingIOError:
                    continue
                shutil.rmtree(entry)
                del sizes[entry]


def parts_of(url: str) -> list[str]:
    """The parts of the path of a URL, the last one first and without the extension of a file: for names."""
    path = re.sub(r"^[a-z0-9+.-]+://", "", url.split("::")[0]).split("?")[0].strip("/")
    parts = [part for part in path.split("/") if part] or ["recording"]
    parts[-1] = re.sub(r"(?<=.)\.[A-Za-z0-9]{1,5}$", "", parts[-1])
    return parts[::-1]


def name_of(url: str) -> str:
    """The last part of the path of a URL, with the extension, for the copy of it."""
    path = re.sub(r"^[a-z0-9+.-]+://", "", url.split("::")[0]).split("?")[0].rstrip("/")
    return path.rsplit("/", 1)[-1] or "recording"


def _version_of(file_system: Any, path: str) -> str:
    """Of a file, its size and time, as far as the file system knows them; of a folder, those of its files."""
    known = ("size", "mtime", "LastModified", "ETag", "etag", "updated", "created")
    if file_system.isdir(path):
        files = file_system.find(path, detail=True)
    else:
        files = {path: file_system.info(path)}
    return repr(sorted((name, [str(info.get(key)) for key in known]) for name, info in files.items()))


def _download(file_system: Any, path: str, to: pathlib.Path) -> None:
    is_folder = file_system.isdir(path)
    end = "/" if is_folder else ""
    to.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=to.parent.parent) as part:
        copy = os.path.join(part, to.name)
        file_system.get(path.rstrip("/") + end, copy + end, recursive=is_folder)
        os.rename(copy, to)
