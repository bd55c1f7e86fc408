"""Where instruments, markers and rods sit on the robot."""
