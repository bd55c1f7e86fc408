"""Formulas of the field's plain notation, ``δ_Rz = (b/2) tanh(τ/w)``, as MathML, which browsers draw without a script.

The notation is that of the effects' docstrings: a subscript behind ``_`` or as digits behind a letter, powers as raised
digits or behind ``^``, products by a blank, quotients by ``/``, whose numerator is the whole product before it.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from html import escape

FUNCTIONS = frozenset({"tanh", "max", "min", "clip", "sign", "exp", "cos", "sin", "diag", "Exp", "Trans", "Rz"})
RAISED = dict(zip("⁰¹²³⁴⁵⁶⁷⁸⁹ᵀ", "0123456789T", strict=True))
CLOSING = {"(": ")", "[": "]", "|": "|"}
RELATIONS = ("+=", "=", "≤", "≥")
BLANK = '<mspace width="0.17em"></mspace>'
SIGNS = ("+", "−", "±")
TOKEN = re.compile(
    r"\s*(?P<token>\+=|[=+−±·×/^()\[\],;|…≤≥]"
    r"|\d+(?:\.\d+)?"
    r"|∂?[^\W\d_][^\W\d_²³ᵀ]*(?:_\{[^}]*\}|_[^\W_]+)*\d*[′]?)"
    r"(?P<raised>[⁰¹²³⁴⁵⁶⁷⁸⁹ᵀ]*)"
)


class FormulaError(ValueError):
    """The text is not in the notation."""


def mathml(text: str, display: bool = True) -> str:
    """Return a formula as MathML.

    Parameters
    ----------
    text : the formula.
    display : True for a line of its own, False within a sentence.

    Raises
    ------
    FormulaError : the text is not in the notation.

    Examples
    --------
    >>> mathml("a = b/2", display=False)
    '<math><mi>a</mi><mo>=</mo><mfrac><mi>b</mi><mn>2</mn></mfrac></math>'
    """
    parser = _Parser(tuple(_tokens(text)))
    body = parser.sequence("")
    if not parser.at_end:
        raise FormulaError(f"not a formula: {text}")
    return f'<math display="block">{body}</math>' if display else f"<math>{body}</math>"


def leading_formulas(law: str, names: frozenset[str]) -> tuple[list[str], str]:
    """Return the equations that a law begins with, and its other words.

    Parameters
    ----------
    law : an effect's law, equations first, separated by commas, semicolons or "and".
    names : words that may stand in an equation, such as the effect's parameters.

    Examples
    --------
    >>> leading_formulas("δ = c τ and w = 2 τ, with τ the torque.", frozenset())
    (['δ = c τ', 'w = 2 τ'], 'with τ the torque.')
    """
    formulas: list[str] = []
    rest = law
    while True:
        end, separator = _end_of_piece(rest)
        piece = rest[:end]
        if "=" not in piece or not _is_formula(piece, names):
            return formulas, rest
        formulas.append(piece.strip())
        rest = rest[end + separator :]


def _end_of_piece(text: str) -> tuple[int, int]:
    """Return where the first piece of a sentence ends outside brackets, and the length of what separates it."""
    depth = 0
    for position, letter in enumerate(text):
        depth += (letter in "([{") - (letter in ")]}")
        found = re.compile(r"[,;:.] | and |\.$").match(text, position)
        if depth == 0 and found:
            return position, len(found.group())
    return len(text), 0


def _is_formula(piece: str, names: frozenset[str]) -> bool:
    """Whether a piece holds symbols alone, no words."""
    words = re.findall(r"(?<![\w{])[^\W\d_]{3,}(?!\w)", piece)
    try:
        mathml(piece)
    except FormulaError:
        return False
    return set(words) <= FUNCTIONS | names


def _tokens(text: str) -> Iterator[tuple[str, str]]:
    """Yield (token, what is raised behind it)."""
    position = 0
    while position < len(text.rstrip()):
        match = TOKEN.match(text, position)
        if match is None:
            raise FormulaError(f"not a formula: {text}")
        yield match["token"], "".join(RAISED[letter] for letter in match["raised"])
        position = match.end()


class _Parser:
    """Reads the tokens of one formula."""

    def __init__(self, tokens: Sequence[tuple[str, str]]) -> None:
        self._tokens = tokens
        self._next = 0

    @property
    def at_end(self) -> bool:
        return self._next == len(self._tokens)

    def _peek(self) -> str:
        return "" if self.at_end else self._tokens[self._next][0]

    def sequence(self, closing: str) -> str:
        """Read products with signs and relations between them, up to a closing bracket."""
        parts = []
        while not self.at_end and self._peek() != closing:
            token = self._peek()
            if token in (*RELATIONS, *SIGNS, ",", ";", "…"):
                parts.append(f"<mo>{token}</mo>")
                self._next += 1
            else:
                parts.append(self._quotient(closing))
        return "".join(parts)

    def _quotient(self, closing: str) -> str:
        """Read a product, divided or not."""
        factors: list[tuple[str, str]] = []
        while not self.at_end and self._peek() not in (*RELATIONS, *SIGNS, ",", ";", "…", closing):
            token = self._peek()
            if token == "/":
                if not factors:
                    raise FormulaError("nothing is divided")
                self._next += 1
                # of a derivative only its own sign stands above the line
                whole = len(factors) == 1 or factors[-1][0][0] not in "d∂" or len(factors[-1][0]) < 2
                above = factors if whole else factors[-1:]
                factors = [] if whole else factors[:-1]
                below = self._factor(closing)
                quotient = f"<mfrac>{_row(above)}{_bare(below)}</mfrac>"
                factors.append(("/", quotient))
            elif token in ("·", "×"):
                self._next += 1
                factors.append((token, f"<mo>{token}</mo>"))
            else:
                factors.append(self._factor(closing))
        return _product(factors)

    def _factor(self, closing: str) -> tuple[str, str]:
        """Read one symbol, number, function with its argument, or bracket, with its power."""
        if self.at_end or self._peek() in (closing, ")", "]"):
            raise FormulaError("a symbol is missing")
        token, raised = self._tokens[self._next]
        self._next += 1
        if token in CLOSING:
            inner = self.sequence(CLOSING[token])
            if self.at_end:
                raise FormulaError("a bracket is open")
            raised = self._tokens[self._next][1]
            self._next += 1
            fence = f"<mo>{token}</mo>{inner}<mo>{CLOSING[token]}</mo>"
            markup = f"<mrow>{fence}</mrow>"
            token = f"({inner}" if token == "(" and not raised else "group"
        elif not token[0].isalnum() and token[0] != "∂":
            raise FormulaError(f"{token} stands where a symbol should")
        else:
            markup = _symbol(token)
        if self._peek() == "^":
            self._next += 1
            raised_markup = _bare(self._factor(closing))
            return "power", f"<msup>{markup}{raised_markup}</msup>"
        if raised:
            kind = "mn" if raised.isdigit() else "mi"
            return "power", f"<msup>{markup}<{kind}>{raised}</{kind}></msup>"
        return token, markup


def _row(factors: Sequence[tuple[str, str]]) -> str:
    """Return factors as one element; a single bracket loses its parentheses."""
    if len(factors) == 1:
        return _bare(factors[0])
    return f"<mrow>{_product(factors)}</mrow>"


def _product(factors: Sequence[tuple[str, str]]) -> str:
    """Return factors side by side, a narrow blank between them, none between a function and its argument."""
    parts: list[str] = []
    for token, markup in factors:
        opens = token == "group" or token.startswith("(")
        parts += [] if not parts or opens or token in ("·", "×") or parts[-1].startswith("<mo>") else [BLANK]
        parts.append(markup)
    return "".join(parts)


def _bare(factor: tuple[str, str]) -> str:
    """Return a factor, without parentheses where it is all that stands there."""
    token, markup = factor
    return f"<mrow>{token[1:]}</mrow>" if token.startswith("(") else markup


def _symbol(token: str) -> str:
    """Return a number, a name or a letter with its subscript."""
    if token[0].isdigit():
        return f"<mn>{token}</mn>"
    prime = token.endswith("′")
    name = token.rstrip("′")
    base, _, below = name.partition("_")
    if not below:
        found = re.fullmatch(r"(\D+?)(\d+)", base)
        if found:
            base, below = found.groups()
    markup = f"<mi>{escape(base)}</mi>"
    if below:
        words = escape(below.strip("{}").replace("}_{", ", ").replace("_", " "))
        markup = f"<msub>{markup}<mi>{words}</mi></msub>"
    return f"<msup>{markup}<mo>′</mo></msup>" if prime else markup
