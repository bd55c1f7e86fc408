"""Rods on links: the field of a bent beam, a link's compliance by its rods."""
