"""Runs the commands of docs/ros2.md, "Try it without a robot"."""
import csv
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
BIN = Path(os.environ['CHASLES_DDS_BINARY']).parent


def main():
    page = (ROOT / 'docs/ros2.md').read_text()
    section = page.split('## Try it without a robot')[1].split('\n## ')[0]
    block = re.search(r'```sh\n(.*?)```', section, re.DOTALL).group(1)
    with tempfile.TemporaryDirectory() as folder:
        script = 'set -e\nmkdir out\n' + block.replace('build/release/bin', str(BIN))
        run = subprocess.run(['bash', '-c', script], cwd=folder, timeout=100, capture_output=True, text=True)
        print(run.stdout, run.stderr)
        with open(Path(folder) / 'out/run/states.csv', newline='') as stream:
            states = list(csv.DictReader(stream))
        html = (Path(folder) / 'out/page.html').stat().st_size
    ok = run.returncode == 0 and len(states) > 50 and html > 100_000 and '"odometry": 0' not in run.stdout
    print(f'{len(states)} states, a page of {html} bytes')
    return 0 if ok else 1


if __name__ == '__main__':
    sys.exit(main())
