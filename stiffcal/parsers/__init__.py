"""Parsers of binary logs, which anybody may have written: they run in a child process, in bounded time and memory.

`client` asks there by `stiffcal.bounded_work`, `answering` answers, `messages` is what travels between them; most other
modules are a format. What is imported here costs every such log time, so a parser takes the libraries of its format and
little else.
"""
