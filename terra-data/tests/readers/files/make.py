"""Makes the files beside it from drive.csv, each with the writer its users have: Foxglove's mcap-ros2-support, pyarrow and
scipy. None of them shares code with the readers they test.

    terra simulate examples/paper/lean_clay.toml --out all.csv, the first 60 rows of which are drive.csv
    pip install mcap-ros2-support pyarrow scipy numpy
    python make.py
"""

import csv
from pathlib import Path

import numpy as np
from mcap.writer import CompressionType
from mcap_ros2.writer import Writer

HERE = Path(__file__).parent
LINE = "=" * 80
TIME = f"{LINE}\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"
HEADER = f"{LINE}\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n" + TIME
XYZ = "float64 x\nfloat64 y\nfloat64 z\n"
VECTOR = f"{LINE}\nMSG: geometry_msgs/Vector3\n{XYZ}"
QUATERNION = f"{LINE}\nMSG: geometry_msgs/Quaternion\nfloat64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n"
TWIST = f"{LINE}\nMSG: geometry_msgs/Twist\nVector3  linear\nVector3  angular\n" + VECTOR
TWIST_COV = f"{LINE}\nMSG: geometry_msgs/TwistWithCovariance\nTwist twist\nfloat64[36] covariance\n" + TWIST
POSE_COV = (
    f"{LINE}\nMSG: geometry_msgs/PoseWithCovariance\nPose pose\nfloat64[36] covariance\n"
    f"{LINE}\nMSG: geometry_msgs/Pose\nPoint position\nQuaternion orientation\n"
    f"{LINE}\nMSG: geometry_msgs/Point\n{XYZ}" + QUATERNION
)
DEFINITIONS = {
    "sensor_msgs/msg/JointState": "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n" + HEADER,
    "sensor_msgs/msg/Imu": "std_msgs/Header header\ngeometry_msgs/Quaternion orientation\nfloat64[9] orientation_covariance # row major\ngeometry_msgs/Vector3 angular_velocity\nfloat64[9] angular_velocity_covariance\ngeometry_msgs/Vector3 linear_acceleration\nfloat64[9] linear_acceleration_covariance\n" + HEADER + QUATERNION + VECTOR,
    "nav_msgs/msg/Odometry": "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/PoseWithCovariance pose\ngeometry_msgs/TwistWithCovariance twist\n" + HEADER + POSE_COV + TWIST_COV,
    "geometry_msgs/msg/TwistStamped": "std_msgs/Header header\nTwist twist\n" + HEADER + TWIST,
    "geometry_msgs/msg/TwistWithCovarianceStamped": "std_msgs/Header header\nTwistWithCovariance twist\n" + HEADER + TWIST_COV,
    "std_msgs/msg/Float64": "float64 data\n",
    "std_msgs/msg/String": "string data\n",
}  # fmt: skip
WHEELS = ["fl", "fr", "rl", "rr"]
START = 1_700_000_000_000_000_000


def read():
    with open(HERE / "drive.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    numbers = {k: np.array([float(r[k]) for r in rows]) for k in rows[0] if k != "segment"}
    return numbers, [r["segment"] for r in rows]


def bag(path, numbers, segments, compression):
    """A drive as a bag: topics.toml is its map."""
    with open(path, "wb") as file:
        writer = Writer(file, compression=compression)
        schemas = {k: writer.register_msgdef(k, text) for k, text in DEFINITIONS.items()}
        vector = lambda x=0.0, y=0.0, z=0.0: {"x": x, "y": y, "z": z}  # noqa: E731
        twist = lambda x=0.0, y=0.0, z=0.0: {"linear": vector(x, y), "angular": vector(z=z)}  # noqa: E731
        for k, t in enumerate(numbers["time_s"]):
            stamp = START + round((t - numbers["time_s"][0]) * 1e9)
            header = {"stamp": {"sec": stamp // 10**9, "nanosec": stamp % 10**9}, "frame_id": "base"}
            v, r = numbers["ground_speed_m_s"][k], numbers["yaw_rate_rad_s"][k]
            # Joints in an order that changes, as drivers do.
            order = WHEELS if k % 2 else WHEELS[::-1]
            messages = [
                ("/joint_states", "sensor_msgs/msg/JointState", {
                    "header": header,
                    "name": [f"wheel_{w}" for w in order],
                    "position": [],
                    "velocity": [numbers[f"wheel_speed_{w}_rad_s"][k] for w in order],
                    "effort": [numbers[f"wheel_torque_{w}_N_m"][k] for w in order],
                }),
                ("/imu/data", "sensor_msgs/msg/Imu", {
                    "header": header,
                    "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0},
                    "orientation_covariance": [0.0] * 9,
                    "angular_velocity": vector(z=r),
                    "angular_velocity_covariance": [0.0] * 9,
                    # Mounted backwards: -x.
                    "linear_acceleration": vector(x=-numbers["accel_x_m_s2"][k], z=9.81),
                    "linear_acceleration_covariance": [0.0] * 9,
                }),
                ("/odom", "nav_msgs/msg/Odometry", {
                    "header": header,
                    "child_frame_id": "base_link",
                    "pose": {"pose": {"position": vector(), "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}}, "covariance": [0.0] * 36},
                    "twist": {"twist": twist(v, 0.0, r), "covariance": [0.0] * 36},
                }),
                ("/twist", "geometry_msgs/msg/TwistStamped", {"header": header, "twist": twist(v)}),
                ("/twist_cov", "geometry_msgs/msg/TwistWithCovarianceStamped", {"header": header, "twist": {"twist": twist(v), "covariance": [0.0] * 36}}),
                ("/pitch", "std_msgs/msg/Float64", {"data": 0.5 * k}),
                ("/manoeuvre", "std_msgs/msg/String", {"data": segments[k]}),
            ]  # fmt: skip
            for topic, kind, message in messages:
                writer.write_message(topic, schemas[kind], message, log_time=stamp, publish_time=stamp)
        writer.finish()


def main():
    import pyarrow as pa
    import pyarrow.parquet as pq
    from scipy.io import savemat

    numbers, segments = read()
    bag(HERE / "drive.mcap", numbers, segments, CompressionType.NONE)
    bag(HERE / "drive_zstd.mcap", numbers, segments, CompressionType.ZSTD)
    table = pa.table({**numbers, "segment": segments})
    pq.write_table(table, HERE / "drive.parquet", compression="snappy")
    log = {**{k: v.reshape(-1, 1) for k, v in numbers.items()}, "segment": np.array(segments, dtype=object).reshape(-1, 1)}
    savemat(HERE / "drive.mat", {"log": log, "rate": 100.0}, do_compression=True)
    flat = {k: v for k, v in numbers.items()}
    flat["segment"] = np.array(segments)
    savemat(HERE / "drive_plain.mat", flat, do_compression=False, long_field_names=True)


if __name__ == "__main__":
    main()
