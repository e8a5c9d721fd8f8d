# Shared by the scripts here: `. "$(dirname "$0")/lib.sh"`. Each script works in a temporary folder, $work,
# which goes when the script ends.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"

# python_with PACKAGE==VERSION...: $python is a Python of its own with these packages of PyPI.
python_with() {
  "${PYTHON:-/usr/bin/python3}" -m venv "$work/venv"
  "$work/venv/bin/pip" install --quiet --disable-pip-version-check "$@"
  python="$work/venv/bin/python"
  export PATH="$work/venv/bin:$PATH" PYTHONDONTWRITEBYTECODE=1
  echo "with $*:"
}
