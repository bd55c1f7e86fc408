"""Parsers of binary logs, which anybody may have written: they run in a child process, in bounded time and memory.

`client` asks there, `child` answers, `messages` is what travels between them; every other module is a format. What is
imported here costs every such log time, so a parser takes the libraries of its format and little else.
"""
