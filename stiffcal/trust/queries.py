"""Queries that a campaign sends to a database: what counts as one, and the digest by which the user allows its text.

The bare name of a table, ``ft`` or ``daq.ft``, is quoted as it is and reads that table alone. Any other text can call
functions that read the server's files or talk to other machines (``pg_read_file``, ``dblink``), and so needs the user's
trust.
"""

from __future__ import annotations

import hashlib
import re

# Without quotes around it a part may hold blanks and hyphens too: it is quoted before it is sent.
_PART = r'"(?:[^"\x00-\x1f\x7f]|"")+"|[^\W\d][\w$ -]*'
_TABLE = re.compile(rf"(?P<first>{_PART})(?:\.(?P<second>{_PART}))?")
_STATEMENT = re.compile(r"(?:select|with|table|values)\b", re.IGNORECASE)


def query_text(text: str) -> str:
    """Return a query as it is sent: without blanks around it and semicolons after it.

    Examples
    --------
    >>> query_text("  select 1 ; ")
    'select 1'
    """
    return text.strip().rstrip(";").strip()


def query_digest(text: str) -> str:
    """Return the SHA-256 by which the user trusts a query, the same for every way to end it.

    Examples
    --------
    >>> query_digest("select t from ft order by t;") == query_digest("select t from ft order by t")
    True
    """
    return hashlib.sha256(b"stiffcal query\0" + query_text(text).encode("utf-8", "surrogateescape")).hexdigest()


def table_of(text: str) -> tuple[str, ...] | None:
    """Return the parts of a bare table's name, schema first where there is one; None where the text is a query.

    Tables of the server itself (``pg_authid``, ``information_schema.tables``) need a query, and so the user's trust.

    Examples
    --------
    >>> table_of("daq.ft"), table_of('"Mess-Daten"'), table_of("select 1"), table_of("pg_authid")
    (('daq', 'ft'), ('Mess-Daten',), None, None)
    """
    match = _TABLE.fullmatch(query_text(text))
    if match is None or _STATEMENT.match(query_text(text)):
        return None
    parts = tuple(_unquoted(identifier) for identifier in match.groups() if identifier is not None)
    first = parts[0].lower()
    return None if first.startswith("pg_") or first == "information_schema" else parts


def needs_trust(text: str) -> bool:
    """Return whether the user must have allowed this text before it is sent."""
    return bool(query_text(text)) and table_of(text) is None


def _unquoted(identifier: str) -> str:
    return identifier[1:-1].replace('""', '"') if identifier.startswith('"') else identifier.strip()
