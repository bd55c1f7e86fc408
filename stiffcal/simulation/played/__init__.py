"""Where the robot really is along each run: loads, motors, controllers."""
