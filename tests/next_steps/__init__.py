"""The `next:` line of every answer, followed through states of campaigns until it ends."""
