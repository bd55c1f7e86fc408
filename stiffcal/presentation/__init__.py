"""What an answer shows, as plain values: sentences, tables and pictures; every medium draws these."""
