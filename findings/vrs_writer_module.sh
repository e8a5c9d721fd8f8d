#!/usr/bin/env bash
# vrs 1.2.2 (reads and writes VRS files, as Project Aria's glasses record them)
#
# Behaviour: the wheel has a module pyvrs.writer with VRSWriter, but importing it raises an ImportError: it needs four
# names of the compiled module that the package does not pass on. The compiled Writer works, and only writes streams of
# the type 65500 with layouts of its own, so no other program finds cameras or an IMU in them.
#
# A good engineer would guess: what a wheel ships can be imported.
#
# So: the test of the conversion of Aria's recordings writes its VRS file itself, and projectaria-tools reads it.
. "$(dirname "$0")/lib.sh"
python_with vrs==1.2.2
"$python" - << 'PY'
import vrsbindings

failure = None
try:
    import pyvrs.writer
except ImportError as error:
    failure = str(error)
writer, streams = vrsbindings.Writer(), {}
for name in ("sample", "sample_with_image", "slam"):
    try:
        streams[name] = writer.createStream(name).getStreamID()
    except ValueError:
        streams[name] = None
print(f"  import pyvrs.writer: {failure}\n  streams: {streams}")
assert failure and "RecordFormat" in failure
assert streams["sample"].startswith("65500-") and streams["sample_with_image"].startswith("65500-") and streams["slam"] is None
PY
