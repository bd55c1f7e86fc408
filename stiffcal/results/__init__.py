"""Whole answers that pages draw and that join what several rooms found: of ``identify`` and ``validate``."""
