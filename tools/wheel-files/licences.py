"""licences.py WHEEL FOLDER: writes the wheel anew with the licences of the libraries that auditwheel has put into it:
dist-info/licenses/bundled/PACKAGE/copyright, as Debian's and Ubuntu's packages state them."""

import pathlib
import re
import shutil
import subprocess
import sys
import tempfile


def package_of(library):
    """The distribution's package that has it. auditwheel has added a hash to its name."""
    name = re.sub(r"-[0-9a-f]{8}(?=\.so)", "", library.name)
    found = subprocess.run(["dpkg", "-S", f"*/{name}"], capture_output=True, text=True, check=False).stdout
    packages = {line.partition(":")[0] for line in found.splitlines() if line.endswith(f"/{name}")}
    if not packages:
        # An alternative, such as libblas.so.3: the file that it leads to.
        for folder in pathlib.Path("/usr/lib").glob("*-linux-gnu"):
            target = (folder / name).resolve()
            if target.exists():
                found = subprocess.run(["dpkg", "-S", str(target)], capture_output=True, text=True, check=True).stdout
                packages = {found.partition(":")[0]}
    if not packages:
        raise SystemExit(f"licences.py: {library.name}: no package of the distribution has {name}; expected one, whose "
                         "licence goes into the wheel")
    return sorted(packages)[0]


def main(wheel, folder):
    with tempfile.TemporaryDirectory() as temporary:
        subprocess.run([sys.executable, "-m", "wheel", "unpack", "--dest", temporary, wheel], check=True)
        (root,) = pathlib.Path(temporary).iterdir()
        (info,) = root.glob("*.dist-info")
        packages = sorted({package_of(library) for library in root.glob("*.libs/*.so*")})
        for package in packages:
            target = info / "licenses/bundled" / package
            target.mkdir(parents=True)
            shutil.copy(f"/usr/share/doc/{package}/copyright", target / "copyright")
        pathlib.Path(folder).mkdir(parents=True, exist_ok=True)
        subprocess.run([sys.executable, "-m", "wheel", "pack", "--dest-dir", folder, root], check=True)
    print(f"licences of {len(packages)} packages: {' '.join(packages)}")


if __name__ == "__main__":
    main(*sys.argv[1:])
