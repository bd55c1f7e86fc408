"""A campaign read once: its logs, their quality, the load states made of them, and whether a store is still current."""
