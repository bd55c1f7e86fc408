"""The diagnosis of a campaign as the store keeps it, made anew where it is missing or stale."""
