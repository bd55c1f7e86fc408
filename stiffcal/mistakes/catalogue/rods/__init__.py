"""Mistakes in rods on links: signs, exchanged columns, fixings, gauges."""
