"""Answers that pages draw: of ``identify`` and ``validate``, which join what several rooms found, and ``history``."""
