"""What is answered and shown of friction: documents, tables, curves, pictures."""
