"""JSON Schemas of the commands' answers and of the store's tables, made from the types."""
