"""What a model would leave with one more effect or one fewer."""
