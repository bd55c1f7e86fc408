"""Which database a campaign may reach: what the user allows by environment, and nothing else.

``STIFFCAL_POSTGRES_ENV`` names the variables that hold addresses, for ``uri_env``; ``STIFFCAL_POSTGRES`` the databases,
``[user@]host[:port]/database``, for ``host``, ``port``, ``database``, ``user``. Several stand there separated by blanks
or commas. An absent host is this machine's own server, a host that is a path is a socket, ``*`` is any database; what
has a blank, comma, slash or @ in its name is percent-encoded.
"""

from __future__ import annotations

import os
import re
import shlex
import socket
from collections.abc import Mapping
from dataclasses import dataclass
from urllib.parse import quote, unquote

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.masking import MASK, is_secret_name, mask
from stiffcal.readers.postgres.conninfo import SHOWN, conninfo_text, read_conninfo

DATABASES, VARIABLES = "STIFFCAL_POSTGRES", "STIFFCAL_POSTGRES_ENV"
PATIENCE_S = 5
"""How long a server may not answer while a connection is made; PGCONNECT_TIMEOUT changes it."""
_SHORTEST_S = 2  # libpq's own: less is rounded up to it
_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_HOST = re.compile(r"/[^\0,]*|[\w.-]+|[0-9A-Fa-f:.]+(%\w+)?")
_STANDARD_PORT = "5432"
_ENTRY = re.compile(r"(?:(?P<user>[^@/]+)@)?(?P<host>\[[^\]]*\]|/.*?|[^:/@]*)(?::(?P<port>\d+))?/(?P<database>[^/]+)")


@dataclass(frozen=True)
class Address:
    """Where a database is, as libpq takes it."""

    text: str
    """For libpq."""
    secrets: tuple[str, ...]
    """What of it must not stand in a message."""

    def without_secrets(self, text: str) -> str:
        """Return a message of libpq or the server without what is secret in this address."""
        for secret in self.secrets:
            text = text.replace(secret, MASK)
        return mask(text)


def address_of(options: Mapping[str, object], display_name: str) -> Address:
    """Return the address that the options of a source stand for.

    Parameters
    ----------
    options : of the manifest.
    display_name : how to call the table or query in a fault.

    Raises
    ------
    InputError : the user does not allow this database or variable, the variable is not set, or its address cannot be
        read.
    """
    variable = options.get("uri_env")
    named = {key: str(options[key]) for key in ("host", "port", "database", "user") if options.get(key) is not None}
    if variable is None:
        parameters = _of_manifest(named, display_name)
    elif named:
        place, mend = "postgres.uri_env", "keep one: the variable, or host, port, database, user"
        raise InputError.at(FaultCode.KEY_CONFLICT, display_name, place, "the address is given twice", mend)
    else:
        parameters = _of_variable(str(variable), display_name)
    further = {"keepalives_idle": "30", "keepalives_interval": "10", "keepalives_count": "3"}
    if "PGCONNECT_TIMEOUT" not in os.environ:
        further["connect_timeout"] = str(_patience(parameters))
    secrets = {value for key, value in parameters.items() if key not in SHOWN and value}
    secrets |= {value for value in (os.environ.get("PGPASSWORD", ""),) if value}
    secrets |= {quote(secret, safe="") for secret in secrets}
    return Address(conninfo_text({**further, **parameters}), tuple(sorted(secrets, key=len, reverse=True)))


def _of_variable(variable: str, display_name: str) -> dict[str, str]:
    place = "postgres.uri_env"
    allowed = _listed(VARIABLES)
    if _NAME.fullmatch(variable) is None:
        raise InputError.at(
            FaultCode.VALUE_INVALID,
            display_name,
            place,
            f"{variable!r} is not a name of a variable",
            'write uri_env = "LAB_DB", say',
        )
    if variable not in allowed:
        reason = f"a campaign is not allowed to use {variable} as address of a database"
        line = _line(VARIABLES, allowed, variable)
        mend = f"if it holds the address of your database: {line}"
        if is_secret_name(variable):  # no advice that opens the way to a password or key
            mend = "use a variable that contains the address of your database, and allow that one"
        raise InputError.at(FaultCode.DATABASE_ADDRESS, display_name, place, reason, mend)
    address = os.environ.get(variable, "").strip()
    if not address:
        mend = f"export {variable}=postgresql://USER@HOST/DATABASE"
        raise InputError.at(
            FaultCode.DATABASE_ADDRESS, display_name, place, f"the environment variable {variable} is not set", mend
        )
    parameters = read_conninfo(address)
    if parameters is None:
        reason = f"the value of {variable} is not the address of a PostgreSQL database"
        mend = f"export {variable}=postgresql://USER@HOST/DATABASE, special characters of a password percent-encoded"
        raise InputError.at(FaultCode.DATABASE_ADDRESS, display_name, place, reason, mend)
    return parameters


