"""The fitted robot in the files of controllers and other programs."""
