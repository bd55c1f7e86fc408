"""A server of S3 on this machine, and its one bucket."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

from stiffcal.store import Store
from stiffcal.store import remote as remote_module

BUCKET = "lab"


@pytest.fixture(scope="module")
def bucket() -> Iterator[Any]:
    """A client of a server of the tests' own, which the environment names; its bucket is empty at first."""
    import boto3
    from moto.server import ThreadedMotoServer

    server = ThreadedMotoServer(ip_address="127.0.0.1", port=0, verbose=False)
    server.start()
    host, port = server.get_host_and_port()
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("AWS_ENDPOINT_URL", f"http://{host}:{port}")
        for key, value in {"REGION": "us-east-1", "ACCESS_KEY_ID": "one", "SECRET_ACCESS_KEY": "geheim"}.items():
            patch.setenv(f"AWS_{key}", value)
        patch.setenv("AWS_EC2_METADATA_DISABLED", "true")
        client = boto3.client("s3", endpoint_url=f"http://{host}:{port}", region_name="us-east-1")
        client.create_bucket(Bucket=BUCKET)
        yield client
        client.close()
    server.stop()


def elsewhere(address: str) -> Store:
    """Return the same store as another machine reads it: without what this process has fetched."""
    remote_module._mirrors.clear()
    return Store(address)
