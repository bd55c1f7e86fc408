"""Addresses of PostgreSQL servers as libpq takes them, read by ourselves before libpq gets them.

Why: where libpq cannot read an address, its message quotes the part that it stumbles over, which may be the password.
An address that these rules cannot read is refused without a word of what stands in it.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from urllib.parse import unquote

_KEYWORDS = frozenset({
    "host", "hostaddr", "port", "dbname", "user", "password", "passfile", "channel_binding", "connect_timeout",
    "client_encoding", "options", "application_name", "fallback_application_name", "keepalives", "keepalives_idle",
    "keepalives_interval", "keepalives_count", "tcp_user_timeout", "replication", "gssencmode", "krbsrvname",
    "gsslib", "gssdelegation", "service", "servicefile", "target_session_attrs", "load_balance_hosts",
    "require_auth", "requirepeer", "sslmode", "sslnegotiation", "requiressl", "sslcompression", "sslcert", "sslkey",
    "sslpassword", "sslcertmode", "sslrootcert", "sslcrl", "sslcrldir", "sslsni", "ssl_min_protocol_version",
    "ssl_max_protocol_version", "min_protocol_version", "max_protocol_version",
})  # fmt: skip
_NUMBERS = frozenset({
    "connect_timeout", "keepalives", "keepalives_idle", "keepalives_interval", "keepalives_count",
    "tcp_user_timeout", "requiressl", "sslcompression", "sslsni",
})  # fmt: skip
_SSL_MODES = frozenset({"disable", "allow", "prefer", "require", "verify-ca", "verify-full"})
SHOWN = frozenset({"host", "hostaddr", "port", "dbname", "user", "sslmode"}) | _NUMBERS
"""What may stand in a message; every other value is masked."""
_PAIR = re.compile(
    r"\s*(?P<key>[a-z_]+)\s*=\s*(?:'(?P<quoted>(?:[^'\\]|\\.)*)'|(?P<plain>(?!')(?:[^\s\\]|\\.)*))(?=\s|$)", re.DOTALL
)
_SCHEME = re.compile(r"postgres(?:ql)?://")
_HOST = re.compile(r"(?P<host>\[[0-9A-Fa-f:.%]+\]|[^:/\[\]@]*)(?::(?P<port>[^:/@]*))?")


def read_conninfo(text: str) -> dict[str, str] | None:
    """Return the parameters of an address, None where it cannot be read.

    Examples
    --------
    >>> read_conninfo("postgresql://lab:geheim@db.example:5433/ft?sslmode=require")["host"]
    'db.example'
    >>> read_conninfo("host=db.example password='my secret'")
    {'host': 'db.example', 'password': 'my secret'}
    >>> read_conninfo("password=my secret"), read_conninfo("postgresql://me:ge/heim@db/ft")
    (None, None)
    """
    if "\0" in text:
        return None
    parameters = _read_uri(text) if _SCHEME.match(text) else _read_pairs(text)
    if parameters is None or not parameters or not _KEYWORDS.issuperset(parameters):
        return None
    numbers = [value for key, value in parameters.items() if key in _NUMBERS]
    numbers += [port for port in parameters.get("port", "").split(",") if port]
    if not all(re.fullmatch(r"-?\d{1,9}", number) for number in numbers):
        return None
    return parameters if parameters.get("sslmode", "prefer") in _SSL_MODES else None


def conninfo_text(parameters: Mapping[str, str]) -> str:
    r"""Return parameters as one text that libpq reads as exactly these.

    Examples
    --------
    >>> print(conninfo_text({"host": "db", "password": "it's"}))
    host='db' password='it\'s'
    """
    quoted = {key: value.replace("\\", "\\\\").replace("'", "\\'") for key, value in parameters.items()}
    return " ".join(f"{key}='{value}'" for key, value in quoted.items())


def _read_pairs(text: str) -> dict[str, str] | None:
    parameters: dict[str, str] = {}
    place = 0
    while text[place:].strip():
        match = _PAIR.match(text, place)
        if match is None:
            return None
        value = match["quoted"] if match["quoted"] is not None else match["plain"]
        parameters[match["key"]] = re.sub(r"\\(.)", r"\1", value, flags=re.DOTALL)
        place = match.end()
    return parameters


def _read_uri(text: str) -> dict[str, str] | None:
    address = _SCHEME.sub("", text, count=1)
    user = re.match(r"(?P<user>[^@/:]*)(?P<password>:[^@/]*)?@", address)
    address = address[user.end() :] if user is not None else address
    before, _, query = address.partition("?")
    hosts, _, database = before.partition("/")
    pieces = [_HOST.fullmatch(host_port) for host_port in hosts.split(",")]
    if "@" in before or any(match is None for match in pieces):
        return None
    raw = {
        "user": user["user"] if user is not None else "",
        "password": (user["password"] or "")[1:] if user is not None else "",
        "host": ",".join(match["host"].strip("[]") for match in pieces if match is not None),
        "port": ",".join(match["port"] or "" for match in pieces if match is not None),
        "dbname": database,
    }
    raw = {key: value for key, value in raw.items() if value.strip(",")}
    for pair in query.split("&") if query else []:
        key, joint, value = pair.partition("=")
        if not joint or "=" in value:
            return None
        raw |= {"sslmode": "require"} if (key, value) == ("ssl", "true") else {key: value}
    if any(re.search(r"%(?![0-9A-Fa-f]{2})|%00", value) for value in raw.values()):
        return None
    return {key: unquote(value) for key, value in raw.items()}
