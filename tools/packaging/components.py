"""What Chasles's binaries contain and link: components.json, the npm packages in the report's pages,
and the shared libraries with the Debian packages that they are from."""
import dataclasses
import json
import pathlib
import re
import subprocess

HERE = pathlib.Path(__file__).resolve().parent
WEB = HERE.parents[1] / "src/web"


@dataclasses.dataclass(frozen=True)
class Component:
    name: str
    version: str
    spdx: str  # licence
    kind: str  # "compiled in", "in the pages", "linked", "loaded"
    purl: str
    copyright: tuple = ()
    licence: str = ""  # Debian's name for it
    path: str = ""     # where its files are from
    text: str = ""     # of the licence, where the component has its own


class UnknownComponent(Exception):
    """A library that components.json does not name, or that no package owns."""


def output(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()


def distribution():
    """The ID of /etc/os-release, for package URLs."""
    return re.search(r"^ID=\"?(\w+)", pathlib.Path("/etc/os-release").read_text(), re.M)[1]


def debian_purl(package, version):
    arch = output("dpkg-query", "-W", "-f", "${Architecture}", package)
    return f"pkg:deb/{distribution()}/{package.split(':')[0]}@{version.replace(':', '%3A').replace('+', '%2B')}?arch={arch}"


def version_of(package):
    return output("dpkg-query", "-W", "-f", "${Version}", package)


def table():
    return json.loads((HERE / "components.json").read_text())


def compiled_in():
    found = []
    for c in table()["compiled_in"]:
        try:
            version = version_of(c["package"])
        except subprocess.CalledProcessError as error:
            if c["name"] == "pybind11":
                continue  # built without the Python module
            raise UnknownComponent(f"{c['package']} is not installed, expected the headers of "
                                   f"{c['name']}: tools/deps build package") from error
        found.append(Component(c["name"], version, c["spdx"], "compiled in",
                               debian_purl(c["package"], version), tuple(c["copyright"]),
                               c["licence"], c["headers"]))
    return found


def in_the_pages(web=WEB):
    """The npm packages that src/web/package.json lists as dependencies: Vite puts them into the pages.
    devDependencies only build and test them."""
    wanted = json.loads((web / "package.json").read_text())["dependencies"]
    locked = json.loads((web / "package-lock.json").read_text())["packages"]
    found = []
    for name in sorted(wanted):
        lock = locked[f"node_modules/{name}"]
        files = list((web / "node_modules" / name).glob("LICEN[CS]E*"))
        if not files:
            raise UnknownComponent(f"src/web/node_modules/{name} has no LICENSE: run tools/deps build")
        text = files[0].read_text(encoding="utf-8")
        owner = re.search(r"^Copyright (?:©|\(c\)) (.+)$", text, re.M)
        if not owner or lock["license"] != "MIT":
            raise UnknownComponent(f"{files[0]}: found the licence {lock['license']}, expected MIT with "
                                   "a line of copyright: adapt tools/packaging/components.py")
        found.append(Component(name, lock["version"], lock["license"], "in the pages",
                               f"pkg:npm/{name}@{lock['version']}", (f"{owner[1]} ({name})",), "Expat",
                               "src/web/dist", text))
    return found


def owner_of(file):
    """The package of a shared library. /lib and /usr/lib are one folder; packages name either."""
    real = str(pathlib.Path(file).resolve())
    names = {real, file, real.removeprefix("/usr"), str(file).removeprefix("/usr")}
    for name in sorted(names):
        found = subprocess.run(["dpkg", "-S", name], capture_output=True, text=True)
        if found.returncode == 0:
            return found.stdout.splitlines()[0].partition(": ")[0].split(",")[0]
    raise UnknownComponent(f"no package owns {file}: expected libraries of the distribution alone")


def library(file, kind):
    package = owner_of(file)
    source = output("dpkg-query", "-W", "-f", "${source:Package}", package)
    source = "gcc" if re.fullmatch(r"gcc-\d+", source) else source
    licences = table()["linked"]
    if source not in licences:
        raise UnknownComponent(f"{file} is from the source package {source}, which has no licence in "
                               "tools/packaging/components.json: add it")
    version = version_of(package)
    return Component(package.split(":")[0], version, licences[source], kind,
                     debian_purl(package, version))


def linked(binaries):
    """The packages of the shared libraries that the ELF files name, without their own."""
    found = {}
    own = {pathlib.Path(binary).resolve().name for binary in binaries}
    for binary in binaries:
        needed = set(re.findall(r"NEEDED\s+(\S+)", output("objdump", "-p", str(binary))))
        for name, file in re.findall(r"(\S+) => (/\S+)", output("ldd", str(binary))):
            if name in needed and pathlib.Path(file).resolve().name not in own:
                component = library(file, "linked")
                found[component.name] = component
    return [found[name] for name in sorted(found)]


def loaded(file_name):
    """The library that is opened at run time, by its file name."""
    listing = output("/sbin/ldconfig", "-p")
    file = re.search(rf"{re.escape(file_name)} .*=> (\S+)", listing)
    return [library(file[1], "loaded")] if file else []
