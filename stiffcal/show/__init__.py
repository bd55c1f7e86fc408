"""Answers as pages: a file of `answers/` for each, found by its document's name; four media draw what it returns."""
