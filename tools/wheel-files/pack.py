"""pack.py PACKAGE FOLDER: packs a built package and pyproject.toml into a wheel for this interpreter, in the folder. The
same files give the same bytes. Prints its name."""

import base64
import hashlib
import pathlib
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import tomllib
import zipfile

ROOT = pathlib.Path(__file__).resolve().parents[2]


def tag():
    python = "cp" + "".join(str(part) for part in sys.version_info[:2])
    return f"{python}-{python}-{sysconfig.get_platform().replace('-', '_').replace('.', '_')}"


def metadata(project):
    lines = ["Metadata-Version: 2.1", f"Name: {project['name']}", f"Version: {project['version']}",
             f"Summary: {project['description']}", f"License: {project['license']}",
             *(f"License-File: {file}" for file in project["license-files"]),
             f"Requires-Python: {project['requires-python']}",
             *(f"Requires-Dist: {one}" for one in project["dependencies"])]
    for extra, packages in project["optional-dependencies"].items():
        lines.append(f"Provides-Extra: {extra}")
        lines += [f"Requires-Dist: {one}; extra == '{extra}'" for one in packages]
    lines.append("Description-Content-Type: text/markdown")
    return "\n".join(lines) + "\n\n" + (ROOT / project["readme"]).read_text(encoding="utf-8")


def stripped(module):
    """The module without the symbols that only a debugger reads."""
    with tempfile.TemporaryDirectory() as folder:
        copy = pathlib.Path(folder) / module.name
        shutil.copy(module, copy)
        subprocess.run(["strip", "--strip-unneeded", copy], check=True)
        return copy.read_bytes()


def files_of(package, project):
    """{name in the wheel: bytes}, in the order of the wheel."""
    suffix = sysconfig.get_config_var("EXT_SUFFIX")
    modules = sorted(package.glob(f"*{suffix}"))
    if len(modules) != 1:
        raise SystemExit(f"pack.py: {package}: found {len(modules)} modules *{suffix}, expected one, for {sys.executable}")
    files = {f"{package.name}/{modules[0].name}": stripped(modules[0])}
    for file in sorted(package.iterdir()):
        if file.suffix in (".py", ".pyi") or file.name == "py.typed":
            files[f"{package.name}/{file.name}"] = file.read_bytes()
    info = f"{project['name']}-{project['version']}.dist-info"
    scripts = "".join(f"{name} = {function}\n" for name, function in project["scripts"].items())
    files[f"{info}/METADATA"] = metadata(project).encode()
    files[f"{info}/WHEEL"] = (f"Wheel-Version: 1.0\nGenerator: {project['name']} tools/wheel-files/pack.py\n"
                              f"Root-Is-Purelib: false\nTag: {tag()}\n").encode()
    files[f"{info}/entry_points.txt"] = f"[console_scripts]\n{scripts}".encode()
    for file in project["license-files"]:
        files[f"{info}/licenses/{file}"] = (ROOT / file).read_bytes()
    record = ""
    for name, content in files.items():
        digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
        record += f"{name},sha256={digest},{len(content)}\n"
    files[f"{info}/RECORD"] = (record + f"{info}/RECORD,,\n").encode()
    return files


def main(package, folder):
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    wheel = pathlib.Path(folder) / f"{project['name']}-{project['version']}-{tag()}.whl"
    wheel.parent.mkdir(parents=True, exist_ok=True)
    for earlier in wheel.parent.glob(f"{project['name']}-*.whl"):
        earlier.unlink()
    with zipfile.ZipFile(wheel, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files_of(pathlib.Path(package), project).items():
            entry = zipfile.ZipInfo(name, date_time=(1980, 1, 1, 0, 0, 0))
            entry.external_attr = (0o755 if name.endswith(".so") else 0o644) << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, content)
    print(wheel)


if __name__ == "__main__":
    main(*sys.argv[1:])
