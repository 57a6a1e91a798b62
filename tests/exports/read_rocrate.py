"""Validate an RO-Crate: ``files`` from standard input, the findings to standard output, as JSON.

The context that the package rocrate carries is put into the cache of the validator, which would
otherwise need a network."""

import json
import sys
import tempfile
from io import BytesIO
from pathlib import Path

import requests
from requests.adapters import HTTPAdapter
from requests_cache.models import CachedResponse
from rocrate_validator import services
from rocrate_validator.utils.http import HttpRequester
from urllib3 import HTTPResponse

asked = json.load(sys.stdin)
context = json.loads(Path(asked["context"]).read_text("utf-8"))
cache = str(Path(tempfile.mkdtemp()) / "cache")
session = HttpRequester.initialize_cache(cache_path=cache).session
url, body = context["@id"], json.dumps(context).encode()
raw = HTTPResponse(
    BytesIO(body), {"Content-Type": "application/ld+json"}, 200, preload_content=False,
    request_url=url,
)  # fmt: skip
answer = HTTPAdapter().build_response(requests.Request("GET", url).prepare(), raw)
session.cache.save_response(CachedResponse.from_response(answer))
given = {"rocrate_uri": asked["files"][0], "profile_identifier": "ro-crate-1.3"}
given |= {"requirement_severity": "REQUIRED", "cache_path": cache, "offline": True}
result = services.validate(given)
issues = [f"{issue.check.name}: {issue.message}" for issue in result.get_issues()]
sys.stdout.write("\n" + json.dumps({"issues": issues}))
