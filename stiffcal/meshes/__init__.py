"""Meshes of a robot's links, for pictures: STL and OBJ files, read in a child process and simplified."""
