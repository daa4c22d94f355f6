"""Makes the seeds under seeds/ from the repository's own examples and test files, a few rows of each, with the writers of
../terra-data/tests/readers/files/make.py. Seeds are kept in the repository, so this is run only when they should change.

    pip install mcap-ros2-support pyarrow scipy numpy
    python seeds.py
"""

import importlib.util
import shutil
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from mcap.writer import CompressionType, IndexType, Writer
from scipy.io import savemat

HERE = Path(__file__).parent
ROOT = HERE.parent
FILES = ROOT / "terra-data/tests/readers/files"
SEEDS = HERE / "seeds"
#: Rows of a log that a mutation still reaches.
ROWS = 3


def makers():
    spec = importlib.util.spec_from_file_location("make", FILES / "make.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def put(target, name, content):
    folder = SEEDS / target
    folder.mkdir(parents=True, exist_ok=True)
    data = content if isinstance(content, bytes) else content.encode()
    (folder / name).write_bytes(data)


def copies():
    """Configurations as they stand."""
    rovers = [*ROOT.glob("examples/*/rover.toml"), *ROOT.glob("examples/*/rig.toml"), *ROOT.glob("terra-cli/src/init/*.toml")]
    for path in rovers:
        put("rover_toml", f"{path.parent.name}_{path.name}", path.read_bytes())
    for path in ROOT.glob("examples/*/*.toml"):
        text = path.read_text()
        if "[[segment]]" in text or "[[trial]]" in text:
            put("scenario_toml", f"{path.parent.name}_{path.name}", text)
    put("topics_toml", "topics.toml", (FILES / "topics.toml").read_bytes())
    rate = (FILES / "topics.toml").read_text().replace('at = "/joint_states"', "rate_hz = 250.0")
    put("topics_toml", "rate.toml", rate)


def texts():
    lines = (FILES / "drive.csv").read_text().splitlines()
    put("drive_csv", "drive.csv", "\n".join(lines[: ROWS + 1]) + "\n")
    put(
        "drive_csv",
        "columns.csv",
        "t,fl,fr,rl,rr,ifl,ifr,irl,irr,v,pitch,note\n0,10,10,10,10,100,100,100,100,1.5,2,a\n10,,nan,10,10,100,100,100,1e9,1.5,2,\"a, b\"\n",
    )
    put(
        "drive_csv",
        "segments.csv",
        "segment,time_s,wheel_speed_fl_rad_s,wheel_speed_fr_rad_s,wheel_speed_rl_rad_s,wheel_speed_rr_rad_s,ground_speed_m_s,pass\na,0,1,2,,nan,0.5,1\na,0.1,1,2,3,4,1e9,1\nb,0,1,1,1,1,1,2\n",
    )
    put("rig_csv", "rig.csv", "trial,condition,slip,slip_sd,normal_load_N,torque_N_m,drawbar_pull_N,sinkage_m\na,smooth,.1,.01,80,2,5,.01\nb,,-.5,,80,3,,\nc,smooth,2,,80,,,\n")
    put("rig_csv", "speeds.csv", "trial,time_s,pass,rim_speed_m_s,travel_speed_m_s,normal_load_N,normal_load_sd_N,torque_N_m\na,0,1,.1,.08,80,1,2\na,.5,1,.1,.05,80,1,2\n")
    put("rig_csv", "columns.csv", "slip_pct,Fz,Fx,z,beta\n20,.08,5,10,2\n40,.08,7,12,0\n")
    put(
        "terrains_csv",
        "soils.csv",
        "# mine\nid,set,name,n,kc_kN_m_n1,kphi_kN_m_n2,c_kPa,phi_deg,K_m,c1,c2,conf,source_note\nsand,mine,Dry sand,1.1,0.9,1523.4,1.04,28,0.025,0.18,0.32,B,\"a table, page 3\"\nclay,mine,Clay,0.5,13.2,692.2,4.14,13,NA,NA,NA,,NA\n",
    )
    put(
        "scm_json",
        "soft.json",
        '{"Name": "soft", "Parameters": {"Bekker Kphi": 0.2e6, "Bekker Kc": 0, "Bekker n exponent": 1.1, "Mohr cohesive limit": 250.0, "Mohr friction limit": 20, "Janosi shear coefficient": 0.01}}\n',
    )
    for k, name in enumerate(
        ["wong-reece", "wong-reece:reece:wong-hump", "wong-reece+slip-sinkage+multipass", "scm-column", "grouser-passive", "slip-sinkage=wong", "percent"]
    ):
        put("model_name", f"{k}.txt", name)
    tables = [
        "wheel,rim_speed_cmd_mm_s,slip_longitudinal,Fz_load_N,Fx_tractive_N,sinkage_mm,Fy_side_N,slip_angle_deg,travel_speed_mm_s,rim_speed_mm_s\nsmooth,10,.1,80,5,10,0,0,9,10\n",
        "case_id,grouser_height_m,slip,vertical_load_n,meas_drawbar_pull_n,meas_torque_nm,meas_sinkage_m\na,0,.1,80,5,2,.01\nb,.01,.3,80,9,4,NA\n",
        "window,calib_step,k,wl_rad_s,wr_rad_s,x_m,y_m,yaw_rad,ax_m_s2,ay_m_s2\n0,1,0,1,1,0,0,0,.1,0\n0,1,1,1,1,.1,0,3.1,.1,0\n0,1,2,1,1,.2,.1,-3.1,,0\n1,1,0,1,1,0,0,0,.1,0\n",
        "terrain,run,time,velL,velR,curL,curR\nSAND,1,0,.2,.2,1,1\nSAND,1,.1,.2,.2,1,1\nSAND,1,.1,.2,NA,1,1\n",
    ]
    for k, table in enumerate(tables):
        put("data_sets", f"{k}.bin", bytes([k]) + table.encode())
    head = [0, 1, 0, 0]
    number = lambda x: list(np.float64(x).tobytes())  # noqa: E731
    text = lambda t: [len(t) + 1, 0, 0, 0, *t.encode(), 0]  # noqa: E731
    message = lambda body: bytes([len(body), *body])  # noqa: E731
    flat = [*head, *number(0.5), 2, 0, 0, 0, 0, 0, 0, 0, *number(1.0), *number(2.0)]
    put("bag_messages", "numbers.bin", b"float64 v\nfloat64[] list\n---\n" + message(flat) + message(flat))
    named = [*head, *number(0.5), 1, 0, 0, 0, *text("front"), 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, *number(3.0)]
    put("bag_messages", "names.bin", b"float64 v\nInner a\nMSG: my/Inner\nstring[] name\nfloat64[] x\n---\n" + message(named))
    stamp = [*head, 5, 0, 0, 0, 0, 1, 0, 0, *text("base"), 0, 0, 0, *number(0.5)]
    put(
        "bag_messages",
        "header.bin",
        b"std_msgs/Header header\nfloat64 v\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n---\n"
        + message(stamp),
    )


def commands():
    """What the command itself reads: bevameter tests, plans, keys, verdicts, tables."""
    plates = "test,soil,plate_diameter_m,sinkage_m,pressure_Pa\n" + "".join(
        f"{test},s,{width},{z / 100},{stiffness * (z / 100) ** 1.1:.1f}\n"
        for test, width, stiffness in (("a", 0.1, 3e6), ("b", 0.2, 2.5e6))
        for z in range(1, 7)
    )
    put("bevameter_csv", "plates.csv", plates)
    shear = "test,normal_stress_Pa,shear_displacement_m,shear_stress_Pa\n" + "".join(
        f"{p},{p},{j / 200},{(500 + 0.5 * p) * (1 - np.exp(-j / 2)):.1f}\n" for p in (5000, 10000) for j in range(1, 7)
    )
    put("bevameter_csv", "shear.csv", shear)
    columns = """[columns]
test = { from = "id" }
sinkage_m = { from = "z", unit = "mm" }
pressure_Pa = { from = "p", unit = "kPa" }
plate_diameter_m = { from = "body", values = { d60 = 0.06, d80 = 0.08 } }
[fit]
from_m = 0.002
to_m = 0.08
"""
    rows = "".join(f"{k},{body},{z},{z * 3 + k}\n" for k, body in enumerate(("d60", "d80", "x")) for z in (2, 4, 8, 16, 32))
    put("bevameter_csv", "columns.bin", columns + "\0# mine\nid,body,z,p\n" + rows)
    put("bevameter_csv", "value.bin", "[columns]\nnormal_stress_Pa = { value = 5, unit = \"kPa\" }\n\0" + shear.replace("normal_stress_Pa", "other"))
    head = 'scenario = "trials.toml"\nruns = 3\nseed = 5\n'
    put("sweep_plan", "grid.toml", f'command = "simulate"\n{head}[vary]\nterrain = ["dry_sand", "lean_clay_22"]\n"effect.0.magnitude" = [0.1, 0.4]\n')
    put("sweep_plan", "nested.toml", f'command = "gap"\n{head}vary.trial.0.normal_load_N = [[150.0], [1, 2]]\nvary.effect = [[], [{{ name = "slip-sinkage", magnitude = 0.2 }}]]\n')
    put("sweep_plan", "plain.toml", f'command = "identify"\n{head}')
    key = (HERE / "fixed/key.json").read_text()
    put("challenge_key", "key.bin", key + "\0a " + "0" * 64 + "\nb " + "f" * 64 + "\n")
    effect = '{"magnitude": [0.1, 0.25], "name": "clock-offset"}'
    whole = """{"schema": "terra-challenge-key/1", "design": {"name": "rig", "rover": "", "scenario": ""}, "draws": {"moving_windows": 2, "window_s": 0.2,
"speed_m_s": 0.01, "rejected": 1}, "cases": [{"case": "case_001", "nonce": "ab", "key": {"kind": "form-variant", "effects": [EFFECT], "seed": 1, "rejected": 3,
"soil": {"left": {"k_phi": 1528430.0}}, "terrain": {"k_phi": 1e6}}}]}""".replace("EFFECT", effect)
    put("challenge_key", "whole.bin", whole)
    verdict = """{"schema": "terra-gap/1", "verdict": "named", "causes": [{"effect": "slip-sinkage", "probability": 0.8, "log_evidence_gain": 12.5, "indistinguishable_from":
["multipass"]}], "probability_none": 0.1, "probability_unknown": 0.1, "set": ["slip-sinkage", "none"], "after": {"effects": ["slip-sinkage"], "held_out":
{"by": "slip", "closed": {"mean": 0.5, "lo": 0.2, "hi": 0.7}}}, "gap": {"chi2_per_dof": {"nominal_refitted": 4.5}}}"""
    put("verdict_json", "named.json", verdict)
    put("verdict_json", "none.json", '{"schema": "terra-gap/1", "verdict": "none", "causes": [], "probability_none": 1, "probability_unknown": 0, "set": ["none"]}')
    put("hypotheses_toml", "grid.toml", """[[set]]
hypotheses = "wong21"
perturb = { copies = 1, sd = 0.05 }
[[set]]
name = "clay"
start = "lean_clay_22"
grid = [{ parameter = "cohesion", from = 1e4, to = 8e4, points = 2 }, { parameter = "friction_angle", from = 0.1, to = 0.3, points = 2 }]
""")
    put("hypotheses_toml", "cube.toml", """[[set]]
model = "wong-reece+slip-sinkage"
start = "dry_sand"
seed = 3
latin_hypercube = { count = 5, axes = [{ parameter = "friction_angle", from = 0.4, to = 0.7 }] }
""")
    put("hypotheses_toml", "file.toml", """[[set]]
hypotheses = "soils.csv"
[[set]]
start = { k_eq = 1.5e6, sinkage_exponent = 1.1, cohesion = 1040.0, friction_angle = 0.5, c1 = 0.2, c2 = 0.3, shear_modulus = 0.02 }
perturb = { copies = 2 }
""")
    put("tables", "matrix.bin", "\0" + "0.9 0.1 0\n0.05,0.9,0.05\n\n0 0.1 0.9\n")
    identified = """{"schema": "terra-identify/1", "groups": [{"group": "all", "refined": {"start": "dry_sand", "parameters": {"k_eq": {"mean": 1.5e6, "sd": 3.1e5},
"cohesion": {"mean": 1000.0}, "friction_angle": {"mean": 0.5}, "shear_modulus": {"mean": 0.02}, "sinkage_exponent": {"mean": 1.1}}}}]}"""
    put("tables", "identify.bin", "\x01" + identified)
    put("tables", "shard.bin", "\x02" + '{"run":0,"seed":1,"vary":{},"result":{}}\n{"run":1,"seed":2,"vary":{"a":1},"result":null}\n')


def bag(name, **how):
    """A bag of one topic, without the checksums that would keep a mutation from getting any further."""
    folder = SEEDS / "bag"
    folder.mkdir(parents=True, exist_ok=True)
    with open(folder / name, "wb") as file:
        writer = Writer(file, enable_crcs=False, index_types=IndexType.NONE, **how)
        writer.start(profile="ros2")
        definition = b"float64 v\nfloat64[] list\nstring text\n"
        schema = writer.register_schema("my/msg/M", "ros2msg", definition)
        channel = writer.register_channel("/speed", "cdr", schema)
        for k in range(2):
            body = np.float64([0.5, 1.0, 2.0]).tobytes()
            body = body[:8] + (2).to_bytes(8, "little") + body[8:] + (2).to_bytes(4, "little") + b"a\0"
            writer.add_message(channel, log_time=k * 10**7, publish_time=k * 10**7, data=bytes([0, 1, 0, 0]) + body)
        writer.finish()


def binaries():
    make = makers()
    numbers, segments = make.read()
    numbers = {k: v[:ROWS] for k, v in numbers.items()}
    segments = segments[:ROWS]
    make.bag(HERE / "fixed/drive.mcap", numbers, segments, CompressionType.NONE)
    bag("plain.mcap", use_chunking=False)
    bag("chunk.mcap", compression=CompressionType.NONE)
    bag("lz4.mcap", compression=CompressionType.LZ4)
    bag("zstd.mcap", compression=CompressionType.ZSTD)
    (SEEDS / "parquet").mkdir(parents=True, exist_ok=True)
    few = ["time_s", "ground_speed_m_s", "wheel_speed_fl_rad_s"]
    table = pa.table({**{k: numbers[k] for k in few}, "segment": segments})
    pq.write_table(table, SEEDS / "parquet/snappy.parquet", compression="snappy", store_schema=False)
    pq.write_table(table, SEEDS / "parquet/plain.parquet", compression="none", use_dictionary=False, store_schema=False)
    mixed = pa.table({"time_s": pa.array([0, 1], pa.timestamp("us")), "n": pa.array([1, None], pa.int32()), "b": [True, False]})
    pq.write_table(mixed, SEEDS / "parquet/mixed.parquet", data_page_version="2.0", store_schema=False)
    (SEEDS / "mat").mkdir(parents=True, exist_ok=True)
    few = ["time_s", "ground_speed_m_s"]
    log = {**{k: numbers[k].reshape(-1, 1) for k in few}, "segment": np.array(segments, dtype=object).reshape(-1, 1)}
    savemat(SEEDS / "mat/structure.mat", {"log": log, "rate": 100.0}, do_compression=False)
    flat = {**{k: numbers[k] for k in few}, "segment": np.array(segments), "n": np.array([[1, 2], [3, 4], [5, 6]], dtype=np.int8)}
    savemat(SEEDS / "mat/plain.mat", flat, do_compression=False, long_field_names=True)
    savemat(SEEDS / "mat/compressed.mat", {k: numbers[k] for k in few}, do_compression=True)


if __name__ == "__main__":
    shutil.rmtree(SEEDS, ignore_errors=True)
    copies()
    texts()
    commands()
    binaries()
