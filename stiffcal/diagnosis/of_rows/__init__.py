"""The same for rows that are no load states: torque over motion."""
