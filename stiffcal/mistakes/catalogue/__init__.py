"""The mistakes, a file each; folders say what they are in. Found by walking, named by nobody."""
