"""Shapes of a robot's links, for pictures: STL, OBJ, COLLADA and solids, read in a child process and simplified."""
