"""What targets and rods on links show of joints and links."""
