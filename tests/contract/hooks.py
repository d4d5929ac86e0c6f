"""What schemathesis cannot find in the contract: scenes that are scenes, and that pictures cost time."""
import io
import json
import os
import struct
import zipfile

import schemathesis
from hypothesis import strategies as st

SAMPLE = open(os.environ["PHOTOND_SAMPLE"], "rb").read()  # a GLB
SCENE = os.environ["PHOTOND_SCENE"]  # its id
FILM = 48  # pixels on a side, at most
PASSES = 4
PHOTONS = 1000


def renamed(name):
    """The sample's bytes with another generator: a scene of its own."""
    (length,) = struct.unpack_from("<I", SAMPLE, 12)
    document = json.loads(SAMPLE[20 : 20 + length])
    document["asset"]["generator"] = name
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    rest = SAMPLE[20 + length :]
    return struct.pack("<4sIIII", b"glTF", 2, 20 + len(text) + len(rest), len(text), 0x4E4F534A) + text + rest


def zipped(glb):
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w") as entries:
        entries.writestr("scene.glb", glb)
    return archive.getvalue()


names = st.text("abc", min_size=1, max_size=3)
schemathesis.openapi.media_type("model/gltf-binary", names.map(renamed) | st.binary(max_size=200))
schemathesis.openapi.media_type("application/zip", names.map(renamed).map(zipped) | st.binary(max_size=200))
schemathesis.openapi.media_type("model/gltf+json", st.binary(max_size=200))


@schemathesis.hook
def before_call(context, case, kwargs):
    """Shortens long polls; gives a valid job a scene that exists, and makes work one of milliseconds."""
    if isinstance((case.query or {}).get("wait"), int):
        case.query["wait"] = min(case.query["wait"], 1)
    if not isinstance(case.body, dict) or not case.meta.generation.mode.is_positive:
        return
    job = case.body
    # Of any operation: what is extended without an end would stream without an end.
    for field, most in (("photons_per_pass", PHOTONS), ("gather_photons", 16), ("passes", PASSES)):
        if isinstance(job.get(field), int):
            job[field] = min(job[field], most)
    if "stop" in job:
        job["stop"] = {"passes": min((job["stop"] or {}).get("passes") or PASSES, 2 * PASSES)}
    if case.operation.label != "POST /v1/jobs":
        return
    job["scene"] = SCENE
    job["film"] = {side: min(job.get("film", {}).get(side, FILM), FILM) for side in ("width", "height")}
    job["photons_per_pass"] = min(job.get("photons_per_pass", PHOTONS), PHOTONS)
    job["stop"] = {"passes": min(job.get("stop", {}).get("passes", PASSES), PASSES)}


answered_again = set()  # ids of jobs that a repeated Idempotency-Key named again: these may be gone by then


@schemathesis.hook
def after_call(context, case, response):
    """Notes the jobs that a request named again without making them."""
    if "idempotency-replayed" in response.headers:
        answered_again.add(response.json()["id"])


@schemathesis.hook
def filter_failure(context, failure, case, response):
    """Drops what is no fault of the service."""
    if response.status_code == 501:
        return False  # what RFC 9110 §9.1 wants of a method that no resource of the service knows
    if type(failure).__name__ == "RejectedPositiveData":
        # No schema says what a scene file is, or that a camera must look somewhere: only refusals by schema count.
        return response.json().get("code") in ("invalid_body", "invalid_parameter")
    if type(failure).__name__ == "EnsureResourceAvailability":
        return case.path_parameters.get("id") not in answered_again
    return True
