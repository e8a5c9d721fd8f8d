#!/usr/bin/env bash
# projectaria-tools 2.3.0 (recordings and trajectories of Project Aria)
#
# Behaviour: read_closed_loop_trajectory and read_global_point_cloud raise nothing for a file that they cannot read.
# Without one of the columns, even one that nobody needs, the result is an empty list. With "nan" in one number it is the
# list of the rows before: a trajectory of 5 poses has 2. An empty cell is read as 0, so a pose moves, and without a
# quaternion its rotation is NaN.
#
# A good engineer would guess: a broken file is an error, or its broken rows are left out.
#
# So: compare the number of poses with the number of lines, and write every column and finite numbers only.
. "$(dirname "$0")/lib.sh"
python_with --no-deps projectaria-tools==2.3.0 numpy==2.4.6
"$python" - 2> messages.txt << 'PY'
import math
from projectaria_tools.core import mps

columns = ("graph_uid,tracking_timestamp_us,utc_timestamp_ns,tx_world_device,ty_world_device,tz_world_device,"
           "qx_world_device,qy_world_device,qz_world_device,qw_world_device,device_linear_velocity_x_device,"
           "device_linear_velocity_y_device,device_linear_velocity_z_device,angular_velocity_x_device,"
           "angular_velocity_y_device,angular_velocity_z_device,gravity_x_world,gravity_y_world,gravity_z_world,"
           "quality_score").split(",")
rows = [f"g,{1000 * i},-1,1,2,3,0,0,0,1,0,0,0,0,0,0,0,0,-9.81,1".split(",") for i in range(5)]


def read(change=lambda table: None):
    table = [list(columns), *map(list, rows)]
    change(table)
    with open("trajectory.csv", "w") as file:
        file.writelines(",".join(row) + "\n" for row in table)
    return mps.read_closed_loop_trajectory("trajectory.csv")


def put(column, text):
    return lambda table: table[3].__setitem__(columns.index(column), text)


whole, cut, empty = read(), read(put("tx_world_device", "nan")), read(put("tx_world_device", ""))
lacking = read(lambda table: [row.pop() for row in table])
x = [float(pose.transform_world_device.translation().flatten()[0]) for pose in empty]
no_rotation = read(lambda table: [put(f"q{axis}_world_device", "")(table) for axis in "xyzw"])
w = float(no_rotation[2].transform_world_device.to_quat_and_translation().flatten()[0])
print(f"  poses: {len(whole)} of 5; {len(lacking)} without quality_score; {len(cut)} with a nan in the third; "
      f"x with an empty cell {x}; a rotation of empty cells has w = {w}")
assert len(whole) == 5 and len(lacking) == 0 and len(cut) == 2 and x == [1, 1, 0, 1, 1] and math.isnan(w)
PY
