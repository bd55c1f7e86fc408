"""What a remainder follows when no effect accounts for it."""
