"""The one filter that keeps secrets out of messages, logs and summaries.

What is masked:

- the value of every environment variable whose name marks a secret (``PGPASSWORD``, ``AWS_SECRET_ACCESS_KEY``,
  ``GITHUB_TOKEN``, ``LAB_API_KEY``), of the database addresses that the user has allowed, and every password that
  stands in another variable's value: as written, percent-encoded, quoted and on one line;
- what is a secret by its form, wherever it came from: the password of an address (``scheme://user:password@host``),
  ``password=…`` and its kin, signatures of presigned addresses, keys and tokens of known services, private keys.

Values of fewer than six characters are no secrets to this filter: they would mask ordinary words and numbers.
"""

from __future__ import annotations

import os
import re
from dataclasses import fields, is_dataclass, replace
from enum import Enum
from functools import cache, lru_cache
from typing import Any

MASK = "…"
SHORTEST = 6
_SECRET_NAME = (
    r"PASSW|PASSPHRASE|SECRET|TOKEN|CREDENTIAL|APIKEY|(^|_)(PASS|PWD|PW|KEYS?|PAT|AUTH|AUTHORIZATION|COOKIE)($|_)"
)
# Names of files and places, and what a desktop sets for itself: no secrets, and often part of an ordinary message.
_NO_SECRET_NAME = r"^(OLD)?PWD$|(^|_)(FILE|PATH|DIR|FOLDER|HOME|SOCK|SOCKET|ASKPASS|COMMAND|TYPE|NAME|USER|HELPER)$"
_OF_DATABASES = "STIFFCAL_POSTGRES_ENV"
# In an environment variable the whole value is an address: its password may hold blanks and quotes.
_PASSWORD_OF_VALUE = r"(?s)://[^/:@\s]{0,256}:(?!\d{1,5}/)(.{1,4096})@"
_PASSWORD_KEYWORD = r"(?i)password\s*=\s*(?:'((?:[^'\\]|\\.)*)'|([^\s&'\"]+))"


@cache
def _secret_patterns() -> tuple[re.Pattern[str], ...]:
    """Return the patterns of secrets; compiled when first needed, as most commands have no message to mask."""
    in_address = re.compile(r"(?P<before>://[^\s/:@'\"]{0,256}:)(?!\d{1,5}/)(?P<secret>[^\s'\"<>]{1,1024})(?=@)")
    assigned = re.compile(
        r"(?P<before>\b(?:[a-z]{0,16}(?:password|passwd|passphrase)|pwd|secret|(?:access|auth|api)?[_-]?token"
        r"|api[_-]?key|(?:aws)?[_-]?secret[_-]?access[_-]?key|aws[_-]?access[_-]?key[_-]?id|aws[_-]?session[_-]?token"
        r"|x-amz-(?:signature|credential|security-token)|signature)(?:\s?=\s?|[\"']\s?:\s?))"
        r"(?P<secret>'(?:[^'\\]|\\.)*'|\"(?:[^\"\\]|\\.)*\"|[^\s&;,'\"<>()]+)",
        re.IGNORECASE,
    )
    header = re.compile(r"(?P<before>\b(?:Bearer|Basic)\s+)(?P<secret>[A-Za-z0-9._~+/-]{8,}=*)")
    by_form = re.compile(
        r"(?P<before>)(?P<secret>\b(?:AKIA|ASIA)[0-9A-Z]{16}\b|\bgh[pousr]_[A-Za-z0-9]{30,}|\bgithub_pat_\w{30,}"
        r"|\bglpat-[\w-]{20,}|\bxox[abprs]-[\w-]{10,}"
        r"|-----BEGIN [A-Z ]{0,32}PRIVATE KEY-----.*?(?:-----END [A-Z ]{0,32}PRIVATE KEY-----|$))",
        re.DOTALL,
    )
    return in_address, assigned, header, by_form


