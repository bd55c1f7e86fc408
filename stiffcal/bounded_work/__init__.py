"""Work on bytes that anybody may have written: in a child process, in bounded time and memory.

`client` asks there, `child` answers, `messages` is what travels between them. What is done there is a module's:
`stiffcal.parsers.answering` for binary logs, `stiffcal.store.foreign_table` for tables of stores.
"""
