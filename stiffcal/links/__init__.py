"""Rods on links: the field of a bent beam, faulty rods, a link's compliance by its rods."""
