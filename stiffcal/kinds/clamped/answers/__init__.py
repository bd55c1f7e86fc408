"""What is answered and shown of clamped runs: each joint, documents, curves, pictures."""
