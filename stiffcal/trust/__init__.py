"""What the user trusts: plugin code, queries, places of stores, and the generations that their own runs wrote."""
