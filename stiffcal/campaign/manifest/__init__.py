"""campaign.toml: sources, runs, frames by place, settings."""
