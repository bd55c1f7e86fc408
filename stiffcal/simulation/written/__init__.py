"""What instruments make of the truth, as they log it."""
