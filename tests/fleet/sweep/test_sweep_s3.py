"""sweep into a bucket: a server of S3 on this machine (moto), with s3fs between."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from support.commands import edit

pytest.importorskip("s3fs")
pytest.importorskip("moto.server")
pytestmark = pytest.mark.slow

ROBOT = """\
robot: mast
args: {height: {type: length, default: 0.3 m}}
links: {base_link: {}, mast: {}}
joints: {mast_joint: {type: fixed, parent: base_link, child: mast, xyz: [0, 0, "${height}"]}}
outputs:
  urdf: {file: mast.urdf}
  static_tf_json: {file: deep/static_tf.json}
"""
COUNT = 20
PROJECT = {
    "mast/robot.yaml": ROBOT,
    "fleet.csv": "name,height\n" + "".join(f"r{n},{n} cm\n" for n in range(1, COUNT + 1)),
}
SERVER = """\
import sys
from moto.server import ThreadedMotoServer
server = ThreadedMotoServer("127.0.0.1", port=0, verbose=False)
server.start()
print("http://%s:%s" % server.get_host_and_port(), flush=True)
sys.stdin.read()
"""


@pytest.fixture(autouse=True)
def here(project: Path) -> Path:
    return project


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    """The address of a server of S3: to start one takes longer than all that it is asked for."""
    with subprocess.Popen(
        [sys.executable, "-c", SERVER],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    ) as server:
        assert server.stdout is not None
        yield server.stdout.readline().strip()
        server.kill()


@pytest.fixture
def s3(monkeypatch: pytest.MonkeyPatch, address: str) -> Iterator[Any]:
    """A client of a server that has an empty bucket, "robots"; to sweeps its address is known."""
    import boto3

    for name in ("AWS_ACCESS_KEY_ID", "AWS_SECRET_ACCESS_KEY"):
        monkeypatch.setenv(name, "testing")
    monkeypatch.setenv("AWS_DEFAULT_REGION", "us-east-1")
    monkeypatch.setenv("AWS_ENDPOINT_URL", address)
    client = boto3.client("s3")
    client.create_bucket(Bucket="robots")
    yield client
    for one in client.list_objects_v2(Bucket="robots").get("Contents", []):
        client.delete_object(Bucket="robots", Key=one["Key"])
    client.delete_bucket(Bucket="robots")
    client.close()


def there(s3: Any) -> dict[str, bytes]:
    """Return what is in the bucket below ``fleet``, of what people look at."""
    found = s3.list_objects_v2(Bucket="robots", Prefix="fleet/").get("Contents", [])
    names = [one["Key"] for one in found if not one["Key"].startswith("fleet/.")]
    return {name.removeprefix("fleet/"): s3.get_object(Bucket="robots", Key=name)["Body"].read() for name in names}


def words(out: str, *more: str) -> list[str]:
    return [sys.executable, "-m", "rosorin_compile", "sweep", "mast", "--over", "fleet.csv", "-o", out, *more]


def swept(out: str, *more: str) -> dict[str, int]:
    """Run a sweep; return its table."""
    done = subprocess.run(words(out, *more), capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    rows = (line.split() for line in done.stdout.splitlines())
    return {row[0]: int(row[1]) for row in rows if row[0] in ("made", "unchanged", "errors")}


def made_here() -> dict[str, bytes]:
    swept("here")
    files = (path for path in Path("here").glob("[!.]*/**/*") if path.is_file())
    return {path.relative_to("here").as_posix(): path.read_bytes() for path in files}


@pytest.mark.tier("outside")
def test_a_bucket_gets_what_a_folder_gets(s3: Any) -> None:
    assert swept("s3://robots/fleet", "-j", "2") == {"made": COUNT, "unchanged": 0, "errors": 0}
    alone, found = made_here(), there(s3)
    index = json.loads(found.pop("sweep.json"))
    assert found == alone
    assert index["variants"] == json.loads(Path("here/sweep.json").read_bytes())["variants"]
    assert swept("s3://robots/fleet") == {"made": 0, "unchanged": COUNT, "errors": 0}
    edit(Path("fleet.csv"), "r7,7 cm", "r7,8 cm")
    edit(Path("fleet.csv"), "r8,8 cm\n", "")
    assert swept("s3://robots/fleet", "--prune") == {"made": 1, "unchanged": COUNT - 2, "errors": 0}
    found = there(s3)
    assert found["r7/mast.urdf"] == alone["r8/mast.urdf"]
    assert not any(name.startswith("r8/") for name in found)


@pytest.mark.tier("outside")
def test_what_is_killed_goes_on(s3: Any) -> None:
    run = subprocess.Popen(words("s3://robots/fleet", "-j", "2", "-q"), stderr=subprocess.DEVNULL)
    until = time.monotonic() + 60
    while len(there(s3)) < 10 and time.monotonic() < until:
        time.sleep(0.1)
    os.kill(run.pid, 9)
    run.wait()
    assert "sweep.json" not in there(s3)
    told = swept("s3://robots/fleet", "-j", "1")
    assert told["unchanged"] >= 4
    found = there(s3)
    index = json.loads(found.pop("sweep.json"))
    assert found == made_here()
    assert [one["status"] for one in index["variants"]] == ["made"] * COUNT


@pytest.mark.tier("outside")
def test_no_bucket_is_made(s3: Any) -> None:
    done = subprocess.run(words("s3://slip/fleet", "-j", "1"), capture_output=True, text=True, timeout=300)
    assert done.returncode == 1
    assert "error[output-failed]: cannot write to s3://slip/fleet: The specified bucket does not exist" in done.stderr
    assert [one["Name"] for one in s3.list_buckets()["Buckets"]] == ["robots"]