def _of_manifest(named: Mapping[str, str], display_name: str) -> dict[str, str]:
    """Return the parameters of an address in the manifest, which the user must allow; what is left out is libpq's."""
    host = named.get("host", os.environ.get("PGHOST", ""))
    port = named.get("port", os.environ.get("PGPORT", _STANDARD_PORT))
    database = named.get("database", os.environ.get("PGDATABASE", ""))
    user = named.get("user", "")
    if "host" in named and _HOST.fullmatch(host) is None:
        mend = "write one name or address, as in db.my-lab.example"
        raise InputError.at(FaultCode.DATABASE_ADDRESS, display_name, "postgres.host", f"{host!r} is not a host", mend)
    if not database:
        mend = 'add postgres.database = "…", or uri_env'
        raise InputError.at(FaultCode.DATABASE_ADDRESS, display_name, "postgres", "no database is given", mend)
    if not any(_allows(entry, host, port, database, user) for entry in _listed(DATABASES)):
        kind = "a socket" if host.startswith(("/", "@")) else "a database"
        place = _entry(host, port, database, user)
        reason = f"a campaign is not allowed to connect to {kind} at {place}"
        mend = f"if it is yours: {_line(DATABASES, _listed(DATABASES), place)}"
        raise InputError.at(FaultCode.DATABASE_UNTRUSTED, display_name, "postgres", reason, mend)
    parameters = {"host": named.get("host"), "port": named.get("port"), "dbname": named.get("database"), "user": user}
    return {key: value for key, value in parameters.items() if value}


def _allows(entry: str, host: str, port: str, database: str, user: str) -> bool:
    match = _ENTRY.fullmatch(entry)
    if match is None:
        mend = f"write [user@]host[:port]/database, as in {DATABASES}=db.my-lab.example/ft"
        raise InputError.at(FaultCode.DATABASE_ADDRESS, "", DATABASES, f"{mask(entry)!r} is not a database", mend)
    own_port = match["port"] or os.environ.get("PGPORT", _STANDARD_PORT)
    return (
        unquote(match["host"].strip("[]")).lower() == host.lower()
        and own_port == port
        and match["database"] in ("*", quote(database, safe=""), database)
        and (not user or unquote(match["user"] or "") == user)
    )


def _entry(host: str, port: str, database: str, user: str) -> str:
    """Return a database as `STIFFCAL_POSTGRES` lists it: nothing in it is more than a word to a shell."""
    place = f"[{host}]" if ":" in host else quote(host, safe="/@" if host.startswith("/") else "")
    own_port = "" if port == os.environ.get("PGPORT", _STANDARD_PORT) else f":{quote(port, safe='')}"
    own_user = f"{quote(user, safe='')}@" if user else ""
    return f"{own_user}{place}{own_port}/{quote(database, safe='')}"


def _listed(variable: str) -> list[str]:
    return [entry for entry in re.split(r"[\s,]+", os.environ.get(variable, "")) if entry]


def _line(variable: str, present: list[str], further: str) -> str:
    return f"export {variable}={shlex.quote(' '.join([*present, further]))}"


def _patience(parameters: Mapping[str, str]) -> int:
    """Return the seconds that libpq may wait at each of a host's addresses, of which it tries one after another."""
    hosts = [host for host in parameters.get("host", os.environ.get("PGHOST", "")).split(",") if host]
    if len(hosts) == 1 and not hosts[0].startswith(("/", "@")) and "hostaddr" not in parameters:
        try:
            hosts = [str(resolved[4][0]) for resolved in socket.getaddrinfo(hosts[0], None, type=socket.SOCK_STREAM)]
        except OSError:  # libpq reports it
            hosts = []
    return PATIENCE_S if len(hosts) <= 1 else max(_SHORTEST_S, PATIENCE_S // len(hosts))
