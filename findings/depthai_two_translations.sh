#!/usr/bin/env bash
# depthai 3.12.0 (the SDK of OAK cameras)
#
# Behaviour: a calibration has two translations between two cameras, the calibrated one and that of the board's
# drawing ("spec"). CalibrationHandler.getCameraExtrinsics returns the calibrated one by default, but
# getCameraTranslationVector and getBaselineDistance return the drawing's (useSpecTranslation is False there and True
# here). All are in centimetres, also in the JSON file, whose "lengthUnit": 1 says so in a number.
#
# A good engineer would guess: the translation vector is the last column of the extrinsics, in metres.
#
# So: read "translation" of the JSON, not "specTranslation", and divide by 100.
. "$(dirname "$0")/lib.sh"
python_with depthai==3.12.0 numpy==2.2.6
"$python" - 2> log.txt << 'PY' | grep -v warning
import depthai as dai
left, right = dai.CameraBoardSocket.CAM_B, dai.CameraBoardSocket.CAM_C
K, I = [[400.0, 0, 320], [0, 400, 200], [0, 0, 1]], [[1.0, 0, 0], [0, 1, 0], [0, 0, 1]]
handler = dai.CalibrationHandler()
for camera in (left, right):
    handler.setCameraIntrinsics(camera, K, 640, 400)
handler.setCameraExtrinsics(left, right, I, [-7.52, 0.01, 0.02], [-7.5, 0, 0])  # calibrated, and of the drawing
column = [round(row[3], 3) for row in handler.getCameraExtrinsics(left, right)[:3]]
vector = [round(v, 3) for v in handler.getCameraTranslationVector(left, right)]
metres = [round(v, 5) for v in handler.getCameraTranslationVector(left, right, unit=dai.LengthUnit.METER)]
unit = handler.eepromToJson()["cameraData"][1][1]["extrinsics"]["lengthUnit"]
print(f"  last column of the extrinsics {column}, translation vector {vector}; in metres {metres}; lengthUnit {unit}")
assert column == [-7.52, 0.01, 0.02] and vector == [-7.5, 0, 0] and metres == [-0.075, 0, 0] and unit == 1
PY
