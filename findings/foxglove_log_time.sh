#!/usr/bin/env bash
# foxglove-sdk 0.30.3 (writes MCAP files and serves viewers)
#
# Behaviour: Channel.log writes a message with the time of the call as its log time and publish time, also for the
# well-known messages that have a timestamp of their own. A recorded run that a loop exports lasts some milliseconds
# in a viewer, since viewers play by log time.
#
# A good engineer would guess: a message with a timestamp is logged at that time.
#
# So: pass log_time= with every message.
. "$(dirname "$0")/lib.sh"
python_with foxglove-sdk==0.30.3 mcap==1.6.0
"$python" - << 'PY'
import foxglove
from foxglove.channels import PoseInFrameChannel
from foxglove.messages import Pose, PoseInFrame, Quaternion, Timestamp, Vector3
from mcap.reader import make_reader
def pose(k):
    return PoseInFrame(timestamp=Timestamp(sec=100 + k, nsec=0), frame_id="world",
                       pose=Pose(position=Vector3(x=k, y=0, z=0), orientation=Quaternion(x=0, y=0, z=0, w=1)))
writer = foxglove.open_mcap("walk.mcap")
default, stated = PoseInFrameChannel("/default"), PoseInFrameChannel("/stated")
for k in range(20):
    default.log(pose(k))
    stated.log(pose(k), log_time=(100 + k) * 10**9)
writer.close()
spans = {}
for topic in ("/default", "/stated"):
    times = [message.log_time / 1e9 for _, _, message in make_reader(open("walk.mcap", "rb")).iter_messages(topics=[topic])]
    spans[topic] = max(times) - min(times)
print("  20 poses over 19 s; log times span " + ", ".join(f"{span:.3f} s in {topic}" for topic, span in spans.items()))
assert spans["/default"] < 1 and spans["/stated"] == 19
PY
