"""Where the loaded chain comes to rest, and why it may find no rest."""
