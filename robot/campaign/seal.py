"""The labels of a campaign: what is wrong in which case, open or sealed.

Sealed, they are encrypted with a key that lies elsewhere, and the SHA-256 of the sealed file and of its
content are published with it before any trial is made: so nobody can change the labels afterwards, and
nobody can read them before.
"""

import hashlib
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from model.errors import ConfigError, RecordError
from record.input_file import read_bytes
from record.json_text import parse_json
from record.toml_file import toml_text
from record.whole_file import check_room, whole_file, write_text
from robot.campaign.plan import CampaignCase
from robot.console.exit_codes import ExitCode
from robot.console.installed import how_to_install
from robot.console.json_output import json_text
from robot.requests.campaign import CampaignUnsealRequest
from sim_hw.twin.catalog import EFFECTS
from sim_hw.twin.effects import find_kind

OPEN_NAME, SEALED_NAME, HASH_NAME = "labels.json", "labels.sealed", "labels.sha256"
ENTROPY_BYTES = 32
PUBLISHED_WORDS = 4  # hash and name, of the sealed file and of its content
LARGEST_LABELS = 1_000_000_000  # bytes


@dataclass(frozen=True, slots=True)
class Labels:
    """Labels of a campaign as JSON, and the entropy that everything random followed from."""

    entropy: bytes
    text: str


def labels_of(cases: tuple[CampaignCase, ...], entropy: bytes) -> Labels:
    """Return the labels of cases."""
    labels = {case.name: _label(case) for case in cases}
    return Labels(entropy, json_text({"entropy": entropy.hex(), "cases": labels}, indent=1) + "\n")


def _label(case: CampaignCase) -> dict[str, object]:
    effects = []
    for one in case.effects:
        kind = find_kind(one.name, EFFECTS)
        values = {p.name: value for p, value in zip(kind.parameters, one.values, strict=True)}
        effects.append(
            {"name": one.name, "stage": kind.stage, "leg": one.leg, "parameters": values}
        )
    return {"kind": case.kind, "robot": case.robot, "seeds": case.seeds, "effects": effects}


def make_key(path: Path) -> bytes:
    """Return the key in a file; make both if there is none.

    Raises:
        ConfigError: It holds no key, or cannot be made.
    """
    if path.exists():
        return read_key(path)
    key: bytes = _fernet().generate_key()
    try:
        handle = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
        with os.fdopen(handle, "wb") as file:
            file.write(key + b"\n")
    except OSError as error:
        raise ConfigError("--key", f"{path} cannot be made: {error.strerror}") from error
    return key


def read_key(path: Path) -> bytes:
    """Return the key in a file.

    Raises:
        ConfigError: There is none.
    """
    fernet = _fernet()
    try:
        key = read_bytes(path).strip()
        fernet(key)
    except OSError as error:
        raise ConfigError("--key", f"{path} cannot be read: {error.strerror}") from error
    except ValueError as error:
        raise ConfigError("--key", f"{path} holds no key of a sealed campaign") from error
    return key


def seal(labels: Labels, folder: Path, key: bytes) -> str:
    """Write sealed labels and their hashes; return the hash of the sealed file."""
    # as long for any labels: its size would tell of numbers of effects
    padded = labels.text + " " * (-len(labels.text) % (1 << 16))
    token: bytes = _fernet()(key).encrypt(padded.encode())
    digest = hashlib.sha256(token).hexdigest()
    inside = hashlib.sha256(labels.text.encode()).hexdigest()
    with whole_file(folder / SEALED_NAME) as part:
        part.write_bytes(token)
    write_text(folder / HASH_NAME, f"{digest}  {SEALED_NAME}\n{inside}  {OPEN_NAME}\n")
    return digest


def unseal(folder: Path, key: bytes) -> Labels:
    """Open sealed labels.

    Raises:
        RecordError: There are none, the key is another's, or they have been changed since.
    """
    from cryptography.fernet import InvalidToken

    try:
        token = read_bytes(folder / SEALED_NAME, LARGEST_LABELS)
        published = read_bytes(folder / HASH_NAME).decode("ascii", errors="replace").split()
    except OSError as error:
        raise RecordError(f"{folder} holds no sealed labels: {error.strerror}") from error
    if len(published) != PUBLISHED_WORDS:
        raise RecordError(f"{folder / HASH_NAME} is damaged; give the file as it was published")
    if hashlib.sha256(token).hexdigest() != published[0]:
        raise RecordError(f"{folder / SEALED_NAME} is not the file whose hash was published")
    try:
        text = _fernet()(key).decrypt(token).decode().rstrip() + "\n"
    except InvalidToken as error:
        raise RecordError(f"this key does not open {folder / SEALED_NAME}; give its own") from error
    if hashlib.sha256(text.encode()).hexdigest() != published[2]:
        raise RecordError(f"the labels in {folder / SEALED_NAME} are not those that were published")
    return Labels(bytes.fromhex(parse_json(text)["entropy"]), text)


def open_seal(request: CampaignUnsealRequest) -> ExitCode:
    """Print the labels of a sealed campaign, or write them.

    Raises:
        ConfigError: The key file or ``--out`` cannot be used.
        RecordError: The labels cannot be opened or written.
    """
    out = request.out
    check_room(out, "--out", ".toml", ".json")
    labels = unseal(request.folder, read_key(request.key))
    text = labels.text
    if not (request.json if out is None else out.suffix == ".json"):
        cases = parse_json(text)["cases"]
        for case in cases.values():
            del case["robot"]
            case["effects"] = [effect | effect.pop("parameters") for effect in case["effects"]]
        text = toml_text({"cases": cases})
    if out is None:
        print(text, end="")
    else:
        write_text(out, text)
        print(f"labels: {out}")
    return ExitCode.OK


def _fernet() -> Any:
    try:
        from cryptography.fernet import Fernet
    except ImportError as error:
        raise ConfigError(
            "--sealed",
            f"needs cryptography; install it with: {how_to_install('seal')}",
        ) from error
    return Fernet
