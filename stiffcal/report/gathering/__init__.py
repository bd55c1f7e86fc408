"""What the report shows, gathered from the store."""
