"""How answers move when the numbers that decide in the reduction of logs are varied by a fifth."""
