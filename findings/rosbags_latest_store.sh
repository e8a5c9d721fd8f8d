#!/usr/bin/env bash
# rosbags 0.11.9 (ROS bags in pure Python)
#
# Behaviour: Stores.LATEST has the message definitions of ROS 2 Kilted, although the same version knows the later
# Lyrical (Stores.ROS2_LYRICAL), whose definitions differ.
#
# A good engineer would guess: LATEST is the last of the list.
#
# So: name the distribution, and do not write LATEST.
. "$(dirname "$0")/lib.sh"
python_with rosbags==0.11.9
"$python" - << 'PY'
from rosbags.typesys import Stores, get_typestore
latest = get_typestore(Stores.LATEST)
ros2 = [store for store in Stores if store.value.startswith("ros2_")]
same = [store.value for store in ros2 if get_typestore(store).fielddefs == latest.fielddefs]
print(f"  last of the list: {ros2[-1].value}; LATEST has the definitions of {', '.join(same)}")
assert ros2[-1] is Stores.ROS2_LYRICAL and same == ["ros2_kilted"]
PY
