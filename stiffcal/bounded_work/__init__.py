"""Work on bytes that anybody may have written: in a child process, in bounded time and memory.

`client` asks there, `child` answers, `messages` is what travels between them. What is done there is a module's:
`stiffcal.parsers.answering` for binary logs, `parquet_tables` for tables of stores. `object_store` asks another kind of
process, `object_child`, for what an object store holds. `waiting` keeps both for the next work.
"""
