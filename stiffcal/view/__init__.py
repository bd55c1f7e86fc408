"""The page for a browser: arrays and words in, one HTML file out; scripts of our own, no server, no network."""
