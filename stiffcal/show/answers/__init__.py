"""A file for each answer, with a function `page`: what the answer shows, in sentences, tables and pictures."""
