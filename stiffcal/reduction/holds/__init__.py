"""Where in a log the load was held, or swept, and what of the log is not used."""
