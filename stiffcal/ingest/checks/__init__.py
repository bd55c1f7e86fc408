"""What the check of a campaign finds, before anything is fitted."""
