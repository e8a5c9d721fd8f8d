"""A VRS file with images and IMU samples in the form of Project Aria's Gen 1 glasses. No package on PyPI writes one: the
wheel `vrs` only reads, but for samples of its own. projectaria-tools is what reads these files, and so checks them."""

import json
import math
import struct

SIZES = {"uint32_t": ("I", 4), "uint64_t": ("Q", 8), "int64_t": ("q", 8), "double": ("d", 8), "Bool": ("B", 1)}
CONFIGURATION, DATA = 2, 3
DESCRIPTION_ID, CAMERA_ID, IMU_ID = 2, 1201, 1202

CAMERA = {"camera_id": "uint32_t", "nominal_rate": "double", "image_width": "uint32_t", "image_height": "uint32_t",
          "image_stride": "uint32_t", "image_pixel_format": "uint32_t"}
IMAGE = {"group_id": "uint64_t", "group_mask": "uint64_t", "frame_number": "uint64_t", "exposure_duration_s": "double",
         "gain": "double", "capture_timestamp_ns": "int64_t", "arrival_timestamp_ns": "int64_t", "temperature_deg_c": "double"}
IMU = {"stream_index": "uint32_t", "device_id": "uint64_t", "nominal_rate": "double", "has_accelerometer": "Bool",
       "has_gyroscope": "Bool", "has_magnetometer": "Bool"}
MOTION = {"accelerometer_valid": "Bool", "gyroscope_valid": "Bool", "magnetometer_valid": "Bool", "temperature_deg_c": "double",
          "capture_timestamp_ns": "int64_t", "arrival_timestamp_ns": "int64_t", "accelerometer": "float[3]",
          "gyroscope": "float[3]", "magnetometer": "float[3]"}


def layout(fields):
    """The description of a block of fields one behind the other, and how many bytes it has."""
    described, offset = [], 0
    for name, kind in fields.items():
        if kind == "float[3]":
            described.append({"name": name, "type": "DataPieceArray<float>", "offset": offset, "size": 3})
            offset += 12
        else:
            described.append({"name": name, "type": f"DataPieceValue<{kind}>", "offset": offset})
            offset += SIZES[kind][1]
    return json.dumps({"data_layout": described}), offset


def packed(fields, values):
    return b"".join(struct.pack("<3f", *value) if kind == "float[3]" else struct.pack("<" + SIZES[kind][0], value)
                    for (kind, value) in zip(fields.values(), values))


def text(value):
    return struct.pack("<I", len(value.encode())) + value.encode()


def tags(values):
    return struct.pack("<I", len(values)) + b"".join(text(key) + text(value) for key, value in values.items())


def write_vrs(path, file_tags, images, samples):
    """images: a list of (time [ns], grey array) for each camera; samples: (time [ns], raw force, raw rate, valid) of imu-right
    (of none where it is empty)."""
    streams, records = [], []
    for number, frames in enumerate(images):
        streams.append((CAMERA_ID, number + 1, CAMERA, IMAGE, "+image/raw"))
        height, width = frames[0][1].shape
        grey8 = 1
        records.append((0.0, CAMERA_ID, number + 1, CONFIGURATION, packed(CAMERA, (number, 10.0, width, height, width, grey8))))
        records += [(t * 1e-9, CAMERA_ID, number + 1, DATA, packed(IMAGE, (i, 1, i, 1e-3, 1.0, t, t, math.nan)) + pixels.tobytes())
                    for i, (t, pixels) in enumerate(frames)]
    if samples:
        streams.append((IMU_ID, 1, IMU, MOTION, ""))
        records.append((0.0, IMU_ID, 1, CONFIGURATION, packed(IMU, (0, 0, 1000.0, 1, 1, 0))))
        records += [(t * 1e-9, IMU_ID, 1, DATA, packed(MOTION, (valid, valid, 0, math.nan, t, t, force, rate, (0, 0, 0))))
                    for t, force, rate, valid in samples]
    described = struct.pack("<I", len(streams))
    for kind, instance, configuration, data, content in streams:
        configured, measured = layout(configuration), layout(data)
        described += struct.pack("<iH", kind, instance) + tags({"device_type": "Aria"}) + tags({
            "DL:Configuration:2:0": configured[0], "RF:Configuration:2": f"data_layout/size={configured[1]}",
            "DL:Data:2:0": measured[0], "RF:Data:2": f"data_layout/size={measured[1]}{content}",
            "VRS_Recordable_Flavor": "device/aria"})
    records.sort(key=lambda record: record[0])
    # The description comes first, and the last possible time is its own.
    records.insert(0, (float.fromhex("0x1.fffffffffffffp+1023"), DESCRIPTION_ID, 0, DATA, described + tags(file_tags)))
    with open(path, "wb") as file:
        file_size, record_size = 80, 32
        file.write(struct.pack("<8sQIIqqq24x4s4s", b"VisionRe", 1, file_size, record_size, 0, file_size, 0, b"cord", b"VRS1"))
        before = 0
        for seconds, kind, instance, record, content in records:
            size = record_size + len(content)
            file.write(struct.pack("<IIiIdHBBI", size, before, kind, 2, seconds, instance, record, 0, 0) + content)
            before = size
