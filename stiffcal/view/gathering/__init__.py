"""What the page for a browser shows, gathered from the store."""
