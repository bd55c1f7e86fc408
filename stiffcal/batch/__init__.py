"""Many campaigns in one go: on this machine's cores or a cluster, with a summary for a pipeline."""