def mask(text: str) -> str:
    """Return a text without the secrets of this process's environment, and without what is a secret by its form.

    Examples
    --------
    >>> mask("no server at postgresql://lab:geheim@db.example/ft")
    'no server at postgresql://lab:…@db.example/ft'
    >>> mask("password='very secret' host=db"), mask("a row of words")
    ('password=… host=db', 'a row of words')
    """
    secrets = _secrets_now()
    if secrets is not None:
        text = secrets.sub(MASK, text)
    for form in _secret_patterns():
        text = form.sub(lambda match: match["before"] + MASK, text)
    return text


def masked(value: Any) -> Any:
    """Return a JSON value or a result with every text in it masked; numbers, keys, codes and the rest stay.

    Examples
    --------
    >>> masked({"reason": "password=geheim", "row": 3, "others": ["x"]})
    {'reason': 'password=…', 'row': 3, 'others': ['x']}
    """
    if isinstance(value, Enum):
        return value
    if isinstance(value, str):
        return mask(value)
    if is_dataclass(value) and not isinstance(value, type):
        return replace(value, **{field.name: masked(getattr(value, field.name)) for field in fields(value)})
    if isinstance(value, dict):
        return {key: masked(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [masked(item) for item in value]
    return value


@lru_cache(maxsize=4096)
def is_secret_name(name: str) -> bool:
    """Return whether an environment variable of this name holds a secret.

    Examples
    --------
    >>> [name for name in ("PGPASSWORD", "PWD", "SSH_AUTH_SOCK", "AWS_REGION", "CI_JOB_TOKEN") if is_secret_name(name)]
    ['PGPASSWORD', 'CI_JOB_TOKEN']
    """
    return re.search(_SECRET_NAME, name, re.IGNORECASE) is not None and (
        re.search(_NO_SECRET_NAME, name, re.IGNORECASE) is None
    )


def _secrets_now() -> re.Pattern[str] | None:
    allowed = frozenset(re.split(r"[\s,]+", os.environ.get(_OF_DATABASES, "")))
    values = []
    for name, value in os.environ.items():
        all_secret = is_secret_name(name) or name in allowed
        if all_secret or "://" in value or "assword" in value or "ASSWORD" in value:
            values.append((value, all_secret))
    return _pattern(tuple(values))


@lru_cache(maxsize=8)
def _pattern(values: tuple[tuple[str, bool], ...]) -> re.Pattern[str] | None:
    """Return the expression that finds every secret in these values.

    Parameters
    ----------
    values : of environment variables; True: the whole value is a secret, False: only passwords in it.
    """
    secrets: set[str] = set()
    for value, all_secret in values:
        if all_secret:
            secrets |= {value, *(line for line in value.splitlines() if len(line.strip()) >= 2 * SHORTEST)}
        secrets |= _passwords_in(value)
    spellings = {spelling for secret in secrets for spelling in _spellings(secret.strip())}
    longest_first = sorted((text for text in spellings if len(text) >= SHORTEST), key=lambda text: (-len(text), text))
    # A message is often put on one line, with its blanks drawn together.
    patterns = (r"\s+".join(re.escape(word) for word in text.split()) for text in longest_first)
    return re.compile("|".join(patterns)) if longest_first else None


def _passwords_in(value: str) -> set[str]:
    passwords = {match[1] for match in re.finditer(_PASSWORD_OF_VALUE, value)}
    return passwords | {match[1] or match[2] for match in re.finditer(_PASSWORD_KEYWORD, value)}


def _spellings(secret: str) -> set[str]:
    """Return the forms in which a secret may stand in a message."""
    from urllib.parse import quote, quote_plus, unquote

    plain = {secret, unquote(secret, errors="surrogateescape")}
    escaped = {text.replace("\\", "\\\\").replace("'", "\\'") for text in plain} | {repr(text)[1:-1] for text in plain}
    escaped |= {text.replace("'", "'\"'\"'") for text in plain}  # as a shell takes it
    percent = {quote_plus(text, errors="surrogateescape") for text in plain}
    percent |= {quote(text, safe=safe, errors="surrogateescape") for text in plain for safe in ("", "/", "/:")}
    printed = {text.encode("unicode_escape").decode() for text in plain}
    return plain | escaped | percent | printed
