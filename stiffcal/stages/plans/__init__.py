"""What a plan takes from a campaign that is measured in part."""
