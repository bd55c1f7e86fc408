"""Tables of absolute places, judged by joint angles and places that meet."""
