"""What a campaign of thousands of runs costs: bytes read, processor time and memory, also after one run more."""
